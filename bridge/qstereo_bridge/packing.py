"""Embeddings of problems in several connected parts: each shape of part once, into a small chip of
the same family, then moved to free tiles of the real one, side by side.

A reduced picture falls into dozens of parts, most of one to thirty variables. Their embeddings are
those of small graphs, which the cache keeps for all problems that have a part of this shape.
"""

import dataclasses
import functools

import networkx as nx
import numpy as np

from . import tiles

# A part is first looked for on a small chip of at least this many qubits a variable; a large one,
# whose chains are longer, straight on the whole.
ROOM, LARGE = 2, 150


class _Board:
    """What is taken of a chip."""

    def __init__(self, chip):
        self.chip, self.tile = chip, tiles.tiling(chip)
        self.free = np.zeros(2 * self.tile.lines * self.tile.places, bool)
        self.free[list(chip.graph)] = True

    def place(self, small, chains):
        """The chains of a small chip, moved to the first tiles where all of their qubits are free
        and all of their couplers work; None where there are none."""
        tile, here = tiles.tiling(small), [q for chain in chains for q in chain]
        couplers = np.array(small.graph.subgraph(here).edges, np.int64).reshape(-1, 2)
        x, y = (shift.ravel() for shift in np.indices((self.tile.tiles - tile.tiles + 1,) * 2))

        def moved(qubits):
            across, place = np.divmod(np.asarray(qubits, np.int64), tile.places)
            turn, line = np.divmod(across, tile.lines)
            dx, dy = x.reshape(-1, *[1] * turn.ndim), y.reshape(-1, *[1] * turn.ndim)
            line = line + self.tile.step * np.where(turn == 0, dx, dy)
            return (turn * self.tile.lines + line) * self.tile.places + place + np.where(
                turn == 0, dy, dx)
        every = moved(here)
        for at in np.flatnonzero(self.free[every].all(axis=1)):
            ends = moved(couplers)[at]
            if all(self.chip.graph.has_edge(p, q) for p, q in ends.tolist()):
                self.free[every[at]] = False
                cuts = np.cumsum([len(chain) for chain in chains])[:-1]
                return [chain.tolist() for chain in np.split(every[at], cuts)]
        return None

    def rest(self):
        """The Chip of the qubits that are free."""
        graph = self.chip.graph.copy()
        graph.remove_nodes_from([q for q in self.chip.graph if not self.free[q]])
        return dataclasses.replace(self.chip, graph=graph)


def _of_shape(source, chip, small, obtain):
    """(small chip, chains) of a part on the smallest chip, `small` of its size, that takes it; None
    where none does."""
    variables = len(source.graph)
    for size in range(2, chip.size if variables <= LARGE else 2):
        if len(small(size).graph) >= ROOM * variables and (found := obtain(source, small(size))):
            return small(size), [found[v] for v in range(variables)]
    return None


def lay_out(source, chip, obtain, find, progress=lambda text: None):
    """{variable: [qubits]} of a Source in several connected parts; None of one in one part, on a
    chip of another family than Zephyr and Pegasus, or where a part finds no room.

    obtain, find    functions of a Source and a Chip to {variable: [qubits]} or None, one for what
                    is worth to be kept, one for what is left of this chip
    """
    parts = sorted(map(sorted, nx.connected_components(source.graph)), key=len, reverse=True)
    if len(parts) < 2 or tiles.tiling(chip) is None:
        return None
    board, known, chains = _Board(chip), {}, {}
    small = functools.cache(lambda size: chip.named(f"{chip.family}:{size}"))
    for number, part in enumerate(parts, 1):
        progress(f"part {number} of {len(parts)}")
        shape = source.part(part)
        if shape.digest not in known:
            known[shape.digest] = _of_shape(shape, chip, small, obtain)
        found = known[shape.digest] and board.place(*known[shape.digest])
        if found is None:
            rest = find(shape, board.rest())
            if not rest:
                return None
            found = [rest[v] for v in range(len(part))]
            board.free[sum(found, [])] = False
        chains.update(zip(part, found))
    return chains
