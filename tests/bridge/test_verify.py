"""Certificates checked by numpy: of tiny problems beside all labellings, and tampered ones."""

import io
import itertools
import json
import struct
from hashlib import sha256

import numpy as np
import pytest
from problems import Table, altered, grid, make, pack_qcf
from qstereo_bridge.verify import certificate as qpf
from qstereo_bridge.core import container, models, qcf, qsf
from qstereo_bridge.core.failure import InputError
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
    by_site = sorted(edges, key=lambda edge: edge[0])
    slots = bytes(slot for edge in by_site for slot in 2 * [int(edge in columns)])
    return (
        struct.pack("<IIII", 1, SCALE, 1, 4) + slots + share.astype("<i4").tobytes(),
        made.offset + -(-int(least) // SCALE),
    )


def sets_of(rows):
    """Which labels stay: of each site a row of its labels that are left, 1 or 0."""
    return np.packbits(np.concatenate(rows).astype(bool), bitorder="little").tobytes()


def compared(sites, labels, rows):
    """A stage of one round: sites whose labels are compared with one each."""
    return (
        struct.pack("<IIIII", 2, 0, 0, 0, len(sites))
        + np.array(sites, "<u4").tobytes() + bytes(labels) + sets_of(rows) + bytes(4)
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


@pytest.mark.parametrize(
    "slots, shares",
    [
        (((0, 0), (0, 0), (0, 0), (0, 1)), 1),  # two edges in one slot of their first site
        (((0, 0), (0, 0), (1, 0), (0, 0)), 1),  # and of their second
        (((0, 0), (0, 0), (2, 0), (0, 1)), 3),  # a third slot at a site of two edges
    ],
)
def test_slots_that_make_no_chains(made, slots, shares):
    problem, data, samples, stages, bound, best = made
    proof = stages[:16] + bytes(sum(slots, ())) + bytes(4 * 3 * shares)
    with pytest.raises(container.FormatError, match="no chains"):
        check(data, samples, packed(data, best, proof, bound, energy(problem, 3, best)))


@pytest.mark.parametrize(
    "stages, zero, digest, width, more",
    [
        (4097, 0, 32, 1, 0),
        (1, 1, 32, 1, 0),
        (1, 0, 33, 1, 0),
        (1, 0, 32, 4, 0),
        (1, 0, 32, 1, 1),
        (1, 0, 32, 1, -1),
    ],
)
def test_malformed_files(stages, zero, digest, width, more):
    def whole(stages, zero, digest, width, more):
        fields = qpf.FIELDS.pack(4, stages, 0, 0, bytes(11) + bytes([zero]))
        best = struct.pack("<I", width) + bytes(4 * width + more)
        return container.pack(
            qpf.MAGIC, fields, [("PROB", bytes(digest)), ("BEST", best), ("STGS", b"")]
        )

    qpf.parse_qpf(whole(4096, 0, 32, 2, 0))
    with pytest.raises(container.FormatError):
        qpf.parse_qpf(whole(stages, zero, digest, width, more))


def labelled(encoding, *more):
    """Side chunks of a problem of 3 labels."""
    head = struct.pack("<16I", encoding, 0, 0, 3, 1, 0, 1, 3, 2, 2, 2, 2, 0, 0, 0, 0)
    return [("labl", head), *more]


def refusing(made, problem, match, stage=None):
    """That with `problem` the certificate is refused as no sound file or input."""
    _, _, _, stages, _, best = made
    data, found = pack_qcf(problem), energy(problem, 3, best)
    samples = answered(problem, data, 3, best)
    with pytest.raises((container.FormatError, InputError), match=match):
        check(data, samples, packed(data, best, stage or stages, 0, found))


def test_problems_without_certificates(made):
    for encoding in (4, 5, 6):
        refusing(made, altered(made[0], sides=labelled(encoding)), "one-hot")
    refusing(made, altered(made[0], sides=[]), "one-hot")


@pytest.mark.parametrize("numbers", [11, 13])
def test_trimmed_costs_of_another_length(made, numbers):
    side = ("trnc", struct.pack("<II", 1, 0) + bytes(numbers))
    refusing(made, altered(made[0], sides=labelled(2, side)), "trnc")


def test_scales_that_leave_64_bits(made):
    large = altered(made[0], linear=np.arange(12) << 27)
    stage = struct.pack("<IIII", 1, 2**29, 1, 4) + made[3][16:]
    refusing(made, large, "64 bits", stage)
    stage = struct.pack("<IIII", 1, 2**30 + 1, 1, 4) + made[3][16:]
    refusing(made, made[0], "head of a stage", stage)


def test_a_site_of_fewer_labels_has_no_others():
    """Labels that another site has, and this one has not, rule nothing out."""
    problem = make(
        [3, 2],
        [Table(np.zeros((3, 2), "<i4"))],
        [{"h": 1, "weight": 1}],
        [5, 6, 7, 5, 6],
        [(1, 1)] * 2,
        sides=labelled(1),
    )
    data = pack_qcf(problem)
    bits = np.array([[1, 0, 0, 1, 0]], np.uint8)
    records = np.array([(10, 1, qsf.NO_CHAINS)], qsf.RECORD)
    samples = qsf.pack_qsf(qsf.Samples(sha256(data).digest(), "test", records, bits))
    for row, valid in (([1, 0], True), ([0, 1], False)):
        proof = compared([0, 1], (0, 0), [[1, 0, 0], row])
        assert check(data, samples, packed(data, (0, 0), proof, qpf.NO_BOUND, 10)).valid == valid
    for proof, match in (
        (compared([0, 1], (0, 0), [[1, 0, 0], [1, 0, 1]]), "label set"),
        (compared([0, 1], (0, 0), [[1, 0, 0], [1, 1]]), "no label leaves"),
        (compared([0, 1], (0, 0), [[1, 0, 0], [1, 0]])[:-4], "STGS"),  # no end
        (compared([0, 1], (0, 2), [[1, 0, 0], [1, 0]]), "not left"),
        (compared([1, 0], (0, 0), [[1, 0, 0], [1, 0]]), "sites of a stage"),
        (compared([0, 0], (0, 0), [[1, 0, 0], [1, 0, 0]]), "sites of a stage"),
        (compared([0, 2], (0, 0), [[1, 0, 0], [1, 0]]), "sites of a stage"),
    ):
        with pytest.raises(container.FormatError, match=match):
            check(data, samples, packed(data, (0, 0), proof, qpf.NO_BOUND, 10))
    with pytest.raises(container.FormatError, match="BEST"):
        check(data, samples, packed(data, (0, 2), b"", qpf.NO_BOUND, 10))


@pytest.mark.parametrize(
    "bound, stage",
    [
        (10, struct.pack("<IIII", 1, SCALE, 1, 4) + b"\0\0"),  # one chain, no shares
        (qpf.NO_BOUND, compared([0], [1], [[0, 1, 1]])),  # label 0 of the first leaves
    ],
)
def test_labels_that_a_site_has_not_weaken_no_proof(bound, stage):
    """A third label of the second site would cost nothing, if there were one."""
    problem = make(
        [3, 2],
        [Table(np.array([[4, 4], [0, 1], [0, 1]], "<i4"))],
        [{"h": 1, "weight": 1}],
        [5, 5, 7, 5, 6],
        [(1, 1)] * 2,
        sides=labelled(1),
    )
    data, bits = pack_qcf(problem), np.array([[0, 1, 0, 1, 0]], np.uint8)
    records = np.array([(10, 1, qsf.NO_CHAINS)], qsf.RECORD)
    samples = qsf.pack_qsf(qsf.Samples(sha256(data).digest(), "test", records, bits))
    assert check(data, samples, packed(data, (1, 0), stage, bound, 10)).valid


def test_a_label_that_leaves_must_be_ruled_out(made):
    problem, data, samples, stages, bound, best = made
    found = energy(problem, 3, best)
    proof = struct.pack("<IIII", 3, *struct.unpack_from("<III", stages, 4)) + stages[16:]
    without, all_of_them = 1 - np.eye(3)[list(best)], np.ones((4, 3))
    for rows, valid in ((without, False), (all_of_them, True)):
        whole = packed(data, best, proof + bytes(best) + sets_of(rows), bound, found)
        verdict = check(data, samples, whole)
        assert verdict.valid == valid and (valid or "does not rule out" in verdict.why)


def test_a_stage_of_no_round(made):
    refusing(made, made[0], "no sites", struct.pack("<5I", 2, 0, 0, 0, 0))


def test_a_stage_that_does_nothing_known(made):
    for has in (0, 5, 9, 12, 16):
        refusing(made, made[0], "head of a stage", struct.pack("<IIII", has, 0, 0, 0))


def test_labels_of_a_stage_that_are_not_left(made):
    """No label, one that has left before, one that comes back."""
    problem, data, samples, stages, bound, best = made
    costs = problem.linear.reshape(4, 3).copy()
    other = (np.array(best) + 1) % 3
    costs[np.arange(4), other] = 99  # so that it leaves
    problem, row = altered(problem, linear=costs.ravel()), np.arange(3) != other[:, None]
    first = compared(range(4), best, row)
    two = np.ones((4, 2))
    for bits in (0x0F, 0x7F):  # none is left to the last site; a bit too many
        again = compared(range(3), best[:3], two[:3])[:-5] + bytes([bits]) + bytes(4)
        refusing_stages(made, problem, "label set", first + again)
    refusing_stages(made, problem, "not left", first + compared(range(4), other.tolist(), two))
    slots = bytes([0, 0, 1, 1, 1, 1, 0, 0])
    split = struct.pack("<IIII", 3, SCALE, 1, 4) + slots + bytes(4 * 2 * 4)
    refusing_stages(made, problem, "not left", first + split + bytes(other.tolist()) + sets_of(two))


def refusing_stages(made, problem, match, stages):
    """As refusing(), with two stages."""
    data, best = pack_qcf(problem), made[5]
    whole = container.pack(
        qpf.MAGIC,
        qpf.FIELDS.pack(4, 2, qpf.NO_BOUND, energy(problem, 3, best), bytes(12)),
        [
            ("PROB", sha256(data).digest()),
            ("BEST", struct.pack("<I", 1) + bytes(best)),
            ("STGS", stages),
        ],
    )
    with pytest.raises(container.FormatError, match=match):
        check(data, answered(problem, data, 3, best), whole)


def test_a_labelling_of_another_number_of_sites(made):
    problem, data, samples, stages, bound, best = made
    for labelling in (best[:3], (*best, 0), best[:1]):
        with pytest.raises(container.FormatError, match="number of sites"):
            check(data, samples, packed(data, labelling, stages, bound, energy(problem, 3, best)))


def test_samples_that_are_no_answer(made):
    problem, data, samples, stages, bound, best = made
    proof, bits = packed(data, best, stages, bound, energy(problem, 3, best)), np.eye(3)[list(best)]
    bits = bits.reshape(1, -1).astype(np.uint8)

    def answer(bits, digest, more):
        found = models.energies(problem, bits) + more
        records = np.array([(found[0], 1, qsf.NO_CHAINS)], qsf.RECORD)
        return qsf.pack_qsf(qsf.Samples(digest, "test", records, bits))

    digest, none = sha256(data).digest(), np.zeros_like(bits)
    assert check(data, answer(bits, digest, 0), proof).valid
    assert check(data, answer(none, digest, 0), proof).why == "no sample is a labelling"
    for wrong in (answer(bits, digest, 1), answer(none, digest, 1)):
        with pytest.raises(InputError, match="another energy"):
            check(data, wrong, proof)
    with pytest.raises(InputError, match="another problem"):
        check(data, answer(bits, bytes(32), 0), proof)


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
    costs = qpf.Problem(problem)
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
        good[:16] + struct.pack("<Iq6I", 5, least, 0, 1, 2, 3, 3, 0),  # a site twice, all others
        good[:16] + struct.pack("<IqII", 1, 0, 0, 0),  # with edges to sites outside
        good[:-4] + good[16:],  # the same part again
        good[:4] + b"\1" + good[5:],  # a scale
    ):
        with pytest.raises(container.FormatError):
            check(data, samples, packed(data, best, wrong, bound, least))


@pytest.mark.parametrize("limit", ["MOST_SITES", "PART_CELLS", "ALL_CELLS"])
def test_limits_of_parts(made, limit, monkeypatch):
    problem, data, samples, _, _, best = made
    least = energy(problem, 3, best)
    proof = packed(data, best, part_of(problem, range(4), least), least, least)
    # In a square the first table is over sites 0, 1 and 2, and the second over 1, 2 and 3.
    most = 4 if limit == "MOST_SITES" else 27 + 27 + 9 + 3
    monkeypatch.setattr(qpf, limit, most)
    assert check(data, samples, proof).valid
    monkeypatch.setattr(qpf, limit, most - 1)
    with pytest.raises(container.FormatError):
        check(data, samples, proof)


def searched(made, order):
    """The least energies from each site of an order on, by all labellings, each edge's least cost
    taken away; and these costs together."""
    unary, edges, table = costs_of(made, 3)
    lost = int(table.min()) * sum(weight for _, _, weight in edges)

    def least(sites):
        inner = [(sites.index(g), sites.index(h), weight) for g, h, weight in edges
                 if g in sites and h in sites]
        return min(
            sum(unary[p, d] for p, d in zip(sites, w))
            + sum(weight * (table[w[i], w[j]] - table.min()) for i, j, weight in inner)
            for w in itertools.product(range(3), repeat=len(sites))
        )

    return [int(least(list(order[k:]))) for k in range(len(order))], lost


def search_of(order, energies):
    """A stage of one searched part."""
    size = len(order)
    return struct.pack(f"<IIIII{size}I{size}qI", 8, 0, 0, 0, size, *order, *energies, 0)


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (3, 0, 2, 1), (2, 1, 3, 0)])
def test_a_part_is_searched_in_any_order(made, order):
    problem, data, samples, _, _, best = made
    least = energy(problem, 3, best)
    energies, lost = searched(problem, order)
    assert problem.offset + lost + energies[0] == least
    for proven, bound in ((True, least), (False, least + 1)):
        proof = packed(data, best, search_of(order, energies), bound, least)
        assert check(data, samples, proof).valid == proven
    for k in range(4):
        energies[k] += 1
        proof = packed(data, best, search_of(order, energies), least, least)
        assert "a part costs less" in check(data, samples, proof).why
        energies[k] -= 1
    energies[0] -= 1
    proof = packed(data, best, search_of(order, energies), least, least)
    assert "higher bound" in check(data, samples, proof).why


