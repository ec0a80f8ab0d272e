"""validate: feasibility, energies, and samples that are not of this problem."""

import json

import numpy as np
from cli_tools import one_hot, run, succeed, write_pgm, write_qsf


def test_samples(solved):
    done = run("validate", solved.problem, solved.samples, "--json")
    assert (done.status, done.err) == (0, "")
    assert json.loads(done.out) == {
        "schema": 1,
        "samples": 3,
        "occurrences": 8,
        "feasible": 2,
        "best_sample": 2,
        "best_energy": solved.energies[1],
        "lowest_energy": min(solved.energies[1], solved.broken_energy),
        "energies_agree": True,
    }
    text = run("validate", solved.problem, solved.samples).out.decode()
    assert (
        "2 feasible" in text
        and f"best: sample 2, energy {solved.energies[1]:g}" in text
        and "energies agree" in text
    )


def test_no_feasible_sample(tmp_path, solved):
    samples = write_qsf(
        tmp_path / "n.qsf", solved.problem, solved.broken, [2 * solved.broken_energy]
    )
    done = run("validate", solved.problem, samples, "--json")
    assert done.status == 1
    facts = json.loads(done.out)
    assert (
        facts["feasible"],
        facts["best_sample"],
        facts["best_energy"],
        facts["energies_agree"],
    ) == (0, None, None, True)
    assert "no sample is feasible" in done.err


def test_no_sample_at_all(tmp_path, solved):
    samples = write_qsf(tmp_path / "n.qsf", solved.problem, np.zeros((0, 160)), [])
    done = run("validate", solved.problem, samples, "--json")
    assert (done.status, json.loads(done.out)["lowest_energy"]) == (1, None)


def test_a_wrong_energy(tmp_path, solved):
    samples = write_qsf(
        tmp_path / "w.qsf",
        solved.problem,
        solved.bits,
        [2 * solved.energies[0], 2 * solved.energies[1] - 1],
    )
    done = run("validate", solved.problem, samples, "--json")
    assert done.status == 3
    facts = json.loads(done.out)
    assert (facts["energies_agree"], facts["best_energy"]) == (False, solved.energies[1])
    assert f"{samples}: sample 1 states the energy {solved.energies[1] - 0.5:g}, but" in done.err
    assert f"p.qcf is {solved.energies[1]:g} (1 of 2 samples" in done.err
    assert "DO NOT agree" in run("validate", solved.problem, samples).out.decode()


def test_samples_of_another_problem(tmp_path, pair, solved):
    succeed("encode", *pair.paths, "-o", tmp_path / "q.qcf", "--disparity", "1:4", "--lambda", "2")
    done = run("validate", tmp_path / "q.qcf", solved.samples)
    assert (done.status, done.out) == (3, b"")
    assert (
        f"{solved.samples}: holds samples of another problem than {tmp_path / 'q.qcf'}" in done.err
    )


def test_memory_limit(tmp_path):
    """The index of a problem takes more than its file."""
    grey = write_pgm(tmp_path / "g.pgm", np.zeros((400, 400), int))
    succeed("encode", grey, grey, "-o", tmp_path / "p.qcf", "--disparity", "0:0")
    samples = write_qsf(
        tmp_path / "s.qsf", tmp_path / "p.qcf", one_hot(np.zeros(160000, int), 1), [0]
    )
    done = run("validate", tmp_path / "p.qcf", samples, "--memory-limit", "1")
    assert (done.status, "raise --memory-limit" in done.err) == (4, True)
    succeed("validate", tmp_path / "p.qcf", samples)
