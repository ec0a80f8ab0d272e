"""The solver ilp: the least H of all labellings, proven, by one integer program for each connected part of the problem.

A labelling is a state in which every one-hot group (one with a penalty) has exactly one variable at 1: there all penalties are 0
and are left out. A group without a penalty is so many free variables. HiGHS is imported when it is needed, not before.
"""

import math
import time
from dataclasses import dataclass

import numpy as np

from . import models
from .container import check_memory
from .solvers import Answer, SolverError, interruptible

# Peak memory of HiGHS for each entry of the matrix, as measured on programs of 10^5 entries.
ENTRY_BYTES = 2500
# What HiGHS takes for 0 in a reduced cost. All columns lie in [0, 1], so a bound of its is wrong by this much a column at most.
DUAL_TOLERANCE = 1e-7
# HiGHS's numbers for the form of a matrix and for the sense of the objective.
ROWWISE, MINIMIZE = 2, 1
# Relative rounding of sums of doubles, far above what sums of 10^6 terms have.
ROUNDING = 2.0**-40


@dataclass
class Form:
    """H on all labellings, as constants, unary terms, and products of literals that each lower it:

        offset + sum_i linear_i x_i - sum_t cost_t * left_t * right_t

    The literal i < n is x_i, n + i is 1 - x_i. A *site* is a free variable or a one-hot group of at least three, named by its
    (first) variable; only of free variables there are complements. The literals of one site exclude each other.

    linear      i64 array (n), 0 where a variable is no longer in use
    left, right, cost   i64 arrays, cost > 0
    site        i64 array (n): the site of each variable, -1 where it is no longer in use
    wide        bool array (n): whether its site is a one-hot group
    ones        the only variables of their groups: they are 1
    firsts      the first variables of groups of two: 1 less the next, which stands for both as a free variable
    """

    offset: int
    linear: np.ndarray
    left: np.ndarray
    right: np.ndarray
    cost: np.ndarray
    site: np.ndarray
    wide: np.ndarray
    ones: np.ndarray
    firsts: np.ndarray

    @property
    def n(self):
        return self.linear.size

    def literals(self, x):
        """The values of all 2 n literals in the state `x`."""
        return np.concatenate((x, 1 - x))

    def bits(self, x):
        """The state of all variables, those included that are not in use."""
        x = x.astype(np.uint8)
        x[self.ones], x[self.firsts] = 1, 1 - x[self.firsts + 1]
        return x


def reduce(problem, limit):
    """The Form of `problem`. Raises OverLimit."""
    linear, (rows, columns, values), offset = models.expand(problem, penalties=False, limit=limit)
    n, hot, sizes, starts = linear.size, problem.one_hot(), problem.sizes(), problem.starts()[:-1]
    ones, firsts = starts[hot & (sizes == 1)], starts[hot & (sizes == 2)]
    wide = np.repeat(hot & (sizes > 2), sizes)
    site = np.where(wide, np.repeat(starts, sizes), np.arange(n))
    site[ones] = site[firsts] = -1
    linear, ends, values = _substitute(linear.copy(), [rows.astype(np.int64), columns.astype(np.int64)], values, ones, firsts)
    offset += int(linear[ones].sum()) + int(linear[firsts].sum())
    linear[firsts + 1] -= linear[firsts]
    linear[ones] = linear[firsts] = 0
    rows, columns, values = _tables(linear, *ends, values, np.where(wide, site, -1), np.repeat(sizes, sizes), limit)
    # What is left above 0 has a free variable: v x y = v x - v x (1 - y).
    for this, other in ((columns, rows), (rows, columns)):
        above = (values > 0) & ~wide[this % n]
        np.add.at(linear, other[above], values[above])
        this[above] += n
        values[above] *= -1
    return Form(offset, linear, rows, columns, -values, site, wide, ones, firsts)


def _substitute(linear, ends, values, ones, firsts):
    """Put 1 for the variables `ones`, and for each of `firsts` 1 less the next, into the quadratic terms."""
    one, first = np.zeros(linear.size, bool), np.zeros(linear.size, bool)
    one[ones] = first[firsts] = True
    for this, other in ((0, 1), (1, 0)):
        gone = one[ends[this]]
        taken = gone | first[ends[this]]
        np.add.at(linear, ends[other][taken], values[taken])
        values = np.where(taken, -values, values)[~gone]
        ends = [end[~gone] for end in ends]
        ends[this] = ends[this] + first[ends[this]]
    rows, columns, values = models.add_up(*ends, values) if values.size else (*ends, values)
    return linear, [rows, columns], values


