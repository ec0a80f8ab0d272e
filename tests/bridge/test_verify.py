"""Certificates checked by numpy: of tiny problems beside all labellings, and tampered ones."""

import io
import itertools
import json
import struct
from hashlib import sha256

import numpy as np
import pytest
from problems import altered, grid, pack_qcf
from qstereo_bridge import certificate as qpf
from qstereo_bridge import container, qcf, qsf
from qstereo_bridge.verify import verify

SCALE = 4


def problem_of(rng, width, height, labels):
    """A .qcf of a grid of random costs, Potts with weight 3, and its bytes."""
    labl = struct.pack(
        "<16I", 2, 0, 0, labels, 1, 0, 1, 3, width, height, width, height, 0, 0, 0, 0
    )
    found = altered(
        grid(width, height, labels, weight=3),
        sides=[("labl", labl)],
        linear=rng.integers(0, 9, width * height * labels),
    )
    return found, pack_qcf(found)


def costs_of(made, labels):
    """(sites, labels) of unary costs; (pairs, weight, block) of edges, from the file's numbers."""
    g, h, block, weight = made.couplings.tolist()
    return made.linear.reshape(-1, labels), list(zip(g, h, weight)), made.blocks[0]


def energy(made, labels, labelling):
    unary, edges, table = costs_of(made, labels)
    return (
        made.offset
        + sum(unary[p, d] for p, d in enumerate(labelling))
        + sum(w * table[labelling[g], labelling[h]] for g, h, w in edges)
    )


def chain_least(unary, edges, table, labels):
    """The least cost of the problem that these shares and edges make, by all labellings."""
    return min(
        sum(unary[p][d] for p, d in enumerate(w))
        + sum(SCALE * weight * table[w[g], w[h]] for g, h, weight in edges)
        for w in itertools.product(range(labels), repeat=len(unary))
    )


