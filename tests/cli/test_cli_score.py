"""score: the three errors by hand, thresholds, and maps that cannot be compared."""

import json
import struct

import numpy as np
import pytest
from cli_tools import run, succeed, tiff, write_pgm


def score(*arguments):
    return json.loads(succeed("score", *arguments, "--json").out)


def write_pfm(path, values, order="<"):
    header = f"Pf\n{values.shape[1]} {values.shape[0]}\n{'-' if order == '<' else ''}1.0\n".encode()
    path.write_bytes(header + values[::-1].astype(order + "f4").tobytes())
    return path


@pytest.fixture
def maps(tmp_path):
    """Four pixels with both values, wrong by 0, 0.5, 0.75 and 2; one without a value in each."""
    found = write_pgm(tmp_path / "m.pgm", np.array([[80, 84, 86, 96, 0, 40]]))
    truth = write_pgm(tmp_path / "t.pgm", np.array([[160, 160, 160, 160, 160, 0]]))
    return found, truth


def test_errors(maps):
    facts = score(*maps, "--scale", "8", "--truth-scale", "16")
    assert facts == {
        "schema": 1,
        "pixels": 4,
        "rms": pytest.approx(np.sqrt((0.25 + 0.5625 + 4) / 4), rel=1e-15),
        "bad_0_5": 50,
        "bad_1_0": 25,
        "bad_2_0": 0,
        "average": pytest.approx(3.25 / 4, rel=1e-15),
        "d1": 0,
        "density": 80,
    }
    text = run("score", *maps, "--truth-scale", "16").out.decode()
    assert (
        "pixels   4" in text
        and "rms      1.0969" in text
        and "bad-0.5  50.00 %" in text
        and "bad-1.0  25.00 %" in text
    )


def test_against_numpy(tmp_path):
    random = np.random.default_rng(5)
    found, truth = random.integers(0, 256, (20, 30)), random.integers(0, 65536, (20, 30))
    facts = score(
        write_pgm(tmp_path / "m.pgm", found),
        write_pgm(tmp_path / "t.pgm", truth, 65535),
        "--scale",
        "5",
        "--truth-scale",
        "1024",
    )
    both = (found > 0) & (truth > 0)
    error = np.abs(np.where(found == 1, 0, found) / 5 - np.where(truth == 1, 0, truth) / 1024)[both]
    assert facts["pixels"] == both.sum()
    assert facts["rms"] == pytest.approx(np.sqrt((error**2).mean()), rel=1e-12)
    assert facts["bad_0_5"] == pytest.approx(100 * (error > 0.5).mean(), rel=1e-12)
    assert facts["bad_1_0"] == pytest.approx(100 * (error > 1).mean(), rel=1e-12)
    assert facts["bad_2_0"] == pytest.approx(100 * (error > 2).mean(), rel=1e-12)
    assert facts["average"] == pytest.approx(error.mean(), rel=1e-12)
    true = np.where(truth == 1, 0, truth)[both] / 1024
    assert facts["d1"] == pytest.approx(100 * ((error > 3) & (error > true / 20)).mean(), rel=1e-12)
    assert 0 < facts["d1"] < facts["bad_2_0"]
    assert facts["density"] == pytest.approx(100 * both.sum() / (truth > 0).sum(), rel=1e-12)


def test_disparity_0(tmp_path):
    """1 is read back as 0 at any scale from 2, and as 1 pixel at scale 1."""
    found = write_pgm(tmp_path / "m.pgm", np.array([[1, 8]]))
    truth = write_pgm(tmp_path / "t.pgm", np.array([[1, 1]]))
    assert score(found, truth)["rms"] == pytest.approx(np.sqrt(0.5))
    assert score(found, truth, "--truth-scale", "1")["rms"] == pytest.approx(np.sqrt(0.5))
    assert score(truth, truth, "--truth-scale", "1")["rms"] == 1


