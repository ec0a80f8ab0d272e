"""The problem file, .qcf: one QUBO as groups of variables and a few distinct coupling blocks.

    H(x) = offset + sum_i linear_i x_i + sum_g [a_g (1 - S_g) + b_g S_g (S_g - 1) / 2]
           + sum over couplings (g, h, weight, block t) of weight * sum_ij t[i][j] x_i x_j

with S_g the sum of the variables of group g. All numbers are integers.
"""

import functools
import hashlib
import struct
from dataclasses import dataclass, field

import numpy as np

from .container import (DEFAULT_LIMIT, MAX_COUNT, Corrupt, Payload, check_memory, read_chunks,
                        read_header, read_stream)

MAGIC = b"\x89QCF\r\n\x1a\n"
FIELDS = struct.Struct("<IIQ20s")
SIDES = ["labl", "mean", "kept", "trnc", "best"]
REQUIRED = ["GRPS", "BLKS", "CPLS", "LINR", "PNLT", "OFFS"]
MAX_ENERGY = 2**53
# Of the 16 numbers of labl: encoding, whether there is a mask, labels, scale, width, height.
LABL = [0, 15, 3, 4, 8, 9]
COUPLINGS_PER_BYTE = 16
# Bytes that the work on an entry of a block takes.
ENTRY_BYTES = 16
ONE_HOT_ENCODINGS, DOMAIN_WALL = (1, 2), 3
NO_BOUND = -2**63


def before(lengths):
    """For each of `lengths` the sum of those before it."""
    return np.cumsum(lengths) - lengths


def places(lengths):
    """0, 1, .. length - 1 for each of `lengths`, one after another."""
    return np.arange(lengths.sum()) - np.repeat(before(lengths), lengths)


