"""Checks what a certificate (.qpf, docs/FORMAT.md, section 4) states of a problem, by numpy alone:
it shares no code with the C library. docs/MATHS.md, section 19, says why it is a proof.

Sites are the groups of the .qcf; the labels of a site are its variables (in a domain wall the
number of its variables that are 1). Each edge is two arcs: from its first site to its second, and
back, half the arrays further on. An arc is alive while both its sites are open, that is, not
settled.
"""

import math
import struct

import numpy as np

from ..core import models, qcf
from ..core.container import Corrupt, check_memory, read_chunks, read_header
from ..core.failure import InputError
from ..core.qcf import DOMAIN_WALL, MAX_ENERGY, NO_BOUND, ONE_HOT_ENCODINGS

MAGIC = b"\x89QPF\r\n\x1a\n"
FIELDS = struct.Struct("<IIqq12s")
REQUIRED = ["PROB", "BEST", "STGS"]
SPLITS, LEAVES, PARTS, SEARCHES = 1, 2, 4, 8  # what a stage has
SLOT_WIDTHS, SHARE_WIDTHS = (1, 2), (1, 2, 4, 8)
MOST_STAGES, MOST_SCALE, MOST_SLOTS = 4096, 2**30, 2**27
MOST_COSTS, MOST_SHARES = 2**59, 2**58
MOST_SITES, PART_CELLS, ALL_CELLS = 4096, 2**23, 2**26  # of solved parts
SEARCH_SITES, SEARCH_LABELS, SEARCH_EDGES, SEARCH_WORK = 256, 2**11, 2**15, 2**27  # of searched
OUT = 2**61  # the cost of a label that has left: above all sums
CHUNK, PIECE = 1 << 20, 1 << 16  # numbers of a temporary array, and of a search's


class Invalid(Exception):
    """A certificate states what is not so."""


def parse_qpf(data):
    """(SHA-256 of the .qcf, lower bound or NO_BOUND, energy, labelling that has it, number of
    stages, the stages' Payload) of a whole .qpf's bytes. Raises FormatError."""
    header = read_header(data, MAGIC, ".qpf", len(data))
    sites, stages, bound, energy, zero = FIELDS.unpack(header.fields)
    if stages > MOST_STAGES or zero != bytes(12):
        raise Corrupt("byte 24: too many stages, or a reserved field in use")
    chunks, _ = read_chunks(data, header, REQUIRED)
    digest, best = chunks["PROB"], chunks["BEST"]
    digest.need(len(digest.view) == 32, "not 32 bytes")
    (width,) = best.unpack("<I")
    best.need(width in (1, 2) and len(best.view) == 4 + sites * width, "its width or length")
    return (bytes(digest.view), bound, energy, best.array(f"<u{width}"), stages,
            chunks["STGS"])


