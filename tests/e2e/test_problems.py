"""docs/PROBLEMS.md's commands run on the samples as they are printed, and the samples are those
that their generator makes.
"""

import json
import re
import shutil
import subprocess
import sys

import pytest
from library import QSTEREO, QSTEREO_PNM, ROOT

SAMPLES = ROOT / "samples" / "problems"
PAGE = (ROOT / "docs" / "PROBLEMS.md").read_text()
# Of each problem the scores that its command prints, and the least or most that they may be.
LIMITS = {
    "label": {},
    "restore": {"psnr": (30, 99), "ssim": (0.85, 1), "hole_psnr": (20, 99)},
    "segment": {"iou": (0.95, 1), "error_rate": (0, 0.02)},
    "flow": {"aepe": (0, 0.2), "aae": (0, 5)},
    "register": {"tre": (0, 0.4), "mse": (0, 100)},
    "detect": {"precision": (0.6, 1), "recall": (0.8, 1), "ap": (0.8, 1)},
}


def printed(problem):
    """The command of a problem's section."""
    section = PAGE.split(f"\n## {problem}:")[1].split("\n## ")[0]
    text = re.search(rf"^    qstereo {problem} (?:.*\\\n)*.*", section, re.M).group(0)
    return text.replace("\\\n", " ").split()[1:]


@pytest.mark.parametrize("problem", LIMITS)
def test_the_commands_of_the_page(problem, tmp_path):
    words = printed(problem)
    for path in SAMPLES.iterdir():
        (tmp_path / path.name).symlink_to(path)
    done = subprocess.run([QSTEREO, *words, "--json"], cwd=tmp_path, capture_output=True,
                          text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    facts = json.loads(done.stdout)
    assert facts["proven_optimal"] and (tmp_path / words[words.index("-o") + 1]).exists()
    for score, (least, most) in LIMITS[problem].items():
        assert least <= facts[score] <= most, score


def test_the_samples_are_those_of_their_generator(tmp_path):
    from PIL import Image

    shutil.copy(SAMPLES / "generate.py", tmp_path)
    subprocess.run([sys.executable, tmp_path / "generate.py"], check=True, timeout=120)
    names = sorted(path.name for path in SAMPLES.iterdir() if path.suffix != ".py")
    made = {path.name for path in tmp_path.iterdir() if path.suffix != ".py"}
    assert made == set(names)
    for name in names:
        if name.endswith(".png"):
            images = [Image.open(folder / name) for folder in (SAMPLES, tmp_path)]
            assert images[0].mode == images[1].mode, name
            assert images[0].tobytes() == images[1].tobytes(), name
        else:
            assert (SAMPLES / name).read_bytes() == (tmp_path / name).read_bytes(), name


def test_a_build_without_opencv_takes_the_same_samples(tmp_path):
    subprocess.run([sys.executable, SAMPLES / "generate.py", "--pnm", tmp_path], check=True,
                   timeout=120)
    done = subprocess.run(
        [QSTEREO_PNM, "segment", "segment-photo.ppm", "segment-strokes.pgm", "-o", "mask.pgm",
         "--truth", "segment-true.pgm", "--json"],
        cwd=tmp_path, capture_output=True, text=True, timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["iou"] > 0.95
