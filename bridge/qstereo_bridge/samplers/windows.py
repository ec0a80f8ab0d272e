"""Windows: a reduced problem that is larger than a chip, answered call by call.

Each call takes some variables and folds the values that all others have in the best state known
into linear terms. What it answers is merged into this state, so H never rises.
"""

from __future__ import annotations

import hashlib
import itertools

import numpy as np

from ..core import merging, models
from ..core.failure import InputError
from ..core.problem import made
from ..core.qcf import Coefficients


def plan(p, variables, call=0, seed=0):
    """The variables of one call: sorted i64 array.

    It follows from the problem's digest, the seed and the number of the call alone.

    p           Problem
    variables   how many a call takes at most
    call        0, 1, 2 ..
    Raises InputError for a problem without variables, and where a group has more of them than a
    call takes.
    """
    if not len(p):
        raise InputError("this problem has no variables")
    return next(itertools.islice(calls(p, variables, seed), call, None))[0]


def calls(p, variables, seed=0):
    """(variables, whether it is the last of its pass) of call after call, without end."""
    for number in itertools.count() if len(p) else ():
        found = passes(p, variables, number, seed)
        yield from ((one, at == len(found)) for at, one in enumerate(found, 1))


def passes(p, variables, number=0, seed=0):
    """The calls of one pass, which have every variable in one of them at least: list of i64 arrays.

    Connected parts that fit are packed into calls, the largest first. A larger part is cut into
    overlapping windows: each is what breadth-first search over the couplings reaches from a group
    that no window has yet.
    """
    if p.sizes.max(initial=0) > variables:
        raise InputError(f"a group has {p.sizes.max():,} variables, a window takes "
                         f"{variables:,}; give larger --windows")
    rng = np.random.default_rng([*np.frombuffer(p.digest, "<u4"), seed, number])
    calls, rooms = [], []
    for part in p.parts():
        groups = np.unique(p.group[part])
        for one in [groups] if part.size <= variables else _cut(p, groups, variables, rng):
            size = p.sizes[one].sum()
            at = next((at for at, room in enumerate(rooms) if room >= size), len(calls))
            if at == len(calls):
                calls.append([])
                rooms.append(variables)
            calls[at].append(one)
            rooms[at] -= size
    every = np.arange(p.sizes.size)
    return [np.flatnonzero(p.of_variables(np.isin(every, np.concatenate(call)))) for call in calls]


def _cut(p, part, variables, rng):
    """The windows of one connected part: list of arrays of groups."""
    near, far = np.append(p.edges, p.edges[::-1], axis=1)
    order = np.argsort(near, kind="stable")
    far, first = far[order], np.searchsorted(near[order], np.arange(p.sizes.size + 1))
    windows, left = [], part
    while left.size:
        seen = np.zeros(p.sizes.size, bool)
        layer, room, window = rng.choice(left, 1), variables, []
        while layer.size and room > 0:
            seen[layer] = True
            taken = layer[np.cumsum(p.sizes[layer]) <= room]
            window.append(taken)
            room = room - p.sizes[taken].sum() if taken.size == layer.size else 0
            layer = np.unique(np.concatenate([far[first[at]:first[at + 1]] for at in layer]))
            layer = rng.permutation(layer[~seen[layer]])
        windows.append(np.concatenate(window))
        left = np.setdiff1d(left, windows[-1])
    return windows


def window(p, bits, variables):
    """The Problem of some variables, all others held at their values in `bits`. Its energies are
    those of the whole problem.

    p           Problem
    bits        array (n,) of 0 and 1
    variables   sorted array, whole groups
    Raises InputError.
    """
    bits = models.fitting(p, bits)[0]
    groups = np.unique(p.group[variables])
    inside, number = np.zeros(p.sizes.size, bool), np.zeros(p.sizes.size, np.int64)
    inside[groups], number[groups] = True, np.arange(groups.size)
    if not np.array_equal(np.flatnonzero(p.of_variables(inside)), variables):
        raise InputError("a window takes whole groups, their variables sorted")
    rest = bits * ~p.of_variables(inside)
    # The penalties of the groups outside are in the offset, those of the groups inside are not.
    fields = merging.States(p, rest[None]).fields[0, variables] + p.of_variables(p.a)[variables]
    g, h, block, weight = p.couplings[:, inside[p.couplings[:2]].all(axis=0)]
    offset = int(p.energies(rest)[0] - p.a[groups].sum())
    said = b"".join(array.astype("<i8").tobytes() for array in (groups, fields))
    return made(Coefficients(
        p.sizes[groups], p.blocks, np.stack([number[g], number[h], block, weight]), fields,
        p.a[groups], p.b[groups], offset, scale=p.scale, encoding=p.encoding,
        digest=hashlib.sha256(p.digest + said).digest(), memory_limit=p.memory_limit))


def begin(p):
    """A state for the rest of the first window, where none is known: each one-hot group's cheapest
    variable at 1, zeros elsewhere. u8 array (n,)."""
    bits = np.zeros(p.linear.size, np.uint8)
    cheapest = np.lexsort((p.linear, p.group))[p.starts[:-1]]
    bits[cheapest[p.one_hot]] = 1
    return bits


def improved(p, bits, variables, samples, known=True):
    """`bits` with the samples of a window merged into them: u8 array (n,).

    variables   of the window
    samples     u8 array (samples, variables)
    known       whether `bits` is a state to keep what is good in, so that H does not rise; else the
                window's variables are those of the samples alone
    """
    part, found = window(p, bits, variables), bits.copy()
    found[variables] = merging.merged(part, np.append(
        samples, bits[None, variables], axis=0) if known else samples)
    return found
