"""Terms, energies and models against the definition of H, state by state."""

import tracemalloc

import dimod
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from problems import (
    Table,
    Toeplitz,
    all_states,
    domain_walls,
    energy_by_definition,
    grid,
    least_of_potts,
    make,
    nothing,
    pack_qcf,
    random_problem,
)
from qstereo_bridge.core import merging, models
from qstereo_bridge.core.container import OverLimit

SEEDS = st.integers(0, 2**32 - 1)


def some_states(n, seed, count=16):
    return np.random.default_rng(seed).integers(0, 2, (count, n)).astype(np.uint8)


def evaluate(coefficients, bits):
    """The energies of the expanded coefficients, in exact integers."""
    linear, (rows, columns, values), offset = coefficients
    x = bits.astype(np.int64)
    return offset + x @ linear + (x[:, rows] * x[:, columns]) @ values


@pytest.fixture
def pieces(monkeypatch):
    """The terms in pieces of few."""
    monkeypatch.setattr(models, "CHUNK", 5)


@pytest.mark.usefixtures("pieces")
@pytest.mark.parametrize("start", range(0, 240, 40))
def test_energies_by_definition(start):
    for seed in range(start, start + 40):
        problem = random_problem(seed)
        bits = some_states(problem.linear.size, seed)
        expected = [energy_by_definition(problem, x) for x in bits.tolist()]
        assert evaluate(models.expand(problem), bits).tolist() == expected
        assert models.energies(problem, bits).tolist() == expected
        assert models.to_bqm(problem).energies((bits, range(bits.shape[1]))).tolist() == expected


@pytest.mark.usefixtures("pieces")
@pytest.mark.parametrize("start", range(0, 200, 100))
def test_terms_are_sorted_and_not_zero(start):
    for seed in range(start, start + 100):
        problem = random_problem(seed)
        for penalties in (False, True):
            _, (rows, columns, values), _ = models.expand(problem, penalties)
            key = rows.astype(np.int64) * problem.linear.size + columns
            assert (rows < columns).all() and (np.diff(key) > 0).all() and values.all()
            terms = models.Terms(problem, penalties)
            assert terms.repeated or terms.count == rows.size


def test_repeated_pairs_add_up_and_cancel():
    block = Table(np.array([[1, 2], [3, 4]], "<i4"))
    problem = make(
        [2, 2],
        [block],
        [
            {"weight": 2, "h": 1},
            {"weight": -2, "h": 1},
            {"form": 1, "width": 1, "count": 2, "pairs": [0, 1, 0, 1], "weights": [0, 1]},
        ],
        [0] * 4,
        [(0, 0)] * 2,
    )
    _, (rows, columns, values), _ = models.expand(problem)
    assert list(zip(rows.tolist(), columns.tolist(), values.tolist())) == [
        (0, 2, 1),
        (0, 3, 2),
        (1, 2, 3),
        (1, 3, 4),
    ]


def test_nothing():
    problem, none = nothing(-7), np.empty((3, 0), np.uint8)
    assert (
        models.energies(problem, none).tolist() == [-7] * 3 and models.feasible(problem, none).all()
    )
    assert models.to_bqm(problem).offset == -7 and not models.to_cqm(problem).constraints


@pytest.mark.parametrize("size", [(1, 1, 2), (2, 2, 2), (3, 1, 4), (2, 2, 4)])
def test_domain_walls(size):
    """Groups without a penalty, coupled with themselves: all is said in H."""
    problem, costs, edges = domain_walls(*size)
    assert models.energies(problem, all_states(problem.linear.size)).min() == least_of_potts(
        costs, edges
    )
    assert (
        models.feasible(problem, all_states(problem.linear.size)).all()
        and not models.to_cqm(problem).constraints
    )


