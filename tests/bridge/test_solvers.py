"""Each solver of this machine on small problems."""

import argparse
import json
import math

import dimod
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from problems import Table, all_states, domain_walls, grid, make, pack_qcf, random_problem
from qstereo_bridge.core import models, qcf, qsf
from qstereo_bridge.samplers import solvers
from qstereo_bridge.core.container import OverLimit

SMALL = grid(2, 2, 3)
DENSE = grid(2, 2, 3, dense=True)


def least(problem):
    states = all_states(problem.linear.size)
    return int(models.energies(problem, states).min())


def solve(name, problem=SMALL, **options):
    defaults = {
        "num_reads": 20,
        "num_sweeps": 100,
        "seed": 1,
        "time_limit": None,
    }
    return getattr(solvers, name)(
        problem, argparse.Namespace(**{**defaults, **options}), lambda text: None
    )


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_exact_finds_all_minimisers(seed):
    problem = random_problem(seed, variables=9)
    states = all_states(problem.linear.size)[:, ::-1]
    energies, sound = models.energies(problem, states), models.feasible(problem, states)
    answer = solve("exact", problem)
    assert answer.lower_bound == energies.min() and (answer.energies == energies.min()).all()
    least = energies == energies.min()
    assert (
        answer.bits
        == np.concatenate([states[least & sound], states[least & ~sound]])[: solvers.EXACT_SAMPLES]
    ).all()
    assert answer.info["minimisers"] == (energies == energies.min()).sum()


def test_exact_at_its_limit():
    answer = solve("exact", grid(4, 2, 3))
    assert (
        answer.info["states"] == 2**24
        and (models.energies(grid(4, 2, 3), answer.bits) == answer.lower_bound).all()
    )
    with pytest.raises(solvers.SolverError, match="at most 24 variables, this problem has 27"):
        solve("exact", grid(3, 3, 3))


@pytest.mark.parametrize(
    "name, options", [("anneal", {}), ("tabu", {"num_reads": 2, "time_limit": 0.2})]
)
@pytest.mark.parametrize("problem", [SMALL, DENSE, grid(1, 1, 1), make([1], [], [], [0], [(0, 0)])])
@pytest.mark.filterwarnings("ignore:All bqm biases are zero")
def test_local_solvers_find_the_minimum(name, options, problem):
    answer = solve(name, problem, **options)
    energies = models.energies(problem, answer.bits)
    assert energies.min() == least(problem) and np.allclose(answer.energies, energies)
    assert answer.info["parameters"]["seed"] == 1
    json.dumps(qsf.plain(answer.info))


@pytest.mark.parametrize("seed", range(8))
def test_anneal_takes_every_feature(seed):
    """Free groups, couplings inside groups, groups of one."""
    for problem in (random_problem(seed), domain_walls(2, 2, 4, seed=seed)[0]):
        answer = solve("anneal", problem)
        energies = models.energies(problem, answer.bits)
        assert np.allclose(answer.energies, energies) and energies.min() == least(problem)


def test_anneal_is_repeatable():
    problem = grid(4, 4, 4)
    one, other = (solve("anneal", problem, num_sweeps=2, num_reads=5) for _ in range(2))
    assert (one.bits == other.bits).all() and one.iterations == 10
    assert (solve("anneal", problem, num_sweeps=2, num_reads=5, seed=2).bits != one.bits).any()
    assert set(solve("anneal", SMALL).info["timing"]["anneal"]) >= {"sampling_ns"}


