"""From a problem to its terms, its exact energies, and dimod's models.

`problem` is qcf.Coefficients everywhere; for Python, functions are methods of problem.Problem.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import numpy as np

from .container import Corrupt, check_memory
from .failure import InputError
from .qcf import ENTRY_BYTES, before, places

if TYPE_CHECKING:
    import dimod
    from dwave.optimization import Model
    from numpy.typing import ArrayLike, NDArray

    from .qcf import Coefficients

# Terms expanded at a time: enough for numpy, few enough to keep temporary arrays out of the peak.
CHUNK = 1 << 19
# Bytes a term: 16 in three arrays; twice 16 in dimod's vectors, which may be half empty.
COO_BYTES, BQM_BYTES = 16, 64
# What a block serves as: itself, its part above the diagonal, transposed, that part mirrored.
WAYS = (lambda block: block, lambda block: np.triu(block, 1), np.transpose,
        lambda block: np.triu(block, 1) + np.triu(block, 1).T)


class Terms:
    """The quadratic terms of a Problem, sorted by (row, column), expanded chunk by chunk.

    Every coupling (and every penalty with b > 0, as a coupling of its group with itself) has a
    *pattern*: the entries of its block that are not 0, row after row. The terms of variable i of
    group g are then row i of the pattern of each of g's couplings, one after another in the order
    of the partner groups.

    `count` is their number, `repeated` says whether a (row, column) may stand there more than once.
    With `penalties` false the one-hot penalties are left out. With `both` each term stands there
    twice, in the row of either of its variables.
    """

    def __init__(self, problem, penalties=True, both=False):
        self.starts, self.limit = problem.starts, problem.memory_limit
        sizes, blocks = problem.sizes, list(problem.blocks)
        links = problem.couplings[:, problem.couplings[3] != 0]
        if penalties:
            own = np.flatnonzero((problem.b != 0) & (sizes > 1))
            of_size, at = np.unique(sizes[own], return_inverse=True)
            links = np.append(links, [own, own, len(blocks) + at, problem.b[own]], axis=1)
            blocks += [np.broadcast_to(np.int32(1), (size, size)) for size in of_size.tolist()]
        # What the block of each serves as: a place in WAYS.
        way = (1 + 2 * both) * (links[0] == links[1])
        if both:
            back = links[:, way == 0][[1, 0, 2, 3]]
            links, way = np.append(links, back, axis=1), np.append(way, np.full(back.shape[1], 2))
        # Stable sorting merges runs that are sorted already, as couplings usually are in a file.
        order = np.argsort(links[0] * sizes.size + links[1], kind="stable")
        g, self.h, block, self.weight = links[:, order]
        used, self.pattern = np.unique(4 * block + way[order], return_inverse=True)
        self.blocks = [(blocks[key // 4], key % 4) for key in used.tolist()]
        # Of each coupling its number of terms; of each group its couplings.
        self.terms = np.array([_count(*one) for one in self.blocks], int)[self.pattern]
        self.partners = np.bincount(g, minlength=sizes.size)
        self.count = int(self.terms.sum())
        self.repeated = self.count > 0 and bool(((np.diff(g) == 0) & (np.diff(self.h) == 0)).any())

    @functools.cached_property
    def _tables(self):
        """Of all patterns' rows one after another: the number of entries, where they begin, their
        columns and values; then the first row of each coupling, the first coupling of each group.
        """
        entries = sum(block.size for block, _ in self.blocks)
        check_memory(ENTRY_BYTES * entries, self.limit, f"blocks of {entries:,} entries")
        patterns = [WAYS[way](block) for block, way in self.blocks]
        lengths, columns, values = (np.concatenate(parts) for parts in zip(*(
            (np.count_nonzero(block, axis=1), np.nonzero(block)[1].astype(np.int32),
             block[block != 0]) for block in patterns)))
        first_row = before(np.array(list(map(len, patterns))))[self.pattern]
        return lengths, before(lengths), columns, values, first_row, before(self.partners)

    def of_rows(self, row):
        """(at, columns, values): the terms in the rows of the variables `row`, one row after
        another; term k is in that of row[at[k]]."""
        if self.count == 0:
            return (np.empty(0, np.int64),) * 3
        lengths, first_entry, columns, values, first_row, first_coupling = self._tables
        group = np.searchsorted(self.starts, row, side="right") - 1
        # A segment is one row of one pattern.
        segments = self.partners[group]
        at, group = np.repeat(np.arange(row.size), segments), np.repeat(group, segments)
        coupling = first_coupling[group] + places(segments)
        entry_row = first_row[coupling] + row[at] - self.starts[group]
        length = lengths[entry_row]
        entry = np.repeat(first_entry[entry_row], length) + places(length)
        coupling = np.repeat(coupling, length)
        return (np.repeat(at, length), self.starts[self.h[coupling]] + columns[entry],
                self.weight[coupling] * values[entry])

    def chunks(self):
        """Yields (rows, columns, values), integer arrays of about CHUNK terms, in the order of
        (row, column)."""
        # Ranges of variables that have about CHUNK terms each.
        terms = np.append(0, np.cumsum(self.terms))[np.append(0, np.cumsum(self.partners))]
        cuts = np.interp(np.arange(0, self.count, CHUNK), terms, self.starts).astype(np.int64)
        cuts = np.unique(np.append([0, self.starts[-1]], cuts))
        for low, high in zip(cuts[:-1], cuts[1:]):
            row = np.arange(low, high)
            at, columns, values = self.of_rows(row)
            yield row[at], columns, values


def _count(block, way):
    """How many entries a pattern has; of a penalty's, whose block is one 1, without its entries."""
    if way in (0, 2):
        return np.count_nonzero(block)
    above = (len(block) * (len(block) - 1) // 2 if block.strides == (0, 0) else
             np.count_nonzero(np.triu(block, 1)))
    return above * (2 if way == 3 else 1)


