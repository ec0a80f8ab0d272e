"""Descent and merging: against all combinations, exactly, and in the command's files."""

import dataclasses
import json

import networkx as nx
import numpy as np
import pytest
import qstereo_bridge as qb
from hypothesis import assume, given
from hypothesis import strategies as st
from problems import all_states, domain_walls, energy_by_definition, grid, pack_qcf, random_problem
from qstereo_bridge.core import merging, models
from qstereo_bridge.samplers import windows
from qstereo_bridge.core.container import OverLimit
from qstereo_bridge.core.problem import made

SMALL = grid(2, 3, 3)
seeds = st.integers(0, 10**6)


def states(problem, seed, count=2, feasible=False):
    """Random states; where asked, with one variable of each one-hot group at 1."""
    rng = np.random.default_rng(seed)
    bits = rng.integers(0, 2, (count, problem.linear.size)).astype(np.uint8)
    for g in np.flatnonzero(problem.one_hot) if feasible else ():
        group = slice(*problem.starts[g:g + 2])
        bits[:, group] = np.eye(problem.sizes[g], dtype=np.uint8)[
            rng.integers(0, problem.sizes[g], count)]
    return bits


def components(problem, differ):
    """The components of the variables `differ`, from H alone: a list of sets."""
    n = problem.linear.size
    group = problem.of_variables(np.arange(problem.sizes.size))

    def h(*ones):
        return energy_by_definition(problem, np.isin(np.arange(n), ones))
    parts = [{i} for i in differ]
    for i in differ:
        for j in differ:
            same = group[i] == group[j] and problem.one_hot[group[i]]
            if i < j and (same or h(i, j) - h(i) - h(j) + h() != 0):
                one, other = (next(part for part in parts if k in part) for k in (i, j))
                if one is not other:
                    parts.remove(other)
                    one |= other
    return parts


@given(seeds)
def test_merging_takes_the_best_of_all_combinations(seed):
    problem = random_problem(seed, 9)
    x, y = states(problem, seed, feasible=True)
    merger = merging.Merger(problem, x)
    # Couplings that cancel still count as couplings there.
    assume(not merger.terms.repeated)
    took = merger.merge(y)
    parts = components(problem, np.flatnonzero(x != y).tolist())
    found = []
    for chosen in all_states(len(parts)) if parts else [()]:
        mixed = x.copy()
        for part in (part for part, taken in zip(parts, chosen) if taken):
            mixed[list(part)] = y[list(part)]
        found.append(energy_by_definition(problem, mixed))
    assert energy_by_definition(problem, merger.bits[0]) == min(found)
    assert took == (min(found) < energy_by_definition(problem, x))
    assert models.feasible(problem, merger.bits)[0]


@given(seeds)
def test_fields_follow_what_is_taken(seed):
    """Three states in turn: what is merged first changes what the others offer."""
    problem = random_problem(seed, 12)
    bits = states(problem, seed, 4)
    merger = merging.Merger(problem, bits[0])
    for other in bits[1:]:
        before = models.energies(problem, merger.bits)[0]
        took = merger.merge(other)
        assert (models.energies(problem, merger.bits)[0] < before) == took
    fresh = merging.States(problem, merger.bits)
    assert (fresh.fields == merger.fields).all()


@given(seeds, st.booleans())
def test_descent_ends_in_local_minima(seed, feasible):
    problem = random_problem(seed, 10)
    bits = states(problem, seed, 5, feasible)
    found = merging.descend(problem, bits)
    energies, sound = models.energies(problem, found), models.feasible(problem, found)
    assert (energies <= models.energies(problem, bits)).all()
    assert sound[models.feasible(problem, bits)].all()
    group = problem.of_variables(np.arange(problem.sizes.size))
    for state, energy in zip(found, energies):
        for i in range(state.size):
            inside = group == group[i]
            exchange = problem.one_hot[group[i]] and state[inside].sum() == 1
            moved = np.where(inside, 0, state) if exchange else state.copy()
            moved[i] = 1 if exchange else 1 - moved[i]
            assert energy_by_definition(problem, moved) >= energy


@given(seeds, st.booleans())
def test_the_result_is_at_least_as_good_as_every_read(seed, feasible):
    problem = random_problem(seed, 10)
    bits = states(problem, seed, 6, feasible)
    found = merging.merged(problem, bits)[None]
    sound = models.feasible(problem, bits)
    energies = models.energies(problem, bits)
    if sound.any():
        assert models.feasible(problem, found)[0]
        energies = energies[sound]
    if sound.any() or not models.feasible(problem, found)[0]:
        assert models.energies(problem, found)[0] <= energies.min()


