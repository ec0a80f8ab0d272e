"""From many samples the best state that they hold together: steepest descent of each, then merging.

Merging is partition crossover (Whitley, Hains and Howe 2009). Let D be the variables in which two
states differ. No coupling joins two connected components of the couplings on D, so each component
changes H by an amount of its own, and those that lower H are taken: of m components the best of 2^m
states. In the same way whole regions of a label are given another one. All numbers are exact
integers.
"""

from __future__ import annotations

import numpy as np

from . import models
from .container import check_memory
from .failure import InputError
from .qsf import NO_CHAINS, RECORD, Samples

# Entries of the arrays (reads, variables) that are worked on at a time, and bytes for each.
BLOCK, ENTRY_BYTES = 1 << 22, 64


class States:
    """Some states of a problem.

    bits        u8 array (states, n)
    fields      i64 array (states, n): what H changes by where the variable becomes 1
    """

    def __init__(self, problem, bits):
        self.problem, self.terms = problem, models.Terms(problem, both=True)
        self.bits = np.zeros(bits.shape, np.uint8)
        self.fields = np.tile(models.linear_terms(problem), (bits.shape[0], 1))
        self.flip(*np.nonzero(bits))

    def flip(self, state, variable):
        """Flip each of the variables in the state beside it; no pair stands there twice."""
        n = self.bits.shape[1]
        pieces = 1 + variable.size * self.terms.count // (max(n, 1) * models.CHUNK)
        for these in np.array_split(np.arange(variable.size), pieces):
            states, variables = state[these], variable[these]
            sign = 1 - 2 * self.bits[states, variables].astype(np.int64)
            self.bits[states, variables] ^= 1
            at, column, value = self.terms.of_rows(variables)
            np.add.at(self.fields.reshape(-1), states[at] * n + column, value * sign[at])

    def best_moves(self):
        """(deltas of all moves, an array as `bits`; the least of each group; whether a group moves
        by an exchange).

        A one-hot group with one variable at 1 keeps that: its moves exchange this variable for
        another. The moves of all other groups are flips.
        """
        problem, bits, fields = self.problem, self.bits, self.fields
        exchanges = (models.ones(problem, bits) == 1) & problem.one_hot
        hot = np.add.reduceat(bits * fields, problem.starts[:-1], axis=1)
        # What an exchange brings to 1 no longer pays for the one that leaves.
        exchanged = np.where(bits == 0, fields - problem.of_variables(hot + problem.b), 0)
        deltas = np.where(problem.of_variables(exchanges), exchanged,
                          np.where(bits == 0, fields, -fields))
        return deltas, np.minimum.reduceat(deltas, problem.starts[:-1], axis=1), exchanges


def _independent(best, g, h):
    """bool array: the groups whose best move lowers H, and by more than that of every group that a
    coupling (g, h) joins them with; the first of equal ones."""
    moves = best < 0
    state, pair = np.nonzero(moves[:, g] & moves[:, h])
    first = best[state, g[pair]] <= best[state, h[pair]]
    moves[state, np.where(first, h[pair], g[pair])] = False
    return moves


def _descend(problem, bits):
    """The local minima that steepest descent leads to from the states `bits`: u8 array. Groups that
    no coupling joins move at once."""
    states = States(problem, bits)
    g, h = np.sort(problem.edges, axis=0)
    g, h = g[g != h], h[g != h]
    while True:
        deltas, best, exchanges = states.best_moves()
        moves = _independent(best, g, h)
        if not moves.any():
            return states.bits
        state, variable = np.nonzero(problem.of_variables(moves)
                                     & (deltas == problem.of_variables(best)))
        # Of equal moves of a group the first.
        _, first = np.unique(state * moves.shape[1] + problem.group[variable], return_index=True)
        state, variable = state[first], variable[first]
        leaving = problem.of_variables(moves & exchanges) & (states.bits == 1)
        states.flip(*(np.append(*pair) for pair in zip((state, variable), np.nonzero(leaving))))


