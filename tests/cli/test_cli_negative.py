"""Disparities below 0: matches that stand further right in the right picture."""

import json

import numpy as np
import pytest
from cli_tools import read_pfm, run, succeed, write_pgm

SEARCH = ["--lambda", "6", "--solver", "best"]


def energy(left, right, disparities, weight):
    """F of a map of whole numbers, NaN = no site."""
    rows, columns = np.nonzero(np.isfinite(disparities))
    to = columns - disparities[rows, columns].astype(int)
    assert to.min() >= 0
    unary = abs(left[rows, columns] - right[rows, to]).sum()
    edges = sum(
        (np.isfinite(a) & np.isfinite(b) & (a != b)).sum()
        for a, b in (
            (disparities[:, 1:], disparities[:, :-1]),
            (disparities[1:], disparities[:-1]),
        )
    )
    return unary + weight * edges


def finite(path):
    values = read_pfm(path.read_bytes())
    assert not np.isneginf(values).any()
    return np.where(np.isfinite(values), values, np.nan)


def match(folder, left, right, disparity):
    """The answer of match and its map."""
    paths = [write_pgm(folder / name, grey) for name, grey in (("l.pgm", left), ("r.pgm", right))]
    options = ["-o", folder / "m.pfm", "--disparity", disparity, "--json", *SEARCH]
    facts = json.loads(succeed("match", *paths, *options).out)
    return facts, finite(folder / "m.pfm")


@pytest.fixture
def scene():
    """A pair of 12 x 5 pixels whose true disparities are -3 and 1."""
    left = np.random.default_rng(2).integers(0, 256, (5, 12))
    right = np.random.default_rng(3).integers(0, 256, (5, 12))
    right[:3, 3:] = left[:3, :-3]
    right[3:, :-1] = left[3:, 1:]
    return left, right


@pytest.mark.parametrize("least, most", [(-3, 2), (-4, 0), (-4, -2), (0, 3)])
def test_a_mirrored_pair_has_the_opposite_disparities(tmp_path, scene, least, most):
    left, right = scene
    facts, found = match(tmp_path, left, right, f"{least}:{most}")
    mirrored, opposite = match(tmp_path, left[:, ::-1], right[:, ::-1], f"{-most}:{-least}")
    assert facts["proven_optimal"] and mirrored["proven_optimal"]
    assert facts["energy"] == mirrored["energy"] == energy(left, right, found, 6)
    assert np.array_equal(np.isnan(found), np.isnan(opposite[:, ::-1]))
    assert energy(left, right, -opposite[:, ::-1], 6) == facts["energy"]
    columns = np.arange(12)
    inside = (columns - most >= 0) & (columns - least < 12)
    assert np.array_equal(np.isfinite(found), np.tile(inside, (5, 1)))
    assert np.nanmin(found) >= least and np.nanmax(found) <= most
    if (least, most) == (-3, 2):  # as drawn
        assert (found[:3, 2:9] == -3).all() and (found[3:, 2:9] == 1).all()


def test_from_the_pictures_to_the_score(tmp_path, scene):
    left, right = scene
    paths = [write_pgm(tmp_path / "l.pgm", left), write_pgm(tmp_path / "r.pgm", right)]
    problem, samples, map_path = (tmp_path / name for name in ("p.qcf", "s.qsf", "m.pfm"))
    said = succeed("encode", *paths, "-o", problem, "--disparity", "-3:2", "--lambda", "6").out
    assert b"2 columns on the left are left out" in said
    assert b"3 columns on the right are left out" in said
    facts = json.loads(succeed("info", problem, "--json").out)
    assert [facts[key] for key in ("disparity_min", "disparity_max", "x", "width")] == [-3, 2, 2, 7]
    assert b"disparities -3 to 2" in succeed("info", problem).out

    solved = json.loads(succeed("solve", problem, "-o", samples, "--json").out)
    succeed("validate", problem, samples)
    succeed("decode", problem, samples, "-o", map_path, "--color")
    found = finite(map_path)
    assert energy(left, right, found, 6) == solved["energy"]
    colours = tmp_path.glob("m.color.*")
    assert next(colours).stat().st_size > 0

    core = tmp_path / "core.qcf"
    succeed("reduce", problem, "-o", core)
    assert json.loads(succeed("info", core, "--json").out)["disparity_min"] == -3
    succeed("solve", core, "-o", tmp_path / "core.qsf")
    succeed("decode", core, tmp_path / "core.qsf", "-o", tmp_path / "c.pfm")
    assert energy(left, right, finite(tmp_path / "c.pfm"), 6) == solved["energy"]

    score = json.loads(succeed("score", map_path, map_path, "--json").out)
    assert (score["pixels"], score["rms"], score["density"]) == (35, 0, 100)
    table = json.loads(
        succeed(
            "compare", problem, "--solvers", "best", "--truth", map_path, "--maps",
            tmp_path / "maps", "--json",
        ).out
    )
    assert table["results"][0]["rms"] == 0
    assert np.array_equal(finite(tmp_path / "maps" / "best.pfm"), found, equal_nan=True)


@pytest.mark.parametrize("name", ["m.pgm", "m.png", "-"])
def test_whole_numbers_hold_none_below_0(tmp_path, scene, name, opencv):
    paths = [write_pgm(tmp_path / f"{i}.pgm", grey) for i, grey in enumerate(scene)]
    problem, samples = tmp_path / "p.qcf", tmp_path / "s.qsf"
    succeed("encode", *paths, "-o", problem, "--disparity", "-1:2")
    succeed("solve", problem, "-o", samples)
    before = set(tmp_path.iterdir())
    output = name if name == "-" else tmp_path / name
    for arguments in (["match", *paths, "--disparity", "-1:2"], ["decode", problem, samples]):
        done = run(*arguments, "-o", output)
        assert done.status == 3 and done.out == b""
        assert "begin at -1" in done.err and "name a .pfm with -o" in done.err
        assert set(tmp_path.iterdir()) == before


@pytest.mark.parametrize("text", ["-5", "--5:5", "-:5", "-5:-6", "5:-5", "-2147483648:0", "-5:+5"])
def test_what_is_no_range(tmp_path, text):
    done = run("encode", "l.pgm", "r.pgm", "-o", tmp_path / "p.qcf", f"--disparity={text}")
    assert done.status == 2 and f"--disparity {text}" in done.err


@pytest.mark.parametrize(
    "options, mend",
    [
        (["--disparity", "-12:0"], "raise the MIN of --disparity"),
        (["--disparity", "-6:6"], "raise the MIN of --disparity"),
        (["--disparity", "-4:0", "--roi", "9,0,3,2"], "move --roi to the left"),
        (["--disparity", "0:12"], "lower --disparity"),
    ],
)
def test_no_column_is_left(tmp_path, scene, options, mend):
    paths = [write_pgm(tmp_path / f"{i}.pgm", grey) for i, grey in enumerate(scene)]
    done = run("encode", *paths, "-o", tmp_path / "p.qcf", *options)
    assert done.status == 3 and mend in done.err
    assert not (tmp_path / "p.qcf").exists()
