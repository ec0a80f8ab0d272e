"""From raw pictures to points in metres: docs/CAMERA.md's commands run on the sample, and what
comes out is held against the truth, which the sample's generator knows.
"""

import importlib.util
import json
import re
import shlex
import shutil
import subprocess
import sys

import cv2
import numpy as np
import pytest
from library import QSTEREO, QSTEREO_PNM, ROOT

SAMPLES = ROOT / "samples" / "camera"
PAGE = (ROOT / "docs" / "CAMERA.md").read_text()
FOCAL, BASELINE = 150, 0.1


@pytest.fixture(scope="module")
def generator():
    spec = importlib.util.spec_from_file_location("camera_sample", SAMPLES / "generate.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def printed():
    """The commands of the sections that the sample is for."""
    part = PAGE.split("## 2.")[1].split("## Middlebury")[0]
    commands = re.findall(r"^    (qstereo (?:.*\\\n)*.*)", part, re.M)
    assert len(commands) == 7
    return [shlex.split(text.replace("\\\n", " ")) for text in commands]


@pytest.fixture(scope="module")
def run_page(tmp_path_factory):
    """The folder after all commands of the page."""
    folder = tmp_path_factory.mktemp("camera")
    for path in SAMPLES.iterdir():
        shutil.copy(path, folder)
    for words in printed():
        # The default solver goes on until its proof is complete; a test needs the map alone.
        quick = ["--solver", "bp", "--iterations", "20"] if words[1] == "match" else []
        done = subprocess.run([QSTEREO, *words[1:], *quick], cwd=folder, capture_output=True,
                              text=True, timeout=600)
        assert done.returncode == 0, (words, done.stderr)
        assert done.stderr == "", words
    return folder


def read_points(path):
    head, data = path.read_bytes().split(b"end_header\n", 1)
    assert b"uchar blue" in head
    return np.frombuffer(data, [("xyz", "<f4", 3), ("rgb", "u1", 3)])


def test_points_lie_on_the_surfaces(run_page, generator):
    points = read_points(run_page / "cloud.ply")
    xyz = points["xyz"].astype(float)
    # What the left camera sees in the direction of each point.
    along, _ = generator.look(0, np.zeros(3), xyz / xyz[:, 2:])
    assert len(points) > 0.85 * generator.WIDTH * generator.HEIGHT
    step = along**2 / (FOCAL * BASELINE)  # metres for a pixel of disparity
    error = np.abs(xyz[:, 2] - along)
    # Whole disparities are half a step off at most; at most 5 % of the points are wrong.
    assert (error < step).mean() > 0.95
    assert np.median(error) < 0.12 and np.median(error / step) < 0.35


def test_the_picture_of_depths_has_the_points_in_millimetres(run_page):
    depths = cv2.imread(str(run_page / "depth.png"), cv2.IMREAD_UNCHANGED)
    points = read_points(run_page / "cloud.ply")["xyz"]
    assert depths.dtype == np.uint16
    assert np.abs(depths[depths > 0] - points[:, 2] * 1000.0).max() <= 0.51


def test_the_sequence_has_the_map_of_each_frame(run_page):
    assert sorted(path.name for path in (run_page / "out").iterdir()) == [
        f"d_{number:04}.pfm" for number in (1, 2, 3)]
    assert (run_page / "out/d_0001.pfm").read_bytes() == (run_page / "disparity.pfm").read_bytes()
    for number in (1, 2, 3):
        done = subprocess.run(
            [QSTEREO, "score", f"out/d_{number:04}.pfm", f"truth_{number:04}.png",
             "--truth-scale", "256", "--json"],
            cwd=run_page, capture_output=True, text=True, timeout=60, check=True)
        assert json.loads(done.stdout)["bad_1_0"] < 5


def test_opencv_rectifies_the_sample_to_the_same_pictures(run_page, generator):
    of = generator.calibration()
    for side, name in ((1, "left"), (2, "right")):
        raw = cv2.imread(str(run_page / f"{name}_0001.png"), 0)
        maps = cv2.initUndistortRectifyMap(of[f"K{side}"], of[f"D{side}"], of[f"R{side}"],
                                           of[f"P{side}"], raw.shape[::-1], cv2.CV_32FC1)
        wanted = cv2.remap(raw, *maps, cv2.INTER_LINEAR).astype(int)
        made = cv2.imread(str(run_page / f"{name}2.png"), 0)
        assert np.abs(made - wanted).max() <= 1


def test_the_sample_is_that_of_its_generator(tmp_path):
    shutil.copy(SAMPLES / "generate.py", tmp_path)
    subprocess.run([sys.executable, tmp_path / "generate.py"], check=True, timeout=120)
    names = sorted(path.name for path in SAMPLES.iterdir() if path.is_file())
    assert sorted(path.name for path in tmp_path.iterdir() if path.is_file()) == names
    for name in names:
        if name.endswith(".png"):
            both = [cv2.imread(str(f / name), cv2.IMREAD_UNCHANGED) for f in (SAMPLES, tmp_path)]
            # The last bit of a sine may differ from one mathematics library to the next.
            assert np.abs(both[0].astype(int) - both[1]).max() <= 1, name
    files = [cv2.FileStorage(str(folder / "stereo.yml"), cv2.FILE_STORAGE_READ)
             for folder in (SAMPLES, tmp_path)]
    for name in ("K1", "D1", "K2", "D2", "R", "T", "R1", "R2", "P1", "P2"):
        stored = [file.getNode(name).mat() for file in files]
        assert np.allclose(*stored, rtol=0, atol=1e-12)


def test_a_build_without_opencv_goes_the_same_way(tmp_path, run_page):
    subprocess.run([sys.executable, SAMPLES / "generate.py", "--pnm", tmp_path], check=True,
                   timeout=120)
    done = subprocess.run(
        [QSTEREO_PNM, "rectify", "left_0001.pgm", "right_0001.pgm", "--calibration", "stereo.yml",
         "-o", "left2.pgm", "right2.pgm"],
        cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    for name in ("left2", "right2"):
        both = [cv2.imread(str(folder / f"{name}.{kind}"), 0)
                for folder, kind in ((tmp_path, "pgm"), (run_page, "png"))]
        assert np.array_equal(*both)
