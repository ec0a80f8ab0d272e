"""A picture of an embedding: the problem's graph on the left, the chip on the right, each chain in
the colour of its variable."""

import io

import numpy as np

from . import tiles
from .failure import SolverError


def require():
    """matplotlib's Figure and colour maps. Raises ImportError where it is not installed."""
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    return Figure, colormaps


def draw(source, chip, embedding):
    """The bytes of a PNG. Raises SolverError for a chip that Ocean has no layout of."""
    import dwave.graphs
    import networkx as nx
    from dwave.graphs.drawing.qubit_layout import draw_embedding

    if chip.family is None:
        raise SolverError(f"{chip.name} is of a shape that cannot be drawn; embed without "
                          "--picture")
    Figure, colormaps = require()
    figure = Figure(figsize=(18, 9.6), dpi=150, layout="constrained")
    left, right = figure.subplots(1, 2, subplot_kw={"aspect": "equal", "anchor": "N"})
    labels = np.diff(source.starts)
    group = np.repeat(np.arange(labels.size), labels)
    cells, label = tiles.cells(source), np.arange(group.size) - source.starts[group]
    if cells is None:
        # The groups of another graph stand in a square.
        side = int(np.ceil(np.sqrt(labels.size)))
        cells = np.stack(np.divmod(np.arange(labels.size), side)[::-1], axis=1)
    # Neighbouring sites have like colours; the variables of a site stand in a ring around it.
    hue = (cells @ (1, 1.7) / max(1, (cells @ (1, 1.7)).max()))[group]
    colours = dict(enumerate(colormaps["turbo"](0.05 + 0.9 * hue).tolist()))
    angle, ring = 2 * np.pi * label / labels[group], 0.3 * (labels[group] > 1)
    at = (cells[group] + np.stack([ring * np.sin(angle), -ring * np.cos(angle)], axis=1)) * (1, -1)
    span = np.ptp(cells, axis=0).max() + 1
    nx.draw_networkx(source.graph, dict(enumerate(at)), ax=left, with_labels=False, width=0.3,
                     node_color=list(colours.values()), node_size=min(300, (140 / span) ** 2 / 3))
    layout, graph = (getattr(dwave.graphs, f"{chip.family}_{what}") for what in ("layout", "graph"))
    zoom = min(12 / chip.size, 4)
    draw_embedding(chip.graph, layout(graph(chip.size)), embedding.chains, ax=right,
                   embedded_graph=source.graph, chain_color=colours, node_size=12 * zoom,
                   unused_color=(0.9, 0.9, 0.9, 1.0), width=0.4 * zoom)
    found = embedding.figures()
    left.set_title(f"{source.variables:,} variables, {source.rows.size:,} couplings", fontsize=15)
    right.set_title(f"{chip.name}: {found['qubits']:,} of {len(chip.graph):,} qubits, longest "
                    f"chain {found['longest_chain']}, mean {found['mean_chain']:.2f}", fontsize=15)
    left.set(xlim=(-0.5, cells[:, 0].max() + 0.5), ylim=(-cells[:, 1].max() - 0.5, 0.5))
    left.set_axis_off()
    data = io.BytesIO()
    figure.savefig(data, format="png")
    return data.getvalue()
