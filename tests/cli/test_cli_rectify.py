"""rectify: held against OpenCV's stereoRectify, initUndistortRectifyMap and remap."""

import json

import cv2
import numpy as np
import pytest
from camera_tools import LENSES, SIZE, calibration, rectified, remapped, write_storage
from cli_tools import read_pnm, run, succeed, write_pgm

SHAPE = SIZE[::-1]


def rectify(folder, pictures, *calibrations, ending="pgm"):
    """Rectifies two pictures and returns what was printed and the two results."""
    paths = [folder / f"in{side}.pgm" for side in (1, 2)]
    for path, picture in zip(paths, pictures):
        write_pgm(path, picture, 65535 if picture.dtype == np.uint16 else 255)
    outputs = [folder / f"out{side}.{ending}" for side in (1, 2)]
    words = [word for path in calibrations for word in ("--calibration", path)]
    done = succeed("rectify", *paths, *words, "-o", *outputs, "--json")
    return json.loads(done.out), [read_pnm(path.read_bytes())[0] for path in outputs]


def noise_of(shape):
    return [np.random.default_rng(side).integers(0, 256, shape).astype(np.uint8) for side in (1, 2)]


@pytest.mark.parametrize("form", ["yml", "xml"])
@pytest.mark.parametrize("projected", [False, True])
@pytest.mark.parametrize("coefficients", LENSES)
def test_pixels_come_from_where_opencv_takes_them(tmp_path, coefficients, projected, form):
    of = calibration(coefficients)
    full = {**of, **rectified(of)}
    path = write_storage(tmp_path / f"stereo.{form}", full if projected else of)
    # Ramps of 512 a pixel say in their samples where each sample comes from.
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(np.uint16) * 512
    for axis, ramp in enumerate((x, y)):
        _, found = rectify(tmp_path, (ramp, ramp), path)
        for side in (1, 2):
            maps = remapped(full, side, ramp)[1]
            inside = np.all([(m >= 0) & (m <= n - 1) for m, n in zip(maps, SIZE)], axis=0)
            assert inside.mean() > 0.98
            assert np.abs(found[side - 1] / 512 - maps[axis])[inside].max() <= 1 / 64


def test_samples_are_those_of_opencv(tmp_path):
    of = calibration()
    full = {**of, **rectified(of)}
    path = write_storage(tmp_path / "stereo.yml", of)
    noise = noise_of(SHAPE)
    _, found = rectify(tmp_path, noise, path)
    for side in (1, 2):
        wanted = remapped(full, side, noise[side - 1])[0].astype(int)
        assert np.abs(found[side - 1] - wanted).max() <= 1


def test_what_it_says_of_the_rectified_cameras(tmp_path):
    of = calibration()
    path = write_storage(tmp_path / "stereo.yml", of)
    flat = np.full(SHAPE, 200, np.uint8)
    facts, found = rectify(tmp_path, (flat, flat), path)
    right = rectified(of)["P2"]
    assert (facts["width"], facts["height"], facts["disparity_offset"]) == (*SIZE, 0)
    assert facts["focal_length"] == pytest.approx(right[0, 0], abs=1e-4)
    assert facts["baseline"] == pytest.approx(-right[0, 3] / right[0, 0], rel=1e-6)
    # With alpha = 0 nothing of the black around is seen, but for a trace between the points at
    # which the edges are looked at.
    assert min(picture.min() for picture in found) >= 190


def test_a_calibration_in_two_files_with_the_names_of_opencvs_sample(tmp_path):
    of = calibration()
    names = {"K1": "M1", "D1": "D1", "K2": "M2", "D2": "D2"}
    inner = write_storage(tmp_path / "intrinsics.yml", {names[n]: of[n] for n in names})
    outer = write_storage(tmp_path / "extrinsics.yml", {n: of[n] for n in ("R", "T")})
    whole = write_storage(tmp_path / "stereo.xml", {
        "cameraMatrix1": of["K1"], "distCoeffs1": of["D1"].T, "cameraMatrix2": of["K2"],
        "distCoeffs2": of["D2"].T, "R": of["R"], "T": of["T"].T,
        "image_width": SIZE[0], "image_height": SIZE[1],
    })
    noise = noise_of(SHAPE)
    two, one = rectify(tmp_path, noise, inner, outer), rectify(tmp_path, noise, whole)
    assert two[0] == one[0] and np.array_equal(two[1], one[1])