@pytest.mark.parametrize("order", ["<", ">"])
def test_pfm_is_in_pixels(tmp_path, order):
    found = write_pfm(tmp_path / "m.pfm", np.array([[1.25, np.inf], [0, np.nan], [3.5, 2]]), order)
    truth = write_pgm(tmp_path / "t.pgm", np.array([[8, 8], [1, 8], [8, 16]]))
    facts = score(found, truth, "--scale", "77")
    assert (facts["pixels"], facts["bad_0_5"], facts["bad_1_0"]) == (4, 25, 25)
    assert facts["rms"] == pytest.approx(np.sqrt((0.0625 + 6.25) / 4), rel=1e-15)


def test_floats_are_rounded_to_the_nearest(tmp_path):
    """PFM maps are held at 1/65536 pixel."""
    truth = write_pgm(tmp_path / "t.pgm", np.array([[1, 1, 1, 1]]))
    found = write_pfm(tmp_path / "m.pfm", np.array([[0.55, 0.45, 7.45, 7.55]]) / 65536)
    assert score(found, truth)["rms"] == pytest.approx(
        np.sqrt((1 + 0 + 49 + 64) / 4) / 65536, rel=1e-12
    )


@pytest.mark.parametrize("behind", [b"", b"\n", b"\r\n"])
@pytest.mark.parametrize("end", [b"\n", b"\r\n"])
def test_line_ends_of_a_pfm(tmp_path, end, behind):
    values = np.frombuffer(b"\n \r#" + struct.pack("<f", 2) + b"#\n\r\n", "<f4")[None]
    whole = write_pfm(tmp_path / "m.pfm", values)
    (tmp_path / "n.pfm").write_bytes(
        b"Pf" + end + b"3 1" + end + b"-1.0" + end + values.tobytes() + behind
    )
    assert score(tmp_path / "n.pfm", whole)["pixels"] == 3
    assert score(tmp_path / "n.pfm", whole)["rms"] == 0


@pytest.mark.parametrize(
    "option, limit, status",
    [
        ("--max-rms", "1.09", 1),
        ("--max-rms", "1.1", 0),
        ("--max-bad-0.5", "50", 0),
        ("--max-bad-0.5", "49.9", 1),
        ("--max-bad-1.0", "25", 0),
        ("--max-bad-1.0", "1e1", 1),
    ],
)
def test_thresholds(maps, option, limit, status):
    done = run("score", *maps, "--truth-scale", "16", option, limit, "--json")
    assert done.status == status
    assert json.loads(done.out)["pixels"] == 4
    assert (f"{option[6:]} is" in done.err and f"above {limit}" in done.err) == (status == 1)


@pytest.mark.parametrize("text", ["x", "nan", "inf", "-1", "0x1", " 1", "1e999"])
def test_thresholds_are_numbers(maps, text):
    done = run("score", *maps, "--max-rms", text)
    assert (done.status, "--max-rms" in done.err) == (2, True)


def test_no_pixel_in_common(tmp_path):
    found = write_pgm(tmp_path / "m.pgm", np.array([[0, 8]]))
    truth = write_pgm(tmp_path / "t.pgm", np.array([[8, 0]]))
    done = run("score", found, truth, "--json")
    assert (done.status, "no pixel has a value both" in done.err) == (1, True)
    assert json.loads(done.out) == {
        "schema": 1,
        "pixels": 0,
        "rms": None,
        "bad_0_5": None,
        "bad_1_0": None,
        "bad_2_0": None,
        "average": None,
        "d1": None,
        "density": None,
    }


def test_truth_of_another_size(tmp_path, maps):
    other = write_pgm(tmp_path / "o.pgm", np.ones((2, 6), int))
    done = run("score", maps[0], other)
    assert (done.status, done.out) == (3, b"")
    assert f"{other}: is 6 x 2 pixels, but {maps[0]} is 6 x 1" in done.err