def test_malformed_searches(made):
    problem, data, samples, _, bound, best = made
    least, (energies, _) = energy(problem, 3, best), searched(problem, (0, 1, 2, 3))
    good = search_of((0, 1, 2, 3), energies)
    for wrong in (
        good[:16] + bytes(4),  # no part
        good[:-4],  # no end
        good[:-4] + good[16:],  # the same part again
        search_of((0, 1, 2, 2), energies),  # a site twice
        search_of((0, 1, 2, 4), energies),  # one that there is not
        search_of((0, 1, 2), energies[:3]),  # with edges to a site outside
        search_of((0, 1, 2, 3), [*energies[:3], 2**53 + 1]),
        search_of((0, 1, 2, 3), [*energies[:3], -(2**63)]),
        good[:4] + b"\1" + good[5:],  # a scale
    ):
        with pytest.raises(container.FormatError):
            check(data, samples, packed(data, best, wrong, bound, least))


@pytest.mark.parametrize(
    "limit, most",
    [("SEARCH_SITES", 4), ("SEARCH_LABELS", 12), ("SEARCH_EDGES", 4), ("SEARCH_WORK", None)],
)
def test_limits_of_searches(made, limit, most, monkeypatch):
    problem, data, samples, _, _, best = made
    least, (energies, _) = energy(problem, 3, best), searched(problem, (0, 1, 2, 3))
    proof = packed(data, best, search_of((0, 1, 2, 3), energies), least, least)
    if most is None:
        costs = qpf.Problem(problem)
        stage = memoryview(search_of((0, 1, 2, 3), energies))
        qpf._check_stage(costs, qcf.Payload("STGS", stage), np.uint8)
        most = costs.looked
        assert most >= 4 * 3 * 12  # from each site on, its own labels at least
    monkeypatch.setattr(qpf, limit, most)
    assert check(data, samples, proof).valid
    monkeypatch.setattr(qpf, limit, most - 1)
    with pytest.raises(container.FormatError):
        check(data, samples, proof)


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
