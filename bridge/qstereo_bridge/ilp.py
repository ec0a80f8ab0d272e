"""The solver ilp: the least H of all labellings, proven, by HiGHS's integer programs.

A labelling is a state in which every one-hot group (one with a penalty) has exactly one variable
at 1: there all penalties are 0 and are left out. A group without a penalty is so many free
variables. Each connected part of the problem is a program of its own.
"""

import math
import time
from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array, csgraph

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
# Columns from which on a program is solved alone: each call of HiGHS costs some milliseconds.
BATCH = 1000
# Seconds that HiGHS may take to notice its time limit before its answer is no longer waited for.
GRACE = 0.25


@dataclass
class Form:
    """H on all labellings: offset + sum_i linear_i x_i - sum_t cost_t * left_t * right_t.

    The literal i < n is x_i, n + i is 1 - x_i; `left`, `right` are those of each product. The
    literals of one site exclude each other. `cost` is above 0, `coupling` the coupling that each
    product is of; `site` and `hot` are those of sites_of(). All are i64 arrays.
    """

    offset: int
    linear: np.ndarray
    left: np.ndarray
    right: np.ndarray
    cost: np.ndarray
    coupling: np.ndarray
    site: np.ndarray
    hot: np.ndarray


def sites_of(problem):
    """(the site of each variable, the first variable of each site, whether it is a one-hot group).
    A site is a one-hot group, or a variable that is free."""
    alone = ~problem.of_variables(problem.one_hot)
    begins = alone.copy()
    begins[problem.starts[:-1]] = True
    first = np.flatnonzero(begins)
    return np.cumsum(begins) - 1, first, ~alone[first]


def _not_above_zero(table):
    """table[i, j] = of_rows[i] + of_columns[j] + rest[i, j] with rest <= 0.

    Maxima are taken from the rows first or from the columns first, whichever leaves more zeros.
    """
    def rows_first(table):
        of_rows = table.max(1)
        of_columns = (table - of_rows[:, None]).max(0)
        return of_rows, of_columns, table - of_rows[:, None] - of_columns

    one, (columns, rows, rest) = rows_first(table), rows_first(table.T)
    nothing = np.zeros(table.shape[0], int), np.zeros(table.shape[1], int), table
    forms = [one, (rows, columns, rest.T)] + [nothing] * bool((table <= 0).all())
    return min(forms, key=lambda form: np.count_nonzero(form[2]))