def expand(problem, penalties=True):
    """All coefficients: (linear, (rows, columns, values), offset).

    linear, values are i64; rows < columns are i32, sorted by (row, column), without repetitions and
    without zeros. The penalties are folded in (-a on each linear term, b on each pair of the group,
    a in the offset) or, with `penalties` false, left out.
    Raises OverLimit where these arrays and dimod's model of them would not fit into the problem's
    memory limit.
    """
    terms = Terms(problem, penalties)
    check_memory(terms.count * (COO_BYTES + BQM_BYTES), problem.memory_limit,
                 f"a model of {terms.count:,} quadratic terms")
    found, at = [np.empty(terms.count, kind) for kind in (np.int32, np.int32, np.int64)], 0
    for chunk in terms.chunks():
        for whole, part in zip(found, chunk):
            whole[at:at + part.size] = part
        at += chunk[0].size
    return (linear_terms(problem, penalties), added_up(*found) if terms.repeated else tuple(found),
            constant(problem, penalties))


def added_up(rows, columns, values):
    """The terms, those of the same (row, column) added up, without those that cancel."""
    order = np.lexsort((columns, rows))
    rows, columns = rows[order], columns[order]
    first = np.flatnonzero(np.append(True, (np.diff(rows) != 0) | (np.diff(columns) != 0)))
    values = np.add.reduceat(values[order], first)
    kept = values != 0
    return rows[first][kept], columns[first][kept], values[kept]


def linear_terms(problem, penalties=True):
    """i64 array: the linear term of each variable, with -a of its group unless `penalties` is
    false."""
    return problem.linear - problem.of_variables(problem.a) if penalties else problem.linear


def constant(problem, penalties=True):
    """H of the state of zeros: the offset, and every group's a unless `penalties` is false."""
    return problem.offset + (int(problem.a.sum()) if penalties else 0)


def fitting(problem, bits):
    """Samples as a u8 array (samples, n) of 0 and 1. Raises InputError."""
    bits, n = np.atleast_2d(np.asarray(bits)), problem.linear.size
    if bits.ndim != 2 or bits.shape[1] != n or not ((bits == 0) | (bits == 1)).all():
        raise InputError(f"bits are 0 and 1 in an array (samples, {n}), these are {bits.shape} of "
                         f"{bits.dtype}")
    return bits.astype(np.uint8, copy=False)