def _tables(linear, rows, columns, values, group, size, limit):
    """Write the products between two one-hot groups with factors below 0, as few as row and column maxima make them.

    Blocks with nothing above 0 and no more entries than a diagonal stay as they are. `group` is the first variable of each one's
    group, -1 of free ones. Adds to `linear`; returns rows, columns, values.
    """
    n, between = linear.size, np.flatnonzero((group[rows] >= 0) & (group[columns] >= 0))
    pairs, of_pair = np.unique(group[rows[between]] * n + group[columns[between]], return_inverse=True)
    g, h = np.divmod(pairs, n)
    dense = np.bincount(of_pair, minlength=pairs.size) > np.maximum(size[g], size[h])
    dense[of_pair[values[between] > 0]] = True
    check_memory(5 * 8 * int((size[g[dense]] * size[h[dense]]).sum()), limit, f"the blocks of {dense.sum():,} couplings")
    inside = dense[of_pair]
    moved, of_pair = between[inside], of_pair[inside]
    kept = np.ones(rows.size, bool)
    kept[moved] = False
    found = [(rows[kept], columns[kept], values[kept])]
    shapes, of_shape = np.unique(size[g] * n + size[h], return_inverse=True)
    for shape in np.unique(of_shape[dense]).tolist():
        chosen = np.flatnonzero(dense & (of_shape == shape))
        place = np.full(pairs.size, -1)
        place[chosen] = np.arange(chosen.size)
        at = place[of_pair]
        these, at = moved[at >= 0], at[at >= 0]
        tables = np.zeros((chosen.size, *divmod(int(shapes[shape]), n)), np.int64)
        tables[at, rows[these] - g[chosen][at], columns[these] - h[chosen][at]] = values[these]
        of_rows, of_columns, tables = _not_above_zero(tables)
        np.add.at(linear, g[chosen, None] + np.arange(tables.shape[1]), of_rows)
        np.add.at(linear, h[chosen, None] + np.arange(tables.shape[2]), of_columns)
        at, i, j = np.nonzero(tables)
        found.append((g[chosen][at] + i, h[chosen][at] + j, tables[at, i, j]))
    return (np.concatenate(parts) for parts in zip(*found))


def _not_above_zero(tables):
    """Each of `tables` as of_rows[i] + of_columns[j] + rest[i, j] with rest <= 0.

    Maxima are taken from the rows first or from the columns first, whichever leaves more zeros.
    """
    def rows_first(tables):
        of_rows = tables.max(2)
        rest = tables - of_rows[:, :, None]
        of_columns = rest.max(1)
        return of_rows, of_columns, rest - of_columns[:, None, :]

    one, (other_columns, other_rows, other) = rows_first(tables), rows_first(tables.transpose(0, 2, 1))
    other = other_rows, other_columns, other.transpose(0, 2, 1)
    better = np.count_nonzero(other[2], axis=(1, 2)) < np.count_nonzero(one[2], axis=(1, 2))
    return (np.where(better.reshape(-1, *[1] * (these.ndim - 1)), those, these) for these, those in zip(one, other))


def _components(count, one, other):
    """The least vertex of the component of each of `count` vertices with the edges (one, other)."""
    least = np.arange(count)
    while one.size:
        low, high = np.minimum(least[one], least[other]), np.maximum(least[one], least[other])
        apart = low != high
        if not apart.any():
            break
        np.minimum.at(least, high[apart], low[apart])
        while (least[least] != least).any():
            least = least[least]
    return least


