"""The solver ilp against all labellings, one by one; its bound, its time limit, its messages."""

import argparse
import itertools
import json
import math
import sys
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from problems import (
    altered,
    Table,
    Toeplitz,
    all_states,
    carrying,
    domain_walls,
    grid,
    least_of_potts,
    make,
    pack_qcf,
    random_problem,
)
from qstereo_bridge.samplers import ilp, solvers
from qstereo_bridge.core import models
from qstereo_bridge.core.container import OverLimit

SEEDS = st.integers(0, 2**32 - 1)


def solve(problem, time_limit=None):
    return ilp.ilp(problem, argparse.Namespace(time_limit=time_limit), lambda text: None)


def labellings(problem):
    """All states with one variable at 1 in each one-hot group: u8 array."""
    groups = []
    for size, hot in zip(problem.sizes.tolist(), problem.one_hot):
        groups.append(np.eye(size, dtype=np.uint8).tolist() if hot else all_states(size).tolist())
    return np.array([sum(parts, []) for parts in itertools.product(*groups)], np.uint8)


def least(problem):
    return int(models.energies(problem, labellings(problem)).min())


def check(problem, answer, optimum=None):
    """A labelling, its own energy, and a bound that is not above the optimum; with `optimum` given
    both are it.
    """
    assert (
        answer.bits.shape == (1, problem.linear.size)
        and models.feasible(problem, answer.bits).all()
    )
    assert (
        answer.objective
        and answer.energies.tolist() == models.energies(problem, answer.bits).tolist()
    )
    if optimum is not None:
        assert answer.energies[0] == answer.lower_bound == optimum


def sites(seed, most=5):
    """One-hot groups of 1 to 5 variables and free ones, every pair of groups coupled with the
    chance 1/2 by a table of any signs.
    """
    rng = np.random.default_rng(seed)
    sizes = rng.integers(1, 6, int(rng.integers(1, most + 1))).tolist()
    penalties = [(1, 1) if rng.random() < 0.8 else (0, 0) for _ in sizes]
    blocks, couplings = [], []
    for g, h in itertools.combinations_with_replacement(range(len(sizes)), 2):
        if rng.random() < 0.5 and not (g == h and any(penalties[g])):
            couplings.append(
                {"block": len(blocks), "weight": int(rng.choice([-1, 1, 2])), "g": g, "h": h}
            )
            blocks.append(
                Table(
                    (rng.integers(-4, 5, (sizes[g], sizes[h])) * rng.integers(0, 2)).astype("<i4")
                )
            )
    return make(
        sizes,
        blocks,
        couplings,
        rng.integers(-9, 10, sum(sizes)),
        penalties,
        int(rng.integers(-99, 99)),
    )


@settings(deadline=None, max_examples=150)
@given(SEEDS)
def test_least_of_all_labellings(seed):
    for problem in (random_problem(seed), sites(seed)):
        check(problem, solve(problem), least(problem))


@settings(deadline=None, max_examples=60)
@given(SEEDS)
def test_bound_without_time(seed):
    for problem in (random_problem(seed), sites(seed)):
        answer, optimum = solve(problem, 1e-6), least(problem)
        check(problem, answer)
        assert answer.lower_bound <= optimum <= answer.energies[0]
        assert answer.info["open_components"] or answer.lower_bound == answer.energies[0]


def least_of_each_alone(problem):
    """What H is at least if every site and every coupling costs its least."""

    def of_block(values, both_hot):
        return int(values.min() if both_hot else np.minimum(values, 0).sum())

    total, hot = problem.offset, problem.one_hot
    for group, values in enumerate(np.split(problem.linear, problem.starts[1:-1])):
        total += of_block(values, hot[group])
    for g, h, block, weight in problem.couplings.T.tolist():
        table = weight * problem.blocks[block].astype(int)
        total += of_block(np.triu(table, 1) if g == h else table, hot[g] and hot[h])
    return total


@settings(deadline=None, max_examples=60)
@given(SEEDS)
def test_bound_without_time_is_no_worse_than_what_the_file_says(seed):
    for problem in (random_problem(seed), sites(seed)):
        assert solve(problem, 1e-6).lower_bound >= least_of_each_alone(problem)


def test_bound_without_time_of_large_tables():
    """Quadratic costs: each pair of labels costs, but one alone of all pairs."""
    label = np.arange(8)
    problem = altered(grid(6, 6, 8, dense=True), blocks=[
        Table(((label - label[:, None])**2).astype("<i4"))])
    assert solve(problem, 1e-6).lower_bound >= least_of_each_alone(problem) >= problem.offset