def test_energies_of_large_numbers_are_exact():
    problem = make(
        [2, 1],
        [Table(np.array([[1], [1]], "<i4"))],
        [{"weight": 1, "h": 1}],
        [2**50, 1, -(2**51)],
        [(2**49, 2**50 + 1), (0, 0)],
        1,
    )
    states = all_states(3)
    assert models.energies(problem, states).tolist() == [
        energy_by_definition(problem, x) for x in states.tolist()
    ]


@settings(deadline=None, max_examples=60)
@given(SEEDS)
def test_cqm_is_h_on_feasible_states(seed):
    problem = random_problem(seed, variables=9)
    states = all_states(problem.linear.size)
    cqm, labels = models.to_cqm(problem), range(problem.linear.size)
    sound = models.feasible(problem, states)
    starts, one_hot = problem.starts, problem.one_hot
    by_definition = [
        all(x[starts[g] : starts[g + 1]].sum() == 1 for g in np.flatnonzero(one_hot))
        for x in states
    ]
    assert sound.tolist() == by_definition
    assert (
        cqm.objective.energies((states[sound], labels)) == models.energies(problem, states[sound])
    ).all()
    assert (
        cqm.objective.energies((states, labels))
        == models.energies(problem, states, penalties=False)
    ).all()
    assert [cqm.check_feasible(dict(enumerate(x))) for x in states.tolist()] == by_definition
    assert cqm.discrete == {g for g in np.flatnonzero(one_hot) if starts[g + 1] - starts[g] > 1}
    with cqm.to_file() as file:
        assert dimod.ConstrainedQuadraticModel.from_file(file).is_equal(cqm)


@settings(deadline=None)
@given(SEEDS, st.integers(1, 6), st.integers(1, 6))
def test_blocks(seed, rows, columns):
    rng = np.random.default_rng(seed)
    first = int(rng.integers(1 - rows, columns))
    values = rng.integers(-2, 3, int(rng.integers(1, columns - first + 1))).astype("<i4")
    toeplitz = Toeplitz((rows, columns), int(rng.integers(-1, 2)), first, values)
    entries = np.array([[toeplitz.entry(i, j) for j in range(columns)] for i in range(rows)], "<i4")
    for block in make(
        [rows, columns], [toeplitz, Table(entries)], [], np.zeros(rows + columns), [(0, 0)] * 2
    ).blocks:
        assert block.dtype == np.int32 and block.tolist() == entries.tolist()


def test_a_penaltys_energy_needs_no_pairs():
    n = 60_000
    problem = make([n, n], [], [], np.zeros(2 * n), [(1, 2)] * 2)
    tracemalloc.start()
    assert models.energies(problem, np.ones((1, 2 * n), np.uint8)).tolist() == [
        2 * (1 - n) + 2 * n * (n - 1)
    ]
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 50 << 20


def test_memory_limits():
    table = Table(np.ones((300, 300), "<i4"))
    small = make([300] * 2, [table], [{"weight": 1, "h": 1}], np.zeros(600), [(1, 1)] * 2)
    small.memory_limit = 1 << 20
    with pytest.raises(OverLimit, match="179,700 quadratic terms would need .* MiB, the limit is"):
        models.to_bqm(small)
    with pytest.raises(OverLimit, match="549,755,289,600 quadratic terms would need"):
        models.to_bqm(make([2**20], [], [], np.zeros(2**20), [(1, 1)]))
    with pytest.raises(OverLimit, match="blocks of 1,600,000,000 entries would need"):
        merging.descend(make([40_000], [], [], np.zeros(40_000), [(1, 1)]),
                        np.zeros((1, 40_000), np.uint8) + (np.arange(40_000) < 1))
    with pytest.raises(OverLimit, match="blocks of 1,099,511,627,776 entries would need"):
        make([2**20] * 2, [Toeplitz((2**20, 2**20), 1, 0, np.empty(0, "<i4"))],
             [{"weight": 1, "h": 1}], np.zeros(2**21), [(1, 1)] * 2)
