"""Each solver on small problems; D-Wave's services through Ocean's own mocks."""

import argparse
import json
import math
from unittest import mock

import dimod
import numpy as np
import pytest
from conftest import TOKEN
from dwave.samplers import SimulatedAnnealingSampler
from dwave.system import EmbeddingComposite, LeapHybridSampler
from dwave.system.testing import MockDWaveSampler, MockLeapHybridSolver
from hypothesis import given, settings
from hypothesis import strategies as st
from problems import all_states, domain_walls, grid, make, random_problem
from qstereo_bridge import models, qcf, qsf, services, solvers
from qstereo_bridge.cli import _records
from qstereo_bridge.container import OverLimit

SMALL = grid(2, 2, 3)
DENSE = grid(2, 2, 3, dense=True)


def least(problem):
    states = all_states(problem.linear.size)
    return int(models.energies(problem, states).min())


def solve(name, problem=SMALL, **options):
    module = solvers if hasattr(solvers, name) else services
    defaults = {"num_reads": 20, "num_sweeps": 100, "seed": 1, "time_limit": None, "annealing_time": None,
                "chain_strength": None, "label": None, "memory_limit": 1 << 33}
    return getattr(module, name)(problem, argparse.Namespace(**{**defaults, **options}), lambda text: None)


class BruteForceCQM(dimod.Scoped):
    """Answers like LeapHybridCQMSampler: the best states, feasible and not, the variables in an order of its own."""

    properties = {"minimum_time_limit_s": 5}

    def close(self):
        pass

    def min_time_limit(self, cqm):
        return 5.0

    def sample_cqm(self, cqm, time_limit, label=None):
        self.sent = cqm, time_limit, label
        n = len(cqm.variables)
        states = all_states(n)
        energies = cqm.objective.energies((states, range(n)))
        order = np.argsort(energies)
        sound = np.array([cqm.check_feasible(dict(enumerate(state))) for state in states[order].tolist()])
        chosen = np.append(order[sound][:3], order[~sound][:2])
        return dimod.SampleSet.from_samples((states[chosen, ::-1].astype(float), range(n)[::-1]), energy=energies[chosen],
                                            vartype="BINARY", info={"run_time": 5000000, "charge_time": np.int64(5000000)})


class HybridSolver(MockLeapHybridSolver):
    """Ocean's mock takes no label, the service does."""

    def sample_bqm(self, problem, time_limit, label=None):
        return super().sample_bqm(problem, time_limit)


def hybrid_sampler(**properties):
    solver = HybridSolver()
    solver.properties = {**solver.properties, **properties}
    with mock.patch("dwave.system.samplers.leap_hybrid_sampler.Client") as client:
        client.from_config().get_solver.return_value = solver
        return LeapHybridSampler()


def mock_qpu():
    return EmbeddingComposite(MockDWaveSampler(topology_type="chimera", topology_shape=[6, 6, 4], parameter_warnings=False,
                                               substitute_sampler=SimulatedAnnealingSampler()))


@pytest.fixture
def service(monkeypatch):
    """Puts a sampler in the place of D-Wave's."""
    def put(sampler):
        monkeypatch.setattr(services, "connect", lambda name: sampler)
        return sampler
    return put


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_exact_finds_all_minimisers(seed):
    problem = random_problem(seed, variables=9)
    states = all_states(problem.linear.size)[:, ::-1]
    energies, sound = models.energies(problem, states), models.feasible(problem, states)
    answer = solve("exact", problem)
    assert answer.lower_bound == energies.min() and (answer.energies == energies.min()).all()
    least = energies == energies.min()
    assert (answer.bits == np.concatenate([states[least & sound], states[least & ~sound]])[:solvers.EXACT_SAMPLES]).all()
    assert answer.info["minimisers"] == (energies == energies.min()).sum()


def test_exact_at_its_limit():
    answer = solve("exact", grid(4, 2, 3))
    assert answer.info["states"] == 2**24 and (models.energies(grid(4, 2, 3), answer.bits) == answer.lower_bound).all()
    with pytest.raises(solvers.SolverError, match="at most 24 variables, this problem has 27"):
        solve("exact", grid(3, 3, 3))