@settings(deadline=None, max_examples=60)
@given(SEEDS)
def test_form_is_h_on_labellings(seed):
    problem = sites(seed, 4)
    form, states = ilp.Labelling(problem), labellings(problem)
    every = np.zeros(form.unary.shape[0], int)
    energies = [form.energies(form.labels(bits), every)[0] for bits in states]
    assert (form.offset + np.array(energies) == models.energies(problem, states)).all()
    form.unary, form.tables = form.reduced, form.rest
    assert energies == [form.energies(form.labels(bits), every)[0] for bits in states]
    assert all((form.bits(form.labels(bits)) == bits).all() for bits in states)
    assert (form.rest <= 0).all() and form.rest.any((1, 2)).all()


def test_plain_qubo_is_as_exact_says():
    rng = np.random.default_rng(1)
    table = Table(rng.integers(-9, 10, (14, 14)).astype("<i4"))
    problem = make([14], [table], [{"weight": 1}], rng.integers(-20, 21, 14), [(0, 0)], 5)
    check(
        problem,
        solve(problem),
        solvers.exact(problem, None, None).lower_bound,
    )


@pytest.mark.parametrize("size", [(2, 2, 3), (6, 5, 4), (3, 7, 2), (9, 8, 5)])
def test_dense_is_as_sparse(size):
    """The dense form of Potts becomes the sparse one: a product for each label of each edge."""
    dense, sparse = grid(*size, dense=True), grid(*size)
    one, other = solve(dense), solve(sparse)
    check(dense, one, other.lower_bound)
    check(sparse, other, one.lower_bound)
    rests = [ilp.Labelling(problem).rest for problem in (dense, sparse)]
    width, height, labels = size
    edges = (width - 1) * height + width * (height - 1)
    assert [np.count_nonzero(rest) for rest in rests] == [edges * labels] * 2
    assert all(((rest == 0) | (rest == -20)).all() for rest in rests)


@pytest.mark.parametrize(
    "table, products",
    [
        ([[-5, -5, -5]] * 3, 0),
        ([[7, 7, 7]] * 3, 0),
        ([[1, 2, 3]] * 3, 0),
        ([[1, 1, 1], [2, 2, 2], [9, 9, 9]], 0),
        ([[0, 0, 0], [1, 2, 3], [0, 0, 0]], 2),
        ([[0, 1, 0], [0, 2, 0], [0, 3, 0]], 2),
        ([[-4, 0, 0], [0, -5, 0], [0, 0, 0]], 2),
        ([[5, 4, 4], [0, 0, 0], [0, 0, 0]], 2),
    ],
)
def test_blocks_of_one_hot_groups(table, products):
    """Unary parts leave, and rows or columns first, whichever leaves fewer products."""
    for entries in (np.array(table, "<i4"), np.array(table, "<i4").T):
        problem = make(
            [3, 3], [Table(entries)], [{"weight": 1, "h": 1}], [4, 0, 1, 0, 3, 1], [(1, 1)] * 2
        )
        assert np.count_nonzero(ilp.Labelling(problem).rest) == products
        check(problem, solve(problem), least(problem))


@pytest.mark.parametrize("size", [(1, 1, 2), (4, 2, 2), (2, 2, 6), (3, 2, 4)])
def test_domain_walls(size):
    problem, costs, edges = domain_walls(*size)
    check(problem, solve(problem), least_of_potts(costs, edges))


def test_repeated_couplings():
    block = Table(np.array([[0, -3, 1], [2, 0, -1], [1, 1, 0]], "<i4"))
    for penalty in ((1, 1), (0, 0)):
        problem = make(
            [3, 3],
            [block],
            [{"weight": 2, "h": 1}, {"weight": -1, "h": 1}, {"weight": 1, "h": 1}],
            range(6),
            [penalty] * 2,
        )
        check(problem, solve(problem), least(problem))


def beside(*problems):
    """The problems, each of one block or none, as one."""
    couplings, groups, raws = [], 0, [problem.raw for problem in problems]
    for raw in raws:
        couplings += [
            {**run, "g": run["g"] + groups, "h": run["h"] + groups} for run in raw.couplings
        ]
        groups += len(raw.sizes)
    return make(
        sum((raw.sizes for raw in raws), []),
        raws[0].blocks,
        couplings,
        np.concatenate([raw.linear for raw in raws]),
        sum((raw.penalties for raw in raws), []),
        sum(raw.offset for raw in raws),
    )


