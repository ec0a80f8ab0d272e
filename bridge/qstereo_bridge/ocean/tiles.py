"""Embeddings of labelling problems on grids, laid out in the tiles of a chip.

A Zephyr or Pegasus chip is a grid of equal tiles. A site of a picture takes one tile, or a block of
s x s tiles, and each of its variables a cross in it: a vertical and a horizontal line of qubits
that meet. Any two of the eight crosses of a tile are coupled (the site's clique), and so is each,
along its two lines, with the one at its place in the next tile (the same label at the neighbouring
site). So k labels with k couplers an edge take chains of 2 ceil(k / 8) qubits.
"""

import collections

import numpy as np

CROSSES = np.arange(8)
# Labels from which on chains of two are short: minorminer takes 1.3 qubits a variable for two
# labels, 2.1 and more for three.
FEWEST = 3
# Qubit (orientation u, line, place along it) of a chip is (u * lines + line) * places + place. The
# tile at (x, y) has the vertical lines step * x + vertical[i] at place y, and the horizontal lines
# step * y + horizontal[i] at place x, for the crosses i = 0 .. 7; there are `tiles` x `tiles`.
Tiling = collections.namedtuple("Tiling", "tiles lines places step vertical horizontal")


def tiling(chip):
    """The Tiling of a chip, or None.

    Zephyr: columns and rows of odd number, whose four lines have two overlapping qubits each at
    every crossing: a complete K_8,8. Pegasus: the lines 8 to 15 both ways. Vertical 8 .. 11 meet
    horizontal 12 .. 15, and vertical 12 .. 15 horizontal 8 .. 11; of a cross of the one kind and
    one of the other, vertical 10, 11 meet horizontal 8 .. 11, and vertical 12 .. 15 horizontal
    12, 13.
    """
    m, eight = chip.size, 8 + CROSSES
    if chip.family == "zephyr":
        return Tiling(m, 8 * (2 * m + 1), m, 16, eight, eight)
    if chip.family == "pegasus":
        return Tiling(m - 1, 12 * m, m - 1, 12, eight, 8 + (CROSSES ^ 4))
    return None


def cells(source):
    """Column and row of each group, array (groups, 2); None where the groups are no grid in raster
    order, or not one piece."""
    groups = source.starts.size - 1
    group = np.repeat(np.arange(groups), np.diff(source.starts))
    pairs = np.unique(group[np.array(source.graph.edges, int).reshape(-1, 2)], axis=0)
    g, h = pairs[pairs[:, 0] != pairs[:, 1]].T
    # In raster order a right neighbour is the next group, and every other neighbour is below.
    step = np.stack([h == g + 1, h != g + 1], axis=1).astype(np.int64)
    place, known, reached = np.zeros((groups, 2), np.int64), np.arange(groups) == 0, 0
    while known.sum() > reached:
        reached = known.sum()
        for near, far, sign in ((g, h, 1), (h, g, -1)):
            at = known[near] & ~known[far]
            place[far[at]] = place[near[at]] + sign * step[at]
            known[far[at]] = True
    # What was not reached stands at the first group's place.
    sound = (place[h] - place[g] == step).all() and np.unique(place, axis=0).shape[0] == groups
    return place - place.min(axis=0) if sound else None


def lay_out(source, chip):
    """{variable: [qubits]}: the crosses of a grid's sites, where on the chip most of their qubits
    work; None where it does not fit. Qubits may be missing, and the couplings may be others than
    crosses have: see embedding.faults()."""
    tile, place, sizes = tiling(chip), cells(source), np.diff(source.starts)
    if tile is None or place is None or sizes.max() < FEWEST or sizes.size == 1:
        return None
    side = -(-int(sizes.max()) // CROSSES.size)
    group = np.repeat(np.arange(sizes.size), sizes)
    label = np.arange(group.size) - source.starts[group]
    works = np.zeros(2 * tile.lines * tile.places, bool)
    works[list(chip.graph)] = True
    # Variable v has its vertical line in column `own` of its site's block of tiles, its horizontal
    # one in row `own`.
    own, cross, along = label // CROSSES.size, label % CROSSES.size, np.arange(side)
    corner, room = side * place[group], tile.tiles - side * (place.max(axis=0) + 1)
    best, most = None, -1
    for x in range(room[0] + 1):
        for y in range(room[1] + 1):
            left, top = (corner + (x, y)).T
            lines = np.concatenate([tile.step * (left + own) + tile.vertical[cross],
                                    tile.lines + tile.step * (top + own) + tile.horizontal[cross]])
            qubits = (lines * tile.places + np.concatenate([top, left]) + along[:, None]).reshape(
                2 * side, -1)
            count = int(works[qubits].sum())
            if count > most:
                best, most = qubits.T, count
    return None if best is None else dict(enumerate(best.tolist()))