@pytest.mark.usefixtures("opencv")
def test_colours_and_png(tmp_path):
    of = calibration()
    full = {**of, **rectified(of)}
    path = write_storage(tmp_path / "stereo.yml", of)
    noise = noise_of((*SHAPE, 3))
    names = [str(tmp_path / name) for name in ("left.png", "right.png", "l2.png", "r2.ppm")]
    for name, picture in zip(names, noise):
        cv2.imwrite(name, picture)
    # The two names after -o belong to it, so that the operands can follow.
    succeed("rectify", "-o", names[2], names[3], "--calibration", path, *names[:2])
    for side in (1, 2):
        wanted = remapped(full, side, noise[side - 1])[0].astype(int)
        assert np.abs(cv2.imread(names[1 + side]).astype(int) - wanted).max() <= 1


def outputs_in(folder):
    return folder / "out1.pgm", folder / "out2.pgm"


BROKEN = [
    ({"K1": None}, "has no matrix K1 or M1"),
    ({"T": None}, "has no matrix T"),
    ({"K2": np.eye(2)}, "K2 is no matrix of 3 x 3"),
    ({"K1": -np.eye(3)}, "K1 is no camera matrix"),
    ({"D1": np.zeros((1, 6))}, "D1 is no list of 4, 5, 8, 12 or 14"),
    ({"D2": np.arange(14.0) / 1e3}, "tilted"),
    ({"D2": np.array([[np.nan, 0, 0, 0]])}, "D2 is no list"),
    ({"R": np.ones((3, 3))}, "R is no rotation"),
    ({"R": np.diag([-1.0, 1, -1])}, "do not look the same way"),
    ({"T": np.array([[0.12], [0], [0]])}, "calibrate with the left camera as the first one"),
    ({"T": np.array([[0.0], [-1], [0]])}, "side by side"),
    ({"T": np.zeros((3, 1))}, "side by side"),
    ({"R1": np.eye(3)}, "some of R1, R2, P1 and P2"),
    ({"image_width": 97, "image_height": 64}, "is of cameras with 97 x 64"),
    ({"size": np.array([0, 64])}, "the size of its pictures is 0 x 64"),
    ({"D1": np.array([[-9.0, 0, 0, 0]])}, "bends the edges"),
]


@pytest.mark.parametrize("form", ["yml", "xml"])
@pytest.mark.parametrize("change, message", BROKEN)
def test_a_calibration_that_cannot_be_used(tmp_path, change, message, form):
    values = {name: v for name, v in {**calibration(), **change}.items() if v is not None}
    path = write_storage(tmp_path / f"stereo.{form}", values)
    flat = write_pgm(tmp_path / "flat.pgm", np.full(SHAPE, 9))
    done = run("rectify", flat, flat, "--calibration", path, "-o", *outputs_in(tmp_path))
    assert (done.status, done.out) == (3, b"")
    assert message in done.err and done.err.count("\n") == 1
    assert not list(tmp_path.glob("out*"))


@pytest.mark.parametrize("text, message", [
    ("", "has no matrix K1"),
    ("{}", "is JSON"),
    ("K1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1., 0.", "K1 is no"),
    ("<opencv_storage><K1><rows>3</rows><cols>3</cols><data>1 0", "has no matrix K1"),
    ("cam0=[100 0 5; 0 100 5; 0 0 1]\n", "lacks one of cam0, cam1"),
])
def test_text_that_is_no_calibration(tmp_path, text, message):
    path = tmp_path / "stereo.txt"
    path.write_text(text)
    flat = write_pgm(tmp_path / "flat.pgm", np.full(SHAPE, 9))
    done = run("rectify", flat, flat, "--calibration", path, "-o", *outputs_in(tmp_path))
    assert done.status == 3 and message in done.err


@pytest.mark.parametrize("words, message", [
    (["-o", "a.pgm"], "-o needs an argument: LEFT2 RIGHT2"),
    (["-o", "a.pgm", "--calibration", "c.yml"], "-o needs an argument: LEFT2 RIGHT2"),
    (["-o", "a.pgm", "b.txt", "--calibration", "c.yml"], "ends in .png, .pgm or .ppm"),
    (["-o", "a.pgm", "b.pgm"], "--calibration FILE is missing"),
])
def test_wrong_usage(pair, words, message):
    done = run("rectify", *pair.paths, *words)
    assert done.status == 2 and message in done.err


def test_grey_pictures_are_no_ppm(tmp_path):
    path = write_storage(tmp_path / "stereo.yml", calibration())
    flat = write_pgm(tmp_path / "flat.pgm", np.full(SHAPE, 9))
    done = run("rectify", flat, flat, "--calibration", path, "-o", tmp_path / "a.pgm",
               tmp_path / "b.ppm")
    assert done.status == 3 and "the picture is grey: name a .pgm" in done.err
    assert not (tmp_path / "a.pgm").exists()