def energies(problem: Coefficients, bits: ArrayLike, penalties: bool = True) -> NDArray[np.int64]:
    """i64 array (samples,): exact H, or with `penalties` false what it is without them.

    bits    array (samples, n) or (n,) of 0 and 1; InputError where it does not fit
    """
    bits = fitting(problem, bits)
    total = np.full(bits.shape[0], problem.offset, np.int64)
    block = max(1, (1 << 26) // max(bits.shape[1], 1))
    for at in range(0, total.size, block):
        part = bits[at:at + block]
        total[at:at + block] += part.astype(np.int64) @ problem.linear
        if penalties:
            count = ones(problem, part)
            total[at:at + block] += (1 - count) @ problem.a + (count * (count - 1) // 2) @ problem.b
    bits = np.ascontiguousarray(bits.T, np.uint8)
    block = max(1, (1 << 24) // CHUNK)
    for row, column, value in Terms(problem, penalties=False).chunks():
        for at in range(0, total.size, block):
            these = np.s_[at:at + block]
            total[these] += value @ (bits[row, these] & bits[column, these]).astype(np.int64)
    return total


def ones(problem, bits):
    """i64 array (samples, groups): how many variables of each group are 1."""
    return np.add.reduceat(bits, problem.starts[:-1], axis=1, dtype=np.int64)


def check_known(problem):
    """Raises Corrupt where the labelling that the file carries is below the bound that it
    states."""
    if problem.known is not None and problem.stated_bound is not None:
        energy = int(energies(problem, problem.known[None])[0])
        if energy < problem.stated_bound:
            raise Corrupt(f"chunk best: it states the lower bound {problem.stated_bound}, but "
                          f"its labelling has {energy}, in integer units: one of them is wrong, "
                          "so reduce the problem again")


def feasible(problem: Coefficients, bits: ArrayLike) -> NDArray[np.bool_]:
    """bool array (samples,): whether each one-hot group has one variable at 1. `bits` as of
    energies()."""
    return ((ones(problem, fitting(problem, bits)) == 1) | ~problem.one_hot).all(axis=1)


def components(count, g, h):
    """i64 array (count,): of each node the least one of its connected component, where the edges
    join the nodes g and h."""
    least = np.arange(count)
    while (least[g] != least[h]).any():
        low, high = np.minimum(least[g], least[h]), np.maximum(least[g], least[h])
        np.minimum.at(least, high, low)
        while (least[least] != least).any():
            least = least[least]
    return least


def parts(problem: Coefficients) -> list[NDArray[np.int64]]:
    """The variables of each connected part: list of i64 arrays, the largest first. No coupling
    joins two parts; a group is in one part."""
    of_variable = components(problem.sizes.size, *problem.edges)[problem.group]
    order = np.argsort(of_variable, kind="stable")
    cuts = np.flatnonzero(np.diff(of_variable[order])) + 1
    return sorted(np.split(order, cuts) if order.size else [], key=lambda part: -part.size)


def to_bqm(problem: Coefficients) -> dimod.BinaryQuadraticModel:
    """dimod.BinaryQuadraticModel of H, penalties folded in, variables 0 .. n - 1. Raises OverLimit.
    """
    import dimod

    return dimod.BinaryQuadraticModel.from_numpy_vectors(*expand(problem), "BINARY")


def to_cqm(problem: Coefficients) -> dimod.ConstrainedQuadraticModel:
    """dimod.ConstrainedQuadraticModel: H without penalties, each one-hot group a constraint. Raises
    OverLimit."""
    import dimod

    cqm, terms = dimod.ConstrainedQuadraticModel(), expand(problem, penalties=False)
    cqm.set_objective(dimod.BinaryQuadraticModel.from_numpy_vectors(*terms, "BINARY"))
    for group in np.flatnonzero(problem.one_hot).tolist():
        # add_discrete says the same, but compares each new group with all others.
        members = [(i, 1) for i in range(*problem.starts[group:group + 2])]
        cqm.add_constraint_from_iterable(members, "==", rhs=1, label=group)
        # On a group of one variable dimod passes over the mark, and the equality alone says it.
        cqm.constraints[group].lhs.mark_discrete()
    return cqm


def to_nl(problem: Coefficients) -> Model:
    """dwave.optimization.Model of H. Raises OverLimit, ImportError without the extra `dwave`.

    Where every group is one-hot, it decides on an integer for each group, the variable that is 1:
    no penalty, no constraint, no infeasible state. Else on a bit for each variable, penalties
    included.
    """
    from dwave.optimization import Model

    model = Model()
    energy = _nl_labels if problem.one_hot.all() else _nl_bits
    model.minimize(energy(model, problem))
    return model


def _nl_labels(model, problem):
    sizes, (g, h, block, weight) = problem.sizes, problem.couplings
    # Indices are checked against the bounds of all labels together: each group has room for the
    # most labels that any has.
    most = int(sizes.max())
    # A constant is held as doubles; of each coupling the model's state keeps a few numbers.
    check_memory(24 * most * sizes.size + 80 * g.size, problem.memory_limit,
                 f"a model of {problem.linear.size:,} labels and {g.size:,} couplings")
    costs = np.zeros((sizes.size, most))
    costs[np.arange(most) < sizes[:, None]] = problem.linear
    label = model.integer(sizes.size, lower_bound=0, upper_bound=sizes - 1)
    at = label + model.constant(np.arange(sizes.size) * most)
    total = model.constant(costs.ravel())[at].sum() + model.constant(problem.offset)
    for number, content in enumerate(problem.blocks):
        these = np.flatnonzero((block == number) & (weight != 0))
        if these.size:
            padded = np.zeros((most, most))
            padded[:content.shape[0], :content.shape[1]] = content
            table = model.constant(padded)
            costs = table[label[model.constant(g[these])], label[model.constant(h[these])]]
            alike = (weight[these] == weight[these[0]]).all()
            total = total + (costs.sum() * model.constant(int(weight[these[0]])) if alike else
                             (costs * model.constant(weight[these])).sum())
    return total


def _nl_bits(model, problem):
    linear, (rows, columns, values), offset = expand(problem)
    bits = model.binary(linear.size)
    total = (bits * model.constant(linear)).sum() + model.constant(offset)
    if rows.size:
        both = bits[model.constant(rows)] * bits[model.constant(columns)]
        total = total + (both * model.constant(values)).sum()
    return total
