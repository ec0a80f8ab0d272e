"""Problems for tests and benchmarks: random ones with every feature of the format, and grids as
`qstereo` makes them.
"""

import dataclasses
import itertools
import struct

import numpy as np
from qstereo_bridge.core import container, qcf

# The fields of a coupling run, in the file's order.
RUN = ("block", "form", "width", "weight", "g", "h", "count", "repeat", "stride")


def runs_of(values):
    """[(count, value)] of neighbouring equal values."""
    found = []
    for value in values:
        if found and found[-1][1] == value:
            found[-1][0] += 1
        else:
            found.append([1, value])
    return found


@dataclasses.dataclass
class Table:
    """A block as the file has it, entry by entry."""

    table: np.ndarray

    def entry(self, i, j):
        return int(self.table[i, j])

    def pack(self):
        return struct.pack("<III", *self.table.shape, 0) + self.table.astype("<i4").tobytes()


@dataclasses.dataclass
class Toeplitz:
    """A block as the file has it: values[j - i - first], and `fill` outside the values."""

    shape: tuple
    fill: int
    first: int
    values: np.ndarray

    def entry(self, i, j):
        k = j - i - self.first
        return int(self.values[k]) if 0 <= k < self.values.size else self.fill

    def pack(self):
        head = struct.pack("<IIIiiI", *self.shape, 1, self.fill, self.first, self.values.size)
        return head + self.values.astype("<i4").tobytes()


@dataclasses.dataclass
class Raw:
    """What a .qcf holds, in plain lists; see make()."""

    sizes: list
    blocks: list
    couplings: list
    linear: np.ndarray
    penalties: list
    offset: int
    sides: list

    def pack(self):
        """The bytes of the file, linear terms and penalties in their least widths. Nothing is
        checked.
        """

        def least(largest):
            return next(width for width in (1, 2, 4, 8) if largest < 1 << 8 * width)

        runs, count = b"", 0
        for run in self.couplings:
            runs += struct.pack("<IIIiIIIII", *(run[name] for name in RUN))
            count += run["count"] * run["repeat"]
            runs += np.array(run["pairs"], "<u4").tobytes() if run["form"] == 1 else b""
            runs += (
                np.array(run["weights"]).astype(f"<i{run['width']}").tobytes()
                if run["width"]
                else b""
            )
        linear = np.array(self.linear, np.int64)
        base = int(linear.min()) if linear.size else 0
        u = linear.view(np.uint64) - np.uint64(base % 2**64)
        width, wide = least(int(u.max(initial=0))), least(
            max((max(pair) for pair in self.penalties), default=0)
        )
        return container.pack(
            qcf.MAGIC,
            qcf.FIELDS.pack(linear.size, len(self.sizes), count, bytes(20)),
            [
                ("GRPS", b"".join(struct.pack("<II", *run) for run in runs_of(self.sizes))),
                (
                    "BLKS",
                    struct.pack("<I", len(self.blocks))
                    + b"".join(block.pack() for block in self.blocks),
                ),
                ("CPLS", struct.pack("<I", len(self.couplings)) + runs),
                ("LINR", struct.pack("<qII", base, width, 0) + u.astype(f"<u{width}").tobytes()),
                (
                    "PNLT",
                    struct.pack("<II", wide, 0)
                    + b"".join(
                        struct.pack("<I", count) + np.array(pair, f"<u{wide}").tobytes()
                        for count, pair in runs_of(self.penalties)
                    ),
                ),
                ("OFFS", struct.pack("<q", self.offset)),
                *self.sides,
            ],
        )


def made(raw):
    """The Problem in a Raw, which it knows as `raw`."""
    problem = qcf.parse_qcf(raw.pack())
    problem.raw = raw
    return problem


def pack_qcf(problem, **changed):
    """The bytes of the file that a problem was made of, some of its Raw's fields changed."""
    return dataclasses.replace(problem.raw, **changed).pack()


def altered(problem, **changed):
    """The problem with some of its Raw's fields changed."""
    return made(dataclasses.replace(problem.raw, **changed))


def make(sizes, blocks, couplings, linear, penalties, offset=0, sides=()):
    """A Problem from plain lists.

    sizes: variables of each group; penalties: (a, b) of each group; couplings: a list of dicts with
    the fields of a
    coupling run, and `pairs` and `weights` where the run has any; they are put in the order of
    their blocks.
    """
    default = {**dict.fromkeys(RUN, 0), "count": 1, "repeat": 1}
    runs = [{**default, **run} for run in couplings]
    return made(
        Raw(
            list(sizes),
            blocks,
            sorted(runs, key=lambda run: run["block"]),
            np.array(linear, np.int64),
            list(penalties),
            offset,
            list(sides),
        )
    )