@pytest.mark.parametrize("name, options", [("anneal", {}), ("tabu", {"num_reads": 2, "time_limit": 0.2})])
@pytest.mark.parametrize("problem", [SMALL, DENSE, grid(1, 1, 1), make([1], [], [], [0], [(0, 0)])])
@pytest.mark.filterwarnings("ignore:All bqm biases are zero")
def test_local_solvers_find_the_minimum(name, options, problem):
    answer = solve(name, problem, **options)
    energies = models.energies(problem, answer.bits)
    assert energies.min() == least(problem) and np.allclose(answer.energies, energies)
    assert answer.info["parameters"]["seed"] == 1
    json.dumps(services.plain(answer.info))


@pytest.mark.parametrize("seed", range(8))
def test_anneal_takes_every_feature(seed):
    """Free groups, couplings inside groups, groups of one: its descent ends in a local minimum of H."""
    for problem in (random_problem(seed), domain_walls(2, 2, 4, seed=seed)[0]):
        answer = solve("anneal", problem)
        energies = models.energies(problem, answer.bits)
        assert np.allclose(answer.energies, energies) and energies.min() == least(problem)


def test_anneal_is_repeatable_and_ends_in_local_minima():
    problem = grid(4, 4, 4)
    one, other = (solve("anneal", problem, num_sweeps=2, num_reads=5) for _ in range(2))
    assert (one.bits == other.bits).all() and one.iterations == 10
    assert (solve("anneal", problem, num_sweeps=2, num_reads=5, seed=2).bits != one.bits).any()
    before = models.energies(problem, one.bits)
    for i in range(problem.linear.size):
        flipped = one.bits.copy()
        flipped[:, i] ^= 1
        assert (models.energies(problem, flipped) >= before).all()
    assert set(solve("anneal", SMALL).info["timing"]["anneal"]) >= {"sampling_ns"}


def test_anneal_heats_by_the_couplings_not_the_penalties():
    weight = int(abs(SMALL.coupling_runs["weight"][0]))
    assert solve("anneal", SMALL).info["parameters"]["beta_range"] == [1 / weight, 20 / weight]
    table = make([2, 2, 2], [qcf.Table(np.array([[0, -7], [2, 0]], "<i4"))], [{"weight": 3, "g": 0, "h": 1},
                 {"form": 1, "width": 1, "count": 1, "pairs": [(1, 2)], "weights": [0]}], [0] * 6, [(100, 1000)] * 3)
    assert solve("anneal", table).info["parameters"]["beta_range"] == [1 / 21, 20 / 21]
    # Without couplings the sampler's own range serves.
    alone = make([2], [], [], [3, 4], [(5, 9)])
    assert solve("anneal", alone).info["parameters"]["beta_range"][0] != 1


def test_anneal_stops_at_its_time_limit():
    answer = solve("anneal", num_reads=10**6, time_limit=0.2)
    assert 1 <= answer.bits.shape[0] < 10**6


def test_tabu_says_what_its_matrix_needs():
    with pytest.raises(OverLimit, match="dense in 1,200 variables"):
        solve("tabu", grid(20, 15, 4), memory_limit=1 << 20, time_limit=1)


def test_qpu(service):
    sampler = service(mock_qpu())
    with mock.patch.object(sampler.child, "sample", wraps=sampler.child.sample) as sent:
        answer = solve("qpu", DENSE, num_reads=50, annealing_time=35.0, label="tiny")
    assert {key: sent.call_args.kwargs[key] for key in ("num_reads", "annealing_time", "label")} \
        == {"num_reads": 50, "annealing_time": 35.0, "label": "tiny"}
    energies = models.energies(DENSE, answer.bits)
    assert energies.min() == least(DENSE) and np.allclose(answer.energies, energies)
    assert answer.occurrences.sum() == 50 and ((0 <= answer.broken) & (answer.broken <= 1)).all()
    info = answer.info
    assert info["embedding"]["qubits"] > DENSE.linear.size and info["embedding"]["longest_chain"] > 1
    assert info["timing"]["qpu_access_time"] and info["chip"] == "MockDWaveSampler" and info["chain_strength"] > 0
    assert json.loads(json.dumps(info)) == info


def test_qpu_chain_strength(service):
    service(mock_qpu())
    assert solve("qpu", DENSE, chain_strength=123.0).info["chain_strength"] == 123.0


def test_qpu_too_small(service):
    service(EmbeddingComposite(MockDWaveSampler(topology_type="chimera", topology_shape=[1, 1, 4])))
    with pytest.raises(solvers.SolverError, match="12 variables do not fit on a chip of 8 qubits"):
        solve("qpu")
    with pytest.raises(solvers.SolverError, match="no embedding was found"):
        solve("qpu", grid(2, 1, 4, dense=True))


