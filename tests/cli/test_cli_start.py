"""--start of solve and reduce, and the labellings that reduce hands on."""

import hashlib
import json
import struct

import numpy as np
import pytest
from cli_tools import (
    ROOT,
    SOLVERS,
    chunks_of,
    random_pair,
    run,
    succeed,
    with_chunk,
    without_chunk,
    write_qsf,
)

MASKED = ROOT / "tests" / "golden" / "good-masked-weighted.qcf"


def call(*arguments):
    return json.loads(succeed(*arguments, "--json").out)


def with_digest(samples, problem, path):
    """The samples as those of another file of the same problem."""
    return with_chunk(samples, "PROB", hashlib.sha256(problem.read_bytes()).digest(), path)


@pytest.fixture
def problem(tmp_path):
    """A noisy pair: two iterations of any solver end above the optimum."""
    *_, left, right = random_pair(tmp_path, 30, 20)
    path = tmp_path / "p.qcf"
    succeed("encode", left, right, "-o", path, "--disparity", "0:5", "--lambda", "40")
    return path


@pytest.fixture
def optimum(problem, tmp_path):
    return call("solve", problem, "-o", tmp_path / "optimum.qsf")


def test_answers_are_not_above_the_start(problem, optimum, tmp_path):
    start = tmp_path / "optimum.qsf"
    better = 0
    for solver in SOLVERS:
        if solver in ("cut", "pack"):  # not for these costs
            continue
        few = ["--solver", solver, "--iterations", "1"]
        alone = call("solve", problem, "-o", tmp_path / "a.qsf", *few)
        found = call("solve", problem, "-o", tmp_path / "s.qsf", *few, "--start", start)
        assert found["energy"] == optimum["energy"]
        better += alone["energy"] > found["energy"]
        checked = call("validate", problem, tmp_path / "s.qsf")
        assert checked["best_energy"] == optimum["energy"]
    assert better > 0


@pytest.mark.parametrize("solver", ["icm", "trws", "best"])
def test_a_start_of_a_masked_grid(tmp_path, solver):
    whole = call("solve", MASKED, "-o", tmp_path / "w.qsf")
    found = call("solve", MASKED, "-o", tmp_path / "s.qsf", "--solver", solver, "--iterations",
                 "1", "--start", tmp_path / "w.qsf")
    assert found["energy"] == whole["energy"]


def test_reduce_begins_with_it_and_hands_it_on(problem, optimum, tmp_path):
    core, samples, answer = (tmp_path / name for name in ("core.qcf", "core.qsf", "answer.qsf"))
    few = ["reduce", problem, "-o", core, "--iterations", "1"]
    alone = call(*few)
    told = call(*few, "--start", tmp_path / "optimum.qsf", "--samples", samples, "--answer",
                answer)
    assert alone["upper_bound"] > told["upper_bound"] == optimum["energy"]
    assert told["variables_after"] > 0
    for of, sample in ((core, samples), (problem, answer)):
        checked = call("validate", of, sample)
        assert checked["feasible"] == checked["samples"] == 1
        assert checked["best_energy"] == optimum["energy"]
    again = call("solve", core, "-o", tmp_path / "s.qsf", "--solver", "icm", "--start", samples)
    assert again["energy"] == optimum["energy"]


def test_samples_that_are_no_start(problem, tmp_path):
    facts = call("info", problem)
    nothing = np.zeros((1, facts["variables"]), int)
    for energy, words in ((facts["offset"], "none of the 1 samples is a labelling"),
                          (facts["offset"] + 1, "energy")):
        write_qsf(tmp_path / "t.qsf", problem, nothing, [energy])
        done = run("solve", problem, "-o", tmp_path / "s.qsf", "--start", tmp_path / "t.qsf")
        assert done.status == 3 and words in done.err
        assert not (tmp_path / "s.qsf").exists()


def test_a_start_that_is_none(problem, tmp_path):
    other = tmp_path / "other.qcf"
    succeed("reduce", problem, "-o", other, "--iterations", "1", "--samples", tmp_path / "o.qsf")
    for command in ("solve", "reduce"):
        done = run(command, problem, "-o", tmp_path / "out", "--start", tmp_path / "o.qsf")
        assert done.status == 3 and "another problem" in done.err
        assert not (tmp_path / "out").exists()


@pytest.fixture
def core(problem, optimum, tmp_path):
    """A reduced problem that is still open, which carries the optimum."""
    path = tmp_path / "core.qcf"
    told = call("reduce", problem, "-o", path, "--iterations", "1", "--start",
                tmp_path / "optimum.qsf", "--encoding", "domain-wall", "--truncate")
    assert told["lower_bound"] < told["upper_bound"] == optimum["energy"]
    return path, told


