"""score: the three errors by hand, thresholds, and maps that cannot be compared."""

import json
import struct

import numpy as np
import pytest
from cli_tools import run, write_pgm


def score(*arguments):
    done = run("score", *arguments, "--json")
    assert done.status == 0, done.err
    return json.loads(done.out)


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
    }


def test_truth_of_another_size(tmp_path, maps):
    other = write_pgm(tmp_path / "o.pgm", np.ones((2, 6), int))
    done = run("score", maps[0], other)
    assert (done.status, done.out) == (3, b"")
    assert f"{other}: is 6 x 2 pixels, but {maps[0]} is 6 x 1" in done.err


def test_maps_in_colours(tmp_path, maps):
    colours = tmp_path / "c.ppm"
    colours.write_bytes(b"P6\n6 1\n255\n" + bytes(18))
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
            done = run(
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
            assert done.status == 0, done.err
    assert score(folder / "1.pgm", folder / "1.pfm", "--scale", "16") == {
        "schema": 1,
        "pixels": 40,
        "rms": 0,
        "bad_0_5": 0,
        "bad_1_0": 0,
    }
    error = np.abs(solved.maps[0] - solved.maps[1])
    facts = score(folder / "1.pfm", folder / "2.pgm", "--truth-scale", "16")
    assert facts["rms"] == pytest.approx(np.sqrt((error**2).mean()))
    assert facts["bad_1_0"] == 100 * (error > 1).mean()