def test_hybrid_bqm(service):
    service(hybrid_sampler())
    best = min(models.energies(SMALL, solve("hybrid_bqm", label="tiny").bits).min() for _ in range(20))
    answer = solve("hybrid_bqm", label="tiny", time_limit=7.0)
    assert np.allclose(answer.energies, models.energies(SMALL, answer.bits))
    assert answer.info["parameters"] == {"time_limit": 7.0, "label": "tiny"} and best == least(SMALL)
    assert solve("hybrid_bqm").info["parameters"] == {"time_limit": 1.0}
    with pytest.raises(solvers.SolverError, match="must be at least 1"):
        solve("hybrid_bqm", time_limit=0.5)


def test_hybrid_bqm_holds_to_the_limit_of_the_service(service):
    service(hybrid_sampler(maximum_number_of_variables=11))
    with pytest.raises(solvers.SolverError, match="12 variables, the service takes 11"):
        solve("hybrid_bqm")


def test_hybrid_cqm(service):
    sampler = service(BruteForceCQM())
    answer = solve("hybrid_cqm", label="tiny")
    cqm, time_limit, label = sampler.sent
    assert (time_limit, label) == (5.0, "tiny") and len(cqm.constraints) == 4 and cqm.discrete == {0, 1, 2, 3}
    assert answer.objective and answer.bits.dtype == np.uint8
    assert (answer.energies == models.energies(SMALL, answer.bits, penalties=False)).all()
    sound = models.feasible(SMALL, answer.bits)
    assert sound.any() and not sound.all() and models.energies(SMALL, answer.bits[sound]).min() == least(SMALL)
    assert json.loads(json.dumps(answer.info)) == answer.info


def test_samples_of_too_many_reads():
    for name in ("anneal", "tabu"):
        with pytest.raises(OverLimit, match="2,000,000,000 samples of 12 variables"):
            solve(name, num_reads=2 * 10**9, time_limit=1)


def test_variables_in_any_order():
    samples = dimod.SampleSet.from_samples(([[1, 0, 0]], [2, 0, 1]), energy=[0], vartype="BINARY", sort_labels=False)
    assert list(samples.variables) == [2, 0, 1] and solvers.from_sampleset(samples, 3).bits.tolist() == [[0, 0, 1]]


def test_wrong_answers_are_refused():
    samples = dimod.SampleSet.from_samples(np.zeros((1, 3), int), energy=[0], vartype="BINARY")
    with pytest.raises(solvers.SolverError, match="3 variables that are not the 4"):
        solvers.from_sampleset(samples, 4)
    with pytest.raises(solvers.SolverError, match="not the 3"):
        solvers.from_sampleset(samples.relabel_variables({0: 7}), 3)
    spins = dimod.SampleSet.from_samples(-np.ones((1, 3), int), energy=[0], vartype="SPIN")
    with pytest.raises(solvers.SolverError, match="values other than 0 and 1"):
        solvers.from_sampleset(spins, 3)


def errors():
    import dwave.cloud.exceptions as cloud
    return [(ValueError("API token not defined"), "dwave config create"), (cloud.ConfigFileReadError("gone"), "dwave config create"),
            (cloud.SolverAuthenticationError(), "does not accept the token"), (cloud.SolverNotFoundError(), "reaches no such solver"),
            (cloud.RequestTimeout(), "cannot be reached"), (cloud.PollingTimeout(), "cannot be reached"),
            (cloud.ProblemUploadError("part 1"), "cannot be reached"), (cloud.SolverFailureError("too many reads"), "too many reads"),
            (KeyError("x is not a parameter"), "not a parameter"), (ImportError("No module"), "pip install"),
            (cloud.InvalidAPIResponseError(f"token {TOKEN}"), "InvalidAPIResponseError: token \\(token\\)")]


@pytest.mark.parametrize("error, said", errors())
def test_errors_of_services(monkeypatch, error, said):
    def connect(name):
        raise error
    monkeypatch.setattr(services, "connect", connect)
    for name in ("qpu", "hybrid_bqm", "hybrid_cqm"):
        with pytest.raises(solvers.SolverError, match=said) as caught:
            solve(name)
        assert TOKEN not in str(caught.value) and caught.value.__cause__ is None and "\n" not in str(caught.value)