def test_a_reduced_file_carries_the_best_labelling_and_the_bound(problem, core, optimum, tmp_path):
    path, told = core
    facts = call("info", path)
    assert facts["known_energy"] == optimum["energy"]
    assert facts["stated_lower_bound"] == told["lower_bound"]
    said = succeed("info", path).out.decode()
    assert f"the file states the lower bound {told['lower_bound']}, without a proof" in said
    assert call("info", problem)["known_energy"] is None
    assert "best known" not in succeed("info", problem).out.decode()
    # So does what encode --reduce writes; what encode alone writes does not.
    *_, left, right = random_pair(tmp_path, 30, 20)
    words = ["encode", left, right, "-o", tmp_path / "e.qcf", "--disparity", "0:5", "--lambda",
             "40", "--truncate"]
    assert call(*words)["known_energy"] is None
    told = call(*words, "--reduce", "--target", "400")
    assert told["known_energy"] == told["upper_bound"]
    assert told["stated_lower_bound"] == told["lower_bound"]


def test_solvers_begin_with_what_the_file_carries(core, optimum, tmp_path):
    path, told = core
    bare = without_chunk(path, "best", tmp_path / "bare.qcf")
    few = ["-o", tmp_path / "s.qsf", "--solver", "icm", "--iterations", "1"]
    assert call("solve", bare, *few)["energy"] > optimum["energy"]
    found = call("solve", path, *few)
    assert found["energy"] == optimum["energy"]
    # The bound of the file proves nothing.
    assert found["lower_bound"] is None and not found["proven_optimal"]
    # A start that is given takes its place.
    call("solve", bare, *few)
    worse = with_digest(tmp_path / "s.qsf", path, tmp_path / "worse.qsf")
    assert call("solve", path, *few, "--start", worse)["energy"] > optimum["energy"]
    again = call("reduce", path, "-o", tmp_path / "again.qcf", "--iterations", "1")
    assert again["upper_bound"] == optimum["energy"]
    rows = {row["solver"]: row for row in call("compare", path, "--solvers", "icm")["results"]}
    assert rows["known"]["energy"] == optimum["energy"] < rows["icm"]["energy"]
    assert rows["known"]["lower_bound"] is None


def test_a_bound_is_not_passed_on(core, optimum, tmp_path):
    """A reduction states the bound that it has proven, whatever the file before it states."""
    path, told = core
    carried = chunks_of(path)["best"]
    high = struct.pack("<q", optimum["energy"]) + carried[8:]
    lie = with_chunk(path, "best", high, tmp_path / "lie.qcf")
    assert call("info", lie)["stated_lower_bound"] == optimum["energy"]
    found = call("solve", lie, "-o", tmp_path / "s.qsf", "--solver", "trws", "--iterations", "1")
    assert found["energy"] == optimum["energy"] > found["lower_bound"]
    assert not found["proven_optimal"]
    again = call("reduce", lie, "-o", tmp_path / "again.qcf", "--iterations", "1")
    facts = call("info", tmp_path / "again.qcf")
    assert facts["stated_lower_bound"] == again["lower_bound"] < optimum["energy"]
    # A labelling below the bound beside it shows that one of them is wrong.
    higher = struct.pack("<q", optimum["energy"] + 1) + carried[8:]
    wrong = with_chunk(path, "best", higher, tmp_path / "wrong.qcf")
    for words in (["info"], ["info", "--complexity"], ["compare"],
                  ["solve", "-o", tmp_path / "t.qsf"], ["reduce", "-o", tmp_path / "t.qcf"]):
        done = run(words[0], wrong, *words[1:])
        assert done.status == 3 and f"lower bound {optimum['energy'] + 1}" in done.err


@pytest.mark.parametrize("solver", ["icm", "trws"])
def test_what_a_masked_grid_carries(tmp_path, solver):
    """Ten sites of two labels among twelve cells: label 1 where the site's second variable is."""
    whole = call("solve", MASKED, "-o", tmp_path / "w.qsf")
    bits = np.unpackbits(np.frombuffer(chunks_of(tmp_path / "w.qsf")["BITS"], "u1"), count=20,
                         bitorder="little")
    best = struct.pack("<qII", -(2**63), 1, 0) + bits[1::2].tobytes()
    carrying = with_chunk(MASKED, "best", best, tmp_path / "p.qcf")
    facts = call("info", carrying)
    assert facts["known_energy"] == whole["energy"] and facts["stated_lower_bound"] is None
    found = call("solve", carrying, "-o", tmp_path / "s.qsf", "--solver", solver, "--iterations",
                 "1")
    assert found["energy"] == whole["energy"]
    maps = tmp_path / "maps"
    call("compare", carrying, "--solvers", solver, "--maps", maps)
    (drawn,) = maps.glob("known.*")
    decoded = tmp_path / f"w{drawn.suffix}"
    succeed("decode", MASKED, tmp_path / "w.qsf", "-o", decoded)
    assert drawn.read_bytes() == decoded.read_bytes()
