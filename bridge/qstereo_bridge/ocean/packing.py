"""Embeddings of problems in several connected parts: each shape of part once, into a small chip of
the same family, then moved to free tiles of the real one, side by side.

A reduced picture falls into dozens of parts, most of one to thirty variables. Their embeddings are
those of small graphs, which the cache keeps for all problems that have a part of this shape.
"""

import dataclasses

import networkx as nx

# A part is first looked for on a small chip of at least this many qubits a variable; a large one,
# whose chains are longer, straight on the whole.
ROOM, LARGE = 2, 150


def _shaped(chip):
    """The chip's graph, with what dwave.graphs asks of its shape."""
    return nx.Graph(chip.graph, family=chip.family, rows=chip.size, columns=chip.size, tile=4,
                    labels="int")


def _placed(source, count, chip, free, obtain):
    """At most `count` embeddings of a part in the graph `free`: that on the smallest chip that
    takes it, moved. List of {variable: qubits}."""
    from minorminer.utils.parallel_embeddings import find_sublattice_embeddings

    for size in range(2, chip.size if len(source.graph) <= LARGE else 2):
        small = chip.named(f"{chip.family}:{size}")
        if len(small.graph) >= ROOM * len(source.graph) and (found := obtain(source, small)):
            return find_sublattice_embeddings(
                source.graph, free, tile=_shaped(small), tile_embedding=found, max_num_emb=count,
                one_to_iterable=True, use_filter=False)
    return []


def lay_out(source, chip, obtain, find, progress=lambda text: None):
    """{variable: [qubits]} of a Source in several connected parts; None of one in one part, on a
    chip of another family than Zephyr and Pegasus, or where a part finds no room.

    obtain, find    functions of a Source and a Chip to {variable: [qubits]} or None, one for what
                    is worth to be kept, one for what is left of this chip
    """
    parts = sorted(map(sorted, nx.connected_components(source.graph)), key=len, reverse=True)
    if len(parts) < 2 or chip.family is None:
        return None
    shapes, free, chains = {}, _shaped(chip), {}
    for part in parts:
        shape = source.part(part)
        shapes.setdefault(shape.digest, (shape, []))[1].append(part)
    for number, (shape, alike) in enumerate(shapes.values(), 1):
        progress(f"shape {number} of {len(shapes)}")
        placed = _placed(shape, len(alike), chip, free, obtain)
        for at, part in enumerate(alike):
            found = placed[at] if at < len(placed) else find(
                shape, dataclasses.replace(chip, graph=free))
            if not found:
                return None
            chains.update((v, list(found[i])) for i, v in enumerate(part))
            free.remove_nodes_from([qubit for chain in found.values() for qubit in chain])
    return chains
