"""A picture of an embedding: the problem's graph on the left, the chip on the right, each chain in
the colour of its variable."""

import io

import numpy as np

from . import tiles
from .failure import SolverError

# Corners of the picture: top left, top right, bottom left, bottom right. Neighbouring sites have
# like colours.
CORNERS = np.array([[[0.07, 0.40, 0.75], [0.52, 0.18, 0.70]],
                    [[0.02, 0.62, 0.45], [0.95, 0.55, 0.08]]])
INK, UNUSED = "#303030", (0.9, 0.9, 0.9, 1.0)


def require():
    """matplotlib's Figure. Raises ImportError where it is not installed."""
    from matplotlib.figure import Figure

    return Figure


def draw(source, chip, embedding):
    """The bytes of a PNG. Raises SolverError for a chip that Ocean has no layout of."""
    import dwave.graphs
    import networkx as nx
    from dwave.graphs.drawing.qubit_layout import draw_embedding

    if chip.family is None:
        raise SolverError(f"{chip.name} is of a shape that cannot be drawn; embed without "
                          "--picture")
    figure = require()(figsize=(18, 9.6), dpi=150, layout="constrained")
    left, right = figure.subplots(1, 2, subplot_kw={"aspect": "equal", "anchor": "N"})
    group = np.repeat(np.arange(source.starts.size - 1), np.diff(source.starts))
    sites, label = _sites(source), np.arange(group.size) - source.starts[group]
    labels = np.diff(source.starts)[group]
    colours = dict(enumerate(map(tuple, _colours(sites, group, label / np.maximum(labels - 1, 1)))))
    # The variables of a site stand in a ring around it.
    angle, ring = 2 * np.pi * label / labels, 0.3 * (labels > 1)
    at = (sites[group] + np.stack([ring * np.sin(angle), -ring * np.cos(angle)], axis=1)) * (1, -1)
    span = np.ptp(sites, axis=0).max() + 1
    nx.draw_networkx(source.graph, dict(enumerate(at)), ax=left, with_labels=False, width=0.3,
                     edge_color=INK, node_color=list(colours.values()),
                     node_size=min(300, (140 / span) ** 2 / 3))
    layout, graph = (getattr(dwave.graphs, f"{chip.family}_{what}") for what in ("layout", "graph"))
    zoom = min(12 / chip.size, 4)
    draw_embedding(chip.graph, layout(graph(chip.size)), embedding.chains,
                   embedded_graph=source.graph, chain_color=colours, unused_color=UNUSED, ax=right,
                   node_size=12 * zoom, width=0.4 * zoom)
    found = embedding.figures()
    left.set_title(f"{source.variables:,} variables, {source.rows.size:,} couplings", fontsize=15)
    right.set_title(f"{chip.name}: {found['qubits']:,} of {len(chip.graph):,} qubits, longest "
                    f"chain {found['longest_chain']}, mean {found['mean_chain']:.2f}", fontsize=15)
    right_end, bottom = sites.max(axis=0) + 0.5
    left.set(xlim=(-0.5, right_end), ylim=(-bottom, 0.5))
    left.set_axis_off()
    data = io.BytesIO()
    figure.savefig(data, format="png")
    return data.getvalue()


def _sites(source):
    """Where each group stands, y downwards: its cell in the grid; those of another graph stand in
    a square, one after another."""
    place, groups = tiles.cells(source), source.starts.size - 1
    if place is None:
        place = np.stack(np.divmod(np.arange(groups), int(np.ceil(np.sqrt(groups))))[::-1], axis=1)
    return place.astype(float)


def _colours(sites, group, light):
    """RGBA of each variable: the site's place between the corners' colours, the label's place from
    dark to light."""
    low, high = sites.min(axis=0), sites.max(axis=0)
    x, y = ((sites - low) / np.maximum(high - low, 1e-9)).T[:, :, None]
    top, bottom = ((1 - x) * row[0] + x * row[1] for row in CORNERS)
    rgb = ((1 - y) * top + y * bottom)[group]
    rgb += 0.45 * light[:, None] * (1 - rgb)
    return np.append(rgb, np.ones((group.size, 1)), axis=1)
