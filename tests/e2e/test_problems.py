"""docs/PROBLEMS.md's commands run on the samples as they are printed, and the samples are those
that their generator makes.
"""

import json
import re
import shutil
import subprocess
import sys

import pytest
from library import BRIDGE, QSTEREO, QSTEREO_PNM, ROOT

sys.path.insert(0, str(ROOT / "tests" / "bench"))

from whole_way import whole_way  # noqa: E402

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


def all_printed(problem):
    """The commands of a problem's section."""
    section = PAGE.split(f"\n## {problem}:")[1].split("\n## ")[0]
    texts = re.findall(r"^    qstereo (?:.*\\\n)*.*", section, re.M)
    return [text.replace("\\\n", " ").split()[1:] for text in texts]


def printed(problem):
    """The first of them, which solves in one go."""
    assert all_printed(problem)[0][0] == problem
    return all_printed(problem)[0]


@pytest.mark.parametrize("problem", ["stereo", *LIMITS])
def test_all_commands_of_the_page(problem, tmp_path):
    """From a clean folder with the samples, one after the other."""
    for path in (SAMPLES.with_name("rendered") if problem == "stereo" else SAMPLES).iterdir():
        (tmp_path / path.name).symlink_to(path)
    for words in all_printed(problem):
        done = subprocess.run([QSTEREO, *words], cwd=tmp_path, capture_output=True, text=True,
                              timeout=300)
        assert (done.returncode, done.stderr) == (0, ""), words
        assert done.stdout


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


@pytest.mark.parametrize("problem", LIMITS)
def test_the_whole_way_of_an_annealer(problem, tmp_path):
    words = [SAMPLES / word if (SAMPLES / word).exists() else word for word in printed(problem)]
    words[words.index("-o") + 1] = tmp_path / words[words.index("-o") + 1]
    found = whole_way(QSTEREO, BRIDGE, words, tmp_path)
    assert found["after"] < found["before"] and found["after"] <= 500
    gap = found["energy"] - found["lower_bound"]
    assert 0 <= gap <= (8 if problem == "detect" else 0.005 * found["lower_bound"])
    for score, (least, most) in LIMITS[problem].items():
        if score in found["scores"]:
            assert least <= found["scores"][score] <= most, score
    assert problem == "label" or found["scores"]


def test_the_picture_of_the_readme_is_what_its_script_draws(tmp_path):
    import numpy as np
    from PIL import Image

    path = tmp_path / "problems.png"
    subprocess.run([sys.executable, ROOT / "scripts" / "pictures", "--qstereo", QSTEREO, "-o",
                    path], check=True, timeout=300)
    drawn, shown = (np.array(Image.open(name).convert("RGB")).astype(int)
                    for name in (path, ROOT / "docs" / "problems.png"))
    assert drawn.shape == shown.shape and abs(drawn - shown).mean() < 1
    assert "(docs/problems.png)" in (ROOT / "README.md").read_text()


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
