"""Checks certificates (.qpf, docs/FORMAT.md) by numpy alone: it shares no code with the C library.
docs/MATHS.md, section 19, has the mathematics.

The labelling problem is what the states of the .qcf say: sites are its groups, the labels of a site
are its variables (in a domain wall the number of its variables that are 1), and their costs are the
linear terms and the blocks. Costs of labels that have left are `OUT`.
"""

from __future__ import annotations

import math
import struct
from dataclasses import asdict, dataclass

import numpy as np

from . import models, qcf, runner
from .container import DEFAULT_LIMIT, Corrupt, read_chunks, read_header, read_stream
from .failure import NO, OK, InputError
from .problem import File, load, load_samples, opened

MAGIC = b"\x89QPF\r\n\x1a\n"
FIELDS = struct.Struct("<IIqq12s")
REQUIRED = ["PROB", "BEST", "STGS"]
NO_BOUND = -2**63
OUT = 2**61
WALL, ENCODINGS = 3, (1, 2, 3)
CHUNK = 1 << 22  # numbers that are in memory at a time
MOST_STAGES = 4096
MOST_SITES, PART_CELLS, ALL_CELLS = 4096, 2**23, 2**26  # of solved parts


@dataclass
class Verdict:
    """Whether a certificate is valid, and if not, why. Energies are in integer units.

    energy          of the best sample, or of the certificate's labelling
    lower_bound     that the certificate states; None = none
    """

    valid: bool
    why: str | None
    energy: int
    lower_bound: int | None
    stages: int


@dataclass
class Certificate:
    """What a .qpf states: of the .qcf with the SHA-256 `digest` a lower bound (None = none), and
    the energy of a labelling (the label number of each undecided site); `proof` has the stages."""

    digest: bytes
    lower_bound: int | None
    energy: int
    labelling: np.ndarray
    stages: int
    proof: memoryview


class Invalid(Exception):
    """A certificate states what is not so."""


def parse_qpf(data):
    """The Certificate in `data`, the bytes of a whole .qpf. Raises FormatError."""
    header = read_header(data, MAGIC, ".qpf", len(data))
    sites, stages, bound, energy, zero = FIELDS.unpack(header.fields)
    if zero != bytes(12):
        raise Corrupt("byte 48: a reserved field is in use")
    chunks, _ = read_chunks(data, header, REQUIRED)
    best, width = chunks["BEST"], int.from_bytes(chunks["BEST"][:4], "little")
    if len(chunks["PROB"]) != 32 or width not in (1, 2) or len(best) != 4 + sites * width:
        raise Corrupt("chunk PROB or BEST: a length or a width is not what it must be")
    return Certificate(bytes(chunks["PROB"]), None if bound == NO_BOUND else bound, energy,
                       np.frombuffer(best, f"<u{width}", offset=4), stages, chunks["STGS"])


