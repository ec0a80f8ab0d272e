"""The solver ilp: the least H of all labellings, proven, by HiGHS's integer programs.

A site is a one-hot group (one with a penalty), whose labels are its variables; a domain wall, whose
label is how many of its variables are 1; or any other variable, whose label is its value.
"""

import math
import time

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array

from ..core import merging, models
from ..core.answers import Answer
from ..core.container import check_memory
from ..core.failure import SolverError
from ..core.qcf import DOMAIN_WALL
from . import windows
from .solvers import interruptible

# Peak memory for each cost of a pair of labels, and of HiGHS for each entry of the matrix, as
# measured on programs of 10^5 entries.
COST_BYTES, ENTRY_BYTES = 80, 2500
# What HiGHS takes for 0 in a reduced cost. All columns lie in [0, 1], so a bound of its is wrong
# by this much a column at most.
DUAL_TOLERANCE = 1e-7
# Relative rounding of sums of doubles, far above what sums of 10^6 terms have.
ROUNDING = 2.0**-40
# Seconds that HiGHS may take to notice its time limit before its answer is no longer waited for.
GRACE = 0.25
# The cost of a label that a site does not have, above all sums; and passes that bound the rest.
OUT, PASSES = 2**60, 200


def factors(tables):
    """(What rows cost, what columns cost, the rest): tables[k] as their sum, rest <= 0. Maxima are
    taken from rows first or from columns first, whichever leaves more zeros."""
    rows, columns = tables.max(2), tables.max(1)
    forms = ((rows, (tables - rows[:, :, None]).max(1)),
             ((tables - columns[:, None]).max(2), columns))
    rests = [tables - of_rows[:, :, None] - of_columns[:, None] for of_rows, of_columns in forms]
    best = np.argmin([np.count_nonzero(rest, (1, 2)) for rest in rests], 0)[:, None]
    return (*(np.choose(best, parts) for parts in zip(*forms)), np.choose(best[:, None], rests))


class Labelling:
    """H on all labellings: offset + sum of unary[site, label] + sum over pairs of sites of
    tables[pair, label of left, label of right]; or with `reduced` for `unary` and `rest`, which is
    not above 0, for `tables`. Arrays of i64, padded to the most labels of a site: `there` says
    which are labels. Raises OverLimit."""

    def __init__(self, problem):
        linear, (rows, columns, values), self.offset = models.expand(problem, penalties=False)
        hot = problem.one_hot
        self.wall = problem.encoding == DOMAIN_WALL and not hot.any()
        begins = problem.of_variables(~hot & (not self.wall))
        begins[problem.starts[:-1]] = True
        first, self.site = np.flatnonzero(begins), np.cumsum(begins) - 1
        more = ~hot[problem.group[first]]
        # The label of its site that a variable stands for.
        self.place = np.arange(linear.size) - first[self.site] + more[self.site]
        last = np.bincount(self.site) - 1 + more
        shape = last.size, int(last.max()) + 1
        self.there = np.arange(shape[1]) <= last[:, None]
        self.unary = np.zeros(shape, np.int64)
        self.unary[self.site, self.place] = linear
        own, far = self.site[rows], self.site[columns]
        inner = own == far
        np.add.at(self.unary, (own[inner], self.place[columns[inner]]), values[inner])
        pairs, pair = np.unique((own * shape[0] + far)[~inner], return_inverse=True)
        size = pairs.size * shape[1]**2
        check_memory(COST_BYTES * size, problem.memory_limit, f"tables of {size:,} costs")
        tables = np.zeros((pairs.size, shape[1], shape[1]), np.int64)
        tables[pair, self.place[rows[~inner]], self.place[columns[~inner]]] = values[~inner]
        if self.wall:
            self.unary, tables = self.unary.cumsum(1), tables.cumsum(1).cumsum(2)
        self.left, self.right = pairs // shape[0], pairs % shape[0]
        # What is no label costs what the last one does, so that no maximum of a table is another.
        ends = np.minimum(np.arange(shape[1]), last[[self.left, self.right], None])
        tables = np.take_along_axis(np.take_along_axis(
            tables, ends[0, :, :, None], 1), ends[1, :, None], 2)
        *costs, rest = factors(tables)
        rest[~(self.there[self.left][:, :, None] & self.there[self.right][:, None])] = 0
        # A pair without a rest is no pair: its costs are those of its sites.
        kept = rest.any((1, 2))
        for site, of_end in zip((self.left, self.right), costs):
            np.add.at(self.unary, site[~kept], of_end[~kept])
        self.reduced = self.unary.copy()
        for site, of_end in zip((self.left, self.right), costs):
            np.add.at(self.reduced, site[kept], of_end[kept])
        self.left, self.right, self.tables, self.rest = (
            array[kept] for array in (self.left, self.right, tables, rest))

    def bits(self, x):
        """The state of a labelling: i64 array."""
        label = x[self.site]
        return (self.place <= label if self.wall else self.place == label).astype(np.int64)

    def labels(self, bits):
        """The labelling of a state."""
        x, ones = np.zeros(self.there.shape[0], np.int64), np.flatnonzero(bits)
        np.maximum.at(x, self.site[ones], self.place[ones])
        return x

    def energies(self, x, part):
        """i64 array (sites,): at the number of each part what a labelling costs there."""
        total = np.zeros(x.size, np.int64)
        np.add.at(total, part, self.unary[np.arange(x.size), x])
        np.add.at(total, part[self.left],
                  self.tables[np.arange(self.left.size), x[self.left], x[self.right]])
        return total

    def better(self, states, part):
        """(The labelling that is in each part the best of these states, its energies)."""
        found = [self.labels(bits) for bits in states]
        energies = np.array([self.energies(x, part) for x in found])
        return np.choose(energies.argmin(0)[part], found), energies.min(0)