def test_components(monkeypatch):
    """Each is a program of its own, from the smallest on; sites without neighbours need none, nor
    does a pair."""
    parts = [
        grid(3, 3, 3, seed=1),
        grid(1, 1, 3, seed=2),
        grid(2, 4, 3, seed=3),
        grid(1, 1, 3, seed=4),
        grid(1, 2, 3, seed=5),
    ]
    problem = beside(*parts)
    answer = solve(problem)
    check(problem, answer, sum(least(part) for part in parts))
    assert answer.info["components"] == 3 and answer.info["open_components"] == 0
    # After one pass the others are left to HiGHS.
    monkeypatch.setattr(ilp, "PASSES", 1)
    sizes, program = [], ilp.program
    monkeypatch.setattr(ilp, "program", lambda p, sites, *rest: (
        sizes.append(sites.size), program(p, sites, *rest))[1])
    assert solve(problem).lower_bound == answer.lower_bound and sizes == [8, 9]
    alone = solve(beside(*[grid(1, 1, 3, seed=k) for k in range(4)]))
    assert alone.info["components"] == 0 and alone.lower_bound == sum(
        least(grid(1, 1, 3, seed=k)) for k in range(4)
    )


def test_common_factors():
    """In units of the common factor the gap of less than 1 is wide, and the doubles are small."""
    problem, factor = grid(9, 8, 5), 10**8
    runs = [{**run, "weight": run["weight"] * factor} for run in problem.raw.couplings]
    large = altered(
        problem, couplings=runs, linear=problem.linear * factor, offset=problem.offset * factor
    )
    check(large, solve(large), solve(problem).lower_bound * factor)


@pytest.mark.parametrize("bits", [20, 30, 40, 43])
def test_bound_of_large_coefficients_is_never_too_high(bits):
    """Where doubles cannot tell units apart, less is claimed."""
    rng = np.random.default_rng(bits)
    for seed in range(20):
        problem = random_problem(seed, 10)
        problem = altered(problem, linear=rng.integers(-(2**bits), 2**bits, problem.linear.size))
        answer, optimum = solve(problem), least(problem)
        check(problem, answer, optimum if bits == 20 else None)
        assert answer.lower_bound <= optimum <= answer.energies[0]


@pytest.mark.parametrize(
    "costs, best, told, low",
    [
        ([3, 5, -7], 0, -3.5, -3),  # between two energies: the one above it
        ([3, 5, -7], 0, -3 + 1e-7, -3),  # by no more than HiGHS takes for 0 in three columns
        ([3, 5, -7], 0, -3 + 1e-6, -2),
        ([30, 50, -70], 0, -3.5, -30),  # in units of the common factor
        ([2**43, 2**43 - 1, -(2**43)], 0, -(2**42) + 2.0, -(2**42) - 22),  # sums of 3 x 2^43
        ([3, 5, -7], 0, -20.0, -15),  # what was known before is not given up
        ([3, 5, -7], 0, np.inf, -15),  # nothing is proven
    ],
)
def test_bound_is_what_is_told_without_rounding(costs, best, told, low, monkeypatch):
    """A bound of HiGHS is wrong by its tolerance and by the rounding of doubles."""
    found = argparse.Namespace(status=1, mip_dual_bound=told, fun=None, x=None, message="")
    monkeypatch.setattr(ilp, "milp", lambda *arguments, **options: found)
    least = -(2**50) if max(costs) > 10 else -15
    values, bound = ilp.solve(np.array(costs), 3, None, best, least, 1.0)
    assert values is None and bound == low


def test_gap_is_below_what_bounds_may_be_wrong(monkeypatch):
    """Nothing better than the best by one unit is left out, nor are answers better than what is
    claimed: of a solution, all that is within the gap may have been left out."""
    for told in (-8.0, -3.0):  # one that is above its own solution is none
        asked = {}

        def solved(cost, options, **rest):
            asked.update(options)
            return argparse.Namespace(status=0, mip_dual_bound=told, fun=-8.0, message="",
                                      x=np.array([0.0, 0.0, 1.0 - 1e-9]))
        monkeypatch.setattr(ilp, "milp", solved)
        values, bound = ilp.solve(np.array([3, 5, -8]), 3, None, -8, -40, 1.0)
        assert values.tolist() == [0, 0, 1] and bound == -8
        assert 0.9 < asked["mip_rel_gap"] * 40 < 1


