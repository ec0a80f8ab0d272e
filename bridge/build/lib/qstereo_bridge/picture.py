<<<<<<< HEAD
"""A picture of an embedding: the problem's graph on the left, the chip on the right, each
chain in the colour of its variable."""
=======
"""A picture of an embedding: the problem's graph on the left, the chip on the right, each chain in
the colour of its variable."""
>>>>>>> services

import io

import dwave.graphs
import networkx as nx
import numpy as np

from . import tiles
from .failure import SolverError

<<<<<<< HEAD
# Corners of the picture: top left, top right, bottom left, bottom right. Neighbours look alike.
CORNERS = np.array([[[0.07, 0.40, 0.75], [0.52, 0.18, 0.70]],
                    [[0.02, 0.62, 0.45], [0.95, 0.55, 0.08]]])
INK, UNUSED = "#303030", "#cccccc"
SPRINGS = 500
=======
# Corners of the picture: top left, top right, bottom left, bottom right. Neighbouring sites have
# like colours.
CORNERS = np.array([[[0.07, 0.40, 0.75], [0.52, 0.18, 0.70]],
                    [[0.02, 0.62, 0.45], [0.95, 0.55, 0.08]]])
INK, UNUSED = "#303030", (0.9, 0.9, 0.9, 1.0)
>>>>>>> services


def require():
    """matplotlib's Figure. Raises ImportError where it is not installed."""
    from matplotlib.figure import Figure

    return Figure


def draw(source, chip, embedding):
    """The bytes of a PNG. Raises SolverError for a chip that Ocean has no layout of."""
    import dwave.graphs
    import networkx as nx
    from dwave.graphs.drawing.qubit_layout import draw_embedding

<<<<<<< HEAD
    figure = require()(figsize=(18, 9.6), dpi=150, facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    sites = _sites(source)
    group = np.repeat(np.arange(len(sites)), np.diff(source.starts))
    label = np.arange(group.size) - source.starts[group]
    share = label / np.diff(source.starts)[group]
    colours = _colours(sites, group, share)
    _problem(left, source, sites, group, share, colours)
    _chip(right, source, chip, embedding, colours)
    found, qubits = embedding.figures(), chip.qubits.size
    _finish(left, f"{source.variables:,} variables, {source.rows.size:,} couplings")
    _finish(right, f"{chip.name}: {found['qubits']:,} of {qubits:,} qubits, longest chain "
                   f"{found['longest_chain']}, mean {found['mean_chain']:.2f}")
=======
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
>>>>>>> services
    data = io.BytesIO()
    figure.savefig(data, format="png")
    return data.getvalue()


<<<<<<< HEAD
def _finish(axes, text):
    """Title, and a square view of all there is."""
    axes.margins(0.03)
    axes.set_aspect("equal", "datalim")
    axes.set_title(text, fontsize=15, color=INK, pad=12)
    axes.set_axis_off()


def _sites(source):
    """Where each group stands, y downwards: its cell in the grid; the groups of another graph are
    drawn to their neighbours."""
    place, groups = tiles.cells(source), source.starts.size - 1
    if place is not None:
        return place.astype(float)
    side = int(np.ceil(np.sqrt(groups)))
    if groups > SPRINGS:
        return np.stack(np.divmod(np.arange(groups), side)[::-1], axis=1).astype(float)
    group = np.repeat(np.arange(groups), np.diff(source.starts))
    graph = nx.empty_graph(groups)
    graph.add_edges_from(zip(group[source.rows].tolist(), group[source.columns].tolist()))
    found = nx.spring_layout(graph, seed=1, method="force")
    return np.array([found[g] for g in range(groups)]) * side


def _colours(sites, group, share):
    """RGB of each variable: the site's place between the corners' colours, lighter by label."""
    low, high = sites.min(axis=0), sites.max(axis=0)
    x, y = ((sites - low) / np.maximum(high - low, 1e-9)).T[:, :, None]
    top, bottom = (1 - x) * CORNERS[:, 0, None] + x * CORNERS[:, 1, None]
    light = 0.45 * share[:, None]
    return np.clip(((1 - y) * top + y * bottom)[group] * (1 - light) + light, 0, 1)


def _problem(axes, source, sites, group, share, colours):
    """Each site's variables in a ring, its couplings darker than those between sites."""
    from matplotlib.collections import LineCollection

    ring = 0.3 * (np.diff(source.starts)[group] > 1)
    angle = 2 * np.pi * share
    at = (sites[group] + np.stack([ring * np.sin(angle), -ring * np.cos(angle)], axis=1)) * (1, -1)
    within = group[source.rows] == group[source.columns]
    lines = np.stack([at[source.rows], at[source.columns]], axis=1)
    for these, alpha in ((~within, 0.25), (within, 0.5)):
        axes.add_collection(LineCollection(lines[these], colors=INK, alpha=alpha, linewidths=0.4))
    span = max(np.ptp(sites, axis=0).max() + 1, 1)
    axes.scatter(*at.T, s=min(300, (140 / span) ** 2 / 3), c=colours, zorder=3, linewidths=0)


def _chip(axes, source, chip, embedding, colours):
    """Ocean's layout of the chip: its own drawing has all couplers, under which no chain is seen."""
    from matplotlib.collections import LineCollection

    if chip.family is None:
        raise SolverError(f"{chip.name} is of a shape that cannot be drawn; leave out --picture")
    layout, graph = (getattr(dwave.graphs, f"{chip.family}_{what}") for what in ("layout", "graph"))
    places = layout(graph(chip.size))
    at = np.zeros((int(chip.qubits.max()) + 1, 2))
    at[chip.qubits] = [places[qubit] for qubit in chip.qubits.tolist()]
    owner = np.full(len(at), -1)
    for variable, chain in embedding.chains.items():
        owner[chain] = variable
    ends, n, zoom = owner[chip.couplers], source.variables, min(12 / chip.size, 4)
    chain = (ends[:, 0] == ends[:, 1]) & (ends[:, 0] >= 0)
    coupled = source.rows.astype(np.int64) * n + source.columns
    across = (ends >= 0).all(axis=1) & np.isin(ends.min(axis=1) * n + ends.max(axis=1), coupled)
    taken = owner[chip.qubits] >= 0
    free, used = chip.qubits[~taken], chip.qubits[taken]
    axes.scatter(*at[free].T, s=3 * zoom, c=UNUSED, linewidths=0)
    for these, style in ((across, {"colors": INK, "alpha": 0.2, "linewidths": 0.3 * zoom}),
                         (chain, {"colors": colours[ends[chain, 0]], "linewidths": 1.4 * zoom})):
        axes.add_collection(LineCollection(at[chip.couplers[these]], **style))
    axes.scatter(*at[used].T, s=9 * zoom, c=colours[owner[used]], linewidths=0, zorder=3)
=======
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
>>>>>>> services
