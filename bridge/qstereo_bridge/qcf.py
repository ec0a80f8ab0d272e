"""The problem file, .qcf: one QUBO as groups of variables and a few distinct coupling blocks.

    H(x) = offset + sum_i linear_i x_i + sum_g [a_g (1 - S_g) + b_g S_g (S_g - 1) / 2]
           + sum over couplings (g, h, weight, block t) of weight * sum_ij t[i][j] x_i x_j

with S_g the sum of the variables of group g. All numbers are integers.
"""

import struct
from dataclasses import dataclass, field

import numpy as np

from .blocks import Table, Toeplitz
from .container import HEADER, Corrupt, check_memory, check_size, pack, read_chunks, read_header, read_stream

MAGIC = b"\x89QCF\r\n\x1a\n"
FIELDS = struct.Struct("<IIQ20s")
REQUIRED = ["GRPS", "BLKS", "CPLS", "LINR", "PNLT", "OFFS"]
MAX_COUNT = 2**31 - 1
MAX_ENERGY = 2**53
DEFAULT_LIMIT = 8 << 30

GROUP_RUN = np.dtype([("count", "<u4"), ("size", "<u4")])
COUPLING_RUN = np.dtype([("block", "<u4"), ("form", "<u4"), ("width", "<u4"), ("weight", "<i4"), ("g", "<u4"),
                         ("h", "<u4"), ("count", "<u4"), ("repeat", "<u4"), ("stride", "<u4")])
LATTICE, LIST = 0, 1
LABL_SIZE, LABL_ENCODING, LABL_SCALE, LABL_GRID, LABL_MASK = 64, 0, 16, 32, 60
COUPLINGS_PER_BYTE = 16
ONE_HOT_ENCODINGS = (1, 2)


def penalty_run(width):
    """The dtype of one run of PNLT whose a and b have `width` bytes."""
    return np.dtype([("count", "<u4"), ("a", f"<u{width}"), ("b", f"<u{width}")])