def test_maps_in_colours(tmp_path, maps):
    colours = tmp_path / "c.ppm"
    colours.write_bytes(b"P6\n6 1\n255\n" + bytes(17) + b"\1")
    done = run("score", colours, maps[1])
    assert (done.status, "is a picture in colours: give a grey one" in done.err) == (3, True)
    (tmp_path / "c.pfm").write_bytes(b"PF\n1 1\n-1.0\n" + bytes(12))
    assert run("score", tmp_path / "c.pfm", maps[1]).status == 3


@pytest.mark.parametrize(
    "data",
    [
        b"Pf\n1 1\n-1.0\n\0\0\0",
        b"Pf\n1 1\n-1.0\n\0\0\0\0\0",
        b"Pf\n1 1\n0\n\0\0\0\0",
        b"Pf\n1 1\nx\n\0\0\0\0",
        b"Pf\n0 1\n-1\n",
        b"Pf\n100000 100000\n-1\n\0\0\0\0",
        b"Pf\n1 1\n-1.0\n" + struct.pack("<f", 40000),
    ],
)
def test_damaged_pfm(tmp_path, maps, data):
    (tmp_path / "m.pfm").write_bytes(data)
    done = run("score", tmp_path / "m.pfm", maps[1])
    assert done.status == 3
    assert done.err.startswith(f"qstereo score: {tmp_path / 'm.pfm'}: ")


def test_missing_map(tmp_path, maps):
    assert run("score", maps[0], tmp_path / "none.pgm").status == 4
    assert run("score", maps[0]).status == 2
    assert run("score", *maps, "--scale", "0").status == 2


def test_round_trip(folder, solved):
    """A map scores 0 against itself in each format, and its own error against another sample."""
    for sample in ("1", "2"):
        for name in (f"{sample}.pgm", f"{sample}.pfm"):
            done = succeed(
                "decode",
                solved.problem,
                solved.samples,
                "-o",
                folder / name,
                "--sample",
                sample,
                "--scale",
                "16",
            )
    assert score(folder / "1.pgm", folder / "1.pfm", "--scale", "16") == {
        "schema": 1,
        "pixels": 40,
        "rms": 0,
        "bad_0_5": 0,
        "bad_1_0": 0,
        "bad_2_0": 0,
        "average": 0,
        "d1": 0,
        "density": 100,
    }
    error = np.abs(solved.maps[0] - solved.maps[1])
    facts = score(folder / "1.pfm", folder / "2.pgm", "--truth-scale", "16")
    assert facts["rms"] == pytest.approx(np.sqrt((error**2).mean()))
    assert facts["bad_1_0"] == 100 * (error > 1).mean()


def test_d1_is_relative_too(tmp_path):
    """4 pixels are wrong at a true disparity of 60, but not at 100."""
    found = write_pfm(tmp_path / "m.pfm", np.array([[64, 104, 63, 57]]))
    truth = write_pfm(tmp_path / "t.pfm", np.array([[60, 100, 60, 60]]))
    assert score(found, truth)["d1"] == 25


def png(path, picture, mode=None):
    image = picture if mode is None else picture.convert(mode)
    image.save(path, "PNG")
    return path


def test_maps_as_other_programs_write_them(tmp_path, opencv):
    """A palette of greys, grey with alpha, R = G = B, and a picture in tiles."""
    from PIL import Image

    held = np.random.default_rng(3).integers(0, 256, (20, 40)).astype("u1")
    grey = write_pgm(tmp_path / "grey.pgm", held)
    image = Image.fromarray(held)
    palette = Image.fromarray(held, "P")
    palette.putpalette([value for level in range(256) for value in (level,) * 3])
    maps = [png(tmp_path / f"{mode}.png", image, mode) for mode in ("LA", "RGB", "RGBA")]
    maps.append(png(tmp_path / "P.png", palette))
    for name, data in (
        ("u8.tiff", tiff(held)),
        ("u16.tiff", tiff(held.astype("u2"))),
        ("i16.tiff", tiff(held.astype("i2"))),
        ("tiles32.tiff", tiff(held, tile=32)),
    ):
        (tmp_path / name).write_bytes(data)
        maps.append(tmp_path / name)
    for other in maps:
        facts = score(other, grey)
        assert (facts["rms"], facts["pixels"]) == (0, (held > 0).sum()), other
        assert facts["density"] == 100


