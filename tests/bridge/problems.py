"""Problems for tests and benchmarks: random ones with every feature of the format, and grids as `qstereo` makes them."""

import itertools

import numpy as np
from qstereo_bridge import qcf


def runs_of(values):
    """[(count, value)] of neighbouring equal values."""
    found = []
    for value in values:
        if found and found[-1][1] == value:
            found[-1][0] += 1
        else:
            found.append([1, value])
    return found


def make(sizes, blocks, couplings, linear, penalties, offset=0, sides=()):
    """A Problem from plain lists.

    sizes: variables of each group; penalties: (a, b) of each group; couplings: a list of dicts with the fields of a
    coupling run, and `pairs` and `weights` where the run has any; they are put in the order of their blocks.
    """
    runs, pairs, weights = [], [np.empty((0, 2), "<u4")], []
    for coupling in sorted(couplings, key=lambda coupling: coupling.get("block", 0)):
        run = {"block": 0, "form": 0, "width": 0, "weight": 0, "g": 0, "h": 0, "count": 1, "repeat": 1, "stride": 0}
        run.update({key: value for key, value in coupling.items() if key in run})
        runs.append(tuple(run.values()))
        if "pairs" in coupling:
            pairs.append(np.array(coupling["pairs"], "<u4").reshape(-1, 2))
        if run["width"]:
            weights.append(np.array(coupling["weights"], f"<i{run['width']}"))
    largest = max((max(pair) for pair in penalties), default=0)
    return qcf.Problem(
        np.array([tuple(run) for run in runs_of(sizes)], qcf.GROUP_RUN), blocks, np.array(runs, qcf.COUPLING_RUN),
        np.concatenate(pairs), weights, np.array(linear, np.int64),
        np.array([(count, *pair) for count, pair in runs_of(penalties)], qcf.penalty_run(qcf.least_width(largest))),
        offset, list(sides))


def random_block(rng, rows, columns):
    if rng.random() < 0.5:
        return qcf.Table(rng.integers(-3, 4, (rows, columns)).astype("<i4"))
    first = int(rng.integers(1 - rows, columns))
    count = int(rng.integers(0, columns - first + 1))
    return qcf.Toeplitz((rows, columns), int(rng.integers(-1, 2)), first if count else 0,
                        rng.integers(-3, 4, count).astype("<i4"))


def random_problem(seed, variables=12):
    """At most `variables` variables: groups of several sizes, one-hot and not, coupled by lattices and lists, with
    weights for the run and for each pair, repeated pairs, couplings inside groups, side chunks."""
    rng = np.random.default_rng(seed)
    uniform, sizes = rng.random() < 0.5, []
    size = int(rng.integers(1, 5))
    while sum(sizes) + size <= variables and (not sizes or rng.random() < 0.9):
        sizes.append(size)
        size = size if uniform else int(rng.integers(1, 5))
    penalties = [(int(rng.integers(0, 9)), int(rng.integers(0, 2) * rng.integers(0, 300))) if rng.random() < 0.7 else (0, 0)
                 for _ in sizes]
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
        return {**coupling, "width": int(rng.choice([1, 2, 4])), "weights": rng.integers(-2, 3, count)}

    for _ in range(int(rng.integers(0, 5))):
        g, h = sorted(rng.integers(0, len(sizes), 2).tolist())
        if g == h and any(penalties[g]):
            continue
        matching = [(p, q) for p in range(len(sizes)) for q in range(p, len(sizes))
                    if (sizes[p], sizes[q]) == (sizes[g], sizes[h]) and not (p == q and any(penalties[p]))]
        chosen = [matching[k] for k in rng.integers(0, len(matching), int(rng.integers(1, 4)))]
        couplings.append(weigh({"block": block_for(g, h), "form": 1, "count": len(chosen), "pairs": chosen}, len(chosen)))
    if uniform and len(sizes) >= 2:
        width = int(rng.integers(2, len(sizes) + 1))
        height = len(sizes) // width
        couplings.append(weigh({"block": block_for(0, 1), "g": 0, "h": 1, "count": width - 1, "repeat": height,
                                "stride": width if height > 1 else 0}, (width - 1) * height))
        if height > 1:
            couplings.append(weigh({"block": block_for(0, 1), "g": 0, "h": width, "count": width * (height - 1)},
                                   width * (height - 1)))
    sides = [("labl", bytes(16) + (2).to_bytes(4, "little") + bytes(44)), ("note", b"kept")][:int(rng.integers(0, 3))]
    return make(sizes, blocks, couplings, rng.integers(-9, 300, sum(sizes)), penalties, int(rng.integers(-99, 99)), sides)