def random_block(rng, rows, columns):
    if rng.random() < 0.5:
        return Table(rng.integers(-3, 4, (rows, columns)).astype("<i4"))
    first = int(rng.integers(1 - rows, columns))
    count = int(rng.integers(0, columns - first + 1))
    return Toeplitz(
        (rows, columns),
        int(rng.integers(-1, 2)),
        first if count else 0,
        rng.integers(-3, 4, count).astype("<i4"),
    )


def random_problem(seed, variables=12):
    """At most `variables` variables: groups of several sizes, one-hot and not, coupled by lattices
    and lists, with
    weights for the run and for each pair, repeated pairs, couplings inside groups, side chunks."""
    rng = np.random.default_rng(seed)
    uniform, sizes = rng.random() < 0.5, []
    size = int(rng.integers(1, 5))
    while sum(sizes) + size <= variables and (not sizes or rng.random() < 0.9):
        sizes.append(size)
        size = size if uniform else int(rng.integers(1, 5))
    penalties = [
        (
            (int(rng.integers(0, 9)), int(rng.integers(0, 2) * rng.integers(0, 300)))
            if rng.random() < 0.7
            else (0, 0)
        )
        for _ in sizes
    ]
    blocks, couplings, shapes = [], [], {}

    def block_for(g, h):
        shape = sizes[g], sizes[h]
        if shape not in shapes or rng.random() < 0.2:
            shapes[shape] = len(blocks)
            blocks.append(random_block(rng, *shape))
        return shapes[shape]

    def weigh(coupling, count):
        if rng.random() < 0.5:
            return {**coupling, "weight": int(rng.choice([-2, -1, 1, 3]))}
        return {
            **coupling,
            "width": int(rng.choice([1, 2, 4])),
            "weights": rng.integers(-2, 3, count),
        }

    for _ in range(int(rng.integers(0, 5))):
        g, h = sorted(rng.integers(0, len(sizes), 2).tolist())
        if g == h and any(penalties[g]):
            continue
        matching = [
            (p, q)
            for p in range(len(sizes))
            for q in range(p, len(sizes))
            if (sizes[p], sizes[q]) == (sizes[g], sizes[h]) and not (p == q and any(penalties[p]))
        ]
        chosen = [matching[k] for k in rng.integers(0, len(matching), int(rng.integers(1, 4)))]
        couplings.append(
            weigh(
                {"block": block_for(g, h), "form": 1, "count": len(chosen), "pairs": chosen},
                len(chosen),
            )
        )
    if uniform and len(sizes) >= 2:
        width = int(rng.integers(2, len(sizes) + 1))
        height = len(sizes) // width
        couplings.append(
            weigh(
                {
                    "block": block_for(0, 1),
                    "g": 0,
                    "h": 1,
                    "count": width - 1,
                    "repeat": height,
                    "stride": width if height > 1 else 0,
                },
                (width - 1) * height,
            )
        )
        if height > 1:
            couplings.append(
                weigh(
                    {"block": block_for(0, 1), "g": 0, "h": width, "count": width * (height - 1)},
                    width * (height - 1),
                )
            )
    sides = [("labl", bytes(16) + (2).to_bytes(4, "little") + bytes(44)), ("note", b"kept")][
        : int(rng.integers(0, 3))
    ]
    return make(
        sizes,
        blocks,
        couplings,
        rng.integers(-9, 300, sum(sizes)),
        penalties,
        int(rng.integers(-99, 99)),
        sides,
    )


def grid(width, height, labels, dense=False, weight=20, seed=0):
    """A Potts problem on a 4-neighbour grid with proven penalties, as `one-hot` (dense) or
    `one-hot-sparse`.
    """
    rng = np.random.default_rng(seed)
    block = (
        Toeplitz((labels, labels), 1, 0, np.array([0], "<i4"))
        if dense
        else Toeplitz((labels, labels), 0, 0, np.array([-1], "<i4"))
    )
    couplings = []
    if width > 1:
        couplings.append(
            {
                "weight": weight,
                "h": 1,
                "count": width - 1,
                "repeat": height,
                "stride": width if height > 1 else 0,
            }
        )
    if height > 1:
        couplings.append({"weight": weight, "h": width, "count": width * (height - 1)})
    degree = np.full((height, width), 4)
    for edge in (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]):
        degree[edge] -= 1
    incident = (weight * degree).ravel().tolist()
    costs = rng.integers(0, 100, (width * height, labels))
    edges = (width - 1) * height + width * (height - 1)
    return make(
        [labels] * (width * height),
        [block],
        couplings,
        (costs - costs.min(1, keepdims=True)).ravel(),
        [(w + 1, w + 2) if dense else (1, w + 2) for w in incident],
        int(costs.min(1).sum()) + (0 if dense else weight * edges),
    )