def test_a_map_of_stereo_sgbm(tmp_path, opencv):
    """OpenCV's int16 of 16 x disparity; -16 says no value, and 0 is disparity 0."""
    (tmp_path / "m.tiff").write_bytes(tiff(np.array([[-16, 0, 16, 40, -8]], "i2")))
    truth = write_pfm(tmp_path / "t.pfm", np.array([[5, 0, 2, 2.5, -0.5]]))
    facts = score(tmp_path / "m.tiff", truth, "--scale", "16", "--no-value", "-16")
    assert (facts["pixels"], facts["average"], facts["density"]) == (4, 0.25, 80)
    assert score(tmp_path / "m.tiff", truth, "--scale", "16")["pixels"] == 2


def test_a_map_of_floats(tmp_path, opencv):
    values = np.array([[1.25, -1, np.nan, -7, 3]], "f4")
    (tmp_path / "m.tiff").write_bytes(tiff(values))
    whole = write_pfm(tmp_path / "m.pfm", values)
    truth = write_pfm(tmp_path / "t.pfm", np.zeros((1, 5)))
    plain = score(tmp_path / "m.tiff", truth)
    assert plain == score(whole, truth) and plain["pixels"] == 4
    for value, pixels in (("-1", 2), ("-2", 3), ("3", 3)):
        facts = score(tmp_path / "m.tiff", truth, "--no-value", value)
        assert facts == score(whole, truth, "--no-value", value)
        assert facts["pixels"] == pixels


def test_no_value_of_the_truth(tmp_path):
    found = write_pgm(tmp_path / "m.pgm", np.array([[0, 8, 16, 255]]))
    truth = write_pgm(tmp_path / "t.pgm", np.array([[0, 8, 255, 255]]))
    assert score(found, truth, "--truth-no-value", "255")["pixels"] == 1
    assert score(found, truth, "--truth-no-value", "255", "--no-value", "255")["pixels"] == 2
    assert score(found, truth)["pixels"] == 3
    done = run("score", found, truth, "--no-value", "x")
    assert (done.status, "--no-value x is not a number" in done.err) == (2, True)


def test_mask(tmp_path, maps):
    """Only the white pixels of the mask count, in the density too."""
    for white, kind in ((255, "pgm"), (1, "pbm")):
        mask = tmp_path / f"mask.{kind}"
        if kind == "pbm":
            mask.write_bytes(b"P1\n6 1\n1 0 0 1 0 1\n")
        else:
            write_pgm(mask, np.array([[128, 255, 255, 0, 255, 254]]))
        facts = score(*maps, "--truth-scale", "16", "--mask", mask)
        assert (facts["pixels"], facts["average"]) == (2, 0.625)
        assert facts["density"] == pytest.approx(200 / 3)
    small = write_pgm(tmp_path / "small.pgm", np.full((2, 2), 255))
    done = run("score", *maps, "--mask", small)
    assert (done.status, "is 2 x 2 pixels, but the truth is 6 x 1" in done.err) == (3, True)


@pytest.mark.parametrize("limit, status", [("80", 0), ("80.1", 1)])
def test_min_density(maps, limit, status):
    done = run("score", *maps, "--truth-scale", "16", "--min-density", limit)
    assert done.status == status
    assert ("density is 80, below 80.1" in done.err) == (status == 1)
    assert b"density  80.00 %" in done.out


def test_a_wrong_scale_is_suspected(tmp_path):
    held = np.full((10, 10), 80)
    right = write_pgm(tmp_path / "m.pgm", held), write_pgm(tmp_path / "t.pgm", 2 * held)
    done = run("score", *right)
    assert done.status == 0
    assert "warning: 100 % of the pixels are wrong by more than 1: are the scales" in done.err
    assert run("score", *right, "--truth-scale", "16").err == ""