@dataclass
class Coefficients:
    """One QUBO as its file has it; arrays are of i64.

    sizes           the number of variables of each group
    blocks          list of i32 arrays, the matrices t of couplings
    couplings       array (4, ..): the groups g and h, the block and the weight of each coupling
    linear          the linear term of each variable, penalties not included
    a, b            the penalty pair of each group
    offset          int, penalties' constants not included
    sides           list of (type, bytes): side chunks
    scale           integer units in one real unit
    encoding        the number of the encoding, None where the file does not tell it
    labels          how many labels the whole problem has, 0 where the file does not tell it
    known           u8 array (n,): the best labelling known, or None where the file carries none
    stated_bound    the lower bound of H that the file states beside it, or None: a claim
    digest          SHA-256 of the file, 32 bytes, by which samples know their problem
    data            the file's bytes, None where there is no file
    memory_limit    bytes that the problem and its models may take
    """

    sizes: np.ndarray
    blocks: list
    couplings: np.ndarray
    linear: np.ndarray
    a: np.ndarray
    b: np.ndarray
    offset: int = 0
    sides: list = field(default_factory=list)
    scale: int = 1
    encoding: int = None
    labels: int = 0
    known: np.ndarray = None
    stated_bound: int = None
    digest: bytes = b""
    data: bytes = None
    memory_limit: int = DEFAULT_LIMIT

    @functools.cached_property
    def starts(self):
        """The first variable of each group, and n at the end."""
        return np.concatenate(([0], np.cumsum(self.sizes)))

    @functools.cached_property
    def group(self):
        """The group of each variable."""
        return self.of_variables(np.arange(self.sizes.size))

    @property
    def edges(self):
        """Array (2, ..): the groups that couplings join, those of weight 0 left out."""
        return self.couplings[:2, self.couplings[3] != 0]

    @property
    def one_hot(self):
        """bool array: whether each group has a penalty, and so wants exactly one variable at 1."""
        return (self.a != 0) | (self.b != 0)

    def of_variables(self, values):
        """Values for each group, along the last axis, as values for each of its variables."""
        return np.repeat(values, self.sizes, axis=-1)

    @property
    def groups_say_all(self):
        """Whether a state is a labelling exactly when each one-hot group has one variable at 1: of
        other encodings the bridge cannot tell."""
        return self.sizes.size == 0 or (self.encoding in (None, *ONE_HOT_ENCODINGS)
                                        and bool(self.one_hot.any()))

    def magnitude(self, dtype):
        """The bound on all energies (FORMAT.md's M), computed in `dtype`: np.int64 is exact where M
        is below 2^62."""
        a, b = (pair.view(np.uint64).astype(dtype) for pair in (self.a, self.b))
        size, (_, _, block, weight) = self.sizes.astype(dtype), self.couplings
        weights = np.zeros(len(self.blocks), dtype)
        np.add.at(weights, block, np.abs(weight).astype(dtype))
        total = abs(dtype(self.offset)) + np.abs(self.linear.astype(dtype)).sum()
        total += (a * (1 + size) + b * (size * (size - 1) // 2)).sum()
        return sum((weight * np.abs(block.astype(dtype)).sum()
                    for weight, block in zip(weights, self.blocks) if weight), total)


def _groups(part, n, groups):
    count, size = part.runs("<u4", "<u4")
    part.need((count > 0).all() and (size > 0).all() and (np.diff(size) != 0).all(),
              "an empty run, an empty group, or neighbouring runs of the same size")
    # Counts come first: with at most 2^31 groups the other sum cannot overflow.
    part.need(count.sum() == groups and (count * size).sum() == n,
              f"not the header's {groups} groups and {n} variables")
    return np.repeat(size, count)


def _blocks(part, limit):
    blocks, entries = [], 0
    for _ in range(part.unpack("<I")[0]):
        rows, columns, kind = part.unpack("<III")
        part.need(rows and columns, "a block without rows or columns")
        part.need(kind in (0, 1), f"unknown kind {kind} of block")
        if kind == 0:
            blocks.append(part.array("<i4", rows * columns).reshape(rows, columns))
            continue
        fill, first, count = part.unpack("<iiI")
        part.need(first == 0 if count == 0 else first > -rows and first + count <= columns,
                  "a Toeplitz block's values reach outside it")
        entries += rows * columns
        check_memory(ENTRY_BYTES * entries, limit, f"blocks of {entries:,} entries")
        # The value of each diagonal, from the bottom left corner on; a row is a part of them.
        diagonals, at = np.full(rows + columns - 1, fill, np.int32), first + rows - 1
        diagonals[at:at + count] = part.array("<i4", count)
        blocks.append(np.lib.stride_tricks.sliding_window_view(diagonals, columns)[::-1])
    return blocks


def _couplings(part, blocks, groups, couplings):
    found, total, last = [np.empty((4, 0), np.int64)], 0, 0
    for _ in range(part.unpack("<I")[0]):
        block, form, width, weight, g, h, count, repeat, stride = part.unpack("<IIIiIIIII")
        part.need(last <= block < blocks, f"block {block} after block {last}, of {blocks}")
        part.need(form in (0, 1), f"unknown form {form}")
        part.need(width in (0, 1, 2, 4), f"unknown width {width}")
        part.need((weight == 0) == (width != 0), f"weight {weight} beside weights of {width} bytes")
        part.need(count and repeat, "an empty run")
        part.need(stride >= count if repeat > 1 else stride == 0,
                  f"stride {stride} of a run of {count} pairs, {repeat} times")
        each, last = count * repeat, block
        total += each
        part.need(total <= couplings, f"more couplings than the header's {couplings}")
        if form == 1:
            part.need(g == h == stride == 0 and repeat == 1, "a lattice's field in use in a list")
            ends = part.array("<u4", 2 * count).reshape(count, 2).T.astype(np.int64)
            part.need((ends[0] <= ends[1]).all() and ends.max() < groups, "a pair of no groups")
        else:
            part.need(g <= h and h + (repeat - 1) * stride + count <= groups,
                      "a lattice reaches outside the groups")
            step = (np.arange(repeat)[:, None] * stride + np.arange(count)).ravel()
            ends = g + step, h + step
        weights = part.array(f"<i{width}", each) if width else np.full(each, weight)
        found.append(np.stack([*ends, np.full(each, block), weights]))
    part.need(total == couplings, f"{total} couplings, the header says {couplings}")
    return np.concatenate(found, axis=1)


def _linear(part, n):
    base = part.unpack("<q")[0]
    u = part.array(f"<u{part.width()}", n)
    part.need(n == 0 or -MAX_ENERGY <= base + int(u.min()) and base + int(u.max()) <= MAX_ENERGY,
              "linear terms above 2^53")
    # Modulo 2^64: base and u may each be far away from their sum.
    return (u.astype(np.uint64) + np.uint64(base % 2**64)).view(np.int64)


def _penalties(part, groups):
    """a and b of each group; the i64 of a number above 2^63 is negative, until magnitude() says
    no."""
    width = part.width()
    count, a, b = part.runs("<u4", f"<u{width}", f"<u{width}")
    part.need((count > 0).all() and count.sum() == groups, f"the runs do not have {groups} groups")
    part.need(((np.diff(a) != 0) | (np.diff(b) != 0)).all(), "the same penalty twice")
    largest = int(np.append(a, b).view(np.uint64).max(initial=0))
    part.need(width == 1 or largest >> 4 * width, f"width {width} is not the least")
    return np.repeat((a, b), count, axis=1)


def _check(problem):
    """What can only be seen with groups, blocks, couplings and penalties together."""
    g, h, block, _ = problem.couplings
    if g.size:
        shapes = np.array([block.shape for block in problem.blocks])
        for wrong, what in (
                ((problem.sizes[[g, h]] != shapes[block].T).any(0),
                 "has a block of another size than its groups"),
                ((g == h) & problem.one_hot[g], "is inside a group that has a penalty")):
            if wrong.any():
                raise Corrupt(f"chunk CPLS: coupling {wrong.argmax()} {what}")
    # In doubles first: what they find below 2^54 cannot overflow 64-bit integers.
    if problem.magnitude(np.float64) > 2 * MAX_ENERGY or problem.magnitude(np.int64) > MAX_ENERGY:
        raise Corrupt("the coefficients add up to more than 2^53, energies would not be exact")


def _labl(sides):
    """(scale, number of the encoding, labels) of the side chunk labl: (1, None, 0) without one. The
    side chunks that FORMAT.md knows stand in its order, each once, and none without labl."""
    known = [name for name, _ in sides if name in SIDES]
    if known != sorted(set(known), key=SIDES.index) or known[:1] not in ([], SIDES[:1]):
        raise Corrupt(f"the side chunks are {', '.join(known)}: of {', '.join(SIDES)} each may be "
                      "there once, in this order, and none without labl")
    if not known:
        return 1, None, 0
    part = Payload("labl", dict(sides)["labl"])
    encoding, masked, labels, scale, width, height = np.array(
        part.unpack("<16I"))[LABL].tolist()
    part.need(scale, "a scale of 0")
    cells = width * height
    part.need(masked != 1 or cells and len(part.view) == part.at + (cells + 7) // 8,
              "a mask without a grid, or of another size than the grid")
    return scale, encoding, labels


def kept(problem):
    """(The chunk kept as a Payload behind its head; how many sites the whole problem has; bytes of
    a site's fixed label, 0 where all labels of all sites are kept). Raises Corrupt."""
    part = Payload("kept", dict(problem.sides).get("kept", bytes(8)))
    sites, width = part.unpack("<II")
    part.need(width in (0, 1, 2), f"width {width}")
    return part, sites, width


def label_sets(problem):
    """(Which labels each site keeps, bool (sites, labels); which sites are undecided), as the
    chunks labl and kept say. Raises Corrupt."""
    part, sites, width = kept(problem)
    if not width:
        sites = sites or problem.sizes.size
        return np.ones((sites, problem.labels), bool), np.ones(sites, bool)
    fixed, row = part.array(f"<u{width}", sites).astype(int), -(-problem.labels // 8)
    undecided, sets = fixed == 256**width - 1, np.arange(problem.labels) == fixed[:, None]
    count = np.count_nonzero(undecided)
    packed = part.array("u1", count * row).reshape(count, row)
    sets[undecided] = np.unpackbits(packed, 1, problem.labels, "little")
    return sets, undecided


def _best(sides, sizes, encoding, labels):
    """(known, stated_bound) of the side chunk best: (None, None) without one."""
    found = dict(sides).get("best")
    if found is None:
        return None, None
    part, wall = Payload("best", found), encoding == DOMAIN_WALL
    part.need(sizes.size and (wall or encoding in ONE_HOT_ENCODINGS),
              "problems of this encoding, or without variables, have none")
    bound, width, zero = part.unpack("<qII")
    part.need(width == (1 if labels <= 255 else 2) and zero == 0
              and (bound == NO_BOUND or abs(bound) <= MAX_ENERGY),
              "a width or bound out of range, or a reserved field in use")
    label = part.array(f"<u{width}", sizes.size).astype(np.int64)
    part.end()
    part.need((label < sizes + wall).all(), "a label that its site does not have")
    place, label = places(sizes), np.repeat(label, sizes)
    return ((place < label if wall else place == label).astype(np.uint8),
            None if bound == NO_BOUND else bound)


def parse_qcf(data, limit=DEFAULT_LIMIT):
    """The Coefficients in `data`, the bytes of a whole .qcf. Raises FormatError."""
    header = read_header(data, MAGIC, ".qcf", len(data))
    n, groups, couplings, zero = FIELDS.unpack(header.fields)
    if not (groups <= n <= MAX_COUNT and (groups == 0) == (n == 0) and couplings <= MAX_COUNT
            and zero == bytes(20)):
        raise Corrupt("byte 24: the header's counts are impossible, or a reserved field is in use")
    check_memory(header.size + 16 * n + 64 * groups + 96 * couplings, limit,
                 f"{n:,} variables, {groups:,} groups and {couplings:,} couplings")
    chunks, sides = read_chunks(data, header, REQUIRED)
    scale, encoding, labels = _labl(sides)
    if couplings // COUPLINGS_PER_BYTE > len(data):
        raise Corrupt(f"byte 32: {couplings:,} couplings are more than a file of {len(data):,} "
                      "bytes may name")

    def read(name, function, *arguments):
        found = function(chunks[name], *arguments)
        chunks[name].end()
        return found

    sizes, blocks = read("GRPS", _groups, n, groups), read("BLKS", _blocks, limit)
    problem = Coefficients(
        sizes, blocks, read("CPLS", _couplings, len(blocks), groups, couplings),
        read("LINR", _linear, n), *read("PNLT", _penalties, groups),
        read("OFFS", lambda part: part.unpack("<q")[0]), sides, scale, encoding,
        labels, *_best(sides, sizes, encoding, labels), hashlib.sha256(data).digest(), data, limit)
    _check(problem)
    return problem


def read_qcf(stream, limit=DEFAULT_LIMIT):
    """The Coefficients in a .qcf in a binary stream. Raises FormatError, OSError."""
    return parse_qcf(read_stream(stream, MAGIC, ".qcf", limit), limit)
