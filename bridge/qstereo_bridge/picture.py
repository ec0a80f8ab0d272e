"""A picture of an embedding: the problem's graph on the left, the chip on the right, each chain in the colour of its variable."""

import io

import numpy as np

from . import tiles
from .solvers import SolverError

# Corners of the picture: top left, top right, bottom left, bottom right. Neighbouring sites have like colours.
CORNERS = np.array([[[0.07, 0.40, 0.75], [0.52, 0.18, 0.70]], [[0.02, 0.62, 0.45], [0.95, 0.55, 0.08]]])
PAPER, INK, UNUSED = "white", "#303030", "#cccccc"
SPRINGS = 500


def require():
    """matplotlib's Figure. Raises ImportError where it is not installed."""
    from matplotlib.figure import Figure

    return Figure


def draw(source, chip, embedding):
    """The bytes of a PNG. Raises SolverError for a chip that Ocean has no layout of."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = require()(figsize=(18, 9.6), dpi=150, facecolor=PAPER, layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    sites = _sites(source)
    group = np.repeat(np.arange(len(sites)), np.diff(source.starts))
    colours = _colours(source, sites, group)
    _problem(left, source, sites, group, colours)
    _chip(right, source, chip, embedding, colours)
    found = embedding.figures()
    _finish(left, f"{source.variables:,} variables, {source.rows.size:,} couplings")
    _finish(right, f"{chip.name}: {found['qubits']:,} of {chip.qubits.size:,} qubits, longest chain {found['longest_chain']}, "
                   f"mean {found['mean_chain']:.2f}")
    data = io.BytesIO()
    figure.savefig(data, format="png")
    return data.getvalue()


def _finish(axes, text):
    """Title, and a square view of all there is."""
    low, high = axes.dataLim.get_points()
    middle, reach = (low + high) / 2, 0.5 * max(high - low) * 1.04 + 0.05
    axes.set(xlim=(middle[0] - reach, middle[0] + reach), ylim=(middle[1] - reach, middle[1] + reach), box_aspect=1)
    axes.set_title(text, fontsize=15, color=INK, pad=12)
    axes.set_axis_off()


def _sites(source):
    """Where each group stands, y downwards: its cell in the grid; the groups of another graph are drawn to their neighbours."""
    import networkx as nx

    place, groups = tiles.cells(source), source.starts.size - 1
    if place is not None:
        return place.astype(float)
    side = int(np.ceil(np.sqrt(groups)))
    if groups > SPRINGS:
        return np.stack(np.divmod(np.arange(groups), side)[::-1], axis=1).astype(float)
    group = np.repeat(np.arange(groups), np.diff(source.starts))
    graph = nx.Graph()
    graph.add_nodes_from(range(groups))
    graph.add_edges_from(zip(group[source.rows].tolist(), group[source.columns].tolist()))
    found = nx.spring_layout(graph, seed=1, method="force")
    return np.array([found[g] for g in range(groups)]) * side


def _colours(source, sites, group):
    """RGB of each variable: the site's place between the corners' colours, the label's place from dark to light."""
    low, high = sites.min(axis=0), sites.max(axis=0)
    x, y = ((sites - low) / np.maximum(high - low, 1e-9)).T[:, :, None]
    rgb = ((1 - y) * ((1 - x) * CORNERS[0, 0] + x * CORNERS[0, 1]) + y * ((1 - x) * CORNERS[1, 0] + x * CORNERS[1, 1]))[group]
    label = (np.arange(group.size) - source.starts[group]) / np.maximum(np.diff(source.starts)[group] - 1, 1)
    light = 0.45 * label[:, None]
    return np.clip(rgb * (1 - light) + light, 0, 1)


def _problem(axes, source, sites, group, colours):
    from matplotlib.collections import LineCollection

    angle = 2 * np.pi * (np.arange(group.size) - source.starts[group]) / np.diff(source.starts)[group]
    ring = 0.3 * (np.diff(source.starts)[group] > 1)
    at = (sites[group] + np.stack([ring * np.sin(angle), -ring * np.cos(angle)], axis=1)) * (1, -1)
    within = group[source.rows] == group[source.columns]
    lines = np.stack([at[source.rows], at[source.columns]], axis=1)
    axes.add_collection(LineCollection(lines[~within], colors=INK, alpha=0.25, linewidths=0.4))
    axes.add_collection(LineCollection(lines[within], colors=INK, alpha=0.5, linewidths=0.4))
    span = max(np.ptp(sites, axis=0).max() + 1, 1)
    axes.scatter(*at.T, s=min(300, (140 / span) ** 2 / 3), c=colours, zorder=3, linewidths=0)


def _chip(axes, source, chip, embedding, colours):
    import dwave.graphs
    from matplotlib.collections import LineCollection

    if chip.family is None:
        raise SolverError(f"{chip.name} is of a shape that cannot be drawn; embed without --picture")
    layout, graph = (getattr(dwave.graphs, f"{chip.family}_{what}") for what in ("layout", "graph"))
    places = layout(graph(chip.size))
    at = np.zeros((int(chip.qubits.max()) + 1, 2))
    at[chip.qubits] = [places[qubit] for qubit in chip.qubits.tolist()]
    owner = np.full(len(at), -1)
    for variable, chain in embedding.chains.items():
        owner[chain] = variable
    ends = owner[chip.couplers]
    used = (ends >= 0).all(axis=1)
    chain = used & (ends[:, 0] == ends[:, 1])
    n = source.variables
    across = used & ~chain & np.isin(ends.min(axis=1) * n + ends.max(axis=1), source.rows.astype(np.int64) * n + source.columns)
    free = chip.qubits[owner[chip.qubits] < 0]
    zoom = min(12 / chip.size, 4)
    axes.scatter(*at[free].T, s=3 * zoom, c=UNUSED, linewidths=0)
    axes.add_collection(LineCollection(at[chip.couplers[across]], colors=INK, alpha=0.2, linewidths=0.3 * zoom))
    axes.add_collection(LineCollection(at[chip.couplers[chain]], colors=colours[ends[chain, 0]], linewidths=1.4 * zoom, zorder=2))
    taken = chip.qubits[owner[chip.qubits] >= 0]
    axes.scatter(*at[taken].T, s=9 * zoom, c=colours[owner[taken]], linewidths=0, zorder=3)
