"""The solver ilp: the least H of all labellings, proven, by HiGHS's integer programs.

A labelling has exactly one variable at 1 in every one-hot group (one with a penalty): there all
penalties are 0 and are left out. A group without a penalty is so many free variables. Each
connected part of the problem is a program of its own.
"""

import math
import time
from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array

from . import models
from .container import check_memory
from .failure import SolverError
from .solvers import Answer, interruptible

# Peak memory of HiGHS for each entry of the matrix, as measured on programs of 10^5 entries.
ENTRY_BYTES = 2500
# What HiGHS takes for 0 in a reduced cost. All columns lie in [0, 1], so a bound of its is wrong
# by this much a column at most.
DUAL_TOLERANCE = 1e-7
# Relative rounding of sums of doubles, far above what sums of 10^6 terms have.
ROUNDING = 2.0**-40
# Columns up to which small parts share a program: each call of HiGHS costs some milliseconds.
BATCH = 200
# Seconds that HiGHS may take to notice its time limit before its answer is no longer waited for.
GRACE = 0.25


@dataclass
class Form:
    """H on all labellings: offset + sum_i linear_i x_i - sum_t cost_t * left_t * right_t, cost > 0.

    The literal i < n is x_i, n + i is 1 - x_i. `coupling` is the coupling that each product is of,
    `site` the one-hot group or free variable of each variable; `first` and `hot` say of each site
    its first variable and whether it is a one-hot group. `twice`: no labelling costs less than the
    half of its sum over the variables at 1. All are i64 arrays.
    """

    offset: int
    linear: np.ndarray
    twice: np.ndarray
    left: np.ndarray
    right: np.ndarray
    cost: np.ndarray
    coupling: np.ndarray
    site: np.ndarray
    first: np.ndarray
    hot: np.ndarray

    def best(self, costs):
        """The labelling that is best by these costs of the variables alone."""
        best, x = np.lexsort((costs, self.site))[self.first], np.zeros(costs.size, np.int64)
        x[best[self.hot | (costs[best] < 0)]] = 1
        return x

    def products(self, x):
        """The value of each product in the state `x`."""
        literals = np.concatenate((x, 1 - x))
        return literals[self.left] * literals[self.right]


def _not_above_zero(table):
    """table[i, j] = of_rows[i] + of_columns[j] + rest[i, j] with rest <= 0: maxima are taken from
    the rows first or from the columns first, whichever leaves more zeros."""
    def rows_first(table):
        of_rows = table.max(1)
        of_columns = (table - of_rows[:, None]).max(0)
        return of_rows, of_columns, table - of_rows[:, None] - of_columns

    one, (columns, rows, rest) = rows_first(table), rows_first(table.T)
    nothing = np.zeros(table.shape[0], int), np.zeros(table.shape[1], int), table
    forms = [one, (rows, columns, rest.T)] + [nothing] * bool((table <= 0).all())
    return min(forms, key=lambda form: np.count_nonzero(form[2]))


def _add(total, ends, times, costs):
    """Adds to the totals of variables what rows and columns of a block cost, in each coupling."""
    for first, of_end in zip(ends, costs):
        np.add.at(total, first + np.arange(of_end.size), times * of_end)