class Problem:
    """A labelling problem, and what a check knows of it by now.

    unary, left     (sites, K): what labels cost, and which are left; K is the most that a site has
    tables          (2 blocks, K, K): of arcs, the labels of their own site first
    own, far, table, weight     of each arc: its sites, and what its labels cost: weight * table
    open, count, degree         of each site: not settled; its labels and edges in the file
    trimmed         (sites, K): what `unary` has and the linear terms have not (chunk trnc)
    """

    def __init__(self, problem):
        if problem.encoding not in (*ONE_HOT_ENCODINGS, DOMAIN_WALL):
            raise InputError("there are certificates of one-hot, one-hot-sparse and domain-wall "
                             "alone")
        self.wall = wall = problem.encoding == DOMAIN_WALL
        self.count, blocks = problem.sizes + wall, len(problem.blocks)
        shape = self.count.size, int(self.count.max(initial=1))
        check_memory(64 * math.prod(shape) + 32 * blocks * shape[1]**2, problem.memory_limit,
                     "the check")
        self.left, self.open = np.arange(shape[1]) < self.count[:, None], np.ones(shape[0], bool)
        linear, self.trimmed = np.zeros((2, *shape), np.int64)
        linear[:, wall:][self.left[:, wall:]] = problem.linear
        labels = int(self.count.sum())
        trimmed = qcf.Payload("trnc", memoryview(dict(problem.sides).get(
            "trnc", b"\1" + bytes(7 + labels))))
        self.trimmed[self.left] = trimmed.array(f"<u{trimmed.width()}", labels)
        trimmed.need(trimmed.at == len(trimmed.view), "too long")
        tables = np.zeros((blocks, shape[1], shape[1]), np.int64)
        for table, block in zip(tables, problem.blocks):
            table[wall:block.shape[0] + wall, wall:block.shape[1] + wall] = block
        # In a wall label a has the first a variables at 1, and may be coupled with itself.
        chains = np.triu(tables, 1).cumsum(1).cumsum(2).diagonal(0, 1, 2)
        if wall:
            linear, tables = linear.cumsum(1), tables.cumsum(1).cumsum(2)
        ones = np.arange(shape[1]) if wall else 1
        self.unary = (linear + self.trimmed + problem.a[:, None] * (1 - ones)
                      + problem.b[:, None] * (ones * (ones - 1) // 2))
        g, h, block, weight = problem.couplings[:, problem.couplings[3] != 0]
        inner = g == h
        np.add.at(self.unary, g[inner], weight[inner, None] * chains[block[inner]])
        g, h, block, weight = (values[~inner] for values in (g, h, block, weight))
        self.tables = np.concatenate([tables, tables.swapaxes(1, 2)])
        self.own, self.far, self.table, self.weight = (np.append(*pair) for pair in (
            (g, h), (h, g), (block, block + blocks), (weight, weight)))
        self.edges, self.degree = g.size, np.bincount(self.own, minlength=shape[0])
        self.near = np.argsort(self.own, kind="stable")  # arcs by their own site
        self.first = self.degree.cumsum() - self.degree
        self.constant, self.cells, self.looked = problem.offset, 0, 0
        largest = np.abs(tables).max((1, 2), initial=0)[block]
        self.magnitude = (abs(problem.offset) + int(np.abs(self.unary).max(1, initial=0).sum())
                          + int((np.abs(weight) * largest).sum()))

    def alive(self):
        """The edges that are alive, each as its arc from the first site, by that."""
        edges = self.near[self.near < self.edges]
        return edges[self.open[self.own[edges]] & self.open[self.far[edges]]]

    def arcs_at(self, sites):
        """(place, arc) of arcs that are alive: arc[k] goes out from sites[place[k]]."""
        place = np.repeat(np.arange(sites.size), self.degree[sites])
        arc = self.near[self.first[sites][place] + qcf.places(self.degree[sites])]
        alive = self.open[self.far[arc]]
        return place[alive], arc[alive]

    def line(self, arcs, label):
        """(arcs, K): what arcs cost with a label of their own site, by the label of the far one."""
        return self.weight[arcs, None] * self.tables[self.table[arcs], label]

    def energies(self, labelling, part=0):
        """i64 (sites,): at the number of each part (array) what a labelling costs there."""
        total, edges, sites = np.zeros(self.open.size, int), self.alive(), np.flatnonzero(self.open)
        part = part + np.zeros_like(total)
        np.add.at(total, part[sites], self.unary[sites, labelling[sites]])
        np.add.at(total, part[self.own[edges]], self.weight[edges] * self.tables[
            self.table[edges], labelling[self.own[edges]], labelling[self.far[edges]]])
        return total

    def energy(self, labelling):
        """What a labelling of the whole problem costs."""
        return self.constant + int(self.energies(labelling).sum())

    def fold(self, sites):
        """Settles those of some open sites that have one label left: their edges become costs of
        the neighbours."""
        sites = sites[self.left[sites].sum(1) == 1]
        label, (place, arc) = self.left[sites].argmax(1), self.arcs_at(sites)
        self.open[sites] = False
        once = self.open[self.far[arc]] | (arc < self.edges)  # also an edge of two such sites
        np.add.at(self.unary, self.far[arc[once]], self.line(arc, label[place])[once])
        self.constant += int(self.unary[sites, label].sum())


class Split:
    """The split of a stage, in rows: one for each slot of each open site, one site after another.

    row             of each arc: that of its slot at its own site
    share, sent     (rows, K): what labels cost in the row, and what its chain costs up to there
    steps           edges: the first of each chain, then the second of each, and so on
    part, least     of each site: the number of its part; of each part S times its bound
    """

    def __init__(self, p, stages, scale, slot_width, share_width):
        stages.need(1 <= scale <= MOST_SCALE and scale * p.magnitude <= MOST_COSTS
                    and slot_width in SLOT_WIDTHS and share_width in SHARE_WIDTHS,
                    "the head of a stage, or a scale too large for 64 bits")
        self.p, self.scale, edges = p, scale, p.alive()
        slots = stages.array(f"<u{slot_width}", 2 * edges.size).reshape(-1, 2).T.astype(int)
        ends, count = np.stack([p.own[edges], p.far[edges]]), p.open.astype(int)
        np.maximum.at(count, ends, slots + 1)
        begin, site = count.cumsum() - count, np.repeat(np.arange(count.size), count)
        first, second = rows = begin[ends] + slots
        after, before = np.full((2, site.size), -1)
        after[first] = before[second] = edges
        stages.need((slots < p.degree[ends]).all() and (after[first] == edges).all()
                    and (before[second] == edges).all() and site.size <= MOST_SLOTS,
                    "slots that make no chains")
        self.row = np.zeros(p.own.size, int)
        self.row[edges], self.row[edges + p.edges] = rows
        self.begin, last = begin[p.open], (begin + count - 1)[p.open]
        self.share, given = np.zeros((site.size, p.left.shape[1]), np.int64), p.left[site]
        given[last] = False
        shares, most = (stages.array(f"<i{share_width}", np.count_nonzero(given)),
                        MOST_SHARES // max(site.size, 1))
        stages.need(((-most <= shares) & (shares <= most)).all(), "a share too large for 64 bits")
        self.share[given] = shares
        self.share[last] = scale * p.unary[p.open] - self._add_up(self.share)
        self.share[~p.left[site]] = OUT
        self.steps, step = [], edges[before[first] < 0]
        while step.size:
            self.steps.append(step)
            step = after[self.row[step + p.edges]]
            step = step[step >= 0]
        self.sent, self.least = self._send(self.steps), np.zeros(count.size, np.int64)
        self.part = models.components(count.size, *ends)
        np.add.at(self.least, self.part[site[after < 0]],
                  (self.share + self.sent)[after < 0].min(1, initial=OUT))

    def _add_up(self, values):
        """Of each open site the sum of its rows."""
        return np.add.reduceat(values, self.begin) if self.begin.size else values

    def _send(self, steps):
        """(rows, K): the least that a chain costs before a row, by the label b there. On each arc
        sent(b) = min over a of share(a) + sent(a) + S cost(a, b)."""
        p, sent, to = self.p, np.zeros_like(self.share), np.roll(self.row, self.p.edges)
        for arcs in steps:
            costs = self.share[self.row[arcs]] + sent[self.row[arcs]]
            least, weight = np.full_like(costs, 2 * OUT), self.scale * p.weight[arcs, None]
            for label in range(costs.shape[1]):
                line = p.tables[:, label].take(p.table[arcs], 0)
                np.minimum(least, costs[:, label, None] + weight * line, out=least)
            sent[to[arcs]] = least
        return sent

    def bound(self):
        """The constant, and of each part what its chains cost, over S and rounded up."""
        return self.p.constant + int(-(-self.least // self.scale).sum())

    def possible(self, labelling):
        """(open sites, K): the labels with which the chains of the part cost at most S times what
        a labelling does."""
        room = self.scale * self.p.energies(labelling, self.part) - self.least
        more = self.share + self.sent + self._send(
            [step + self.p.edges for step in reversed(self.steps)])
        more -= more.min(1, keepdims=True, initial=OUT)
        return self._add_up(more) <= room[self.part[self.p.open], None]


def _read_labels(p, stages, kind, sites):
    """The labels that a stage compares with."""
    labels = stages.array(kind, sites.size).astype(int)
    stages.need((labels < p.count[sites]).all() and p.left[sites, labels].all(),
                "a label of a stage that is not left")
    return labels


def _read_sets(p, stages, sites):
    """(sites, K): the labels that stay, as p.left."""
    stay = p.left[sites]
    size = np.count_nonzero(stay)
    bits = np.unpackbits(stages.array("u1", -(-size // 8)), bitorder="little").astype(bool)
    stay[stay] = bits[:size]
    stages.need(stay.any(1).all() and not bits[size:].any(), "the label set of a site")
    return stay


def _leave(p, sites, stay, possible):
    """Labels leave that do not stay: those that are possible must not."""
    if (possible & ~stay).any():
        raise Invalid("a label leaves that its stage does not rule out")
    p.left[sites] = stay
    p.fold(sites)


def _compare(p, stages, kind, count):
    """A round of labels that leave by Goldstein's criterion (1994): at its site each costs more
    than another, whatever the neighbours have."""
    sites = stages.array("<u4", count).astype(int)
    stages.need((sites < p.open.size).all() and p.open[sites].all() and (np.diff(sites) > 0).all(),
                "the sites of a stage")
    other, stay = _read_labels(p, stages, kind, sites), _read_sets(p, stages, sites)
    possible = p.left[sites]
    stages.need((possible & ~stay).any(1).all(), "a round in which no label leaves a site")
    place, label = np.nonzero(possible & ~stay)
    site, other = sites[place], other[place]
    more, (pair, arc) = p.unary[site, label] - p.unary[site, other], p.arcs_at(site)
    for some in np.array_split(np.arange(arc.size), 1 + arc.size * stay.shape[1] // CHUNK):
        arcs, pairs = arc[some], pair[some]
        costs = p.line(arcs, label[pairs]) - p.line(arcs, other[pairs])
        np.add.at(more, pairs, np.where(p.left[p.far[arcs]], costs, OUT).min(1, initial=OUT))
    possible[place, label] = more <= 0
    _leave(p, sites, stay, possible)


def _edges_inside(p, stages, sites):
    """The arcs of a part's sites: (place of each one's own site, of its far site, arc)."""
    stages.need((sites < p.open.size).all() and p.open[sites].all()
                and np.unique(sites).size == sites.size, "sites that are no part")
    (place, arcs), order = p.arcs_at(sites), sites.argsort()
    to = order[np.searchsorted(sites[order], p.far[arcs]) % sites.size]
    stages.need((sites[to] == p.far[arcs]).all(), "sites that are no part")
    return place, to, arcs


def _solve_part(p, stages, count):
    """Checks the least energy of a part by elimination (Dechter 1999), then takes out the labels
    that no labelling of that energy has. Places are numbers in `sites`; a table is over places in
    rising order, and the first of them is being taken out."""
    (value,), sites = stages.unpack("<q"), stages.array("<u4", count).astype(int)
    place, to, arcs = _edges_inside(p, stages, sites)
    names, tables, size = [np.flatnonzero(left) for left in p.left[sites]], [], 0
    terms = [[([i], p.unary[site, names[i]])] for i, site in enumerate(sites)] + [[]]
    for i, j, arc in zip(place.tolist(), to.tolist(), arcs.tolist()):
        if i < j:
            costs = p.weight[arc] * p.tables[p.table[arc]][np.ix_(names[i], names[j])]
            terms[i].append(([i, j], costs))
    for own in terms[:-1]:
        over = sorted({side for few, _ in own for side in few})
        cells = math.prod(names[side].size for side in over)
        size, p.cells = size + cells, p.cells + cells
        stages.need(size <= PART_CELLS and p.cells <= ALL_CELLS, "a part's tables are too large")
        table = sum(np.expand_dims(costs, [axis for axis, side in enumerate(over)
                                           if side not in few]) for few, costs in own)
        tables.append((over, table, table.min(0)))
        terms[over[1] if len(over) > 1 else -1].append((over[1:], tables[-1][2]))
    if sum(int(costs) for _, costs in terms[-1]) != value:
        raise Invalid("a part has another least energy than it states")
    for i in reversed(range(sites.size)):
        over, table, sent = tables[i]
        if len(over) > 1:  # what all the rest of the part costs, with the labels of this table
            sides, whole, _ = tables[over[1]]
            beside = tuple(axis for axis, side in enumerate(sides) if side not in over)
            table = table + (whole.min(beside) - sent)
        tables[i] = over, table, sent
        least = table.min(tuple(range(1, len(over))))
        p.left[sites[i], names[i]] = least == least.min()
    p.constant += value
    p.open[sites] = False


def _search_part(p, stages, count):
    """Checks by search what the sites of a part cost at least, from each of them to the last; the
    labels stay. Columns are the labels left to the sites, one site after another."""
    sites = stages.array("<u4", count).astype(int)
    place, to, arcs = _edges_inside(p, stages, sites)
    site, label = np.nonzero(p.left[sites])
    inner, begin = np.flatnonzero(place < to), np.searchsorted(site, np.arange(count + 1))
    stages.need(count <= SEARCH_SITES and site.size <= SEARCH_LABELS
                and inner.size <= SEARCH_EDGES, "a part that is too large to search")
    unary, pair, edges_least = p.unary[sites[site], label], np.zeros((site.size,) * 2, int), 0
    for i, j, arc in zip(place[inner], to[inner], arcs[inner]):
        own, far = slice(*begin[i:i + 2]), slice(*begin[j:j + 2])
        costs = p.weight[arc] * p.tables[p.table[arc]][np.ix_(label[own], label[far])]
        edges_least += int(costs.min())
        pair[own, far] += costs - costs.min()
    least, most = np.append(stages.array("<i8", count), 0), int(np.diff(begin).max())
    stages.need(((-MAX_ENERGY <= least) & (least <= MAX_ENERGY)).all(), "a bound of a search")

    def bound(ahead, i):
        """What the sites from i on cost at least; `ahead` (labellings, labels): the edges to
        sites that have labels."""
        if i == count:
            return 0
        whole, ahead = (np.minimum.reduceat(costs[:, begin[i]:], begin[i:-1] - begin[i], 1)
                        for costs in (unary + ahead, ahead))
        before = np.pad(whole.cumsum(1), ((0, 0), (1, 0)))
        behind = np.pad(ahead[:, ::-1].cumsum(1)[:, ::-1], ((0, 0), (0, 1)))
        return (before + behind + least[i:]).max(1)

    for first in reversed(range(count)):
        work = [(first, np.zeros(1, int), np.zeros((1, site.size), int))]
        while work:
            i, cost, ahead = work.pop()
            if i == count:
                raise Invalid("a part costs less than the least that it states")
            own = slice(*begin[i:i + 2])
            cost = (cost[:, None] + unary[own] + ahead[:, own]).ravel()
            p.looked += cost.size * site.size
            stages.need(p.looked <= SEARCH_WORK, "a search that takes too long")
            ahead = (ahead[:, None] + pair[own]).reshape(-1, site.size)
            stays = np.flatnonzero(cost + bound(ahead, i + 1) < least[first])
            for some in np.array_split(stays, 1 + stays.size * site.size * most // PIECE):
                if some.size:
                    work.append((i + 1, cost[some], ahead[some]))
    p.constant += int(least[0]) + edges_least
    p.open[sites] = False


def _counts(stages):
    """How many sites each round or part of a stage has, to be read one by one."""
    (count,) = stages.unpack("<I")
    stages.need(count, "a stage of no sites")
    while count:
        yield count
        (count,) = stages.unpack("<I")


def _check_parts(p, stages, check_part):
    for count in _counts(stages):
        stages.need(count <= MOST_SITES, "a part of too many sites")
        check_part(p, stages, count)


def _check_stage(p, stages, kind):
    """Returns the bound that a stage proves, NO_BOUND if none. `kind` is the type of labels."""
    has, *head = stages.unpack("<4I")
    stages.need((1 <= has <= PARTS or has == SEARCHES) and (has & SPLITS or not any(head)),
                "the head of a stage")
    if has == LEAVES:
        for count in _counts(stages):
            _compare(p, stages, kind, count)
    elif not has & SPLITS:
        _check_parts(p, stages, _solve_part if has == PARTS else _search_part)
    else:
        split, labelling = Split(p, stages, *head), np.zeros(p.open.size, int)
        bound, sites = split.bound(), np.flatnonzero(p.open)
        if has & LEAVES:
            labelling[sites] = _read_labels(p, stages, kind, sites)
            stay = _read_sets(p, stages, sites)
            _leave(p, sites, stay, p.left[sites] & split.possible(labelling))
        return bound
    return NO_BOUND


def check(p, problem_digest, certificate):
    """Checks what a certificate, as of parse_qpf, states of a Problem, and leaves there the labels
    that may be in an optimum. Raises Invalid, FormatError."""
    digest, lower_bound, energy, labelling, count, stages = certificate
    if digest != problem_digest:
        raise Invalid("it is of another problem: the digests differ")
    if labelling.size != p.open.size or (labelling >= p.count).any():
        raise Corrupt("chunk BEST: another number of sites, or a label that there is not")
    if p.energy(labelling.astype(int)) != energy:
        raise Invalid("its labelling has another energy than it states")
    p.fold(np.arange(p.open.size))
    bounds = [_check_stage(p, stages, labelling.dtype) for _ in range(count)]
    stages.need(stages.at == len(stages.view), "bytes after the last stage")
    bounds.append(NO_BOUND if p.open.any() else p.constant)
    if max(bounds) < lower_bound:
        raise Invalid("it states a higher bound than it proves")
