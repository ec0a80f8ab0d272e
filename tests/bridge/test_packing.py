"""Parts of a problem side by side on a chip, each shape of part embedded once."""

import dwave.embedding
import dwave.graphs
import networkx as nx
import numpy as np
import pytest
from qstereo_bridge.ocean import embedding, packing


def source_of(*parts):
    graph = nx.disjoint_union_all(parts)
    return embedding.Source(graph, np.arange(len(graph) + 1))


def broken_chip(name, seed):
    """A chip some of whose qubits and couplers do not work."""
    chip, rng = embedding.Chip.named(name), np.random.default_rng(seed)
    graph = chip.graph.copy()
    graph.remove_nodes_from(rng.choice(list(graph), len(graph) // 20, replace=False).tolist())
    edges = list(graph.edges)
    graph.remove_edges_from(edges[at] for at in rng.choice(len(edges), len(edges) // 20))
    return embedding.Chip(name, chip.family, chip.size, graph)


@pytest.mark.parametrize("name", ["zephyr:4", "pegasus:5"])
def test_parts_lie_side_by_side(name):
    source = source_of(nx.grid_2d_graph(4, 4), *[nx.cycle_graph(5)] * 9, *[nx.path_graph(3)] * 9,
                       *[nx.empty_graph(1)] * 9)
    chip = broken_chip(name, 1)
    found = embedding.find(source, chip, seed=1)
    assert found.method == "parts"
    dwave.embedding.verify_embedding(found.chains, source.graph, chip.graph)


def test_each_shape_is_looked_for_once():
    source, asked = source_of(*[nx.cycle_graph(5)] * 4, *[nx.path_graph(3)] * 4), []

    def obtain(part, where):
        asked.append((len(part.graph), where.name))
        return embedding.find(part, where, seed=1).chains
    chip = embedding.Chip.named("zephyr:6")
    chains = packing.lay_out(source, chip, obtain, None)
    dwave.embedding.verify_embedding(chains, source.graph, chip.graph)
    assert asked == [(5, "zephyr:2"), (3, "zephyr:2")]


def test_where_the_tiles_are_taken_what_is_left_is_searched():
    source, found = source_of(*[nx.complete_graph(6)] * 60), []

    def find(part, rest):
        found.append(len(rest.graph))
        return None
    obtain = lambda part, where: embedding.find(part, where, seed=1).chains  # noqa: E731
    assert packing.lay_out(source, embedding.Chip.named("zephyr:3"), obtain, find) is None
    assert len(found) == 1 and found[0] < 336
    assert packing.lay_out(source_of(nx.path_graph(3)), embedding.Chip.named("zephyr:3"), obtain,
                           find) is None