def reduce(problem):
    """The Form of `problem`, each of its blocks written with factors below 0. Raises OverLimit."""
    starts, one_hot, linear = problem.starts[:-1], problem.one_hot, problem.linear.copy()
    free, n = ~problem.of_variables(one_hot), linear.size
    begins, twice = free.copy(), 2 * problem.linear
    begins[starts] = True
    first = np.flatnonzero(begins)
    g, h, block, weight = problem.couplings
    kind = 8 * block + 4 * (g == h) + 2 * (one_hot[g] & one_hot[h]) + (weight < 0)
    parts, entries = [np.empty((4, 0), np.int64)], 0
    for each in np.unique(kind[weight != 0]).tolist():
        content, these = problem.blocks[each // 8], np.flatnonzero((kind == each) & (weight != 0))
        rows, columns = content.shape
        check_memory(40 * rows * columns, problem.memory_limit,
                     f"a block of {rows:,} x {columns:,}")
        table = content.astype(np.int64) * (-1 if each & 1 else 1)
        table = np.triu(table, 1) if each & 4 else table
        above, beside = starts[g[these], None], starts[h[these], None]
        ends, times = (above, beside), np.abs(weight[these, None])
        shares = [np.minimum(table, 0).sum(axis) for axis in (1, 0)]
        if each & 2:
            *unary, rest = _not_above_zero(table)
            _add(linear, ends, times, unary)
            # Each end has half of what the block costs at least; where no product is left, its own.
            shares = ([table.min(axis) for axis in (1, 0)] if rest.any() else
                      [2 * costs for costs in unary])
            table = rest
        _add(twice, ends, times, shares)
        i, j = np.nonzero(table)
        entries += 3 * i.size * these.size
        check_memory(ENTRY_BYTES * entries, problem.memory_limit,
                     f"an integer program of {entries:,} entries")
        left, right, value = above + i, beside + j, times * table[i, j]
        # What is above 0 has a free variable: v x y = v y - v (1 - x) y.
        for this, other in ((left, right), (right, left)):
            turned = (value > 0) & free[this % n]
            np.add.at(linear, other[turned] % n, value[turned])
            this[turned] += n
            value[turned] *= -1
        number = np.broadcast_to(these[:, None], value.shape)
        parts.append(np.stack([left, right, -value, number]).reshape(4, -1))
    return Form(problem.offset, linear, twice, *np.concatenate(parts, axis=1),
                np.cumsum(begins) - 1, first, ~free[first])


def descend(problem, form, x, over):
    """Better labellings until over(), or no site alone has one. In each step a share of the sites
    that gain moves; the share is halved where neighbours spoil it for each other."""
    linear, (rows, columns, values), _ = models.expand(problem, penalties=False)
    matrix = coo_array((values, (rows, columns)), (x.size, x.size)).tocsr()
    matrix, lot, share = matrix + matrix.T, np.random.default_rng(0), 1.0
    while not over():
        costs = linear + matrix @ x
        # Of two labels that cost the same the old one stays.
        change = form.best(2 * costs - x) - x
        sites = np.unique(form.site[change != 0])
        if not sites.size:
            break
        moving = lot.choice(sites, math.ceil(share * sites.size), replace=False)
        step = np.where(np.isin(form.site, moving), change, 0)
        better = 2 * (costs @ step) + step @ (matrix @ step) < 0
        x, share = (x + step, min(1.0, 2 * share)) if better else (x, share / 2)
    return x


def split(form):
    """(The program of each variable, numbered from the smallest on, -1 at sites without products;
    how many connected parts there are.) Small parts share a program."""
    left, right = form.left % form.linear.size, form.right % form.linear.size
    part = models.components(form.hot.size, form.site[left], form.site[right])[form.site]
    met = np.bincount(part[left], minlength=part.size)
    sizes = np.where(met > 0, met + np.bincount(part, minlength=part.size), 0)
    order = np.argsort(sizes, kind="stable")
    batch = np.where(sizes[order] > 0, np.cumsum(sizes[order]) // BATCH, -1)
    program = np.empty_like(order)
    program[order] = np.unique(np.append(-1, batch), return_inverse=True)[1][1:] - 1
    return program[part], int(np.sum(met > 0))


def bounds_of(form, program):
    """A bound of each program without any search: every site for itself. i64 array."""
    least = np.minimum.reduceat(form.twice, form.first)
    bounds, inside = np.zeros(program.max() + 1, np.int64), program[form.first] >= 0
    np.add.at(bounds, program[form.first][inside],
              np.where(form.hot, least, np.minimum(least, 0))[inside])
    return -(-bounds // 2)


def better_of(form, program, x, other):
    """Of two states the better one in each program; `x` at sites without products."""
    change = np.zeros(program.max() + 2, np.int64)
    np.add.at(change, program, form.linear * (other - x))
    np.subtract.at(change, program[form.left % form.linear.size],
                   form.cost * (form.products(other) - form.products(x)))
    change[-1] = 0
    return np.where(change[program] < 0, other, x)


def constraints(form, variables, products):
    """Of a program with columns for these variables and products. sum = 1 for each one-hot group.
    For each literal and each site that it meets in a coupling the sum of their products is at most
    the literal: the relaxation by marginals of sites and pairs, without what costs nothing."""
    n, left, right = form.linear.size, form.left[products], form.right[products]
    literal, other = np.concatenate((left, right)), np.concatenate((right, left))
    (_, literal, _), link = np.unique(
        np.stack([np.tile(form.coupling[products], 2), literal, form.site[other % n]]), axis=1,
        return_inverse=True)
    hot = np.flatnonzero(form.hot[form.site[variables]])
    group = np.unique(form.site[variables[hot]], return_inverse=True)[1]
    groups, product = group.max(initial=-1) + 1, variables.size + np.arange(products.size)
    rows = np.concatenate((group, groups + link.ravel(), groups + np.arange(literal.size)))
    columns = np.concatenate((hot, product, product, np.searchsorted(variables, literal % n)))
    entries = np.concatenate((np.ones(rows.size - literal.size), np.where(literal < n, -1.0, 1.0)))
    matrix = coo_array((entries, (rows, columns)),
                       (groups + literal.size, variables.size + products.size))
    return LinearConstraint(matrix.tocsr(), np.repeat([1.0, -np.inf], [groups, literal.size]),
                            np.concatenate((np.ones(groups), literal >= n)))


def solve(costs, count, rules, best, low, seconds):
    """(The values of the first `count` columns that HiGHS finds, or None; a proven lower bound) of
    the program with these costs and constraints, where a state of energy `best` and the bound `low`
    are known."""
    # All energies are multiples of the unit: nothing is better than the best by less than that. The
    # gap is less by what bounds may be wrong, there and in what is claimed here.
    unit = max(1, int(np.gcd.reduce(costs)))
    cost, reach = costs / unit, max(abs(best), abs(low), unit) / unit
    margin = DUAL_TOLERANCE * cost.size + ROUNDING * float(np.abs(cost).sum())
    gap = max(0.0, 1 - 2 * margin)
    # Presolve makes these programs two to twelve times slower, and would leave out what is not
    # better by 1, to a tolerance of its own.
    found = milp(cost, integrality=np.arange(cost.size) < count, bounds=Bounds(0, 1),
                 constraints=rules, options={
                     "presolve": False, "mip_rel_gap": gap / reach,
                     "time_limit": min(max(0.0, seconds), 1e9)})
    if found.status not in (0, 1):
        raise SolverError(f"HiGHS fails ({found.message}); please report this")
    # What it left out was no less than its best solution less the gap.
    proven = [bound for bound in (found.mip_dual_bound,
                                  None if found.fun is None else found.fun - gap)
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
        self.bits, self.bound, self.text = np.zeros(problem.linear.size, np.int64), None, "building"
        self.bits[problem.starts[:-1][problem.one_hot]] = 1
        self.info = {"components": 0, "programs": 0, "open_programs": 0}

    def over(self):
        return time.monotonic() >= self.stop

    def run(self):
        form = reduce(self.problem)
        self.bits, (program, parts) = form.best(form.linear), split(form)
        of_product, alone = program[form.left % form.linear.size], program < 0
        bounds = bounds_of(form, program)
        rest = form.offset + int(form.linear[alone] @ self.bits[alone])
        self.bound = rest + int(bounds.sum())
        self.info = {"components": parts, "programs": bounds.size, "open_programs": bounds.size}
        self.bits = descend(self.problem, form, self.bits, self.over)
        if self.problem.known is not None:
            self.bits = better_of(form, program, self.bits, self.problem.known.astype(np.int64))
        for k, low in enumerate(bounds.tolist()):
            variables, products = np.flatnonzero(program == k), np.flatnonzero(of_product == k)
            self.text = f"program {k + 1:,} of {bounds.size:,}, {variables.size:,} variables"
            costs = np.concatenate((form.linear[variables], -form.cost[products]))

            def energy(x):
                return int(costs @ np.concatenate((x[variables], form.products(x)[products])))
            best = energy(self.bits)
            if best > low and not self.over():
                values, bounds[k] = solve(
                    costs, variables.size, constraints(form, variables, products), best, low,
                    self.stop - time.monotonic())
                x = self.bits.copy()
                x[variables] = self.bits[variables] if values is None else values
                # What the search finds is checked like anything from outside.
                if energy(x) < best and models.feasible(self.problem, x[None]).all():
                    self.bits, best = x, energy(x)
                self.bound = rest + int(bounds.sum())
            self.info["open_programs"] -= best <= int(bounds[k])


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