def beliefs(p, scale, over):
    """i64 array (sites, labels): bounds, in 1 / scale, of what labels cost. H less the offset is at
    least the sum of each site's least, and with another label by so much more. over(beliefs) ends
    the passes.

    Sites share their costs among their pairs, and each pair gives half of what its labels cost at
    least back to either end. No such pass lowers the bound, and all numbers are whole.
    """
    belief, tables = scale * np.where(p.there, p.unary, OUT // scale), scale * p.tables
    degree = np.bincount(np.append(p.left, p.right), minlength=p.there.shape[0])[:, None]
    before = None
    for _ in range(PASSES):
        share = belief // np.maximum(degree, 1) * (degree > 0)
        belief -= share * degree
        tables += share[p.left][:, :, None] + share[p.right][:, None]
        halves = tables.min(2) // 2, tables.min(1) // 2
        tables -= halves[0][:, :, None] + halves[1][:, None]
        np.add.at(belief, p.left, halves[0])
        np.add.at(belief, p.right, halves[1])
        total = belief.min(1).sum()
        if over(belief) or before is not None and total - before < scale:
            break
        before = total
    return belief


def program(p, sites, there, limit):
    """(Costs, constraints) of the program of some sites with the labels `there`, bool (sites,
    labels): a column for each label, then one for each product of two labels that lowers the cost.
    One label of each site is 1, and at each label the products of each pair are at most the label,
    in all: the relaxation by marginals of sites and pairs, without what costs nothing."""
    inside, number = np.zeros(p.there.shape, bool), np.full(p.there.shape, -1)
    inside[sites] = there
    count = int(inside.sum())
    number[inside] = np.arange(count)
    pair, one, other = np.nonzero(p.rest * (inside[p.left][:, :, None] & inside[p.right][:, None]))
    entries = count + 4 * pair.size
    check_memory(ENTRY_BYTES * entries, limit, f"an integer program of {entries:,} entries")
    ends = np.append(number[p.left[pair], one], number[p.right[pair], other])
    _, chosen, link = np.unique(
        np.append(pair, pair + p.left.size) * p.there.shape[1] + np.append(one, other),
        return_index=True, return_inverse=True)
    groups, product = sites.size, count + np.arange(pair.size)
    rows = np.concatenate((np.nonzero(there)[0], groups + link.ravel(),
                           groups + np.arange(chosen.size)))
    columns = np.concatenate((np.arange(count), product, product, ends[chosen]))
    entries = np.repeat([1.0, -1.0], [rows.size - chosen.size, chosen.size])
    matrix = coo_array((entries, (rows, columns)), (groups + chosen.size, count + pair.size))
    sides = (np.repeat([low, high], [groups, chosen.size]) for low, high in (
        (1.0, -np.inf), (1.0, 0.0)))
    return (np.append(p.reduced[inside], p.rest[pair, one, other]),
            LinearConstraint(matrix.tocsr(), *sides))


def solve(costs, count, rules, best, low, seconds):
    """(The values of the first `count` columns that HiGHS finds, or None; a proven lower bound) of
    the program with these costs and constraints, where a state of energy `best` and the bound `low`
    are known."""
    # All energies are multiples of the unit: nothing is better than the best by less than that. The
    # gap is less by what bounds may be wrong, there and in what is claimed here.
    unit = max(1, int(np.gcd.reduce(costs)))
    cost, reach = costs / unit, max(abs(best), abs(low), unit) / unit
    margin = DUAL_TOLERANCE * cost.size + ROUNDING * float(np.abs(cost).sum())
    gap = max(0.0, 1 - 2 * margin) / reach
    # Presolve makes these programs two to twelve times slower, and would leave out what is not
    # better by 1, to a tolerance of its own.
    found = milp(cost, integrality=np.arange(cost.size) < count, bounds=Bounds(0, 1),
                 constraints=rules, options={
                     "presolve": False, "mip_rel_gap": gap,
                     "time_limit": min(max(0.0, seconds), 1e9)})
    if found.status not in (0, 1):
        raise SolverError(f"HiGHS fails ({found.message}); please report this")
    # What it left out was no less than its best solution less the gap, which is a share of that
    # solution, however bad.
    proven = [bound for bound in (found.mip_dual_bound, None if found.fun is None else
                                  found.fun - gap * max(reach, abs(found.fun)))
              if bound is not None and math.isfinite(bound)]
    if proven:
        low = max(low, unit * math.ceil(min(proven) - margin))
    return None if found.x is None else np.rint(found.x[:count]).astype(np.int64), low


class Search:
    """One program after another. Whoever stops waiting finds in `bits` a labelling, in `bound` what
    is proven of all (None: nothing yet), in `text` where it is."""

    def __init__(self, problem, options):
        self.problem = problem
        self.stop = time.monotonic() + (options.time_limit or math.inf)
        self.bits, self.bound, self.text = problem.known, None, "building"
        if self.bits is None:
            self.bits = windows.begin(problem)
        self.info = {"components": 0, "open_components": 0}

    def run(self):
        problem, p = self.problem, Labelling(self.problem)
        scale = OUT // 2 // int(problem.magnitude(np.int64) + 1)

        def over(belief):
            if problem.known is None:
                self.bits = p.bits(belief.argmin(1))
            self.bound = p.offset - int(-belief.min(1).sum() // scale)
            return time.monotonic() >= self.stop
        self.text = "bounding"
        belief, part = beliefs(p, scale, over), models.components(len(p.there), p.left, p.right)
        least, bounds = belief.min(1), np.zeros(part.size, np.int64)
        np.add.at(bounds, part, least)
        room, bounds = -bounds, -(-bounds // scale)
        states = [p.bits(belief.argmin(1))] + [problem.known] * (problem.known is not None)
        x, best = p.better(states, part)
        self.tell(p, x, best, bounds)
        x, best = p.better([p.bits(x), *merging.descend(problem, p.bits(x)[None])], part)
        open_parts = np.flatnonzero(best > bounds)
        self.info["components"] = np.unique(part[p.left]).size
        order = open_parts[np.argsort(np.bincount(part)[open_parts], kind="stable")]
        for number, k in enumerate(order.tolist(), 1):
            self.tell(p, x, best, bounds)
            if time.monotonic() >= self.stop:
                break
            sites = np.flatnonzero(part == k)
            self.text = f"program {number:,} of {order.size:,}, {sites.size:,} sites"
            # No better labelling has a label that costs more than what is between best and bound.
            there = p.there[sites] & (
                belief[sites] - least[sites, None] <= room[k] + scale * best[k])
            costs, rules = program(p, sites, there, problem.memory_limit)
            values, bounds[k] = solve(costs, there.sum(), rules, int(best[k]), int(bounds[k]),
                                      self.stop - time.monotonic())
            if values is not None:
                # What the search finds is checked like anything from outside.
                chosen, y = np.zeros(there.shape, np.int64), x.copy()
                chosen[there] = values
                y[sites] = chosen.argmax(1)
                energy = int(p.energies(y, part)[k])
                if (chosen.sum(1) == 1).all() and energy < best[k]:
                    x, best[k] = y, energy
        self.tell(p, x, best, bounds)

    def tell(self, p, x, best, bounds):
        self.bits, self.bound = p.bits(x), p.offset + int(bounds.sum())
        self.info["open_components"] = int((best > bounds).sum())


def ilp(problem, options, progress):
    """The least labelling and its proof; a time limit leaves the best that was found and what was
    proven until then."""
    search = Search(problem, options)
    # HiGHS looks at its clock rarely: some of its steps take minutes on large programs.
    interruptible(search.run, lambda: progress(search.text), search.stop + GRACE)
    bits = search.bits[None].astype(np.uint8)
    return Answer(bits, models.energies(problem, bits, penalties=False), objective=True,
                  lower_bound=search.bound,
                  info={"parameters": {"time_limit": options.time_limit}, **search.info})
