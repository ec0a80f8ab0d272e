"""scripts/reproduce: tables of every method over a folder of scenes."""

import json
import subprocess
import sys

import numpy as np
import pytest
from cli_tools import LONG, QSTEREO, ROOT, SOLVERS


def reproduce(*arguments):
    return subprocess.run(
        [
            sys.executable,
            ROOT / "scripts" / "reproduce",
            "--qstereo",
            QSTEREO,
            *map(str, arguments),
        ],
        capture_output=True,
        text=True,
        timeout=LONG,
    )


@pytest.fixture
def scenes(tmp_path, opencv):
    """One scene, a little larger than the window."""
    from PIL import Image

    folder = tmp_path / "data" / "noise"
    folder.mkdir(parents=True)
    random = np.random.default_rng(1)
    for name in ("left", "right", "truth"):
        Image.fromarray(random.integers(0, 160, (104, 142), dtype=np.uint8)).save(
            folder / f"{name}.png"
        )
    return folder.parent


def test_tables_and_the_reference(tmp_path, scenes):
    known = {
        "whole": {"noise": {"icm": 10**6, "best": 1}},
        "crop100": {"noise": {"bp": 10**6, "optimum": 2}},
    }
    (tmp_path / "reference.json").write_text(json.dumps(known))
    done = reproduce("--json", "--time-limit", "0.02", scenes)
    assert (done.returncode, done.stderr) == (0, "")
    whole, crop = json.loads(done.stdout)["problems"]
    shapes = [
        tuple(of[key] for key in ("part", "width", "height", "labels")) for of in (whole, crop)
    ]
    assert shapes == [("whole", 123, 104, 20), ("crop100", 100, 100, 20)]
    for of, reference in ((whole, {"icm": 10**6, "best": 1}), (crop, {"bp": 10**6, "best": 2})):
        assert [result["solver"] for result in of["results"]] == SOLVERS
        for result in of["results"]:
            assert result["reference"] == reference.get(result["solver"])
            assert result["difference"] == (
                None if result["reference"] is None else result["energy"] - result["reference"]
            )
            assert result["gap"] == result["energy"] - of["lower_bound"] >= 0
    done = reproduce("--time-limit", "0.02", scenes)
    assert (
        "noise, whole: 123 x 104 sites, 20 labels" in done.stdout
        and "noise, crop100: 100 x 100 sites" in done.stdout
    )
    assert "icm        at or below in 1 of 1" in done.stdout


def test_without_a_reference(scenes):
    done = reproduce("--time-limit", "0.02", scenes)
    assert (done.returncode, "reference" in done.stdout) == (0, False)


def test_no_scenes(tmp_path):
    done = reproduce()
    assert done.returncode == 1 and "make reproduce DATA=folder" in done.stderr
    done = reproduce(tmp_path)
    assert done.returncode == 1 and "holds no scene" in done.stderr


def test_scenes_json_says_scale_and_range(scenes):
    """The same truth at another scale gives another error; the range is that of the file."""
    found = []
    for facts in ({}, {"disparity_max": 4}, {"disparity_max": 4, "truth_scale": 40}):
        (scenes / "scenes.json").write_text(json.dumps({"noise": facts}))
        done = reproduce("--json", "--time-limit", "0.02", scenes)
        assert (done.returncode, done.stderr) == (0, "")
        found.append(json.loads(done.stdout)["problems"][0])
    assert [of["labels"] for of in found] == [20, 5, 5]
    icm = [{r["solver"]: r for r in of["results"]}["icm"] for of in found]
    # Where the time limit stops icm may differ; the error differs far more.
    assert icm[1]["rms"] > 2 * icm[2]["rms"]