def reduce(problem, limit):
    """The Form of `problem`, each of its blocks written with factors below 0. Raises OverLimit."""
    starts, one_hot, linear = problem.starts[:-1], problem.one_hot, problem.linear.copy()
    (site, _, hot), n = sites_of(problem), linear.size
    g, h, block, weight = problem.couplings
    kind = 8 * block + 4 * (g == h) + 2 * (one_hot[g] & one_hot[h]) + (weight < 0)
    parts, entries = [np.empty((4, 0), np.int64)], 0
    for each in np.unique(kind[weight != 0]).tolist():
        content, these = problem.blocks[each // 8], np.flatnonzero((kind == each) & (weight != 0))
        rows, columns = content.shape
        check_memory(40 * rows * columns, limit, f"a block of {rows:,} x {columns:,}")
        table = content.dense().astype(np.int64) * (-1 if each & 1 else 1)
        table = np.triu(table, 1) if each & 4 else table
        above, beside = starts[g[these], None], starts[h[these], None]
        times = np.abs(weight[these, None])
        if each & 2:
            of_rows, of_columns, table = _not_above_zero(table)
            np.add.at(linear, above + np.arange(rows), times * of_rows)
            np.add.at(linear, beside + np.arange(columns), times * of_columns)
        i, j = np.nonzero(table)
        entries += 3 * i.size * these.size
        check_memory(ENTRY_BYTES * entries, limit, f"an integer program of {entries:,} entries")
        left, right, value = above + i, beside + j, times * table[i, j]
        # What is above 0 has a free variable: v x y = v y - v (1 - x) y.
        for this, other in ((left, right), (right, left)):
            turned = (value > 0) & ~hot[site[this % n]]
            np.add.at(linear, other[turned] % n, value[turned])
            this[turned] += n
            value[turned] *= -1
        number = np.broadcast_to(these[:, None], value.shape)
        parts.append(np.stack([left, right, -value, number]).reshape(4, -1))
    return Form(problem.offset, linear, *np.concatenate(parts, axis=1), site, hot)


def begin(problem, linear):
    """The labelling that is best by the terms `linear` alone: i64 array (n)."""
    site, first, hot = sites_of(problem)
    best, x = np.lexsort((linear, site))[first], np.zeros(linear.size, np.int64)
    x[best[hot | (linear[best] < 0)]] = 1
    return x


def descend(problem, x, limit, over):
    """Better labellings until over(), or no site alone has one. In each step a share of the sites
    that gain moves; the share is halved where neighbours spoil it for each other."""
    linear, (rows, columns, values), _ = models.expand(problem, penalties=False, limit=limit)
    matrix = coo_array((values, (rows, columns)), (x.size, x.size)).tocsr()
    (site, first, hot), matrix = sites_of(problem), matrix + matrix.T
    lot, share = np.random.default_rng(0), 1.0
    while not over():
        costs = linear + matrix @ x
        best = np.lexsort((costs, site))[first]
        gain = np.where(hot, np.add.reduceat(costs * x, first) - costs[best],
                        costs[best] * (2 * x[best] - 1))
        moves = (gain > 0) & (lot.random(gain.size) < share)
        if not moves.any():
            if gain.max(initial=0) <= 0:
                break
            moves = np.arange(gain.size) == gain.argmax()
        step = np.where(moves[site], -x, 0)
        step[best[moves]] += np.where(hot, 1, 1 - x[best])[moves]
        better = 2 * (costs @ step) + step @ (matrix @ step) < 0
        x, share = (x + step, min(1.0, 2 * share)) if better else (x, share / 2)
    return x


def split(form):
    """[(variables, products)] of the programs, the smallest first, and how many connected parts
    there are. Sites without products are in none; small parts share a program."""
    left, right = form.left % form.linear.size, form.right % form.linear.size
    graph = coo_array((np.ones(left.size), (form.site[left], form.site[right])), 2 * form.hot.shape)
    part = csgraph.connected_components(graph, directed=False)[1][form.site]
    met = np.bincount(part[left], minlength=part.size)
    sizes = np.where(met > 0, met + np.bincount(part, minlength=part.size), 0)
    order = np.argsort(sizes, kind="stable")
    program = np.empty_like(order)
    program[order] = np.where(sizes[order] > 0, np.cumsum(sizes[order]) // BATCH, -1)
    of_variables, of_products = program[part], program[part[left]]
    return [(np.flatnonzero(of_variables == k), np.flatnonzero(of_products == k))
            for k in np.unique(of_products).tolist()], int(np.sum(met > 0))


class Program:
    """Some connected parts of a Form as one integer program.

    Columns are the variables and the products, each in [0, 1]. Rows are sum = 1 for each one-hot
    group, and for each literal and each site that it meets in a coupling: the sum of their
    products is at most the literal. That is the relaxation by marginals of sites and pairs, in
    which what costs nothing is left out.
    """

    def __init__(self, form, variables, products):
        self.form, self.variables, self.n = form, variables, form.linear.size
        self.left, self.right = form.left[products], form.right[products]
        self.coupling, self.cost = form.coupling[products], form.cost[products]
        self.costs = np.concatenate((form.linear[variables], -self.cost))
        self.site = form.site[variables]

    def energy(self, bits):
        """The costs of the columns in the state `bits`."""
        literals = np.concatenate((bits, 1 - bits))
        products = literals[self.left] * literals[self.right]
        return int(self.costs @ np.concatenate((bits[self.variables], products)))

    def bound(self):
        """A bound without any search: -c A B >= -c (A + B) / 2, then every site for itself."""
        double, constant = 2 * self.form.linear, 0
        for end in (self.left, self.right):
            turned = end >= self.n
            np.add.at(double, end % self.n, np.where(turned, self.cost, -self.cost))
            constant -= int(self.cost[turned].sum())
        least = np.where(self.form.hot, np.iinfo(np.int64).max, 0)
        np.minimum.at(least, self.site, double[self.variables])
        return -(-(constant + int(least[np.unique(self.site)].sum())) // 2)

    def constraints(self):
        n, columns = self.n, self.costs.size
        # A link is a literal with a site of one coupling: one row for all their products.
        literal, other = (np.concatenate(ends) for ends in (
            (self.left, self.right), (self.right, self.left)))
        keys = np.stack([np.tile(self.coupling, 2), literal, self.form.site[other % n]])
        order = np.lexsort(keys)
        new = np.append(True, (np.diff(keys[:, order]) != 0).any(0))
        link = np.empty(order.size, np.int64)
        link[order], literal = np.cumsum(new) - 1, literal[order[new]]
        hot = np.flatnonzero(self.form.hot[self.site])
        group = np.unique(self.site[hot], return_inverse=True)[1]
        groups, product = group.max(initial=-1) + 1, self.variables.size + np.arange(self.cost.size)
        rows = np.concatenate((group, groups + link, groups + np.arange(literal.size)))
        entries = np.concatenate((np.ones(rows.size - literal.size),
                                  np.where(literal < n, -1.0, 1.0)))
        matrix = coo_array((entries, (rows, np.concatenate((
            hot, product, product, np.searchsorted(self.variables, literal % n))))),
            (groups + literal.size, columns))
        return LinearConstraint(
            matrix.tocsr(), np.repeat([1.0, -np.inf], [groups, literal.size]),
            np.concatenate((np.ones(groups), literal >= n)))

    def solve(self, best, low, seconds):
        """(the values of the variables that HiGHS finds or None, a proven lower bound), where a
        state of energy `best` and the bound `low` are known."""
        # All energies are multiples of the unit: nothing is better than the best by less than
        # that. The gap is less by what bounds may be wrong, there and in what is claimed here.
        unit = max(1, int(np.gcd.reduce(self.costs)))
        cost, reach = self.costs / unit, max(abs(best), abs(low), unit) / unit
        margin = DUAL_TOLERANCE * cost.size + ROUNDING * float(np.abs(cost).sum())
        gap = max(0.0, 1 - 2 * margin)
        # Presolve makes these programs two to twelve times slower, and it would find that the
        # energies are whole: HiGHS would then leave out what is not better by 1, to a tolerance
        # of its own.
        found = milp(cost, integrality=np.arange(cost.size) < self.variables.size,
                     bounds=Bounds(0, 1), constraints=self.constraints(), options={
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
        return None if found.x is None else np.rint(found.x[:self.variables.size]), low


class Search:
    """One program after another. Whoever stops waiting finds in `bits` a labelling, in `bound` what
    is proven of all (None: nothing yet), in `text` where it is."""

    def __init__(self, problem, options):
        self.problem, self.limit = problem, options.memory_limit
        self.stop = time.monotonic() + (options.time_limit or math.inf)
        self.bits, self.bound, self.text = begin(problem, problem.linear), None, "building"
        self.info = {"components": 0, "programs": 0, "open_programs": 0}

    def over(self):
        return time.monotonic() >= self.stop

    def run(self):
        form = reduce(self.problem, self.limit)
        self.bits = begin(self.problem, form.linear)
        parts, components = split(form)
        programs = [Program(form, *part) for part in parts]
        bounds, alone = [program.bound() for program in programs], np.ones(form.linear.size, bool)
        for program in programs:
            alone[program.variables] = False
        rest = form.offset + int(form.linear[alone] @ self.bits[alone])
        self.bound = rest + sum(bounds)
        self.info.update(components=components, programs=len(programs), open_programs=len(programs))
        self.bits = descend(self.problem, self.bits, self.limit, self.over)
        for k, program in enumerate(programs):
            self.text = (f"program {k + 1:,} of {len(programs):,}, "
                         f"{program.variables.size:,} variables")
            best = program.energy(self.bits)
            if best > bounds[k] and not self.over():
                values, bounds[k] = program.solve(best, bounds[k], self.stop - time.monotonic())
                best = self.take(program, values, best)
                self.bound = rest + sum(bounds)
            self.info["open_programs"] -= best <= bounds[k]

    def take(self, program, values, best):
        """The energy of `program` after taking over the values of its variables, where they are a
        better labelling."""
        bits = self.bits.copy()
        if values is not None:
            bits[program.variables] = values
        energy = program.energy(bits)
        if energy < best and models.feasible(self.problem, bits[None]).all():
            self.bits, best = bits, energy
        return best


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