def test_scrub(monkeypatch, tmp_path):
    monkeypatch.setenv("DWAVE_API_TOKEN", "short-secret")
    assert services.scrub(f"a short-secret and {TOKEN}.") == "a (token) and (token)."
    monkeypatch.delenv("DWAVE_API_TOKEN")
    (tmp_path / "dwave.conf").write_text("[defaults]\ntoken = from-the-file\n")
    monkeypatch.setenv("DWAVE_CONFIG_FILE", str(tmp_path / "dwave.conf"))
    assert services.scrub("with from-the-file") == "with (token)"


def test_plain():
    value = {1: np.int64(2), "a": np.array([1.5, math.nan]), "b": {"c": (True, None)}, "d": {3}, "e": np.bool_(True), "f": object}
    found = services.plain(value)
    assert found == {"1": 2, "a": [1.5, None], "b": {"c": [True, None]}, "d": [3], "e": True, "f": str(object)}
    assert json.loads(json.dumps(found, allow_nan=False)) == found


@pytest.mark.parametrize("dense", [False, True])
def test_plans_agree_with_the_models(dense):
    problem = grid(5, 4, 4, dense)
    bqm, cqm = models.to_bqm(problem), models.to_cqm(problem)
    plan = services.plan("hybrid-bqm", problem)
    with bqm.to_file(version=2) as file:
        assert plan["upload_bytes"] == len(file.read())
    assert (plan["variables"], plan["quadratic_terms"]) == bqm.shape and plan["biases"] == sum(bqm.shape)
    plan = services.plan("hybrid-cqm", problem)
    assert plan["biases"] == cqm.num_biases() and plan["constraints"] == len(cqm.constraints)
    with cqm.to_file() as file:
        assert 0.8 < plan["upload_bytes"] / file.seek(0, 2) < 1.3
    plan = services.plan("qpu", problem)
    assert plan["upload_bytes"] == 4 * sum(math.ceil(8 * count / 3) for count in bqm.shape)
    assert plan["largest_degree"] == max(bqm.degree(v) for v in bqm.variables)
    assert (plan["linear_min"], plan["linear_max"]) == (bqm.linear.min(), bqm.linear.max())
    assert (plan["quadratic_min"], plan["quadratic_max"]) == (bqm.quadratic.min(), bqm.quadratic.max())


@pytest.mark.parametrize("size, bqm, cqm", [((100, 100, 16), 600, 38), ((176, 178, 16), 600, 189)])
def test_least_time_limits(size, bqm, cqm):
    problem = grid(*size)
    assert services.plan("hybrid-bqm", problem)["minimum_time_limit"] == bqm
    assert services.plan("hybrid-cqm", problem)["minimum_time_limit"] == pytest.approx(cqm, rel=0.02)
    assert services.plan("hybrid-bqm", problem)["fits"] and not services.plan("qpu", problem)["fits"]


def test_plan_beyond_the_limits():
    problem = grid(384, 288, 16)
    assert not services.plan("hybrid-bqm", problem)["fits"] and not services.plan("hybrid-cqm", problem)["fits"]
    assert services.plan("qpu", SMALL)["fits"] is None
    assert services.plan("qpu", grid(41, 41, 4))["fits"] is False
    assert services.plan("qpu", make([1], [], [], [3], [(0, 0)]))["quadratic_max"] is None


def test_plan_of_repeated_pairs():
    """What cancels is not sent."""
    problem = make([1] * 3, [qcf.Table(np.array([[5]], "<i4"))], [{"weight": 1, "h": 1}, {"weight": 2, "h": 1},
                                                                 {"weight": 1, "h": 2}, {"weight": -1, "h": 2}], [0] * 3, [(0, 0)] * 3)
    plan = services.plan("qpu", problem)
    assert (plan["quadratic_terms"], plan["quadratic_min"], plan["quadratic_max"], plan["largest_degree"]) == (1, 15, 15, 1)


def test_qsf_holds_what_solvers_say(service):
    service(mock_qpu())
    answer = solve("qpu", DENSE)
    records = _records(answer, models.energies(DENSE, answer.bits))
    read = qsf.parse_qsf(qsf.pack_qsf(qsf.Samples(bytes(32), "qpu", records, answer.bits, answer.info)))
    assert read.info == answer.info and (read.records["occurrences"] == answer.occurrences).all()
    assert np.allclose(read.records["broken"] / qsf.BROKEN_UNITS, answer.broken, atol=1e-9)


def test_qsf_holds_halves_of_surrogate_pairs():
    data = qsf.pack_qsf(qsf.Samples(bytes(32), "qpu", np.empty(0, qsf.RECORD), np.empty((0, 1), np.uint8), {"chip": "\ud800"}))
    assert qsf.parse_qsf(data).info == {"chip": "?"}