def grid(width, height, labels, dense=False, weight=20, seed=0):
    """A Potts problem on a 4-neighbour grid with proven penalties, as `one-hot` (dense) or `one-hot-sparse`."""
    rng = np.random.default_rng(seed)
    block = (qcf.Toeplitz((labels, labels), 1, 0, np.array([0], "<i4")) if dense
             else qcf.Toeplitz((labels, labels), 0, 0, np.array([-1], "<i4")))
    couplings = []
    if width > 1:
        couplings.append({"weight": weight, "h": 1, "count": width - 1, "repeat": height, "stride": width if height > 1 else 0})
    if height > 1:
        couplings.append({"weight": weight, "h": width, "count": width * (height - 1)})
    degree = np.full((height, width), 4)
    for edge in (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]):
        degree[edge] -= 1
    incident = (weight * degree).ravel().tolist()
    costs = rng.integers(0, 100, (width * height, labels))
    edges = (width - 1) * height + width * (height - 1)
    return make([labels] * (width * height), [block], couplings, (costs - costs.min(1, keepdims=True)).ravel(),
                [(w + 1, w + 2) if dense else (1, w + 2) for w in incident],
                int(costs.min(1).sum()) + (0 if dense else weight * edges))


def nothing(offset=0, sides=()):
    """A problem in which nothing is left to decide."""
    return make([], [], [], [], [], offset, sides)


def domain_walls(width, height, labels, weight=20, seed=0):
    """Potts on a 4-neighbour grid by domain walls, labels - 1 free variables a site: (problem, costs of each site and label).

    The ones of a site come first; kappa (1 - u_i) u_(i+1) keeps them there.
    """
    rng = np.random.default_rng(seed)
    costs, k, sites = rng.integers(0, 100, (width * height, labels)), labels - 1, width * height
    edges = [(p, p + 1) for p in range(sites) if (p + 1) % width] + [(p, p + width) for p in range(sites - width)]
    kappa = int(costs.max()) + 4 * weight + 1
    linear = np.diff(costs, axis=1)
    linear[:, 1:] += kappa
    np.add.at(linear[:, 0], np.array(edges, np.int64).reshape(-1, 2).ravel(), weight)
    values = np.array([1, -2, 1] if k > 1 else [-2], "<i4")
    blocks = [qcf.Toeplitz((k, k), 0, -1 if k > 1 else 0, values)]
    couplings = [{"form": 1, "weight": weight, "count": len(edges), "pairs": edges}] if edges else []
    if k > 1:
        blocks.append(qcf.Toeplitz((k, k), 0, 1, np.array([-1], "<i4")))
        couplings += [{"block": 1, "form": 1, "weight": kappa, "count": sites, "pairs": [(p, p) for p in range(sites)]}]
    return make([k] * sites, blocks, couplings, linear.ravel(), [(0, 0)] * sites, int(costs[:, 0].sum())), costs, edges


def least_of_potts(costs, edges, weight=20):
    """The least energy of all labellings, one by one."""
    sites, labels = costs.shape
    every = np.array(list(itertools.product(range(labels), repeat=sites)))
    energies = costs[np.arange(sites), every].sum(1)
    return int((energies + weight * sum((every[:, p] != every[:, q]).astype(int) for p, q in edges)).min())


def all_states(n):
    return np.array(list(itertools.product((0, 1), repeat=n)), np.uint8)


def energy_by_definition(problem, x):
    """H of one state, written down from docs/FORMAT.md term by term."""
    starts, sizes = problem.starts().tolist(), problem.sizes().tolist()
    a, b = (values.tolist() for values in problem.penalty_pairs())
    total = problem.offset + sum(int(c) for c, value in zip(problem.linear, x) if value)
    for g, size in enumerate(sizes):
        s = sum(int(value) for value in x[starts[g]:starts[g] + size])
        total += a[g] * (1 - s) + b[g] * s * (s - 1) // 2
    pairs, weights = iter(problem.pairs.tolist()), iter(problem.weights)
    for run in problem.coupling_runs:
        block, form, width, weight, g, h, count, repeat, stride = run.tolist()
        weigh = iter(next(weights).tolist()) if width else iter([weight] * (count * repeat))
        for r in range(repeat):
            for c in range(count):
                p, q = next(pairs) if form == 1 else (g + r * stride + c, h + r * stride + c)
                w = next(weigh)
                for i in range(sizes[p]):
                    for j in range(i + 1 if p == q else 0, sizes[q]):
                        total += w * entry(problem.blocks[block], i, j) * int(x[starts[p] + i]) * int(x[starts[q] + j])
    return total


def entry(block, i, j):
    if isinstance(block, qcf.Table):
        return int(block.table[i, j])
    k = j - i - block.first
    return int(block.values[k]) if 0 <= k < block.values.size else block.fill