class Local:
    """A labelling by the unary terms alone, then moved to better labels until no site has one."""

    def __init__(self, form):
        self.form, n = form, form.n
        self.variable = [form.left % n, form.right % n]
        self.sign = [np.where(form.left < n, 1, -1), np.where(form.right < n, 1, -1)]
        edges = np.unique(form.site[self.variable[0]] * n + form.site[self.variable[1]])
        self.edges = np.divmod(edges, n)
        self.wide = np.flatnonzero(form.wide)
        self.firsts = np.flatnonzero(form.wide & (form.site == np.arange(n)))
        self.free = np.flatnonzero((form.site >= 0) & ~form.wide)
        self.starts = np.searchsorted(self.wide, self.firsts)

    def best(self, field):
        """For each one-hot group: its variable of the least `field`, and that."""
        if not self.firsts.size:
            return self.firsts, self.firsts
        mine = field[self.wide]
        least = np.minimum.reduceat(mine, self.starts)
        lengths = np.diff(np.append(self.starts, mine.size))
        hits = np.flatnonzero(mine == np.repeat(least, lengths))
        group = np.repeat(np.arange(self.starts.size), lengths)[hits]
        first = np.append(True, group[1:] != group[:-1])
        return self.wide[hits[first]], least

    def _field(self, x):
        """What each variable's 1 costs while the others are as they are."""
        field, values = self.form.linear.copy(), self.form.literals(x)
        for this, other in ((0, self.form.right), (1, self.form.left)):
            np.subtract.at(field, self.variable[this], self.sign[this] * self.form.cost * values[other])
        return field

    def start(self):
        x = np.zeros(self.form.n, np.int64)
        x[self.best(self.form.linear)[0]] = 1
        x[self.free] = self.form.linear[self.free] < 0
        return x

    def descend(self, x, over):
        """Until over() or no gain: of neighbours that gain, the one that gains most moves (of equals one drawn by lot)."""
        lot = np.random.default_rng(0).permutation(self.form.n)
        one, other = self.edges
        while self.edges[0].size and not over():
            field, gain = self._field(x), np.zeros(self.form.n, np.int64)
            best, least = self.best(field)
            now = self.wide[x[self.wide] == 1]
            gain[self.firsts] = field[now] - least
            gain[self.free] = np.where(x[self.free] == 1, field[self.free], -field[self.free])
            behind = (gain[one] < gain[other]) | ((gain[one] == gain[other]) & (lot[one] < lot[other]))
            gain[np.where(behind, one, other)] = 0
            moves, flips = gain[self.firsts] > 0, self.free[gain[self.free] > 0]
            if not moves.any() and not flips.size:
                break
            x[now[moves]], x[best[moves]] = 0, 1
            x[flips] ^= 1
        return x


@dataclass
class Programs:
    """All components of more than one site as one integer program, sorted by component, the smallest first.

    A component's columns are first its variables, then the products of literals, each of these in [0, 1]. Its rows are sum = 1 for
    each one-hot group, and for each literal and each site that it meets: the sum of their products is at most the literal. That is
    the relaxation by marginals of sites and pairs, in which what costs nothing is left out.

    cost            i64 array: of each column
    variable        of each column: its variable, or -1 - t for the product t
    lower, upper    of each row
    start, index, entry     the matrix, row by row
    columns, rows   where each component's columns and rows begin, and their number at the end
    single          bool array (n): variables of sites that are alone
    """

    cost: np.ndarray
    variable: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    start: np.ndarray
    index: np.ndarray
    entry: np.ndarray
    columns: np.ndarray
    rows: np.ndarray
    single: np.ndarray

    def model(self, k, cost):
        """Component `k` with the costs `cost`, as HiGHS takes a model row by row: to be minimised, constant 0."""
        columns, rows = (slice(*at[k:k + 2].tolist()) for at in (self.columns, self.rows))
        start = self.start[rows.start:rows.stop + 1]
        entries, ones = slice(start[0], start[-1]), np.ones(cost.size)
        return (cost.size, start.size - 1, start[-1] - start[0], ROWWISE, MINIMIZE, 0.0, cost, 0 * ones, ones, self.lower[rows],
                self.upper[rows], (start[:-1] - start[0]).astype(np.int32),
                (self.index[entries] - columns.start).astype(np.int32), self.entry[entries],
                (self.variable[columns] >= 0).astype(np.int32))