def carrying(encoding, labels, numbers, bound=-(2**63)):
    """The side chunks of a file that carries a labelling (numbers of the groups' labels), and the
    bound beside it."""
    width = 1 if labels <= 255 else 2
    return [
        ("labl", struct.pack("<16I", encoding, 0, 0, labels, 1, *[0] * 11)),
        ("best", struct.pack("<qII", bound, width, 0) + np.array(numbers, f"<u{width}").tobytes()),
    ]


def nothing(offset=0, sides=()):
    """A problem in which nothing is left to decide."""
    return make([], [], [], [], [], offset, sides)


def domain_walls(width, height, labels, weight=20, seed=0):
    """Potts on a 4-neighbour grid by domain walls, labels - 1 free variables a site: (problem,
    costs of each site and label).

    The ones of a site come first; kappa (1 - u_i) u_(i+1) keeps them there.
    """
    rng = np.random.default_rng(seed)
    costs, k, sites = rng.integers(0, 100, (width * height, labels)), labels - 1, width * height
    edges = [(p, p + 1) for p in range(sites) if (p + 1) % width] + [
        (p, p + width) for p in range(sites - width)
    ]
    kappa = int(costs.max()) + 4 * weight + 1
    linear = np.diff(costs, axis=1)
    linear[:, 1:] += kappa
    np.add.at(linear[:, 0], np.array(edges, np.int64).reshape(-1, 2).ravel(), weight)
    values = np.array([1, -2, 1] if k > 1 else [-2], "<i4")
    blocks = [Toeplitz((k, k), 0, -1 if k > 1 else 0, values)]
    couplings = (
        [{"form": 1, "weight": weight, "count": len(edges), "pairs": edges}] if edges else []
    )
    if k > 1:
        blocks.append(Toeplitz((k, k), 0, 1, np.array([-1], "<i4")))
        couplings += [
            {
                "block": 1,
                "form": 1,
                "weight": kappa,
                "count": sites,
                "pairs": [(p, p) for p in range(sites)],
            }
        ]
    return (
        make(
            [k] * sites, blocks, couplings, linear.ravel(), [(0, 0)] * sites, int(costs[:, 0].sum())
        ),
        costs,
        edges,
    )


def least_of_potts(costs, edges, weight=20):
    """The least energy of all labellings, one by one."""
    sites, labels = costs.shape
    every = np.array(list(itertools.product(range(labels), repeat=sites)))
    energies = costs[np.arange(sites), every].sum(1)
    return int(
        (energies + weight * sum((every[:, p] != every[:, q]).astype(int) for p, q in edges)).min()
    )


def all_states(n):
    return np.array(list(itertools.product((0, 1), repeat=n)), np.uint8)


def energy_by_definition(problem, x):
    """H of one state, written down from docs/FORMAT.md term by term."""
    raw = problem.raw
    starts, total = [0, *itertools.accumulate(raw.sizes)], raw.offset
    total += sum(int(c) for c, value in zip(raw.linear, x) if value)
    for g, size in enumerate(raw.sizes):
        s, (a, b) = sum(int(value) for value in x[starts[g] : starts[g] + size]), raw.penalties[g]
        total += a * (1 - s) + b * s * (s - 1) // 2
    for run in raw.couplings:
        pairs = iter(np.array(run.get("pairs", [])).reshape(-1, 2).tolist())
        weigh = (
            iter(np.array(run["weights"]).tolist())
            if run["width"]
            else itertools.repeat(run["weight"])
        )
        for r in range(run["repeat"]):
            for c in range(run["count"]):
                step = r * run["stride"] + c
                p, q = next(pairs) if run["form"] == 1 else (run["g"] + step, run["h"] + step)
                w = next(weigh)
                for i in range(raw.sizes[p]):
                    for j in range(i + 1 if p == q else 0, raw.sizes[q]):
                        total += (
                            w
                            * raw.blocks[run["block"]].entry(i, j)
                            * int(x[starts[p] + i])
                            * int(x[starts[q] + j])
                        )
    return total