def test_anneal_heats_by_the_couplings_not_the_penalties():
    weight = int(abs(SMALL.couplings[3, 0]))
    assert solve("anneal", SMALL).info["parameters"]["beta_range"] == [1 / weight, 20 / weight]
    table = make(
        [2, 2, 2],
        [Table(np.array([[0, -7], [2, 0]], "<i4"))],
        [
            {"weight": 3, "g": 0, "h": 1},
            {"form": 1, "width": 1, "count": 1, "pairs": [(1, 2)], "weights": [0]},
        ],
        [0] * 6,
        [(100, 1000)] * 3,
    )
    assert solve("anneal", table).info["parameters"]["beta_range"] == [1 / 21, 20 / 21]
    # Without couplings the sampler's own range serves.
    alone = make([2], [], [], [3, 4], [(5, 9)])
    assert solve("anneal", alone).info["parameters"]["beta_range"][0] != 1


def test_anneal_stops_at_its_time_limit():
    answer = solve("anneal", num_reads=10**6, time_limit=0.2)
    assert 1 <= answer.bits.shape[0] < 10**6


def test_tabu_says_what_its_matrix_needs():
    problem = grid(20, 15, 4)
    problem.memory_limit = 1 << 20
    with pytest.raises(OverLimit, match="dense in 1,200 variables"):
        solve("tabu", problem, time_limit=1)


def test_samples_of_too_many_reads():
    for name in ("anneal", "tabu"):
        with pytest.raises(OverLimit, match="2,000,000,000 samples of 12 variables"):
            solve(name, num_reads=2 * 10**9, time_limit=1)


def test_variables_in_any_order():
    samples = dimod.SampleSet.from_samples(
        ([[1, 0, 0]], [2, 0, 1]), energy=[0], vartype="BINARY", sort_labels=False
    )
    assert list(samples.variables) == [2, 0, 1] and solvers.from_sampleset(
        samples, 3
    ).bits.tolist() == [[0, 0, 1]]


def test_wrong_answers_are_refused():
    samples = dimod.SampleSet.from_samples(np.zeros((1, 3), int), energy=[0], vartype="BINARY")
    with pytest.raises(solvers.SolverError, match="3 variables that are not the 4"):
        solvers.from_sampleset(samples, 4)
    with pytest.raises(solvers.SolverError, match="not the 3"):
        solvers.from_sampleset(samples.relabel_variables({0: 7}, inplace=False), 3)
    samples.record.sample[0, 1] = -1
    with pytest.raises(solvers.SolverError, match="values other than 0 and 1"):
        solvers.from_sampleset(samples, 3)


def test_spins_are_bits():
    spins = dimod.SampleSet.from_samples(([[1, -1, 1]], [2, 1, 0]), energy=[0], vartype="SPIN")
    assert solvers.from_sampleset(spins, 3).bits.tolist() == [[1, 0, 1]]
    spins.record.sample[0, 1] = 0
    with pytest.raises(solvers.SolverError, match="values other than -1 and 1"):
        solvers.from_sampleset(spins, 3)


@pytest.mark.parametrize(
    "sampler, more",
    [
        (
            "dwave.samplers:SimulatedAnnealingSampler",
            ["--num-reads", 9, "--seed", 1, "--param", "num_sweeps=50"],
        ),
        ("dwave.samplers:TreeDecompositionSolver", []),
        ("dimod:ExactSolver", []),
        (
            "dwave.samplers:SteepestDescentSolver",
            ["--num-reads", 30, "--spin-reversals", 3, "--seed", 2],
        ),
    ],
)
def test_any_sampler(sampler, more, problem_file, tmp_path, main):
    solve = "solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", sampler, *more
    status, out, err = main(*solve, "--json")
    assert (status, err) == (0, "") and json.loads(out)["energy"] == least(
        qcf.parse_qcf(problem_file.read_bytes())
    )
    samples = qsf.parse_qsf((tmp_path / "s.qsf").read_bytes())
    assert samples.solver == sampler
    if "--param" in more:
        assert samples.info["parameters"] == {"num_reads": 9, "seed": 1, "num_sweeps": 50}
    if "--spin-reversals" in more:
        assert samples.bits.shape[0] == 90 and samples.info["parameters"]["spin_reversals"] == 3


