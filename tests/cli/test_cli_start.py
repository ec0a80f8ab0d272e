"""--start of solve and reduce, and the labellings that reduce hands on."""

import json

import numpy as np
import pytest
from cli_tools import ROOT, SOLVERS, random_pair, run, succeed, write_qsf

MASKED = ROOT / "tests" / "golden" / "good-masked-weighted.qcf"


def call(*arguments):
    return json.loads(succeed(*arguments, "--json").out)


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