def descend(problem, bits):
    """Steepest descent of each state: u8 array (samples, n). A feasible state stays feasible.

    problem     qcf.Coefficients
    bits        u8 array (samples, n)
    """
    if not bits.size:
        return bits
    step = max(1, BLOCK // bits.shape[1])
    return np.concatenate([_descend(problem, bits[at:at + step])
                           for at in range(0, bits.shape[0], step)])


class Merger(States):
    """One state, into which others are merged."""

    def __init__(self, problem, bits):
        super().__init__(problem, bits[None])
        self.place = np.full(bits.size, -1)

    def merge(self, other):
        """Merge the state `other`; whether H has fallen."""
        return self.take(np.flatnonzero(self.bits[0] != other))

    def take(self, differ):
        """Flip those components of the variables `differ`, sorted, that lower H; whether there are
        any."""
        if not differ.size:
            return False
        bits, problem = self.bits[0], self.problem
        sign, group = 1 - 2 * bits[differ].astype(np.int64), problem.group[differ]
        at, column, value = self.terms.of_rows(differ)
        self.place[differ] = np.arange(differ.size)
        there = self.place[column]
        self.place[differ] = -1
        at, there, value = (array[there > at] for array in (at, there, value))
        # The variables of a one-hot group count as coupled.
        same = np.flatnonzero((group[1:] == group[:-1]) & problem.one_hot[group[1:]])
        label = models.components(differ.size, np.append(at, same), np.append(there, same + 1))
        gains = sign * self.fields[0, differ]
        np.add.at(gains, at, value * sign[at] * sign[there])
        total, spoilt = np.zeros(differ.size, np.int64), np.zeros(differ.size, bool)
        np.add.at(total, label, gains)
        # A group with one variable at 1 keeps that.
        run = np.cumsum(np.append(0, group[1:] != group[:-1]))
        lost = problem.one_hot[group] & (np.bincount(run, sign) != 0)[run]
        if lost.any():
            lost &= (models.ones(problem, self.bits)[0] == 1)[group]
        np.logical_or.at(spoilt, label, lost)
        taken = differ[(total < 0)[label] & ~spoilt[label]]
        self.flip(np.zeros(taken.size, np.int64), taken)
        return taken.size > 0

    def recolour(self):
        """Give regions the label of a neighbour, each where that lowers H; whether there are any. A
        region is what couplings join of the one-hot groups with one label. Descent moves one group
        at a time, and where all reads err in the same region, merging them cannot mend it."""
        problem, starts, found = self.problem, self.problem.starts[:-1], False
        sound = problem.one_hot & (models.ones(problem, self.bits)[0] == 1)
        at = np.flatnonzero(self.bits[0] & problem.of_variables(sound))
        label = np.full(starts.size, -1)
        label[problem.group[at]] = at - starts[problem.group[at]]
        near, far = np.append(problem.edges, problem.edges[::-1], axis=1)
        near, far = np.stack([near, far])[:, (label[near] >= 0) & (label[far] >= 0)]
        alike = label[near] == label[far]
        region = models.components(starts.size, near[alike], far[alike])
        # Label, that of a neighbour, region; those of one pair of labels stand together.
        touch = np.unique(np.stack([label[near], label[far], region[near]])[:, ~alike], axis=1)
        cuts = np.flatnonzero(np.diff(touch[:2]).any(axis=0)) + 1
        for these in np.split(touch, cuts, axis=1) if touch.size else ():
            old, new = these[:2, 0]
            first = starts[np.isin(region, these[2]) & (problem.sizes > new)]
            first = first[self.bits[0, first + old] == 1]
            found |= self.take(np.sort(np.append(first + old, first + new)))
        return found


def merged(problem, bits):
    """The best state that descent and merging make of some samples: u8 array (n,).

    Its H is at most that of each feasible sample, and it is feasible, where there is one; else at
    most that of every sample.

    problem     qcf.Coefficients
    bits        u8 array (samples, n), at least one sample
    Raises OverLimit.
    """
    if not bits.size:
        return bits[0]
    reads, n = bits.shape
    check_memory(ENTRY_BYTES * min(n * reads, max(BLOCK, n)), problem.memory_limit,
                 f"descent of {reads:,} samples of {n:,} variables")
    states = np.unique(np.packbits(descend(problem, bits), axis=1), axis=0)
    states = np.unpackbits(states, axis=1, count=bits.shape[1])
    order = np.lexsort((models.energies(problem, states), ~models.feasible(problem, states)))
    merger = Merger(problem, states[order[0]])
    # Another round may find more: what was taken last changes what the first ones offer.
    while any([merger.merge(states[at]) for at in order[1:]]) or merger.recolour():
        pass
    return merger.bits[0]


def best_of(problem, samples):
    """The number of the best of some Samples, feasible ones first; None without any."""
    order = np.lexsort((samples.records["energy"], ~models.feasible(problem, samples.bits)))
    return int(order[0]) if order.size else None


def finished(problem, samples, known=None):
    """The Samples with the result of descent and merging: as one more sample, the last, where it
    is better than all others. INFO's "result" says how many reads there are, which sample is the
    result, and whether a state known before was merged, too.

    problem     qcf.Coefficients
    known       u8 array (n,): a state to merge with the samples, or None
    Raises OverLimit.
    """
    bits, records, reads = samples.bits, samples.records, samples.records.size
    if not reads:
        return samples
    others = bits[:0] if known is None else known[None]
    result = merged(problem, np.append(bits, others, axis=0))[None]
    energy, best = models.energies(problem, result), best_of(problem, samples)
    sound, was_sound = (models.feasible(problem, one)[0] for one in (result, bits[[best]]))
    if (not sound, energy[0]) < (not was_sound, records["energy"][best]):
        best, bits = reads, np.append(bits, result, axis=0)
        records = np.append(records, np.array([(energy[0], 1, NO_CHAINS)], RECORD))
    info = {**samples.info, "result": {"reads": reads, "sample": best,
                                       **({} if known is None else {"known": True})}}
    return Samples(samples.digest, samples.solver, records, bits, info, samples.sides)


def merge(p, *samples):
    """The Samples of all `samples` of the Problem `p`, and the best state that they hold together:
    where it is better than each of them it is one more sample, the last. See finished().

    Energies are exact; the result's is at most that of each feasible sample, and it is feasible
    where one of them is. Raises InputError for samples of another problem, or none; OverLimit.
    """
    if not samples or any(one.digest != p.digest for one in samples):
        raise InputError("these samples are of another problem: the SHA-256 of its file differs"
                         if samples else "give samples to merge")
    names = dict.fromkeys(one.solver for one in samples)
    together = Samples(
        p.digest, next(iter(names)) if len(names) == 1 else "merge",
        np.concatenate([one.records for one in samples]),
        np.concatenate([one.bits for one in samples]),
        samples[0].info if len(samples) == 1 else {"merged": [
            {"solver": one.solver, "samples": one.records.size, **one.info} for one in samples]})
    return finished(p, together)