@given(seeds)
def test_no_region_gains_by_the_label_of_a_neighbour(seed):
    problem = grid(4, 4, 3, seed=seed)
    bits = merging.merged(problem, states(problem, seed, 1, True))
    labels = bits.reshape(16, 3).argmax(axis=1)
    neighbours = nx.Graph(problem.edges.T.tolist())
    for old in range(3):
        for region in nx.connected_components(neighbours.subgraph(
                np.flatnonzero(labels == old).tolist())):
            for new in {labels[q] for p in region for q in neighbours[p]} - {old}:
                moved = labels.copy()
                moved[list(region)] = new
                assert energy_by_definition(problem, np.eye(3, dtype=np.uint8)[moved].ravel()) >= (
                    energy_by_definition(problem, bits))


def test_a_region_that_all_reads_have_wrong_is_mended():
    """A stripe of the dearer label, which no site leaves with a gain by itself."""
    problem = grid(9, 9, 2)
    problem = dataclasses.replace(problem, linear=np.tile([0, 12], 81).astype(problem.linear.dtype))
    labels = np.zeros((9, 9), int)
    labels[3:6] = 1
    read = np.eye(2, dtype=np.uint8)[labels].reshape(1, -1)
    assert (merging.descend(problem, read) == read).all()
    assert (merging.merged(problem, read).reshape(81, 2) == [1, 0]).all()


def test_merging_says_what_memory_it_needs():
    """In windows, too: what a call answers is merged into the state known."""
    problem = made(grid(30, 30, 8))
    problem.memory_limit = 10 << 20
    bits = np.tile(windows.begin(problem), (100, 1))
    for merge in (lambda: merging.merged(problem, bits), lambda: windows.improved(
            problem, bits[0], np.arange(bits.shape[1]), bits)):
        with pytest.raises(OverLimit, match="descent of 10[01] samples of 7,200 variables"):
            merge()


def test_domain_walls_are_merged_to_the_optimum():
    problem = domain_walls(4, 3, 2, seed=3)[0]
    least = models.energies(problem, all_states(12)).min()
    found = merging.merged(problem, states(problem, 1, 40))
    assert models.energies(problem, found[None])[0] == least


@pytest.fixture
def files(tmp_path):
    """A problem, and two samples files of it."""
    path = tmp_path / "p.qcf"
    path.write_bytes(pack_qcf(SMALL))
    p = qb.load(path)
    for name, seed in (("a", 1), ("b", 2)):
        bits = states(SMALL, seed, 8, True)
        records = np.zeros(8, merging.RECORD)
        records["energy"], records["occurrences"] = models.energies(SMALL, bits), 1
        records["broken"] = merging.NO_CHAINS
        qb.Samples(p.digest, "by hand", records, bits).save(tmp_path / f"{name}.qsf")
    return p, path, tmp_path / "a.qsf", tmp_path / "b.qsf"


def test_reads_and_result_stay_apart(files):
    p, _, *names = files
    one, other = map(qb.load_samples, names)
    found = qb.merge(p, one, other)
    told = found.info["result"]
    assert told == {"reads": 16, "sample": 16} and found.records.size == 17
    assert (found.bits[:16] == np.append(one.bits, other.bits, axis=0)).all()
    assert found.records["energy"][16] == p.energies(found.bits[16])[0]
    assert found.records["energy"][16] < found.records["energy"][:16].min()
    again = qb.merge(p, found)
    assert again.info["result"] == {"reads": 17, "sample": 16} and again.records.size == 17


def test_merge_refuses_other_problems(files, tmp_path):
    p, _, name, _ = files
    samples = qb.load_samples(name)
    samples.digest = bytes(32)
    with pytest.raises(qb.InputError, match="another problem"):
        qb.merge(p, samples)
    with pytest.raises(qb.InputError, match="give samples"):
        qb.merge(p)


def test_the_command_merges(files, tmp_path, main):
    p, path, *names = files
    status, out, err = main("merge", path, *names, "-o", tmp_path / "m.qsf", "--json")
    found = qb.load_samples(tmp_path / "m.qsf")
    assert status == 0 and not err and json.loads(out)["samples"] == 17
    assert json.loads(out)["best_energy"] == found.records["energy"][16] / p.scale
    assert main("merge", path, *names, "-o", names[0])[0] == 2
    assert main("merge", path, path, "-o", tmp_path / "n.qsf")[0] == 3
    assert not (tmp_path / "n.qsf").exists()


def test_every_solver_is_followed_by_merging(tmp_path, main):
    path, out = tmp_path / "p.qcf", tmp_path / "s.qsf"
    path.write_bytes(pack_qcf(grid(6, 6, 4)))
    few = ["--num-reads", 6, "--num-sweeps", 3, "--seed", 1]
    assert main("solve", path, "-o", out, *few, "--no-postprocess")[0] == 0
    raw = qb.load_samples(out)
    assert raw.records.size == 6 and "result" not in raw.info
    assert main("solve", path, "-o", out, *few)[0] == 0
    found = qb.load_samples(out)
    assert found.info["result"] == {"reads": 6, "sample": 6}
    assert (found.bits[:6] == raw.bits).all()
    assert found.records["energy"][6] < raw.records["energy"].min()