def build(form):
    """The Programs of `form`."""
    n, left, right = form.n, form.left % form.n, form.right % form.n
    component = _components(n, form.site[left], form.site[right])[form.site]
    joined = np.zeros(n, bool)
    joined[component[left]] = True
    used = np.flatnonzero((form.site >= 0) & joined[component])
    variable = np.concatenate((used, -1 - np.arange(form.cost.size)))
    owner = component[np.concatenate((used, left))]
    names, owner, sizes = np.unique(owner, return_inverse=True, return_counts=True)
    rank = np.empty(names.size, np.int64)
    rank[np.argsort(sizes, kind="stable")] = np.arange(names.size)
    rank_of_column = rank[owner]
    order = np.argsort(rank_of_column, kind="stable")
    place = np.empty(order.size, np.int64)
    place[order] = np.arange(order.size)
    column = np.full(n, -1)
    column[used] = place[:used.size]
    product = place[used.size:]

    # One-hot groups, then links: the key of a link is a literal and the other's site.
    wide = used[form.wide[used]]
    _, group = np.unique(form.site[wide], return_inverse=True)
    groups = int(group.max(initial=-1)) + 1
    ends = np.concatenate((form.left * n + form.site[right], form.right * n + form.site[left]))
    keys, link = np.unique(ends, return_inverse=True)
    literal = keys // n
    row = np.concatenate((group, groups + link, groups + np.arange(keys.size)))
    index = np.concatenate((column[wide], product, product, column[literal % n]))
    entry = np.ones(row.size)
    entry[row.size - keys.size:] = np.where(literal < n, -1.0, 1.0)
    upper = np.concatenate((np.ones(groups), (literal >= n).astype(float)))
    rank_of_row = np.zeros(upper.size, np.int64)
    rank_of_row[row] = rank_of_column[order][index]
    rows = np.argsort(rank_of_row, kind="stable")
    place = np.empty(rows.size, np.int64)
    place[rows] = np.arange(rows.size)
    entries = np.argsort(place[row], kind="stable")
    counts, ends = np.bincount(place[row], minlength=rows.size), np.arange(names.size + 1)
    return Programs(np.concatenate((form.linear[used], -form.cost))[order], variable[order],
                    np.where(rows < groups, 1.0, -np.inf), upper[rows], np.concatenate(([0], np.cumsum(counts))),
                    index[entries], entry[entries], np.searchsorted(rank_of_column[order], ends),
                    np.searchsorted(rank_of_row[rows], ends), (form.site >= 0) & ~joined[component])