def test_a_bad_solution_proves_little(monkeypatch):
    """HiGHS's gap is a share of its own solution: of one that is far above the best known, all
    labellings down to the bound may be left out."""
    found = argparse.Namespace(status=0, mip_dual_bound=100.0, fun=100.0, message="",
                               x=np.array([0.0, 0.0, 1.0]))
    monkeypatch.setattr(ilp, "milp", lambda *arguments, **options: found)
    for best, least in ((1, 0), (-1, -2), (2, 0), (50, 49)):
        values, bound = ilp.solve(np.array([3, 5, 100]), 3, None, best, least, 1.0)
        assert values.tolist() == [0, 0, 1] and least <= bound <= 100 - math.floor(
            100 / max(abs(best), abs(least))) + 1


def dearest(costs, count, rules):
    """The values of the labelling of the label of each site that costs most by itself."""
    values = np.zeros(count, int)
    for row in rules.A.toarray()[rules.lb == 1, :count]:
        labels = np.flatnonzero(row)
        values[labels[np.argmax(costs[labels])]] = 1
    return values


@pytest.mark.parametrize("wrong", [[1, 1, 1, 0], [0, 0, 0, 0], "dearest", None])
def test_what_the_search_finds_is_checked(wrong, monkeypatch):
    """A state that is no labelling is not taken, though its H without penalties be less; nor is a
    worse labelling.
    """
    problem = altered(grid(4, 4, 4), linear=np.tile([0, 0, 0, 500], 16) + np.arange(64) % 3)
    expected, answers = solve(problem), []
    monkeypatch.setattr(ilp, "PASSES", 1)
    for found in (None, wrong):
        monkeypatch.setattr(ilp, "solve", lambda costs, count, rules, best, low, seconds: (
            None if found is None else dearest(costs, count, rules) if found == "dearest" else
            np.resize(found, count), low))
        answers.append(solve(problem))
    nothing_found, answer = answers
    check(problem, answer)
    assert answer.energies == nothing_found.energies
    assert (
        answer.lower_bound < expected.lower_bound <= answer.energies[0]
        and answer.info["open_components"] == 1
    )


def test_no_program_is_begun_out_of_time(monkeypatch):
    monkeypatch.setattr(ilp, "solve", None)
    check(grid(4, 4, 4), solve(grid(4, 4, 4), 1e-6))


@pytest.mark.parametrize("step", ["Labelling", "beliefs", "program", "milp"])
def test_no_step_is_waited_for_beyond_the_limit(step, monkeypatch):
    """Whatever is under way at the limit: a labelling, and what is proven until then."""
    held, problem = threading.Event(), grid(4, 4, 4)
    optimum = solve(problem).lower_bound
    monkeypatch.setattr(ilp, step, lambda *arguments, **options: held.wait())
    answer = solve(problem, 1e-3)
    check(problem, answer)
    assert (answer.lower_bound is None) == (step in ("Labelling", "beliefs"))
    assert answer.lower_bound is None or answer.lower_bound <= optimum
    held.set()


@pytest.mark.parametrize("seed", range(3))
def test_bound_of_beliefs_is_not_too_high(seed, monkeypatch):
    """Of one site alone beliefs tell the least energy, which is then known at any time."""
    held, problem = threading.Event(), grid(1, 1, 3, seed=seed)
    monkeypatch.setattr(ilp.models, "components", lambda *arguments: held.wait())
    assert solve(problem, 1e-3).lower_bound == least(problem)
    held.set()


def test_what_is_left_at_the_limit_is_a_local_minimum(monkeypatch):
    monkeypatch.setattr(ilp, "solve", lambda costs, count, rules, best, low, seconds: (None, low))
    for problem in (grid(6, 6, 5), sites(3), sites(4), random_problem(5)):
        x = solve(problem).bits[0]
        before, starts = models.energies(problem, x[None])[0], problem.starts.tolist()
        assert models.feasible(problem, x[None]).all()
        for low, high, hot in zip(starts, starts[1:], problem.one_hot):
            others = np.repeat(x[None], high - low, axis=0)
            if hot:
                others[:, low:high] = np.eye(high - low, dtype=np.uint8)
            else:
                others[np.arange(high - low), np.arange(low, high)] ^= 1
            assert (models.energies(problem, others) >= before).all()


def test_walls_are_labels(tmp_path, main, monkeypatch):
    """A file of domain walls: with HiGHS the optimum, without it a bound above that of all sites
    alone, whatever holds the walls together."""
    plain, costs, edges = domain_walls(4, 2, 3)
    problem = altered(plain, sides=carrying(3, 3, [0] * 8))
    answer = solve(problem)
    check(problem, answer, least_of_potts(costs, edges))
    ones = answer.bits.reshape(8, 2)
    assert (ones[:, 0] >= ones[:, 1]).all()
    assert "(proven best of all labellings)" in main(*write(tmp_path, problem))[1]
    monkeypatch.setattr(ilp, "solve", lambda costs, count, rules, best, low, seconds: (None, low))
    assert costs.min(1).sum() < solve(problem).lower_bound <= least_of_potts(costs, edges)