def split_of(made, width, labels, rng):
    """A stage with random shares of the rows, and the bound that it proves, by all labellings of
    rows and columns."""
    unary, edges, table = costs_of(made, labels)
    rows = [edge for edge in edges if edge[1] == edge[0] + 1 and edge[1] % width]
    columns = [edge for edge in edges if edge not in rows]
    share = SCALE * unary // 2 + rng.integers(-3, 4, unary.shape)
    least = chain_least(share, rows, table, labels) + chain_least(
        SCALE * unary - share, columns, table, labels
    )
    slots = bytes(slot for edge in edges for slot in 2 * [int(edge in columns)])
    return (
        struct.pack("<IIII", 1, SCALE, 1, 4) + slots + share.astype("<i4").tobytes(),
        made.offset + -(-int(least) // SCALE),
    )


def packed(data, labelling, stages, bound, found):
    """The bytes of a .qpf of one stage."""
    return container.pack(
        qpf.MAGIC,
        qpf.FIELDS.pack(len(labelling), 1, bound, found, bytes(12)),
        [
            ("PROB", sha256(data).digest()),
            ("BEST", struct.pack("<I", 1) + bytes(labelling)),
            ("STGS", stages),
        ],
    )


def answered(made, data, labels, labelling):
    """The bytes of a .qsf of one labelling."""
    bits = (np.array(labelling)[:, None] == np.arange(labels)).reshape(1, -1).astype(np.uint8)
    records = np.array([(energy(made, labels, labelling), 1, qsf.NO_CHAINS)], qsf.RECORD)
    return qsf.pack_qsf(qsf.Samples(sha256(data).digest(), "test", records, bits))


def check(data, samples, certificate):
    return verify(io.BytesIO(data), io.BytesIO(samples), io.BytesIO(certificate))


@pytest.fixture
def made():
    """A problem, its samples, a stage and the bound of it, and the best labelling."""
    rng = np.random.default_rng(1)
    problem, data = problem_of(rng, 2, 2, 3)
    best = min(itertools.product(range(3), repeat=4), key=lambda w: energy(problem, 3, w))
    stages, bound = split_of(problem, 2, 3, rng)
    return problem, data, answered(problem, data, 3, best), stages, bound, best


@pytest.mark.parametrize("seed", range(12))
def test_the_bound_is_that_of_all_labellings_of_rows_and_columns(seed):
    rng = np.random.default_rng(seed)
    problem, data = problem_of(rng, 3, 2, 2 + seed % 2)
    labels = 2 + seed % 2
    best = min(itertools.product(range(labels), repeat=6), key=lambda w: energy(problem, labels, w))
    stages, bound = split_of(problem, 3, labels, rng)
    found, samples = energy(problem, labels, best), answered(problem, data, labels, best)
    assert bound <= found
    verdict = check(data, samples, packed(data, best, stages, bound, found))
    assert (verdict.valid, verdict.energy, verdict.lower_bound) == (True, found, bound)
    verdict = check(data, samples, packed(data, best, stages, bound + 1, found))
    assert not verdict.valid and "higher bound" in verdict.why


def test_energies_that_are_not_so(made):
    problem, data, samples, stages, bound, best = made
    found = energy(problem, 3, best)
    for wrong in (found - 1, found + 1):
        verdict = check(data, samples, packed(data, best, stages, bound, wrong))
        assert not verdict.valid and "another energy" in verdict.why
    worse = max(itertools.product(range(3), repeat=4), key=lambda w: energy(problem, 3, w))
    verdict = check(
        data, answered(problem, data, 3, worse), packed(data, best, stages, bound, found)
    )
    assert not verdict.valid and "best sample costs more" in verdict.why


def test_of_another_problem(made):
    problem, data, samples, stages, bound, best = made
    other = packed(data + b"x", best, stages, bound, energy(problem, 3, best))
    assert "another problem" in check(data, samples, other).why


def test_every_cut_and_every_flipped_bit_is_refused(made):
    problem, data, samples, stages, bound, best = made
    whole = packed(data, best, stages, bound, energy(problem, 3, best))
    for size in range(len(whole)):
        with pytest.raises(container.FormatError):
            qpf.parse_qpf(whole[:size])
    for bit in range(8 * len(whole)):
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << bit % 8
        with pytest.raises(container.FormatError):
            qpf.parse_qpf(bytes(changed))


def test_malformed_stages(made):
    problem, data, samples, stages, bound, best = made
    heads = [(0, 0, 0, 0), (4, 0, 0, 0), (1, 0, 1, 4), (1, 2**31, 1, 4), (1, 4, 3, 4), (2, 4, 0, 0)]
    wrong = [struct.pack("<IIII", *head) + stages[16:] for head in heads]
    wrong += [
        stages[:-1],
        stages + b"\0",
        stages[:16] + b"\x09" + stages[17:],
        stages[:16] + b"\0" * 8 + stages[24:],
    ]
    for proof in wrong:
        with pytest.raises(container.FormatError):
            check(data, samples, packed(data, best, proof, bound, energy(problem, 3, best)))


def test_a_label_that_leaves_must_be_ruled_out(made):
    problem, data, samples, stages, bound, best = made
    found = energy(problem, 3, best)
    without = bytes(7 & ~(1 << label) for label in best)
    proof = struct.pack("<IIII", 3, *struct.unpack_from("<III", stages, 4)) + stages[16:]
    verdict = check(data, samples, packed(data, best, proof + bytes(best) + without, bound, found))
    assert not verdict.valid and "does not rule out" in verdict.why
    verdict = check(
        data, samples, packed(data, best, proof + bytes(best) + b"\7" * 4, bound, found)
    )
    assert verdict.valid


def part_of(problem, order, least):
    """A stage of one part: all sites, in an order."""
    value = least - problem.offset
    return struct.pack("<IIIIIq5I", 4, 0, 0, 0, len(order), value, *order, 0)


@pytest.mark.parametrize("order", list(itertools.permutations(range(4))))
def test_a_part_is_solved_in_any_order(made, order):
    problem, data, samples, _, _, best = made
    least = energy(problem, 3, best)
    verdict = check(data, samples, packed(data, best, part_of(problem, order, least), least, least))
    assert verdict.valid and verdict.lower_bound == least
    for wrong in (least - 1, least + 1):
        proof = packed(data, best, part_of(problem, order, wrong), least, least)
        assert "another least energy" in check(data, samples, proof).why
    proof = packed(data, best, part_of(problem, order, least), least + 1, least)
    assert "higher bound" in check(data, samples, proof).why


@pytest.mark.parametrize("seed", range(8))
def test_exactly_the_labels_of_optima_are_left(seed):
    rng = np.random.default_rng(seed)
    problem, _ = problem_of(rng, 3, 2, 3)
    energies = {w: energy(problem, 3, w) for w in itertools.product(range(3), repeat=6)}
    least = min(energies.values())
    optima = [w for w, cost in energies.items() if cost == least]
    costs = qpf.Problem(problem, 1 << 30)
    order = rng.permutation(6)
    stage = struct.pack("<IIIIIq7I", 4, 0, 0, 0, 6, least - problem.offset, *order, 0)
    qpf._check_stage(costs, qcf.Payload("STGS", memoryview(stage)), np.uint8)
    assert not costs.open.any() and costs.constant == least
    left = [{w[site] for w in optima} for site in range(6)]
    assert [set(np.flatnonzero(row)) for row in costs.left] == left


def test_malformed_parts(made):
    problem, data, samples, _, bound, best = made
    least = energy(problem, 3, best)
    good = part_of(problem, range(4), least)
    for wrong in (
        good[:16] + bytes(4),  # no part
        good[:-4],  # no end
        part_of(problem, (0, 1, 2, 2), least),  # a site twice
        part_of(problem, (0, 1, 2, 4), least),  # one that there is not
        good[:16] + struct.pack("<IqII", 1, 0, 0, 0),  # with edges to sites outside
        good[:-4] + good[16:],  # the same part again
        good[:4] + b"\1" + good[5:],  # a scale
    ):
        with pytest.raises(container.FormatError):
            check(data, samples, packed(data, best, wrong, bound, least))


def test_the_command(made, command, tmp_path):
    problem, data, samples, stages, bound, best = made
    found = energy(problem, 3, best)
    names = [tmp_path / name for name in ("p.qcf", "s.qsf", "c.qpf")]
    for name, content in zip(names, (data, samples, packed(data, best, stages, bound, found))):
        name.write_bytes(content)
    done = command("verify", *names, "--json")
    facts = json.loads(done.stdout)
    assert (done.returncode, facts["valid"], facts["energy"]) == (0, True, found)
    names[2].write_bytes(packed(data, best, stages, bound + 1, found))
    done = command("verify", *names)
    assert done.returncode == 1 and b"not valid: it states a higher bound" in done.stdout
    names[2].write_bytes(b"\x89QPF")
    assert command("verify", *names).returncode == 3