@pytest.mark.parametrize(
    "more, status, said",
    [
        (["--solver", "dwave.samplers:None"], 2, "no such sampler"),
        (["--solver", "nowhere:X"], 2, "No module named 'nowhere'"),
        (["--solver", "json:JSONDecoder"], 2, "not a dimod sampler"),
        (["--solver", "taboo"], 2, "did you mean tabu?"),
        (
            ["--solver", "dwave.samplers:TabuSampler", "--param", "sweeps=1"],
            2,
            "does not take the parameter sweeps, only",
        ),
        (
            ["--solver", "dwave.samplers:TreeDecompositionSolver", "--seed", 1],
            2,
            "does not take the parameter seed",
        ),
        (["--solver", "dwave.samplers:TabuSampler", "--param", "tenure"], 2, "not KEY=JSON"),
        (
            ["--solver", "dwave.samplers:TabuSampler", "--param", "tenure=one"],
            2,
            "put a text in quotes",
        ),
        (
            [
                "--solver",
                "dwave.samplers:TabuSampler",
                "--param",
                "tenure=1",
                "--param",
                "tenure=1",
            ],
            2,
            "given twice",
        ),
        (["--solver", "dwave.samplers:TabuSampler", "--param", "tenure=-5"], 5, "fails"),
        (["--solver", "dimod:NullSampler"], 5, "the solver's answer has no samples"),
        (["--param", "x=1"], 2, "anneal does not take --param"),
        (["--spin-reversals", 2], 2, "only these do: qpu, MODULE:CLASS"),
    ],
)
def test_samplers_that_refuse(more, status, said, problem_file, tmp_path, main):
    found, out, err = main("solve", problem_file, "-o", tmp_path / "s.qsf", *more)
    assert (found, out) == (status, "") and said in err and err.count("\n") == 1
    assert not (tmp_path / "s.qsf").exists()


def test_states_that_are_all_equal_are_no_cause_to_warn(tmp_path, main, recwarn):
    flat = tmp_path / "flat.qcf"
    flat.write_bytes(pack_qcf(make([1, 1], [], [], [0, 0], [(0, 0)] * 2)))
    status, _, err = main("solve", flat, "-o", tmp_path / "s.qsf", "--num-reads", 2)
    assert (status, err, recwarn.list) == (0, "", [])


def test_plain():
    value = {
        1: np.int64(2),
        "a": np.array([1.5, math.nan]),
        "b": {"c": (True, None)},
        "d": {3},
        "e": np.bool_(True),
        "f": object,
    }
    found = qsf.plain(value)
    assert found == {
        "1": 2,
        "a": [1.5, None],
        "b": {"c": [True, None]},
        "d": [3],
        "e": True,
        "f": str(object),
    }
    assert json.loads(json.dumps(found, allow_nan=False)) == found


def test_qsf_holds_halves_of_surrogate_pairs():
    data = qsf.pack_qsf(
        qsf.Samples(
            bytes(32),
            "qpu",
            np.empty(0, qsf.RECORD),
            np.empty((0, 1), np.uint8),
            {"chip": "\ud800"},
        )
    )
    assert qsf.parse_qsf(data).info == {"chip": "?"}


class Terse(dimod.ExactSolver):
    """Names only some of its parameters, as openjij's samplers do."""

    parameters = {"beta": []}

    def sample(self, bqm, beta=None, num_reads=1, **more):
        return super().sample(bqm).truncate(num_reads)


def test_parameters_that_only_the_method_names(problem_file, tmp_path, main, monkeypatch):
    monkeypatch.setattr(dimod, "Terse", Terse, raising=False)
    solve = "solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", "dimod:Terse"
    assert main(*solve, "--num-reads", 3, "--param", "beta=2")[0] == 0
    assert qsf.parse_qsf((tmp_path / "s.qsf").read_bytes()).bits.shape[0] == 3
    status, _, err = main(*solve, "--seed", 3)
    assert status == 2 and "does not take the parameter seed, only beta, num_reads" in err
