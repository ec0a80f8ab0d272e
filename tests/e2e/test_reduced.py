"""From pictures to a proof: reduce, solve what is left, and decode the whole map; and the
coefficients that an annealer gets.
"""

import numpy as np
import pytest
from PIL import Image
from library import ROOT
from qstereo_bridge.core import models, qcf

RENDERED = ROOT / "samples" / "rendered"
SCENES = ROOT.parent / "shared" / "data" / "middlebury"


def grey(path):
    rgb = np.asarray(Image.open(path).convert("RGB")).astype(int)
    return (299 * rgb[..., 0] + 587 * rgb[..., 1] + 114 * rgb[..., 2] + 500) // 1000


def energy_of_map(path, left, right, window, lam):
    """F of the map in the window, from the pictures."""
    held = np.asarray(Image.open(path)).astype(int)[window]
    assert (held > 0).all()
    disparities = np.where(held == 1, 0, held // 8)
    rows, columns = np.mgrid[window]
    unary = np.abs(grey(left)[window] - grey(right)[rows, columns - disparities]).sum()
    return unary + lam * (np.count_nonzero(np.diff(disparities, axis=1)) +
                          np.count_nonzero(np.diff(disparities, axis=0)))


@pytest.fixture
def pairs(run):
    """Encodes the pair that the test asks for; returns its pictures and its window."""
    def encode(scene, roi, output, *options):
        left, right = (next(scene.glob(f"{side}.*")) for side in ("left", "right"))
        x, y, width, height = map(int, roi.split(","))
        run("qstereo", "encode", left, right, "-o", output, "--roi", roi, *options)
        return left, right, (slice(y, y + height), slice(x, x + width))
    return encode


CASES = {"rendered": (RENDERED, "40,20,40,30"), "tsukuba": (SCENES / "tsukuba", "142,94,100,100")}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("encoding", ["one-hot", "one-hot-sparse", "domain-wall"])
def test_the_whole_map_of_what_is_left(run, pairs, tmp_path, name, encoding):
    scene, roi = CASES[name]
    if not scene.is_dir():
        pytest.skip(f"no scene in {scene}")
    left, right, window = pairs(scene, roi, "p.qcf")
    facts = run("qstereo", "reduce", "p.qcf", "-o", "small.qcf", "--encoding", encoding,
                "--truncate", "--json")
    assert facts["proven_optimal"]
    if name == "tsukuba":
        assert facts["variables_before"] == 160000 and facts["variables_after"] < 160
    run("qstereo", "solve", "small.qcf", "-o", "s.qsf")
    decoded = run("qstereo", "decode", "small.qcf", "s.qsf", "-o", "m.png", "--json")
    assert decoded["energy"] == facts["lower_bound"] == energy_of_map(tmp_path / "m.png", left,
                                                                      right, window, 20)
    whole = run("qstereo", "solve", "p.qcf", "-o", "w.qsf", "--json")
    assert whole["energy"] == decoded["energy"] and whole["proven_optimal"]


def test_a_reduced_picture_window_by_window(run, pairs):
    """Without a bound the calls go on until a pass gains nothing; C reads what the bridge made."""
    pairs(RENDERED, "40,20,40,30", "p.qcf")
    facts = run("qstereo", "reduce", "p.qcf", "-o", "core.qcf", "--encoding", "domain-wall",
                "--truncate", "--json")
    few = max(2, facts["variables_after"] // 2)
    told = run("qstereo-bridge", "solve", "core.qcf", "-o", "s.qsf", "--windows", few, "--bound",
               facts["lower_bound"], "--seed", 1, "--json")
    assert told["proven_optimal"] and told["energy"] == facts["lower_bound"]
    decoded = run("qstereo", "decode", "core.qcf", "s.qsf", "-o", "m.png", "--json")
    assert decoded["energy"] == facts["lower_bound"]
    assert run("qstereo", "validate", "core.qcf", "s.qsf", "--json")["energies_agree"]


def test_windows_begin_from_what_reduce_knows(run, pairs):
    """Without a proof the bound is still known; with one nothing is left to ask. The file carries
    both."""
    pairs(RENDERED, "40,20,40,30", "p.qcf")
    for words in ("--target", 100), ():
        facts = run("qstereo", "reduce", "p.qcf", "-o", "core.qcf", "--encoding", "domain-wall",
                    "--json", *words)
        told = run("qstereo-bridge", "solve", "core.qcf", "-o", f"{len(words)}.qsf", "--windows",
                   200, "--seed", 1, "--calls", 2, "--json")
        known = run("qstereo", "info", "core.qcf", "--json")
        assert known["known_energy"] == facts["upper_bound"]
        assert known["stated_lower_bound"] == facts["lower_bound"]
        assert told["lower_bound"] == facts["lower_bound"] <= told["energy"]
        assert told["energy"] <= facts["upper_bound"]
        assert (told["calls"] > 0) == (facts["upper_bound"] > facts["lower_bound"])


def test_a_picture_that_is_not_reduced_gets_no_windows(run, pairs):
    pairs(RENDERED, "40,20,20,10", "p.qcf")
    run("qstereo-bridge", "solve", "p.qcf", "-o", "s.qsf", "--windows", 100, status=3)


def test_the_merged_result_is_what_is_decoded(run, pairs):
    pairs(RENDERED, "40,20,40,30", "p.qcf")
    run("qstereo-bridge", "solve", "p.qcf", "-o", "s.qsf", "--num-reads", 5, "--num-sweeps", 100,
        "--seed", 1)
    told = run("qstereo", "info", "s.qsf", "--json")["info"]["result"]
    decoded = run("qstereo", "decode", "p.qcf", "s.qsf", "-o", "m.png", "--json")
    assert decoded["sample"] == told["sample"] == told["reads"] == 5


@pytest.mark.parametrize("encoding", ["one-hot-sparse", "domain-wall"])
def test_a_core_is_left_for_an_annealer(run, pairs, tmp_path, encoding):
    """The bridge anneals what a target leaves, without knowing of labels; repair and the fixed
    labels make the whole map.
    """
    left, right, window = pairs(RENDERED, "40,20,40,30", "small.qcf", "--reduce", "--target", "200",
                                "--encoding", encoding, "--truncate")
    info = run("qstereo", "info", "small.qcf", "--json")
    assert info["variables"] <= 200 and info["sites"] == 1200
    run("qstereo-bridge", "solve", "small.qcf", "-o", "s.qsf", "--num-reads", "5", "--seed", "1")
    decoded = run("qstereo", "decode", "small.qcf", "s.qsf", "-o", "m.png", "--repair", "--json")
    assert decoded["energy"] == energy_of_map(tmp_path / "m.png", left, right, window, 20)
    best = run("qstereo", "reduce", "small.qcf", "-o", "t.qcf", "--json")
    assert decoded["energy"] >= best["lower_bound"]


def test_units_are_those_of_the_ising_model(run, pairs, tmp_path):
    """info --complexity beside dimod, whatever encoding the file has."""
    pairs(RENDERED, "40,20,12,10", "p.qcf", "--lambda", "12.5")
    rows = run("qstereo", "info", "p.qcf", "--complexity", "--json")["encodings"]
    checked = 0
    for row in rows:
        if row["why_not"] is None:
            pairs(RENDERED, "40,20,12,10", "q.qcf", "--lambda", "12.5", "--encoding",
                  row["encoding"], "--penalty", row["penalty"],
                  *(["--truncate"] if row["truncated"] else []))
            h, J, _ = models.to_bqm(qcf.parse_qcf((tmp_path / "q.qcf").read_bytes())).to_ising()
            h, J = np.array(list(h.values())) / 2, np.array(list(J.values())) / 2
            unit = min(4 / abs(h).max(), *([2 / -J.min()] if J.min() < 0 else []),
                       *([1 / J.max()] if J.max() > 0 else []))
            assert row["unit"] == pytest.approx(unit, rel=1e-9), row
            checked += 1
    assert checked == 12


@pytest.mark.skipif(not SCENES.is_dir(), reason=f"no scenes in {SCENES}")
def test_units_of_a_real_window(run, pairs):
    pairs(*CASES["tsukuba"], "p.qcf")
    rows = run("qstereo", "info", "p.qcf", "--complexity", "--json")["encodings"]
    units = {(row["encoding"], row["penalty"]): row["unit"] for row in rows if row["truncated"]}
    assert units["domain-wall", "local"] >= 0.04
    assert units["one-hot-sparse", "local"] >= 0.012
    assert units["one-hot", "local"] >= 0.004
    assert units["one-hot", "paper"] < 1e-6