def bounds(form, local, programs):
    """A lower bound of each component without any search: -c A B >= -c (A + B) / 2, and then every site for itself."""
    double, least = 2 * form.linear, np.zeros(form.n, np.int64)
    for variable, sign in zip(local.variable, local.sign):
        np.subtract.at(double, variable, sign * form.cost)
        np.subtract.at(least, variable, np.where(sign < 0, form.cost, 0))
    least[local.free] += np.minimum(double[local.free], 0)
    least[local.firsts] += local.best(double)[1]
    at = np.flatnonzero(programs.variable >= 0)
    component = np.searchsorted(programs.columns, at, side="right") - 1
    bound = np.zeros(programs.columns.size - 1, np.int64)
    np.add.at(bound, component, least[programs.variable[at]])
    return -(-bound // 2)


class Search:
    """HiGHS on one component after another. `text` says where it is."""

    def __init__(self, form, programs, options, began):
        self.form, self.programs = form, programs
        self.stop = began + (options.time_limit or float("inf"))
        self.text, self.nodes, self.open, self.seconds = "", 0, 0, []

    def over(self):
        return time.monotonic() >= self.stop

    def run(self, x, least):
        """Improve the labelling `x`; returns (its energy, a lower bound). `least` bounds each component without any search."""
        energy = bound = self.form.offset + int(self.form.linear[self.programs.single] @ x[self.programs.single])
        for k, low in enumerate(least.tolist()):
            columns = slice(*self.programs.columns[k:k + 2].tolist())
            cost, variable = self.programs.cost[columns], self.programs.variable[columns]
            variables = variable[variable >= 0]
            values = self._values(x, variable)
            best, began = int(cost @ values), time.monotonic()
            if not self.over() and best > low:
                # All energies of the component are multiples of its unit.
                unit = int(np.gcd.reduce(cost))
                self.text = f"component {k + 1:,} of {least.size:,}, {variables.size:,} variables"
                found, proven = self._component(k, cost / unit, values)
                low = max(low, unit * math.ceil(proven)) if math.isfinite(proven) else low
                x[variables], before = found[:variables.size], x[variables]
                now = int(cost @ self._values(x, variable))
                if now < best and self._feasible(k, x):
                    best = now
                else:
                    x[variables] = before
            self.seconds.append(time.monotonic() - began)
            self.open += best > low
            energy, bound = energy + best, bound + low
        return energy, bound

    def _values(self, x, variable):
        """The values of the columns `variable` in the state `x`."""
        product = -1 - variable[variable < 0]
        ends = self.form.left[product], self.form.right[product]
        one, other = (x[end % x.size] ^ (end >= x.size) for end in ends)
        return np.concatenate((x[variable[variable >= 0]], one & other))

    def _component(self, k, cost, values):
        """HiGHS on component `k` from the solution `values`: (the values it found, a proven lower bound)."""
        import highspy

        # The energies are integers: nothing is better than the best by less than 1. The gap is less than that by what the bounds
        # may be wrong, there and in what is claimed at the end.
        margin = DUAL_TOLERANCE * cost.size + ROUNDING * float(np.abs(cost).sum())
        gap = max(0.0, 1 - 2 * margin)
        # Presolve makes these programs two to twelve times slower, and it would find that the energies are whole: HiGHS would then
        # leave out all that is not better by 1, to a tolerance of its own. Without it, what is left out is within the gap.
        highs = highspy.Highs()
        for option, value in {"output_flag": False, "threads": 1, "presolve": "off", "mip_rel_gap": 0.0, "mip_abs_gap": gap,
                              "time_limit": max(0.0, self.stop - time.monotonic())}.items():
            highs.setOptionValue(option, value)
        highs.passModel(*self.programs.model(k, cost))
        highs.setSolution(cost.size, np.arange(cost.size, dtype=np.int32), values.astype(float))
        text = self.text

        def said(event):
            self.text = f"{text}, gap {event.data_out.mip_primal_bound - event.data_out.mip_dual_bound:.4g}"
        highs.cbMipInterrupt += said
        highs.run()
        status, info = highs.getModelStatus(), highs.getInfo()
        if status not in (highspy.HighsModelStatus.kOptimal, highspy.HighsModelStatus.kTimeLimit):
            raise SolverError(f"HiGHS ends with {highs.modelStatusToString(status)!r} on component {k + 1}; please report this")
        self.nodes += max(0, info.mip_node_count)
        # What it left out was no less than its best solution less the gap.
        proven = min(info.mip_dual_bound, info.objective_function_value - gap) - margin
        return np.rint(highs.getSolution().col_value).astype(np.int64), proven

    def _feasible(self, k, x):
        """Whether component `k` has exactly one variable at 1 in each of its one-hot groups."""
        variable = self.programs.variable[self.programs.columns[k]:self.programs.columns[k + 1]]
        wide = variable[variable >= 0]
        wide = wide[self.form.wide[wide]]
        site = self.form.site[wide]
        groups = np.flatnonzero(np.append(True, site[1:] != site[:-1])[:site.size])
        return bool((np.add.reduceat(x[wide], groups) == 1).all()) if groups.size else True


def ilp(problem, options, progress):
    """The least labelling and its proof; a time limit leaves the best that was found and what was proven until then."""
    try:
        import highspy
    except ImportError:
        raise SolverError("the solver HiGHS is not installed; pip install qstereo-bridge[exact]") from None
    began, search = time.monotonic(), []

    def solve():
        form = reduce(problem, options.memory_limit)
        programs, local = build(form), Local(form)
        entries = np.diff(programs.start[programs.rows])
        check_memory(ENTRY_BYTES * int(entries.max(initial=0)), options.memory_limit,
                     f"an integer program of {entries.max(initial=0):,} entries")
        built = time.monotonic()
        search.append(Search(form, programs, options, began))
        x = local.descend(local.start(), search[0].over)
        started = time.monotonic()
        energy, bound = search[0].run(x, bounds(form, local, programs))
        return form, form.bits(x), energy, bound, {"build": built - began, "start": started - built}

    form, bits, energy, bound, timing = interruptible(solve, lambda: progress(search[0].text if search else "building"))
    programs, seconds = search[0].programs, search[0].seconds
    variables = np.diff(np.searchsorted(np.flatnonzero(programs.variable >= 0), programs.columns))
    info = {"parameters": {"time_limit": options.time_limit}, "highs": highspy.Highs().version(), "components": len(seconds),
            "open_components": search[0].open, "largest": int(variables.max(initial=0)), "nodes": search[0].nodes,
            "timing": {**timing, "components": sum(seconds), "longest": max(seconds, default=0.0)}}
    return Answer(bits[None], np.array([energy]), objective=True, lower_bound=bound, info=info)
