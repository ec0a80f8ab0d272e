"""The problem file, .qcf: one QUBO as groups of variables and a few distinct coupling blocks.

    H(x) = offset + sum_i linear_i x_i + sum_g [a_g (1 - S_g) + b_g S_g (S_g - 1) / 2]
           + sum over couplings (g, h, weight, block t) of weight * sum_ij t[i][j] x_i x_j

with S_g the sum of the variables of group g. All numbers are integers.
"""

import struct
from dataclasses import dataclass, field

import numpy as np

from .blocks import Table, Toeplitz, places
from .container import (DEFAULT_LIMIT, HEADER, MAX_COUNT, Corrupt, check_memory, check_size, pack,
                        read_chunks, read_header, read_stream)

MAGIC = b"\x89QCF\r\n\x1a\n"
FIELDS = struct.Struct("<IIQ20s")
REQUIRED = ["GRPS", "BLKS", "CPLS", "LINR", "PNLT", "OFFS"]
MAX_ENERGY = 2**53

GROUP_RUN = np.dtype([("count", "<u4"), ("size", "<u4")])
COUPLING_RUN = np.dtype([(name, "<i4" if name == "weight" else "<u4") for name in (
    "block", "form", "width", "weight", "g", "h", "count", "repeat", "stride")])
LATTICE, LIST = 0, 1
WIDTHS = (1, 2, 4, 8)
LABL_SIZE, LABL_ENCODING, LABL_SCALE, LABL_GRID, LABL_MASK = 64, 0, 16, 32, 60
COUPLINGS_PER_BYTE = 16
ONE_HOT_ENCODINGS = (1, 2)


def penalty_run(width):
    """The dtype of one run of PNLT whose a and b have `width` bytes."""
    return np.dtype([("count", "<u4"), ("a", f"<u{width}"), ("b", f"<u{width}")])


def least_width(largest):
    """The least of 1, 2, 4, 8 bytes that hold the unsigned integer `largest`."""
    return next(width for width in WIDTHS if largest < 1 << 8 * width)


