"""depth: depths and points of disparity maps, held against OpenCV's reprojectImageTo3D."""

import json

import cv2
import numpy as np
import pytest
from camera_tools import (
    SIZE,
    calibration,
    read_ply,
    rectified,
    write_calib,
    write_pfm,
    write_storage,
)
from cli_tools import read_pnm, run, succeed, write_pgm

SHAPE = SIZE[::-1]


@pytest.fixture
def disparities():
    """A map of 96 x 64 pixels with values, and holes of every kind that a PFM can have."""
    values = np.random.default_rng(7).uniform(0.5, 30, SHAPE).astype(np.float32)
    values[3:9, 4:20] = np.inf
    values[20, :10] = np.nan
    values[30, 5:8] = 0, -2, -np.inf
    return values


def points_of_opencv(of, disparities):
    """The points in the calibration's unit, of the pixels whose disparity is a point."""
    q = cv2.stereoRectify(of["K1"], of["D1"], of["K2"], of["D2"], SIZE, of["R"], of["T"],
                          flags=cv2.CALIB_ZERO_DISPARITY, alpha=0)[4]
    there = np.isfinite(disparities) & (disparities > 0)
    return cv2.reprojectImageTo3D(np.where(there, disparities, 1), q)[there], there


@pytest.mark.parametrize("unit, metres", [("m", 1), ("cm", 0.01), ("mm", 0.001)])
@pytest.mark.parametrize("projected", [False, True])
def test_points_are_those_of_opencv(tmp_path, disparities, projected, unit, metres):
    of = calibration()
    path = write_storage(tmp_path / "c.yml", {**of, **(rectified(of) if projected else {})})
    wanted, there = points_of_opencv(of, disparities)
    out, map_path = tmp_path / "cloud.ply", write_pfm(tmp_path / "d.pfm", disparities)
    done = succeed("depth", map_path, "--calibration", path, "-o", out, "--unit", unit, "--json")
    points, colours = read_ply(out)
    facts = json.loads(done.out)
    assert colours is None
    assert np.allclose(points, wanted * metres, rtol=2e-5, atol=1e-6 * metres)
    assert facts["points"] == there.sum() and facts["left_out"] == (~there).sum()
    assert facts["nearest"] == pytest.approx(points[:, 2].min(), rel=1e-6)
    assert facts["farthest"] == pytest.approx(points[:, 2].max(), rel=1e-6)


def test_depths_are_whole_millimetres(tmp_path, disparities):
    of = calibration()
    path = write_storage(tmp_path / "c.yml", of)
    wanted, there = points_of_opencv(of, disparities)
    out, map_path = tmp_path / "depth.pgm", write_pfm(tmp_path / "d.pfm", disparities)
    succeed("depth", map_path, "--calibration", path, "-o", out, "--unit", "m")
    depths, maxval = read_pnm(out.read_bytes())
    assert maxval == 65535 and not depths[~there].any()
    wanted = wanted[:, 2] * 1000
    # A map is held in steps of 1/65536 pixel.
    assert (np.abs(depths[there] - wanted) <= 0.5 + 2e-5 * wanted).all()


@pytest.mark.usefixtures("opencv")
def test_depths_as_png(tmp_path, disparities):
    path = write_storage(tmp_path / "c.yml", calibration())
    map_path = write_pfm(tmp_path / "d.pfm", disparities)
    for name in ("depth.pgm", "depth.png"):
        succeed("depth", map_path, "--calibration", path, "-o", tmp_path / name, "--unit", "m")
    png, pgm = (cv2.imread(str(tmp_path / f"depth.{end}"), -1) for end in ("png", "pgm"))
    assert png.dtype == np.uint16 and np.array_equal(png, pgm)


@pytest.mark.parametrize("channels", [1, 3])
def test_points_have_the_colours_of_their_pixels(tmp_path, disparities, channels):
    path = write_storage(tmp_path / "c.xml", calibration())
    there = np.isfinite(disparities) & (disparities > 0)
    picture = np.random.default_rng(1).integers(0, 256, (*SHAPE, 3)).astype(np.uint8)
    colour = tmp_path / "left.ppm"
    if channels == 1:
        write_pgm(colour, picture[:, :, 0])
        picture = np.repeat(picture[:, :, :1], 3, axis=2)
    else:
        colour.write_bytes(b"P6\n%d %d\n255\n" % SIZE + picture.tobytes())
    out, map_path = tmp_path / "cloud.ply", write_pfm(tmp_path / "d.pfm", disparities)
    succeed("depth", map_path, "--calibration", path, "-o", out, "--unit", "m", "--color", colour)
    assert np.array_equal(read_ply(out)[1], picture[there])


def test_middleburys_offset_and_a_map_of_whole_numbers(tmp_path):
    values = np.arange(96).reshape(8, 12)
    map_path = write_pgm(tmp_path / "d.pgm", values)
    path = write_calib(tmp_path / "calib.txt")
    succeed("depth", map_path, "--calibration", path, "-o", tmp_path / "c.ply", "--scale", "4")
    points, _ = read_ply(tmp_path / "c.ply")
    y, x = np.nonzero(values)
    held = np.where(values == 1, 0, values)[y, x]  # 0 is no value, so disparity 0 is held as 1
    z = 50 * 193.001 / (held / 4 + 3.5) / 1000
    wanted = np.stack([(x - 5.5) * z / 50, (y - 3.5) * z / 50, z], axis=1)
    assert np.allclose(points, wanted, rtol=1e-6, atol=1e-7)


def test_what_may_be_a_mistake_is_said(tmp_path):
    map_path = write_pfm(tmp_path / "d.pfm", np.full(SHAPE, 0.01))
    path = write_storage(tmp_path / "c.yml", calibration())
    done = succeed("depth", map_path, "--calibration", path, "-o", tmp_path / "d.pgm")
    assert "m with --unit mm: is that its unit?" in done.err
    words = ["--calibration", path, "-o", tmp_path / "d.pgm", "--unit", "m"]
    done = succeed("depth", map_path, *words)
    assert "16 bits of millimetres end at 65.535 m" in done.err
    assert not read_pnm((tmp_path / "d.pgm").read_bytes())[0].any()


@pytest.mark.parametrize("words, status, message", [
    (["-o", "x.txt"], 2, "the name ends in .png or .pgm for depths, in .ply for points"),
    (["-o", "x.pgm", "--color", "d.pfm"], 2, "--color goes with points"),
    (["-o", "x.ply", "--unit", "inch"], 2, "--unit inch is unknown"),
    (["-o", "x.ply", "--color", "small.pgm"], 3, "is 12 x 8 pixels, but the map is 96 x 64"),
    (["-o", "x.ply", "--calibration", "calib.txt"], 3, "is 96 x 64 pixels, but"),
])
def test_what_is_refused(tmp_path, disparities, monkeypatch, words, status, message):
    monkeypatch.chdir(tmp_path)
    write_pfm(tmp_path / "d.pfm", disparities)
    write_pgm(tmp_path / "small.pgm", np.zeros((8, 12)))
    write_calib(tmp_path / "calib.txt")
    write_storage("c.yml", calibration())
    given = [] if "--calibration" in words else ["--calibration", "c.yml", "--unit", "m"]
    done = run("depth", "d.pfm", *given, *words)
    assert done.status == status and message in done.err, done.err
    assert not list(tmp_path.glob("x.*"))


def test_a_map_alone_has_no_depth(tmp_path, disparities):
    done = run("depth", write_pfm(tmp_path / "d.pfm", disparities), "-o", tmp_path / "c.ply")
    assert done.status == 2 and "--calibration FILE is missing" in done.err
