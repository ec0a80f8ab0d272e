"""Minor embeddings: layouts in tiles and minorminer's, the file, the cache, the command, the
picture."""

import json
import shutil
import signal
import subprocess
import sys

import dwave.embedding
import dwave.graphs
import networkx as nx
import numpy as np
import pytest
from problems import Toeplitz, grid, make, nothing, pack_qcf, random_problem
from service import TOKEN
from qstereo_bridge.desk import embed
from qstereo_bridge.ocean import embedding, tiles
from qstereo_bridge.core import models, qcf
from qstereo_bridge.samplers import solvers

GRAPH = {"zephyr": dwave.graphs.zephyr_graph, "pegasus": dwave.graphs.pegasus_graph}


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """The user's cache, empty and of this test alone."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "qstereo"


def source_of(graph, group=1):
    """A Source of a networkx graph over 0 .. n - 1, in groups of equal size."""
    return embedding.Source(embedding.graph_of(graph, graph.edges),
                            np.arange(0, len(graph) + 1, group))



def chip_of(graph):
    told = graph.graph
    usual = told["tile"] == {"pegasus": 12}.get(told["family"], 4)
    return embedding.Chip("chip", told["family"] if usual else None, told["rows"],
                          embedding.graph_of(graph, graph.edges))


def full(name):
    family, size = name.split(":")
    return GRAPH[family](int(size))


def without(graph, share, seed):
    """The graph less a share of its nodes, and as large a share of its edges."""
    rng = np.random.default_rng(seed)
    graph.remove_nodes_from(rng.choice(sorted(graph), int(share * len(graph)),
                                       replace=False).tolist())
    graph.remove_edges_from([edge for edge in sorted(graph.edges) if rng.random() < share / 10])
    return graph


def masked(width, height, labels, dropped):
    """The sparse graph of a grid with some cells left out, its sites in raster order."""
    cells = [(x, y) for y in range(height) for x in range(width) if (x, y) not in dropped]
    site, graph = {cell: p for p, cell in enumerate(cells)}, nx.Graph()
    for (x, y), p in site.items():
        members = range(p * labels, (p + 1) * labels)
        graph.add_edges_from((i, j) for i in members for j in members if i < j)
        for cell in ((x + 1, y), (x, y + 1)):
            if cell in site:
                graph.add_edges_from((p * labels + d, site[cell] * labels + d)
                                     for d in range(labels))
    return graph


@pytest.mark.parametrize("name, width, height, labels", [("zephyr:2", 2, 2, 8),
                                                         ("zephyr:3", 1, 3, 7),
                                                         ("zephyr:4", 4, 2, 3),
                                                         ("zephyr:4", 2, 2, 16),
                                                         ("zephyr:6", 2, 2, 20),
                                                         ("zephyr:12", 12, 12, 8),
                                                         ("zephyr:12", 10, 10, 8),
                                                         ("zephyr:12", 6, 6, 16),
                                                         ("pegasus:3", 2, 2, 8),
                                                         ("pegasus:4", 3, 1, 5),
                                                         ("pegasus:5", 2, 2, 13),
                                                         ("pegasus:7", 2, 1, 24),
                                                         ("pegasus:16", 15, 15, 8),
                                                         ("pegasus:16", 10, 10, 8),
                                                         ("pegasus:16", 7, 7, 16)])
def test_a_grid_is_laid_out_in_tiles(name, width, height, labels):
    problem = grid(width, height, labels)
    found = embedding.find(embedding.Source.of(problem), embedding.Chip.named(name), seed=1,
                           timeout=10)
    dwave.embedding.verify_embedding(found.chains, nx.Graph(
        models.to_bqm(problem).quadratic.keys()), full(name))
    length = 2 * -(-labels // 8)
    assert found.method == "tiles" and {len(chain) for chain in found.chains.values()} == {length}
    assert (found.figures() == {"qubits": length * width * height * labels, "longest_chain": length,
                                "mean_chain": length})


@pytest.mark.parametrize("name, width, height, labels", [("zephyr:3", 4, 1, 8),
                                                         ("zephyr:3", 1, 4, 8),
                                                         ("zephyr:3", 2, 1, 16),
                                                         ("pegasus:3", 3, 1, 8),
                                                         ("pegasus:3", 1, 1, 17)])
def test_a_grid_larger_than_the_chip_has_no_layout(name, width, height, labels):
    assert (tiles.lay_out(embedding.Source.of(grid(width, height, labels)),
                          embedding.Chip.named(name)) is None)


@pytest.mark.parametrize("dropped", [{(1, 1)}, {(0, 0)}, {(2, 0), (1, 2)}, {(0, 0), (1, 0)}])
def test_a_window_with_a_mask_is_laid_out(dropped):
    graph = masked(4, 3, 5, dropped)
    found = embedding.find(source_of(graph, 5), chip_of(full("zephyr:4")), seed=1, timeout=10)
    dwave.embedding.verify_embedding(found.chains, graph, full("zephyr:4"))
    assert found.method == "tiles"


def test_cells_are_those_of_the_grid_or_none():
    at = tiles.cells(embedding.Source.of(grid(4, 3, 2)))
    assert at.tolist() == [[x, y] for y in range(3) for x in range(4)]
    assert (tiles.cells(source_of(nx.cycle_graph(5))) is None
            and tiles.cells(source_of(nx.star_graph(5))) is None)
    assert (tiles.cells(source_of(nx.Graph([(0, 1), (2, 3)]))) is None
            and tiles.cells(source_of(nx.complete_graph(4), 4)).tolist() == [[0, 0]])


@pytest.mark.parametrize("name, share", [("zephyr:6", 0.05), ("pegasus:8", 0.02)])
def test_what_missing_qubits_break_is_mended(name, share):
    """As many qubits missing as on chips that are sold, and some couplers: most sites keep their
    tile."""
    problem, graph = grid(5, 5, 8), without(full(name), share, 3)
    found = embedding.find(embedding.Source.of(problem), chip_of(graph), seed=1, timeout=60)
    dwave.embedding.verify_embedding(found.chains, nx.Graph(
        models.to_bqm(problem).quadratic.keys()), graph)
    assert found.method == "tiles, mended" and found.figures()["mean_chain"] < 2.5
    assert sum(len(chain) == 2 for chain in found.chains.values()) > 120


def test_a_layout_looks_for_the_place_where_qubits_work():
    graph = full("zephyr:4")
    graph.remove_nodes_from([qubit for qubit in list(graph)
                             if dwave.graphs.zephyr_coordinates(4).linear_to_zephyr(qubit)[1] < 3])
    found = embedding.find(embedding.Source.of(grid(2, 2, 8)), chip_of(graph), seed=1, timeout=10)
    assert found.method == "tiles"


@pytest.mark.parametrize("name, share, size, copies, chains", [("zephyr:6", 0, (3, 2, 8), 6, {2}),
    ("pegasus:5", 0, (2, 2, 5), 4, {2}), ("zephyr:8", 0, (2, 2, 10), 4, {4}),
    ("zephyr:6", 0.05, (3, 2, 8), 4, None), ("zephyr:3", 0, (3, 3, 2), 9, None)])
def test_copies_have_qubits_of_their_own(name, share, size, copies, chains):
    """Of a layout in tiles they are the same layout in other tiles, as long as there are any."""
    problem, graph = grid(*size), without(full(name), share, 3)
    source, chip = embedding.Source.of(problem), chip_of(graph)
    first = embedding.find(source, chip, seed=1, timeout=60)
    found = embedding.find_copies(source, chip, copies, first, seed=1, timeout=60)
    n, pairs = len(source.graph), models.to_bqm(problem).quadratic.keys()
    dwave.embedding.verify_embedding(found.chains, nx.Graph((c * n + i, c * n + j)
                                                            for c in range(copies) for i,
                                                            j in pairs), graph)
    assert len(found.chains) == copies * n and first.chains.items() <= found.chains.items()
    assert chains is None or {len(chain) for chain in found.chains.values()} == chains
    embedding.check(found, source.times(copies), chip)


def test_other_graphs_are_minorminers():
    for problem in (grid(2, 2, 4, dense=True), grid(3, 3, 2), grid(1, 1, 5), random_problem(3),
                    make([3, 2], [], [], [0] * 5, [(0, 0)] * 2)):
        source = embedding.Source.of(problem)
        found = embedding.find(source, embedding.Chip.named("zephyr:3"), seed=1, timeout=30)
        graph = nx.Graph(models.to_bqm(problem).quadratic.keys())
        graph.add_nodes_from(range(len(source.graph)))
        dwave.embedding.verify_embedding(found.chains, graph, full("zephyr:3"))
        again = embedding.find(source, embedding.Chip.named("zephyr:3"), seed=1, timeout=30)
        parts = nx.number_connected_components(source.graph)
        assert found.method == ("minorminer" if parts == 1 else "parts")
        assert again.chains == found.chains


def test_chains_of_one_where_there_are_some():
    """minorminer alone gives this grid chains of two."""
    source, chip = source_of(nx.convert_node_labels_to_integers(
        nx.grid_2d_graph(9, 9))), embedding.Chip.named("zephyr:4")
    searched = embedding.search(source, chip, 1, 30)
    assert max(map(len, searched.values())) > 1
    found, again = (embedding.find(source, chip, seed=1) for _ in range(2))
    assert found.method == "subgraph" and found.figures()["longest_chain"] == 1
    assert not embedding.faults(source, chip, found.chains) and again.chains == found.chains
    # A clique of six is in no Zephyr without chains; what minorminer finds stays.
    assert embedding.find(source_of(nx.complete_graph(6)), chip, seed=1).method == "minorminer"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_leaves_no_search_behind(number):
    """The child holds the pipe open that the command was given: its end is that of both."""
    code = ("import os, signal, subprocess, sys\n"
            "from qstereo_bridge import __main__\n"
            "from qstereo_bridge.ocean import embedding\n"
            "child = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(1000)'])\n"
            "embedding.searching.add(child)\n"
            f"__main__._stop({int(number)}, None)\n")
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, timeout=600)
    assert ended.returncode == 128 + number and ended.stderr == b"qstereo-bridge: interrupted\n"


def test_ctrl_c_ends_the_search_for_chains_of_one(monkeypatch):
    children = []

    class Popen(subprocess.Popen):
        def __init__(self, words, **options):
            children.append(self)
            super().__init__([*words[:2], "import time; time.sleep(1000)"], **options)

    def progress(text):
        raise KeyboardInterrupt
    monkeypatch.setattr(subprocess, "Popen", Popen)
    with pytest.raises(KeyboardInterrupt):
        embedding.subgraph(source_of(nx.path_graph(3)), embedding.Chip.named("zephyr:2"), 1, 1,
                           progress)
    assert [child.returncode for child in children] == [-signal.SIGKILL]


def test_a_chip_of_unusual_tiles():
    """No layout in tiles, which number the qubits in another way."""
    graph = dwave.graphs.zephyr_graph(3, 2)
    source, chip = embedding.Source.of(grid(2, 1, 3)), chip_of(graph)
    found = embedding.find(source, chip, seed=1, timeout=30)
    dwave.embedding.verify_embedding(found.chains, source.graph, graph)
    assert found.method == "minorminer"
    with pytest.raises(solvers.SolverError, match="cannot be drawn"):
        embed.draw(source, chip, found)


def test_no_embedding():
    with pytest.raises(embedding.NoEmbedding, match="cannot fit on zephyr:2"):
        embedding.find(embedding.Source.of(grid(9, 9, 8)), embedding.Chip.named("zephyr:2"))
    with pytest.raises(embedding.NoEmbedding, match="no embedding found on pegasus:2 within 0.5 s"):
        embedding.find(source_of(nx.complete_graph(16)), embedding.Chip.named("pegasus:2"), seed=1,
                       timeout=0.5)


@pytest.mark.parametrize("change, wrong", [({}, set()), ({1: []}, {1}), ({1: [100_000]}, {1}),
                                           ({0: [1, 5]}, {0}), ({2: [0, 4]}, {0, 2}),
                                           ({2: [4, 6]}, {2, 3}), ({1: [7]}, {0, 1, 2}),
                                           ({3: [7]}, set())])
def test_faults_name_the_variables(change, wrong):
    """A path of three variables, and one by itself, on a path of seven qubits."""
    source = embedding.Source(embedding.graph_of(range(4), [(0, 1), (1, 2)]), np.arange(5))
    chip = embedding.Chip("path", None, None, nx.path_graph(8))
    chains = {0: [0, 1], 1: [2, 3], 2: [4], 3: [6]}
    assert embedding.faults(source, chip, chains) == set()
    assert embedding.faults(source, chip, {**chains, **change}) == wrong


def test_file(tmp_path):
    source, chip = embedding.Source.of(grid(2, 2, 3)), embedding.Chip.named("zephyr:3")
    found = embedding.find(source, chip, seed=4)
    path = tmp_path / "e.json"
    path.write_text(found.to_json())
    read = embedding.read(path)
    assert read == found
    embedding.check(read, source, chip)
    told = json.loads(path.read_text())
    assert (told["seed"] == 4 and told["qubits"] == 24 and told["problem"] == source.digest
            and told["chip"] == chip.digest)


@pytest.mark.parametrize("change", [lambda told: "[]", lambda told: "", lambda told: "{}",
                                    lambda told: "[" * 5000, lambda told: "\xff\xfe",
                                    lambda told: json.dumps({**told, "format": "x"}),
                                    lambda told: json.dumps({**told, "schema": 2}),
                                    lambda told: json.dumps({**told, "chains": None}),
                                    lambda told: json.dumps({**told, "chains": [[0.5]]}),
                                    lambda told: json.dumps({**told, "chains": [["1"]]}),
                                    lambda told: json.dumps({**told, "chains": [[-1]]}),
                                    lambda told: json.dumps({**told, "chains": [7]}),
                                    lambda told: json.dumps({key: told[key] for key in told
                                                             if key != "problem"})])
def test_no_embedding_file(change, tmp_path):
    found = embedding.find(embedding.Source.of(grid(2, 1, 3)), embedding.Chip.named("zephyr:3"),
                           seed=4)
    (tmp_path / "e.json").write_bytes(change(json.loads(found.to_json())).encode("latin-1"))
    with pytest.raises(embedding.NotThisOne, match="no embedding file"):
        embedding.read(tmp_path / "e.json")


def test_an_embedding_of_something_else_is_refused():
    source, chip = embedding.Source.of(grid(2, 2, 3)), embedding.Chip.named("zephyr:3")
    found = embedding.find(source, chip, seed=4)
    for other in (grid(2, 2, 4), grid(4, 1, 3), grid(2, 2, 3, dense=True)):
        with pytest.raises(embedding.NotThisOne, match="another problem graph"):
            embedding.check(found, embedding.Source.of(other), chip)
    with pytest.raises(embedding.NotThisOne,
                       match="made for zephyr:3: embed the problem on this chip again"):
        embedding.check(found, source, embedding.Chip.named("pegasus:3"))
    lost = full("zephyr:3")
    lost.remove_node(found.chains[5][1])
    with pytest.raises(embedding.NotThisOne, match="1 of its chains"):
        embedding.check(found, source, chip_of(lost))
    unused = full("zephyr:3")
    unused.remove_nodes_from(sorted(set(unused) - {qubit for chain in found.chains.values()
                                                   for qubit in chain}))
    embedding.check(found, source, chip_of(unused))


def test_digests_are_of_the_graphs_alone():
    frames = [embedding.Source.of(grid(3, 2, 4, seed=seed)).digest for seed in (1, 2)]
    assert frames[0] == frames[1] != embedding.Source.of(grid(2, 3, 4)).digest
    assert (len({source_of(graph).digest for graph in (nx.path_graph(4), nx.star_graph(3),
                                                       nx.path_graph(3), nx.cycle_graph(4))}) == 4)
    whole, less = full("zephyr:2"), full("zephyr:2")
    less.remove_edge(*next(iter(less.edges)))
    assert chip_of(whole).digest == embedding.Chip.named("zephyr:2").digest != chip_of(less).digest


def test_cache(cache, monkeypatch):
    source, chip = embedding.Source.of(grid(2, 2, 3, dense=True)), embedding.Chip.named("zephyr:3")
    found = embedding.obtain(source, chip, seed=1)
    monkeypatch.setattr(embedding, "search", None)
    assert embedding.obtain(source, chip) == found and len(list(cache.iterdir())) == 1
    longer = embedding.Embedding(**{**vars(found), "chains": {**found.chains, 0: [0] * 50}})
    embedding.keep(longer, source, chip)
    assert embedding.kept(source, chip) == found
    assert embedding.kept(source, embedding.Chip.named("zephyr:4")) is None
    file, = cache.iterdir()
    file.write_text(longer.to_json())
    assert embedding.kept(source, chip) is None
    embedding.keep(found, source, chip)
    assert embedding.kept(source, chip) == found and len(list(cache.iterdir())) == 1


def test_a_seed_passes_the_cache_by(cache, monkeypatch):
    """What it finds is kept all the same, where it is no longer than what is there."""
    source, chip = embedding.Source.of(grid(2, 2, 3, dense=True)), embedding.Chip.named("zephyr:3")
    kept = embedding.obtain(source, chip)
    seeds, search = [], embedding.search
    monkeypatch.setattr(embedding, "search", lambda *given, **hints: seeds.append(given[2])
                        or search(*given, **hints))
    found = [embedding.obtain(source, chip, seed=seed) for seed in range(51, 53)]
    assert seeds == [one.seed for one in found] == list(range(51, 53))
    least = min(one.figures()["qubits"] for one in [kept, *found])
    assert embedding.obtain(source, chip).figures()["qubits"] == least and len(seeds) == 2
    assert embedding.obtain(source, chip, seed=51).chains == found[0].chains
    shutil.rmtree(cache)
    assert embedding.obtain(source, chip, seed=52, copies=2).chains.items() >= (
        found[1].chains.items())


def test_no_two_writers_of_the_cache_share_a_file(cache, monkeypatch):
    source, chip = embedding.Source.of(grid(2, 1, 3)), embedding.Chip.named("zephyr:3")
    found, names, replace = embedding.find(source, chip), [], embedding.os.replace
    monkeypatch.setattr(embedding.os, "replace", lambda old, new: names.append(old)
                        or replace(old, new))
    for _ in range(2):
        embedding.keep(found, source, chip)
        shutil.rmtree(cache)
    assert len(set(names)) == 2


def test_a_cache_that_cannot_be_written_is_none(cache, tmp_path):
    source, chip = embedding.Source.of(grid(2, 1, 3)), embedding.Chip.named("zephyr:3")
    (tmp_path / "cache").write_text("a file, no folder")
    assert (embedding.obtain(source, chip, seed=1).method == "tiles" and embedding.kept(source,
        chip) is None)
    (tmp_path / "cache").unlink()
    target = cache / f"embedding-{source.digest[:32]}-{chip.digest[:32]}-1.json"
    target.mkdir(parents=True)
    embedding.obtain(source, chip, seed=1)
    assert list(cache.iterdir()) == [target]


def test_nothing_to_embed(tmp_path, main, cache):
    (tmp_path / "p.qcf").write_bytes(pack_qcf(nothing(3)))
    status, _, err = main("embed", tmp_path / "p.qcf", "--topology", "zephyr:3", "-o",
                          tmp_path / "e.json")
    assert status == 1 and "nothing is left to decide" in err and not (tmp_path / "e.json").exists()


def test_command(problem_file, tmp_path, main, cache):
    path = tmp_path / "e.json"
    status, out, err = main("embed", problem_file, "--topology", "zephyr:3", "-o", path)
    assert (status, err) == (0, "") and f"{path}: written" in out
    assert "zephyr:3: 12 variables, 24 couplers on 24 qubits, 7.1% of the chip; " in out
    assert "; longest chain 2, mean 2.00; tiles" in out
    found = embedding.read(path)
    dwave.embedding.verify_embedding(found.chains, nx.Graph(
        models.to_bqm(qcf.parse_qcf(problem_file.read_bytes())).quadratic.keys()), full("zephyr:3"))
    assert len(list(cache.iterdir())) == 1
    status, out, _ = main("embed", problem_file, "--topology", "pegasus:3", "-o", path, "--seed", 7,
                          "--json")
    told = json.loads(out)
    assert status == 0 and told.pop("seconds") >= 0
    assert (told == {"schema": 1, "topology": "pegasus:3", "method": "tiles", "seed": 7,
                     "variables": 12, "couplers": 24, "qubits": 24, "longest_chain": 2,
                     "mean_chain": 2, "chip_qubits": 128, "share": 0.1875})
    assert (main("embed", problem_file, "--topology", "zephyr:3", "-o", path, "--quiet") == (0, "",
        ""))


def test_command_says_no(tmp_path, main):
    (tmp_path / "p.qcf").write_bytes(pack_qcf(grid(5, 5, 8, dense=True)))
    status, out, err = main("embed", tmp_path / "p.qcf", "--topology", "zephyr:2", "-o",
                            tmp_path / "e.json", "--timeout", 1)
    assert ((status, out) == (1, "") and "cannot fit on zephyr:2" in err and "qstereo reduce" in err
            and err.count("\n") == 1)
    (tmp_path / "p.qcf").write_bytes(pack_qcf(grid(2, 2, 4, dense=True)))
    status, out, err = main("embed", tmp_path / "p.qcf", "--topology", "pegasus:2", "-o",
                            tmp_path / "e.json", "--timeout", 0.3)
    assert ((status, out) == (1, "") and "no embedding found on pegasus:2 within 0.3 s" in err
            and "one-hot-sparse or domain-wall" in err)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["p.qcf"]


@pytest.mark.parametrize("encoding, said", [(1, "(--encoding one-hot-sparse or domain-wall)"),
                                            (2, None), (3, "(--encoding one-hot-sparse)"),
                                            (5, "(--encoding one-hot-sparse or domain-wall)")])
def test_advice_names_no_encoding_that_the_problem_has(encoding, said, tmp_path, main):
    labl = encoding.to_bytes(4, "little") + bytes(12) + (1).to_bytes(4, "little") + bytes(44)
    problem = grid(5, 5, 8, dense=True)
    (tmp_path / "p.qcf").write_bytes(pack_qcf(problem, sides=[("labl", labl)]))
    status, _, err = main("embed", tmp_path / "p.qcf", "--topology", "zephyr:2", "-o",
                          tmp_path / "e.json")
    assert status == 1 and ("--encoding" in err) == bool(said) and (said or "qstereo reduce") in err
    assert "--roi" in err and "--seed" not in err and "--timeout" not in err


def test_advice_for_a_graph_in_parts(tmp_path, main):
    """Two graphs that share no coupling, each too large."""
    whole = make([20, 20], [Toeplitz((20, 20), 1, 0, np.empty(0, "<i4"))],
                 [{"weight": 1, "g": 0, "h": 0}, {"weight": 1, "g": 1, "h": 1}], [0] * 40,
                 [(0, 0)] * 2)
    (tmp_path / "p.qcf").write_bytes(pack_qcf(whole))
    status, _, err = main("embed", tmp_path / "p.qcf", "--topology", "pegasus:2", "-o",
                          tmp_path / "e.json")
    assert status == 1 and "solve its 2 parts" in err and "--timeout" not in err


@pytest.mark.parametrize("arguments, status, said", [(["-o", "E"], 2, "--topology"),
                                                     (["--topology", "zephyr:3"], 2, "-o"),
                                                     (["--topology", "zephyr:0", "-o", "E"], 2,
                                                      "zephyr:12"),
                                                     (["--topology", "chimera:4", "-o", "E"], 2,
                                                      "no topology is called chimera:4"),
                                                     (["--topology", "zephyr:3", "-o", "P"], 2,
                                                      "different names"),
                                                     (["--topology", "zephyr:3", "-o", "-",
                                                       "--json"], 2, "stdout"),
                                                     (["--topology", "zephyr:3", "-o", "E",
                                                       "--picture", "-"], 2, "stdout"),
                                                     (["--topology", "zephyr:3", "-o", "E",
                                                       "--picture", "E"], 2, "different names"),
                                                     (["--topology", "zephyr:3", "-o", "no/E"], 4,
                                                      "no folder"),
                                                     (["--topology", "zephyr:3", "-o", "E",
                                                       "--picture", "no/p.png"], 4, "no folder"),
                                                     (["--topology", "zephyr:3", "-o", "E",
                                                       "--timeout", "0"], 2, "not between")])
def test_usage(arguments, status, said, problem_file, main, monkeypatch):
    monkeypatch.chdir(problem_file.parent)
    problem_file.rename("P")
    found, out, err = main("embed", "P", *arguments)
    assert ((found, out) == (status, "") and said in err and err.startswith("qstereo-bridge")
            and err.count("\n") == 1)
    # matplotlib keeps a list of fonts in the same cache.
    assert [path.name for path in problem_file.parent.iterdir() if path.name != "cache"] == ["P"]


def test_a_solver_of_the_account(problem_file, tmp_path, main, service):
    """Its working graph, a qubit short."""
    properties = service.solvers["Advantage2_mock"]["properties"]
    properties.update(qubits=properties["qubits"][1:], couplers=[pair
        for pair in properties["couplers"] if 0 not in pair])
    status, out, _ = main("embed", problem_file, "--topology", "Advantage2_mock", "-o",
                          tmp_path / "e.json", "--json")
    assert (status == 0 and json.loads(out).items() >= {"topology": "Advantage2_mock",
                                                        "chip_qubits": 335}.items())
    status, out, err = main("embed", problem_file, "--topology", "Advantage3", "-o",
                            tmp_path / "f.json")
    assert ((status, out) == (5, "") and "reaches no such solver" in err
            and not (tmp_path / "f.json").exists())


def test_a_service_that_refuses(problem_file, tmp_path, main, service):
    service.fail("GET", "solvers", 401, times=9)
    status, out, err = main("embed", problem_file, "--topology", "Advantage2_mock", "-o",
                            tmp_path / "e.json")
    assert ((status, out) == (5, "") and "does not accept the token" in err and TOKEN not in err
            and not (tmp_path / "e.json").exists())


@pytest.mark.parametrize("problem", [grid(3, 2, 4), grid(1, 1, 2), random_problem(5)])
def test_picture(problem, tmp_path, main):
    """A PNG with more colours in it than the paper and the grey of the rest."""
    image = pytest.importorskip("PIL.Image")
    (tmp_path / "p.qcf").write_bytes(pack_qcf(problem))
    status, out, err = main("embed", tmp_path / "p.qcf", "--topology", "zephyr:3", "-o",
                            tmp_path / "e.json", "--picture", tmp_path / "e.png")
    assert (status, err) == (0, "") and f"{tmp_path / 'e.png'}: written" in out
    with image.open(tmp_path / "e.png") as drawn:
        half = np.array(drawn.convert("RGB")).astype(int)
    assert (np.ptp(half, axis=2) > 60).sum() > 200


def test_picture_without_matplotlib(problem_file, tmp_path, main, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    status, out, err = main("embed", problem_file, "--topology", "zephyr:3", "-o",
                            tmp_path / "e.json", "--picture", tmp_path / "e.png")
    assert ((status, out) == (5, "") and "./bridge[picture]" in err
            and not (tmp_path / "e.json").exists())