class _Problem:
    """Costs as arrays. `unary`, `kept`: (sites, most labels); `tables`: (blocks, most labels, most
    labels), padded; `first`, `second`, `block`, `weight`, `alive`: of each edge."""

    def __init__(self, problem):
        if problem.encoding not in ENCODINGS:
            raise InputError("there are certificates of one-hot, one-hot-sparse and domain-wall "
                             "alone")
        self.wall = wall = problem.encoding == WALL
        self.count = problem.sizes + wall
        self.most = most = int(self.count.max(initial=1))
        self.kept = np.arange(most) < self.count[:, None]
        linear, self.trimmed = np.zeros((2, *self.kept.shape), np.int64)
        linear[:, wall:][self.kept[:, wall:]] = problem.linear
        self.trimmed[self.kept] = _trimmed(problem, int(self.count.sum()))
        ones = np.arange(most) if wall else 1
        self.unary = (linear.cumsum(1) if wall else linear) + self.trimmed
        self.unary += problem.a[:, None] * (1 - ones) + problem.b[:, None] * (
            ones * (ones - 1) // 2)
        g, h, block, weight = problem.couplings[:, problem.couplings[3] != 0]
        self.tables = np.zeros((len(problem.blocks), most, most), np.int64)
        for table, dense in zip(self.tables, problem.blocks):
            table[wall:dense.shape[0] + wall, wall:dense.shape[1] + wall] = dense
        own = g == h
        chains = np.diagonal(np.triu(self.tables[block[own]], 1).cumsum(1).cumsum(2), 0, 1, 2)
        np.add.at(self.unary, g[own], weight[own, None] * chains)
        if wall:
            self.tables = self.tables.cumsum(1).cumsum(2)
        self.first, self.second, self.block, self.weight = (end[~own] for end in (
            g, h, block, weight))
        ends = np.append(self.first, self.second)
        self.degree = np.bincount(ends, minlength=self.count.size)
        self.near = np.argsort(ends, kind="stable") % max(self.first.size, 1)  # the edges of a site
        self.near_start = np.append(0, self.degree.cumsum())
        self.alive, self.fixed = np.ones(self.first.size, bool), np.zeros(self.count.size, bool)
        self.constant, self.cells = problem.offset, 0
        largest = np.abs(self.tables).max((1, 2), initial=0)[self.block]
        self.magnitude = (abs(problem.offset) + int(np.abs(self.unary).max(1, initial=0).sum())
                          + int((np.abs(self.weight) * largest).sum()))

    def energy(self, labelling):
        return int(self.constant + self.unary[np.arange(len(labelling)), labelling].sum()
                   + self.edge_costs(slice(None), labelling).sum())

    def edge_costs(self, edges, labelling):
        a, b = labelling[self.first[edges]], labelling[self.second[edges]]
        return self.weight[edges] * self.tables[self.block[edges], a, b]

    def edges_at(self, sites):
        """(row, edge) of the edges that are alive: edge[k] has the end sites[row[k]]."""
        row = np.repeat(np.arange(sites.size), self.degree[sites])
        edge = self.near[self.near_start[sites][row] + qcf.places(self.degree[sites])]
        return row[self.alive[edge]], edge[self.alive[edge]]

    def costs(self, edges):
        """(edges, labels, labels): what the labels cost on edges."""
        return self.tables[self.block[edges]] * self.weight[edges, None, None]

    def fold(self):
        """Sites with one label left become constants, their edges costs of the neighbours."""
        new = ~self.fixed & (self.kept.sum(1) == 1)
        self.fixed |= new
        label = self.kept.argmax(1)
        for p, q, turned in ((self.first, self.second, 0), (self.second, self.first, 1)):
            edges = np.flatnonzero(self.alive & new[p])
            tables = self.tables.swapaxes(1, 2) if turned else self.tables
            np.add.at(self.unary, q[edges], self.weight[edges, None]
                      * tables[self.block[edges], label[p[edges]]])
            self.alive[edges] = False
        self.constant += int(self.unary[new, label[new]].sum())


def _trimmed(problem, count):
    side = dict(problem.sides).get("trnc")
    if side is None:
        return 0
    width = int.from_bytes(side[:4], "little")
    if width not in (1, 2, 4) or len(side) != 8 + count * width:
        raise Corrupt("chunk trnc: its length is not what it must be")
    return np.frombuffer(side, f"<u{width}", offset=8)


class _Split:
    """The split of a stage: a row for each slot of each site that is not fixed."""

    def __init__(self, p, stages, scale, slot_width, share_width):
        stages.need(1 <= scale <= 2**30 and slot_width in (1, 2) and share_width in (1, 2, 4)
                    and scale * p.magnitude <= 2**59, "the head of a stage")
        self.p, self.scale, self.edges = p, scale, np.flatnonzero(p.alive)
        self.first, self.second = p.first[self.edges], p.second[self.edges]
        slots = stages.array(f"<u{slot_width}", 2 * self.edges.size).reshape(-1, 2).astype(int)
        ends = np.stack([self.first, self.second], 1)
        count = np.where(p.fixed, 0, 1)
        np.maximum.at(count, ends, slots + 1)
        start = np.concatenate([[0], count.cumsum()])
        self.site = np.repeat(np.arange(count.size), count)
        self.start, rows = start[:-1][~p.fixed], int(start[-1])
        self.row, self.to = start[self.first] + slots[:, 0], start[self.second] + slots[:, 1]
        self.next, self.before = np.full((2, rows), -1)
        self.next[self.row] = self.before[self.to] = np.arange(self.edges.size)
        stages.need((slots < p.degree[ends]).all() and rows <= 2**27 and
                    np.unique(self.row).size == np.unique(self.to).size == self.edges.size,
                    "slots that make no chains")
        last = np.zeros(rows, bool)
        last[self.start + count[~p.fixed] - 1] = True
        given = p.kept[self.site] & ~last[:, None]
        share = np.zeros(given.shape, np.int64)
        share[given] = stages.array(f"<i{share_width}", int(given.sum()))
        sums = np.add.reduceat(share, self.start, 0) if rows else share
        share[last] = scale * p.unary[~p.fixed] - sums
        self.share = np.where(p.kept[self.site], share, OUT)
        self.part = models.components(count.size, self.first, self.second)

    def bound(self):
        """The dynamic program of all chains, an edge of each at a time."""
        self.come, self.steps = np.zeros_like(self.share), []
        step = np.flatnonzero(self.before[self.row] < 0)
        while step.size:
            self.steps.append(step)
            costs = np.minimum(self.share[self.row[step]] + self.come[self.row[step]], OUT)
            cost = self.scale * self.p.costs(self.edges[step])
            self.come[self.to[step]] = (costs[:, :, None] + cost).min(1)
            step = self.next[self.to[step]]
            step = step[step >= 0]
        ends = self.next < 0
        self.least = np.zeros(self.part.size, np.int64)
        np.add.at(self.least, self.part[self.site[ends]],
                  (self.share + self.come)[ends].min(1, initial=OUT))
        return self.p.constant + int(-(-self.least // self.scale).sum())

    def take_out(self, labelling):
        """The labels with which not every labelling costs more than this one does, part by part."""
        p, later = self.p, np.zeros_like(self.share)
        for step in reversed(self.steps):
            costs = np.minimum(self.share[self.to[step]] + later[self.to[step]], OUT)
            cost = self.scale * p.costs(self.edges[step])
            later[self.row[step]] = (costs[:, None] + cost).min(2)
        room, live = -self.least, np.flatnonzero(~p.fixed)
        np.add.at(room, self.part[live], self.scale * p.unary[live, labelling[live]])
        np.add.at(room, self.part[self.first],
                  self.scale * p.edge_costs(self.edges, labelling))
        more = np.where(p.kept[self.site], self.share + self.come + later, OUT)
        more -= more.min(1, initial=OUT)[:, None]
        excess = np.add.reduceat(more, self.start, 0) if live.size else more
        sets = p.kept.copy()
        sets[live] &= excess <= room[self.part[live]][:, None]
        return sets


class _Part:
    """A part that is solved by elimination, in the order of its `sites`. Of each site: `left`,
    which labels; `terms`, pairs of places, rising, and costs; `table`, of all terms, over `sides`.
    """

    def __init__(self, p, stages, sites):
        stages.need(np.unique(sites).size == sites.size and (sites < p.fixed.size).all()
                    and not p.fixed[sites].any(), "sites that are no part")
        self.p, self.sites, self.left = p, sites, p.kept[sites]
        self.edges = np.unique(p.edges_at(sites)[1])
        place = {site: at for at, site in enumerate(sites.tolist())}
        ends = [[place.get(site, -1) for site in end[self.edges].tolist()]
                for end in (p.first, p.second)]
        stages.need(-1 not in ends[0] + ends[1], "sites that are no part")
        self.terms = [[((i,), p.unary[site][self.left[i]])] for i, site in enumerate(sites)]
        for i, j, cost in zip(*ends, p.costs(self.edges)):
            cost = cost[self.left[i]][:, self.left[j]]
            self.terms[min(i, j)].append(((i, j), cost) if i < j else ((j, i), cost.T))
        self._lay(stages)

    def _lay(self, stages):
        labels, self.sides = self.left.sum(1).tolist(), []
        into = [{side for places, _ in own for side in places} for own in self.terms]
        for sides in into:
            self.sides.append(sorted(sides))
            if len(sides) > 1:
                into[self.sides[-1][1]].update(self.sides[-1][1:])
        cells = sum(math.prod(labels[side] for side in sides) for sides in self.sides)
        self.p.cells += cells
        stages.need(cells <= PART_CELLS and self.p.cells <= ALL_CELLS,
                    "a part whose tables are too large")

    def solve(self):
        """The least energy of the part."""
        self.table, self.sent, value = [], [], 0
        for sides, own in zip(self.sides, self.terms):
            self.table.append(sum(np.expand_dims(costs, [
                axis for axis, side in enumerate(sides) if side not in places])
                for places, costs in own))
            self.sent.append(self.table[-1].min(0))
            if len(sides) > 1:
                self.terms[sides[1]].append((sides[1:], self.sent[-1]))
            else:
                value += int(self.sent[-1])
        return value

    def settle(self, value):
        """Takes out the labels that no labelling of the least energy has, and the sites."""
        p = self.p
        for i in reversed(range(self.sites.size)):
            sides = self.sides[i]
            if len(sides) > 1:
                axes = tuple(n for n, side in enumerate(self.sides[sides[1]]) if side not in sides)
                self.table[i] = self.table[i] + (self.table[sides[1]].min(axes) - self.sent[i])
            least = self.table[i].min(tuple(range(1, len(sides))))
            p.kept[self.sites[i], self.left[i]] = least == least.min()
        p.fixed[self.sites] = True
        p.alive[self.edges] = False
        p.constant += value


def _solve_parts(p, stages):
    (count,) = stages.unpack("<I")
    stages.need(count, "a stage of no parts")
    while count:
        stages.need(count <= MOST_SITES, "a part of too many sites")
        (value,) = stages.unpack("<q")
        part = _Part(p, stages, stages.array("<u4", count).astype(int))
        if part.solve() != value:
            raise Invalid("a part has another least energy than it states")
        part.settle(value)
        (count,) = stages.unpack("<I")


def _goldstein(p, sets, claimed):
    """Takes out of `sets` what Goldstein's criterion rules out at sites where more is left than
    `claimed`, until there is nothing. Labels are compared with the cheapest one, then with each."""
    calls, at = np.ones(p.fixed.size, bool), 0  # where the criterion may say more than before
    rest = np.arange(p.fixed.size)
    cheapest = np.where(p.kept, p.unary, OUT).argmin(1)
    others = [cheapest, *(np.full_like(cheapest, label) for label in range(p.most))]
    while at < len(others):
        rest = rest[(sets[rest] & ~claimed[rest]).any(1)]
        changed = _goldstein_once(p, sets, rest[calls[rest]] if at == 0 else rest, others[at])
        calls[rest] = False
        edges = p.edges_at(changed)[1]
        calls[changed] = calls[p.first[edges]] = calls[p.second[edges]] = True
        at = 0 if changed.size else at + 1


def _goldstein_once(p, sets, sites, other):
    """Applies the criterion at sites with one other label of each. Where labels leave."""
    sites = sites[p.kept[sites, other[sites]]]
    gain, (row, edge) = np.zeros((sites.size, p.most), np.int64), p.edges_at(sites)
    for piece in np.array_split(np.arange(edge.size), -(-edge.size * p.most**2 // CHUNK) or 1):
        own, edges = sites[row[piece]], edge[piece]
        turned, cost = p.second[edges] == own, p.costs(edges)
        cost[turned] = cost[turned].swapaxes(1, 2)
        far = np.where(turned, p.first[edges], p.second[edges])
        less = cost[np.arange(own.size), other[own]][:, None] - cost
        np.add.at(gain, row[piece], np.where(sets[far][:, None], less, -OUT).max(2, initial=-OUT))
    more = p.unary[sites] - p.unary[sites, other[sites]][:, None]
    leaves = sets[sites] & (more > gain)
    sets[sites] &= ~leaves
    return sites[leaves.any(1)]


def _stage(p, stages, label):
    """Checks a stage, whose labels are numbers of the type `label`. Returns the bound that it
    proves, or None."""
    has, scale, slot_width, share_width = stages.array("<u4", 4).tolist()
    stages.need(1 <= has <= 4, "the head of a stage")
    split = _Split(p, stages, scale, slot_width, share_width) if has & 1 else None
    stages.need(has & 1 or not (scale or slot_width or share_width), "the head of a stage")
    if has == 4:
        _solve_parts(p, stages)
    bound, live, sets = split.bound() if split else None, np.flatnonzero(~p.fixed), p.kept.copy()
    if has & 2:
        if split:
            labelling = np.zeros(p.fixed.size, int)
            labelling[live] = stages.array(label, live.size)
            stages.need((labelling < p.most).all() and p.kept[live, labelling[live]].all(),
                        "a label of a stage that is not left")
            sets = split.take_out(labelling)
        claimed = _read_sets(p, stages, live)
        _goldstein(p, sets, claimed)
        if (sets & ~claimed).any():
            raise Invalid("a label leaves that its stage does not rule out")
        p.kept[:] = claimed
        p.fold()
    return bound


def _read_sets(p, stages, live):
    """The labels that a stage leaves, as p.kept."""
    width = -(-p.count[live] // 8)
    data, claimed = np.zeros((live.size, -(-p.most // 8)), np.uint8), p.kept.copy()
    data[np.arange(data.shape[1]) < width[:, None]] = stages.array("u1", int(width.sum()))
    left = np.unpackbits(data, axis=1, bitorder="little").astype(bool)
    stages.need(left.any(1).all() and not left[:, p.most:].any()
                and not (left[:, :p.most] & ~p.kept[live]).any(), "the label set of a site")
    claimed[live] = left[:, :p.most]
    return claimed


def _prove(p, certificate):
    """The highest bound that the stages prove, None without one."""
    stages, bounds = qcf.Payload("STGS", certificate.proof), []
    stages.need(certificate.stages <= MOST_STAGES, f"more than {MOST_STAGES} stages")
    p.fold()
    for _ in range(certificate.stages):
        bounds.append(_stage(p, stages, certificate.labelling.dtype))
    stages.need(stages.at == len(stages.view), "bytes after the last stage")
    bounds.append(p.constant if p.fixed.all() else None)
    return max((bound for bound in bounds if bound is not None), default=None)


def _best_energy(p, problem, samples):
    """The energy of the best sample that is a labelling. Raises Invalid, InputError."""
    if samples.digest != problem.digest:
        raise InputError("the samples are of another problem: the SHA-256 of its file differs")
    energies, rows = [], np.zeros_like(p.unary)
    for bits, record in zip(samples.bits, samples.records):
        rows[:, p.wall:][p.kept[:, p.wall:]] = bits
        rows[:, :p.wall] = 1
        if (np.diff(rows) > 0).any() if p.wall else (rows.sum(1) != 1).any():
            continue
        labelling = rows.sum(1) - 1 if p.wall else rows.argmax(1)
        energies.append(p.energy(labelling))
        trimmed = int(p.trimmed[np.arange(len(labelling)), labelling].sum())
        if energies[-1] - trimmed != record["energy"]:
            raise InputError("a sample has another energy than the samples file states")
    if not energies:
        raise Invalid("no sample is a labelling")
    return min(energies)


def _label_sets(problem):
    """(sites, labels) bool: the labels that the chunk kept leaves; without one, all."""
    sides = dict(problem.coefficients.sides)
    labels = int.from_bytes(sides["labl"][12:16], "little")
    kept = sides.get("kept")
    sites, width = np.frombuffer(kept[:8], "<u4").tolist() if kept else (0, 0)
    if not width:
        return np.ones((problem.coefficients.sizes.size, labels), bool)
    fixed = np.frombuffer(kept, f"<u{width}", sites, 8).astype(int)
    sets = np.arange(labels) == fixed[:, None]
    packed = np.frombuffer(kept, np.uint8, offset=8 + sites * width).reshape(-1, -(-labels // 8))
    sets[fixed == 256**width - 1] = np.unpackbits(packed, 1, labels, "little")
    return sets


def _check_reduced(p, left, problem, smaller):
    """Every label that the certificate leaves must be in the reduced problem."""
    sets, others = _label_sets(problem), _label_sets(smaller)
    undecided = sets.sum(1) > 1 if "kept" in dict(problem.coefficients.sides) else slice(None)
    inside = sets[undecided]
    inside[inside] = left
    sets[undecided] = inside
    if sets.shape != others.shape or (sets & ~others).any():
        raise Invalid("a label has left the reduced problem that the certificate does not rule out")


def verify(problem: File, other: File, certificate: File,
           memory_limit: int = DEFAULT_LIMIT) -> Verdict:
    """Check a certificate of a problem (.qcf): paths or binary streams.

    other           samples (.qsf), of which the best must be as good as the certificate states; or
                    the .qcf that `qstereo reduce` has written: each label that has left it must be
                    in no optimum
    Raises FormatError (a damaged file), InputError, FileError.
    """
    whole = load(problem, memory_limit)
    with opened(certificate) as stream:
        proof = parse_qpf(read_stream(stream, MAGIC, ".qpf", memory_limit))
    p, why, energy = _Problem(whole.coefficients), None, proof.energy
    try:
        if proof.digest != whole.digest:
            raise Invalid("it is of another problem: the digests differ")
        if proof.labelling.size != p.fixed.size or (proof.labelling >= p.count).any():
            raise Corrupt("chunk BEST: another number of sites, or a label that there is not")
        if p.energy(proof.labelling.astype(int)) != proof.energy:
            raise Invalid("its labelling has another energy than it states")
        reduced = _is_problem(other)
        if not reduced:
            energy = _best_energy(p, whole, load_samples(other, memory_limit))
        bound = _prove(p, proof)
        if proof.lower_bound is not None and (bound is None or bound < proof.lower_bound):
            raise Invalid("it states a higher bound than it proves")
        if reduced:
            _check_reduced(p, p.kept[np.arange(p.most) < p.count[:, None]], whole,
                           load(other, memory_limit))
        if energy > proof.energy:
            raise Invalid("the best sample costs more than the certificate states")
    except Invalid as reason:
        why = str(reason)
    return Verdict(why is None, why, energy, proof.lower_bound, proof.stages)


def _is_problem(file):
    with opened(file) as stream:
        head = stream.read(len(qcf.MAGIC))
        if stream is file:
            stream.seek(-len(head), 1)
    return head == qcf.MAGIC


def command(options):
    """The command `verify`."""
    found = verify(options.problem, options.other, options.certificate, options.memory_limit)
    scale = load(options.problem, options.memory_limit).scale
    facts = {**asdict(found), "proven_optimal": found.valid and found.energy == found.lower_bound}
    for key in ("energy", "lower_bound"):
        facts[key] = runner.real(facts[key], scale)
    runner.show(options, f"valid: energy {facts['energy']}, lower bound {facts['lower_bound']}, "
                f"{found.stages} stages" if found.valid else f"not valid: {found.why}", facts)
    return OK if found.valid else NO