def test_programs_say_what_they_need():
    table = Toeplitz((3000, 3000), 0, 0, np.array([1], "<i4"))
    for problem, limit, what in (
        (grid(30, 30, 8), 10 << 20, "an integer program of [0-9,]+ entries"),
        (
            make([3000] * 2, [table], [{"weight": 1, "h": 1}], np.zeros(6000), [(1, 1)] * 2),
            200 << 20,
            "tables of 9,000,000 costs",
        ),
    ):
        problem.memory_limit = limit
        with pytest.raises(OverLimit, match=f"{what} would need"):
            solve(problem)


def write(folder, problem):
    (folder / "p.qcf").write_bytes(pack_qcf(problem))
    return "solve", folder / "p.qcf", "-o", folder / "s.qsf", "--solver", "ilp"


def test_command(tmp_path, main):
    command = write(tmp_path, grid(4, 4, 4))
    found = json.loads(main(*command, "--json")[1])
    assert (
        found.keys()
        == json.loads(main(*command[:-1], "anneal", "--json", "--num-reads", 1)[1]).keys()
    )
    assert (
        found["proven_optimal"] and found["gap"] == 0 and found["samples"] == found["feasible"] == 1
    )
    assert found["energy"] == found["lower_bound"] == found["best_energy"]
    status, out, err = main(*command)
    assert (status, err) == (0, "") and "(proven optimal)" in out


def test_command_out_of_time(tmp_path, main):
    """In real units, of which the file's are the half."""
    labl = bytes(16) + (2).to_bytes(4, "little") + bytes(44)
    problem = altered(grid(6, 6, 5), sides=[("labl", labl)])
    optimum = solve(problem).lower_bound / 2
    found = json.loads(main(*write(tmp_path, problem), "--time-limit", 1e-6, "--json")[1])
    assert (
        not found["proven_optimal"]
        and found["lower_bound"] < optimum <= found["energy"] == found["best_energy"]
    )
    assert found["gap"] == found["energy"] - found["lower_bound"]
    status, out, _ = main(*write(tmp_path, problem), "--time-limit", 1e-6)
    assert status == 0 and f"(at most {found['gap']:g} above the least)" in out


def test_penalty_too_small(tmp_path, main):
    """What it proves is of the labellings; H may be less where there is none."""
    problem = make([2], [], [], [-5, -6], [(1, 0)])
    found = json.loads(main(*write(tmp_path, problem), "--json")[1])
    assert found["proven_optimal"] and found["energy"] == -6
    assert json.loads(main(*write(tmp_path, problem)[:-1], "exact", "--json")[1])["energy"] < -6


def test_without_scipy(tmp_path, main, monkeypatch):
    monkeypatch.delitem(sys.modules, "qstereo_bridge.samplers.ilp")
    monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    status, out, err = main(*write(tmp_path, grid(2, 2, 3)))
    assert (
        (status, out) == (5, "")
        and "pip install './bridge[exact]'" in err
        and err.count("\n") == 1
    )
    assert not (tmp_path / "s.qsf").exists()


def test_highs_fails(tmp_path, main, monkeypatch):
    monkeypatch.setattr(
        ilp,
        "milp",
        lambda *arguments, **options: argparse.Namespace(status=4, message="Solve error"),
    )
    status, _, err = main(*write(tmp_path, grid(4, 4, 4)))
    assert status == 5 and "HiGHS fails (Solve error)" in err


def test_no_worse_than_what_the_file_carries():
    """Even without time: in each program the better one of what descent and the file know."""
    problem = domain_walls(8, 6, 3, seed=3)[0]
    told = solve(problem)
    problem.known = told.bits[0]
    hurried = solve(problem, time_limit=1e-9)
    assert models.energies(problem, hurried.bits) == told.lower_bound
    # A worse one does not hurt.
    problem.known = np.zeros(problem.linear.size, np.uint8)
    check(problem, solve(problem), told.lower_bound)


@settings(max_examples=30, deadline=None)
@given(SEEDS)
def test_any_state_that_is_known(seed):
    problem = random_problem(seed)
    states = labellings(problem)
    problem.known = states[seed % len(states)]
    check(problem, solve(problem), least(problem))
    hurried = solve(problem, time_limit=1e-9)
    assert models.energies(problem, hurried.bits) <= models.energies(problem, problem.known[None])