@dataclass
class Problem:
    """One QUBO. Arrays of runs have the file's own layout.

    group_runs      GROUP_RUN array: `count` groups of `size` variables each
    blocks          list of Table and Toeplitz
    coupling_runs   COUPLING_RUN array
    pairs           u32 array (.., 2): the pairs (g, h) of all list runs, one after another
    weights         one array (i1, i2 or i4) for each run whose width is not 0, in the pairs' order
    linear          i64 array (n): the linear term of each variable, penalties not included
    penalties       array (count, a, b): the next `count` groups have the penalty pair (a, b)
    offset          int, penalties' constants not included
    sides           list of (type, bytes): side chunks, kept as they are
    """

    group_runs: np.ndarray
    blocks: list
    coupling_runs: np.ndarray
    pairs: np.ndarray
    weights: list
    linear: np.ndarray
    penalties: np.ndarray
    offset: int = 0
    sides: list = field(default_factory=list)

    @property
    def groups(self):
        return int(self.group_runs["count"].sum(dtype=np.int64))

    @property
    def couplings(self):
        runs = self.coupling_runs
        return int((runs["count"].astype(np.int64) * runs["repeat"]).sum())

    def sizes(self):
        """i64 array: the number of variables of each group."""
        return np.repeat(self.group_runs["size"].astype(np.int64), self.group_runs["count"])

    def starts(self):
        """i64 array: the first variable of each group, and n at the end."""
        return np.concatenate(([0], np.cumsum(self.sizes())))

    def penalty_pairs(self, dtype=np.int64):
        """Two arrays: a and b of each group."""
        return tuple(np.repeat(self.penalties[key].astype(dtype), self.penalties["count"])
                     for key in "ab")

    def one_hot(self):
        """bool array: whether each group has a penalty, and so wants exactly one variable at 1."""
        penalties = self.penalties
        return np.repeat((penalties["a"] != 0) | (penalties["b"] != 0), penalties["count"])

    def coupled_pairs(self):
        """All couplings in the file's order: i64 arrays g, h, block, weight."""
        runs = self.coupling_runs
        counts = runs["count"].astype(np.int64) * runs["repeat"]
        run = np.repeat(np.arange(runs.size), counts)
        row, column = np.divmod(places(counts), runs["count"].astype(np.int64)[run])
        step = row * runs["stride"][run] + column
        g, h = runs["g"][run] + step, runs["h"][run] + step
        listed = runs["form"][run] == LIST
        g[listed], h[listed] = self.pairs[:, 0], self.pairs[:, 1]
        weight = runs["weight"][run].astype(np.int64)
        weight[runs["width"][run] != 0] = np.concatenate([np.empty(0, np.int64), *self.weights])
        return g, h, runs["block"][run].astype(np.int64), weight

    def _labl(self, at):
        """A number in the side chunk labl, None without one."""
        return next((struct.unpack_from("<I", side, at)[0] for name, side in self.sides
                     if name == "labl"), None)

    @property
    def scale(self):
        """Integer units in one real unit."""
        return self._labl(LABL_SCALE) or 1

    @property
    def encoding(self):
        """The number of the encoding, None where the file does not tell it."""
        return self._labl(LABL_ENCODING)

    @property
    def groups_say_all(self):
        """Whether a state is a labelling exactly when each one-hot group has one variable at 1: of
        other encodings the bridge cannot tell."""
        return self.groups == 0 or (self.encoding in (None, *ONE_HOT_ENCODINGS)
                                    and bool(self.one_hot().any()))

    def magnitude(self, dtype):
        """The bound on all energies (FORMAT.md's M), computed in `dtype`: np.int64 is exact where M
        is below 2^62."""
        (a, b), size = self.penalty_pairs(dtype), self.sizes().astype(dtype)
        _, _, block, weight = self.coupled_pairs()
        weights = np.zeros(len(self.blocks), dtype)
        np.add.at(weights, block, np.abs(weight).astype(dtype))
        total = abs(dtype(self.offset)) + np.abs(self.linear.astype(dtype)).sum()
        total += (a * (1 + size) + b * (size * (size - 1) // 2)).sum()
        return sum((weight * block.abs_sum(dtype) for weight, block in zip(weights, self.blocks)
                    if weight), total)


class _Payload:
    """Reads one chunk from front to back; all that is wrong is a Corrupt that names the place."""

    def __init__(self, chunks, name):
        self.name, self.view, self.at = name, chunks[name], 0

    def need(self, sound, reason):
        if not sound:
            raise Corrupt(f"chunk {self.name}, byte {self.at}: {reason}")

    def left(self):
        return len(self.view) - self.at

    def unpack(self, layout):
        self.need(struct.calcsize(layout) <= self.left(), "the chunk ends too early")
        values = struct.unpack_from(layout, self.view, self.at)
        self.at += struct.calcsize(layout)
        return values

    def array(self, dtype, count):
        size = count * np.dtype(dtype).itemsize
        self.need(size <= self.left(), f"the chunk ends too early for {count} values")
        values = np.frombuffer(self.view, dtype, count, self.at)
        self.at += size
        return values

    def rest(self, dtype):
        """All that is left, as an array."""
        count, odd = divmod(self.left(), np.dtype(dtype).itemsize)
        self.need(odd == 0, f"{self.left()} bytes are no whole number of entries")
        return self.array(dtype, count)

    def width(self):
        """The width of the integers that follow, checked, with its reserved field."""
        width, zero = self.unpack("<II")
        self.need(width in WIDTHS and zero == 0, f"width {width}, or a reserved field in use")
        return width

    def end(self):
        self.need(self.left() == 0, f"{self.left()} bytes too many")


def _read_groups(chunks, n, groups):
    part = _Payload(chunks, "GRPS")
    runs = part.rest(GROUP_RUN)
    counts, sizes = runs["count"].astype(np.int64), runs["size"].astype(np.int64)
    part.need((counts >= 1).all() and (sizes >= 1).all(), "an empty run, or an empty group")
    part.need((sizes[1:] != sizes[:-1]).all(), "neighbouring runs of the same size")
    part.need(counts.sum() == groups, f"{counts.sum()} groups, the header says {groups}")
    # Counts were first: with at most 2^31 groups the next sum cannot overflow.
    part.need((counts * sizes).sum() == n, f"the groups do not have the header's {n} variables")
    return runs


def _read_blocks(chunks):
    part, blocks = _Payload(chunks, "BLKS"), []
    for _ in range(part.unpack("<I")[0]):
        rows, columns, kind = part.unpack("<III")
        part.need(rows and columns, "a block without rows or columns")
        part.need(kind in (0, 1), f"unknown kind {kind} of block")
        if kind == 0:
            blocks.append(Table(part.array("<i4", rows * columns).reshape(rows, columns)))
            continue
        fill, first, count = part.unpack("<iiI")
        part.need(first == 0 if count == 0 else first > -rows and first + count <= columns,
                  "a Toeplitz block's values reach outside it")
        blocks.append(Toeplitz((rows, columns), fill, first, part.array("<i4", count)))
    part.end()
    return blocks


def _read_couplings(chunks, blocks, groups, couplings):
    """Returns coupling_runs, pairs and weights of a Problem."""
    part, runs, weights, total, last = _Payload(chunks, "CPLS"), [], [], 0, 0
    pairs = [np.empty((0, 2), "<u4")]
    for _ in range(part.unpack("<I")[0]):
        runs.append(part.unpack("<IIIiIIIII"))
        block, form, width, weight, g, h, count, repeat, stride = runs[-1]
        part.need(last <= block < blocks, f"block {block} after block {last}, of {blocks}")
        part.need(form in (LATTICE, LIST), f"unknown form {form}")
        part.need(width in (0, 1, 2, 4), f"unknown width {width}")
        part.need((weight == 0) == (width != 0), f"weight {weight} beside weights of {width} bytes")
        part.need(count and repeat, "an empty run")
        part.need(stride >= count if repeat > 1 else stride == 0,
                  f"stride {stride} of a run of {count} pairs, {repeat} times")
        if form == LIST:
            part.need(g == h == stride == 0 and repeat == 1, "a lattice's field in use in a list")
            pairs.append(part.array("<u4", 2 * count).reshape(count, 2))
            part.need((pairs[-1][:, 0] <= pairs[-1][:, 1]).all() and pairs[-1].max() < groups,
                      "a pair of no groups")
        else:
            part.need(g <= h and h + (repeat - 1) * stride + count <= groups,
                      "a lattice reaches outside the groups")
        if width:
            weights.append(part.array(f"<i{width}", count * repeat))
        total, last = total + count * repeat, block
    part.end()
    part.need(total == couplings, f"{total} couplings, the header says {couplings}")
    return np.array(runs, COUPLING_RUN), np.concatenate(pairs), weights


def _read_linear(chunks, n):
    part = _Payload(chunks, "LINR")
    base = part.unpack("<q")[0]
    u = part.array(f"<u{part.width()}", n)
    part.end()
    part.need(n == 0 or -MAX_ENERGY <= base + int(u.min()) and base + int(u.max()) <= MAX_ENERGY,
              "linear terms above 2^53")
    # Modulo 2^64: base and u may each be far away from their sum.
    return (u.astype(np.uint64) + np.uint64(base % 2**64)).view(np.int64)


def _read_penalties(chunks, groups):
    part = _Payload(chunks, "PNLT")
    width = part.width()
    runs = part.rest(penalty_run(width))
    part.need((runs["count"] >= 1).all(), "an empty run")
    part.need(runs["count"].sum(dtype=np.int64) == groups, f"the runs do not have {groups} groups")
    part.need((runs[1:][["a", "b"]] != runs[:-1][["a", "b"]]).all(), "the same penalty twice")
    part.need(_penalty_width(runs) == width, f"width {width} is not the least")
    return runs


def _penalty_width(runs):
    return least_width(int(max(runs["a"].max(initial=0), runs["b"].max(initial=0))))


def _check_couplings(problem):
    """What can only be seen with groups, blocks, couplings and penalties together."""
    g, h, block, _ = problem.coupled_pairs()
    if g.size:
        sizes, shapes = problem.sizes(), np.array([block.shape for block in problem.blocks])
        for wrong, what in (
                ((sizes[g] != shapes[block, 0]) | (sizes[h] != shapes[block, 1]),
                 "has a block of another size than its groups"),
                ((g == h) & problem.one_hot()[g], "is inside a group that has a penalty")):
            if wrong.any():
                raise Corrupt(f"chunk CPLS: coupling {wrong.argmax()} {what}")
    # In doubles first: what they find below 2^54 cannot overflow 64-bit integers.
    if problem.magnitude(np.float64) > 2 * MAX_ENERGY or problem.magnitude(np.int64) > MAX_ENERGY:
        raise Corrupt("the coefficients add up to more than 2^53, energies would not be exact")


def _is_mask_sound(labl):
    """Whether a mask in the payload of labl has a grid, and its length."""
    width, height = struct.unpack_from("<II", labl, LABL_GRID)
    cells = width * height
    return (struct.unpack_from("<I", labl, LABL_MASK)[0] != 1
            or 0 < cells and len(labl) == LABL_SIZE + (cells + 7) // 8)


def _check_sides(sides):
    labls = [side for name, side in sides if name == "labl"]
    if len(labls) > 1 or any(len(labl) < LABL_SIZE or not any(labl[LABL_SCALE:LABL_SCALE + 4])
                             for labl in labls):
        raise Corrupt("chunk labl: it is there twice, it is too short, or its scale is 0")
    if not all(_is_mask_sound(labl) for labl in labls):
        raise Corrupt("chunk labl, byte 60: a mask without a grid, "
                      "or of another size than the grid")


def parse_qcf(data, limit=DEFAULT_LIMIT):
    """The Problem in `data`, the bytes of a whole .qcf. Raises FormatError."""
    header = read_header(data[:HEADER.size], MAGIC, ".qcf")
    check_size(len(data), header.size)
    n, groups, couplings, zero = FIELDS.unpack(header.fields)
    if not (groups <= n <= MAX_COUNT and (groups == 0) == (n == 0) and couplings <= MAX_COUNT
            and zero == bytes(20)):
        raise Corrupt("byte 24: the header's counts are impossible, or a reserved field is in use")
    check_memory(header.size + 16 * n + 64 * groups + 96 * couplings, limit,
                 f"{n:,} variables, {groups:,} groups and {couplings:,} couplings")
    chunks, sides = read_chunks(data, header, REQUIRED)
    _check_sides(sides)
    if couplings // COUPLINGS_PER_BYTE > len(data):
        raise Corrupt(f"byte 32: {couplings:,} couplings are more than a file of {len(data):,} "
                      "bytes may name")
    offset = _Payload(chunks, "OFFS")
    group_runs, blocks = _read_groups(chunks, n, groups), _read_blocks(chunks)
    problem = Problem(
        group_runs, blocks, *_read_couplings(chunks, len(blocks), groups, couplings),
        _read_linear(chunks, n), _read_penalties(chunks, groups), *offset.unpack("<q"),
        [(name, bytes(side)) for name, side in sides])
    offset.end()
    _check_couplings(problem)
    return problem


def read_qcf(stream, limit=DEFAULT_LIMIT):
    """(Problem, the file's bytes) of a .qcf in a binary stream. Raises FormatError, OSError."""
    data = read_stream(stream, MAGIC, ".qcf", limit)
    return parse_qcf(data, limit), data


def pack_qcf(problem):
    """The bytes of `problem` as a .qcf, linear terms and penalties in their least widths. Nothing
    is checked."""
    couplings, weights, at = [], iter(problem.weights), 0
    for run in problem.coupling_runs:
        couplings.append(run.tobytes())
        if run["form"] == LIST:
            couplings.append(problem.pairs[at:at + run["count"]].astype("<u4").tobytes())
            at += run["count"]
        if run["width"]:
            couplings.append(next(weights).astype(f"<i{run['width']}").tobytes())
    base = int(problem.linear.min()) if problem.linear.size else 0
    u = problem.linear.view(np.uint64) - np.uint64(base % 2**64)
    width, penalty_width = least_width(int(u.max(initial=0))), _penalty_width(problem.penalties)

    def counted(parts, count):
        return struct.pack("<I", count) + b"".join(parts)
    return pack(MAGIC, FIELDS.pack(problem.linear.size, problem.groups, problem.couplings,
                                   bytes(20)), [
        ("GRPS", problem.group_runs.astype(GROUP_RUN).tobytes()),
        ("BLKS", counted((block.pack() for block in problem.blocks), len(problem.blocks))),
        ("CPLS", counted(couplings, problem.coupling_runs.size)),
        ("LINR", struct.pack("<qII", base, width, 0) + u.astype(f"<u{width}").tobytes()),
        ("PNLT", struct.pack("<II", penalty_width, 0)
         + problem.penalties.astype(penalty_run(penalty_width)).tobytes()),
        ("OFFS", struct.pack("<q", problem.offset)),
        *problem.sides,
    ])