@dataclass
class Problem:
    """One QUBO. Arrays of runs have the file's own layout.

    group_runs      GROUP_RUN array: `count` groups of `size` variables each
    blocks          list of Table and Toeplitz
    coupling_runs   COUPLING_RUN array
    pairs           u32 array (.., 2): the pairs (g, h) of all list runs, one after another
    weights         one array (i1, i2 or i4) for each run whose width is not 0: its weights, in the order of the pairs
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

    def penalty_pairs(self):
        """Two i64 arrays: a and b of each group."""
        return (np.repeat(self.penalties["a"].astype(np.int64), self.penalties["count"]),
                np.repeat(self.penalties["b"].astype(np.int64), self.penalties["count"]))

    def one_hot(self):
        """bool array: whether each group has a penalty, and so wants exactly one variable at 1."""
        return np.repeat((self.penalties["a"] != 0) | (self.penalties["b"] != 0), self.penalties["count"])

    def coupled_pairs(self):
        """All couplings in the file's order: i64 arrays g, h, block, weight."""
        runs = self.coupling_runs
        counts = runs["count"].astype(np.int64) * runs["repeat"]
        run = np.repeat(np.arange(runs.size), counts)
        place = np.arange(run.size) - np.repeat(np.cumsum(counts) - counts, counts)
        row, column = np.divmod(place, runs["count"].astype(np.int64)[run])
        step = row * runs["stride"][run] + column
        g, h = runs["g"][run] + step, runs["h"][run] + step
        listed = runs["form"][run] == LIST
        g[listed], h[listed] = self.pairs[:, 0], self.pairs[:, 1]
        weight = runs["weight"][run].astype(np.int64)
        weight[runs["width"][run] != 0] = np.concatenate([np.empty(0, np.int64), *self.weights])
        return g, h, runs["block"][run].astype(np.int64), weight

    @property
    def scale(self):
        """Integer units in one real unit: from the side chunk labl, 1 without one."""
        return next((struct.unpack_from("<I", labl, LABL_SCALE)[0] for name, labl in self.sides if name == "labl"), 1)

    @property
    def encoding(self):
        """The number of the encoding that the side chunk labl names, None without one."""
        return next((struct.unpack_from("<I", labl, LABL_ENCODING)[0] for name, labl in self.sides if name == "labl"), None)

    @property
    def groups_say_all(self):
        """Whether a state is a labelling exactly when each one-hot group has one variable at 1: of other encodings the bridge cannot tell."""
        return self.groups == 0 or (self.encoding in (None, *ONE_HOT_ENCODINGS) and bool(self.one_hot().any()))

    def magnitude(self, dtype):
        """The bound on all energies (FORMAT.md's M), computed in `dtype`: np.int64 is exact where M is below 2^62."""
        a, b = (np.repeat(self.penalties[key].astype(dtype), self.penalties["count"]) for key in "ab")
        size = self.sizes().astype(dtype)
        _, _, block, weight = self.coupled_pairs()
        weights = np.zeros(len(self.blocks), dtype)
        np.add.at(weights, block, np.abs(weight).astype(dtype))
        total = abs(dtype(self.offset)) + np.abs(self.linear.astype(dtype)).sum()
        total += (a * (1 + size) + b * (size * (size - 1) // 2)).sum()
        return total + sum((weight * block.abs_sum(dtype) for weight, block in zip(weights, self.blocks) if weight), dtype(0))


class _Payload:
    """Reads one chunk from front to back; everything wrong is a Corrupt that names the chunk and the byte in it."""

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
        dtype = np.dtype(dtype)
        self.need(count * dtype.itemsize <= self.left(), f"the chunk ends too early for {count} values")
        values = np.frombuffer(self.view, dtype, count, self.at)
        self.at += count * dtype.itemsize
        return values

    def rest(self, dtype):
        """All that is left, as an array."""
        size = np.dtype(dtype).itemsize
        self.need(self.left() % size == 0, f"{self.left()} bytes are no whole number of entries of {size} bytes")
        return self.array(dtype, self.left() // size)

    def end(self):
        self.need(self.left() == 0, f"{self.left()} bytes too many")


def _read_groups(chunks, n, groups):
    part = _Payload(chunks, "GRPS")
    runs = part.rest(GROUP_RUN)
    part.need((runs["count"] >= 1).all() and (runs["size"] >= 1).all(), "an empty run or a group without variables")
    part.need((runs["size"][1:] != runs["size"][:-1]).all(), "neighbouring runs of the same size")
    counts, sizes = runs["count"].astype(np.int64), runs["size"].astype(np.int64)
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
    part, runs, pairs, weights, total = _Payload(chunks, "CPLS"), [], [np.empty((0, 2), "<u4")], [], 0
    for _ in range(part.unpack("<I")[0]):
        run = part.unpack("<IIIiIIIII")
        block, form, width, weight, g, h, count, repeat, stride = run
        part.need(block < blocks, f"block {block} of {blocks}")
        part.need(not runs or block >= runs[-1][0], f"block {block} after block {runs[-1][0] if runs else 0}")
        part.need(form in (LATTICE, LIST) and width in (0, 1, 2, 4), f"unknown form {form} or width {width}")
        part.need((weight == 0) == (width != 0), f"weight {weight} of a run with weights of {width} bytes each")
        part.need(count and repeat, "an empty run")
        part.need(stride >= count if repeat > 1 else stride == 0,
                  f"stride {stride} of a run of {count} pairs, {repeat} times")
        if form == LIST:
            part.need(g == h == stride == 0 and repeat == 1, "g, h, stride or repeat in use in a list of pairs")
            pairs.append(part.array("<u4", 2 * count).reshape(count, 2))
            part.need((pairs[-1][:, 0] <= pairs[-1][:, 1]).all() and pairs[-1].max() < groups, "a pair of no groups")
        else:
            part.need(g <= h and h + (repeat - 1) * stride + count <= groups, "a lattice reaches outside the groups")
        total += count * repeat
        if width:
            weights.append(part.array(f"<i{width}", count * repeat))
        runs.append(run)
    part.end()
    part.need(total == couplings, f"{total} couplings, the header says {couplings}")
    return np.array(runs, COUPLING_RUN), np.concatenate(pairs), weights


def _read_linear(chunks, n):
    part = _Payload(chunks, "LINR")
    base, width, zero = part.unpack("<qII")
    part.need(width in (1, 2, 4, 8) and zero == 0, f"width {width} of the linear terms, or a reserved field in use")
    u = part.array(f"<u{width}", n)
    part.end()
    part.need(n == 0 or base + int(u.min()) >= -MAX_ENERGY and base + int(u.max()) <= MAX_ENERGY, "linear terms above 2^53")
    # Modulo 2^64: base and u may each be far away from their sum.
    return (u.astype(np.uint64) + np.uint64(base % 2**64)).view(np.int64)


def _read_penalties(chunks, groups):
    part = _Payload(chunks, "PNLT")
    width, zero = part.unpack("<II")
    part.need(width in (1, 2, 4, 8) and zero == 0, f"width {width} of the penalties, or a reserved field in use")
    runs = part.rest(penalty_run(width))
    part.need((runs["count"] >= 1).all(), "an empty run")
    part.need(runs["count"].sum(dtype=np.int64) == groups, f"the runs do not have the header's {groups} groups")
    part.need((runs[1:][["a", "b"]] != runs[:-1][["a", "b"]]).all(), "neighbouring runs with the same penalty")
    part.need(least_width(int(max(runs["a"].max(initial=0), runs["b"].max(initial=0)))) == width, f"width {width} is not the least")
    return runs


def least_width(largest):
    """The least of 1, 2, 4, 8 bytes that hold the unsigned integer `largest`."""
    return next(width for width in (1, 2, 4, 8) if largest < 1 << 8 * width)


def _check_couplings(problem):
    """What can only be seen with groups, blocks, couplings and penalties together."""
    g, h, block, _ = problem.coupled_pairs()
    if g.size:
        sizes, shapes = problem.sizes(), np.array([block.shape for block in problem.blocks])
        wrong = (sizes[g] != shapes[block, 0]) | (sizes[h] != shapes[block, 1])
        if wrong.any():
            raise Corrupt(f"chunk CPLS: coupling {wrong.argmax()} has a block of another size than its groups")
        inside = (g == h) & problem.one_hot()[g]
        if inside.any():
            raise Corrupt(f"chunk CPLS: coupling {inside.argmax()} is inside a group that has a penalty")
    # In doubles first: what they find below 2^54 cannot overflow 64-bit integers.
    if problem.magnitude(np.float64) > 2 * MAX_ENERGY or problem.magnitude(np.int64) > MAX_ENERGY:
        raise Corrupt("the coefficients add up to more than 2^53, energies would not be exact")


def _is_mask_sound(labl):
    """Whether a mask in the payload of labl has a grid, and its length."""
    width, height = struct.unpack_from("<II", labl, LABL_GRID)
    cells = width * height
    return struct.unpack_from("<I", labl, LABL_MASK)[0] != 1 or 0 < cells and len(labl) == LABL_SIZE + (cells + 7) // 8


def parse_qcf(data, limit=DEFAULT_LIMIT):
    """The Problem in `data`, the bytes of a whole .qcf. Raises FormatError."""
    header = read_header(data[:HEADER.size], MAGIC, ".qcf")
    check_size(len(data), header.size)
    n, groups, couplings, zero = FIELDS.unpack(header.fields)
    if not (groups <= n <= MAX_COUNT and (groups == 0) == (n == 0) and couplings <= MAX_COUNT and zero == bytes(20)):
        raise Corrupt("byte 24: the header's counts are impossible, or a reserved field is in use")
    check_memory(header.size + 16 * n + 64 * groups + 96 * couplings, limit,
                 f"{n:,} variables, {groups:,} groups and {couplings:,} couplings")
    chunks, sides = read_chunks(data, header, REQUIRED)
    labls = [side for name, side in sides if name == "labl"]
    if len(labls) > 1 or any(len(labl) < LABL_SIZE or not any(labl[LABL_SCALE:LABL_SCALE + 4]) for labl in labls):
        raise Corrupt("chunk labl: it is there twice, it is too short, or its scale is 0")
    if not all(_is_mask_sound(labl) for labl in labls):
        raise Corrupt("chunk labl, byte 60: a mask without a grid, or of another size than the grid")
    if couplings // COUPLINGS_PER_BYTE > len(data):
        raise Corrupt(f"byte 32: {couplings:,} couplings are more than a file of {len(data):,} bytes may name")
    offset = _Payload(chunks, "OFFS")
    group_runs, blocks = _read_groups(chunks, n, groups), _read_blocks(chunks)
    runs, pairs, weights = _read_couplings(chunks, len(blocks), groups, couplings)
    problem = Problem(group_runs, blocks, runs, pairs, weights, _read_linear(chunks, n),
                      _read_penalties(chunks, groups), *offset.unpack("<q"), [(name, bytes(side)) for name, side in sides])
    offset.end()
    _check_couplings(problem)
    return problem


def read_qcf(stream, limit=DEFAULT_LIMIT):
    """Read a .qcf from a binary stream: (Problem, the file's bytes). Raises FormatError, OSError."""
    data = read_stream(stream, MAGIC, ".qcf", limit)
    return parse_qcf(data, limit), data


def pack_qcf(problem):
    """The bytes of `problem` as a .qcf, linear terms and penalties in their least widths. Nothing is checked."""
    couplings, weights, at = [struct.pack("<I", problem.coupling_runs.size)], iter(problem.weights), 0
    for run in problem.coupling_runs:
        couplings.append(run.tobytes())
        if run["form"] == LIST:
            couplings.append(problem.pairs[at:at + run["count"]].astype("<u4").tobytes())
            at += run["count"]
        if run["width"]:
            couplings.append(next(weights).astype(f"<i{run['width']}").tobytes())
    base = int(problem.linear.min()) if problem.linear.size else 0
    u = (problem.linear.view(np.uint64) - np.uint64(base % 2**64))
    linear_width = least_width(int(u.max(initial=0)))
    penalty_width = least_width(int(max(problem.penalties["a"].max(initial=0), problem.penalties["b"].max(initial=0))))
    fields = FIELDS.pack(problem.linear.size, problem.groups, problem.couplings, bytes(20))
    return pack(MAGIC, fields, [
        ("GRPS", problem.group_runs.astype(GROUP_RUN).tobytes()),
        ("BLKS", struct.pack("<I", len(problem.blocks)) + b"".join(block.pack() for block in problem.blocks)),
        ("CPLS", b"".join(couplings)),
        ("LINR", struct.pack("<qII", base, linear_width, 0) + u.astype(f"<u{linear_width}").tobytes()),
        ("PNLT", struct.pack("<II", penalty_width, 0) + problem.penalties.astype(penalty_run(penalty_width)).tobytes()),
        ("OFFS", struct.pack("<q", problem.offset)),
        *problem.sides,
    ])
