"""Minor embedding: every variable of a problem becomes a chain of qubits of a chip.

    found = embedding.obtain(Source.of(problem), Chip.named("zephyr:12"))
    found.chains            # {variable: [qubits]}, as Ocean's FixedEmbeddingComposite takes it

An embedding depends on which pairs of variables are coupled and on nothing else: the frames of one
camera share theirs.
"""

import contextlib
import functools
import hashlib
import json
import math
import os
import re
import secrets
import subprocess
import sys
import time
from dataclasses import asdict, dataclass, fields, replace

import networkx as nx
import numpy as np

from ..core import models
from ..core.failure import NO, Error, FileError, SolverError
from ..core.output import save
from ..core.text import parse
from ..samplers.solvers import interruptible
from . import packing, services, tiles

TIMEOUT = 100.0
# Two graphs and options in, pairs of a variable and its qubit out. No module of the user's folder.
# What it finds does not depend on how busy the machine is: it has 20 seconds of a processor.
SUBGRAPH = """
import sys
sys.path = [place for place in sys.path if place]
import json, networkx, resource
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
resource.setrlimit(resource.RLIMIT_CPU, (20, 20))
from minorminer.subgraph import find_subgraph
*graphs, options = json.load(sys.stdin)
def graph(nodes, edges):
    found = networkx.Graph(edges)
    found.add_nodes_from(nodes)
    return found
print(json.dumps(list(find_subgraph(*(graph(*one) for one in graphs), **options).items())))
"""
HEAD = {"schema": 1, "format": "qstereo-embedding"}
SMALLEST, LARGEST = 2, 32
# Processes that search. They end with the command: a signal's handler kills them.
searching = set()


class NoEmbedding(Error):
    """No embedding was found."""

    status = NO


class Hopeless(NoEmbedding):
    """No search can find one: the chip is too small."""


class NotThisOne(Error):
    """A file that holds no embedding, or not one of this problem into this chip."""


def graph_of(nodes, edges):
    """A graph whose nodes and edges stand in order: minorminer's result depends on it."""
    graph = nx.Graph()
    graph.add_nodes_from(sorted(nodes))
    graph.add_edges_from(sorted((min(edge), max(edge)) for edge in edges))
    return graph


def _digest(graph):
    """SHA-256 of the nodes and edges of a graph_of()."""
    return hashlib.sha256(json.dumps([list(graph), list(graph.edges)]).encode()).hexdigest()


@dataclass(frozen=True)
class Source:
    """A problem's graph over its variables, and the first variable of each group, n at the end."""

    graph: nx.Graph
    starts: np.ndarray

    @classmethod
    def of(cls, problem):
        """The graph of a Problem's QUBO, penalties included. Raises OverLimit."""
        _, (rows, columns, _), _ = models.expand(problem)
        return cls(graph_of(range(problem.linear.size), zip(rows.tolist(), columns.tolist())),
                   problem.starts)

    @functools.cached_property
    def digest(self):
        return _digest(self.graph)

    def part(self, variables):
        """The Source of some variables, numbered anew: the same for parts of one shape."""
        graph = nx.relabel_nodes(self.graph.subgraph(variables),
                                 {variable: at for at, variable in enumerate(variables)})
        return Source(graph_of(graph, graph.edges), np.arange(len(variables) + 1))

    def times(self, copies):
        """Copies side by side: variable v of copy c is c * n + v."""
        return Source(nx.disjoint_union_all([self.graph] * copies), None)


@dataclass(frozen=True)
class Chip:
    """A chip's working graph, its qubits as Ocean numbers them. `family` and `size` ("zephyr", 12)
    name the full graph that it is a part of; no family where its tiles are not of usual size."""

    name: str
    family: str
    size: int
    graph: nx.Graph

    @classmethod
    def named(cls, name):
        """pegasus:M and zephyr:M: all qubits work; else the solver of this name at the account.

        Raises ValueError where there can be none of this name, SolverError where the service does
        not give its graph.
        """
        shape = re.fullmatch(r"(pegasus|zephyr):([0-9]+)", name)
        if shape is None and ":" not in name:
            with services.connect("qpu", name) as session:
                return cls.of_solver(session.solver)
        if shape is None or not SMALLEST <= int(shape[2]) <= LARGEST:
            raise ValueError(f"no topology is called {name}; give pegasus:16 or zephyr:12 (sizes "
                             f"{SMALLEST} to {LARGEST}), or the name of a solver of your account")
        import dwave.graphs

        graph = getattr(dwave.graphs, f"{shape[1]}_graph")(int(shape[2]))
        return cls(name, shape[1], int(shape[2]), graph_of(graph, graph.edges))

    @classmethod
    def of_solver(cls, solver):
        """The qubits and couplers that work in one of D-Wave's solvers."""
        topology = solver.properties.get("topology", {})
        family, shape = topology.get("type"), topology.get("shape", [None])
        usual = family == "pegasus" or shape[1:] == [4]
        return cls(solver.name, family if usual else None, shape[0],
                   graph_of(solver.nodes, solver.undirected_edges))

    @functools.cached_property
    def digest(self):
        return _digest(self.graph)


@dataclass(frozen=True)
class Embedding:
    """An embedding and where it comes from; `problem` and `chip` are the digests of the graphs."""

    topology: str
    method: str
    seed: int
    seconds: float
    problem: str
    chip: str
    chains: dict

    def figures(self):
        """What is worth a look: qubits, the longest and the mean chain."""
        lengths = np.array([len(chain) for chain in self.chains.values()])
        return {"qubits": int(lengths.sum()), "longest_chain": int(lengths.max()),
                "mean_chain": round(float(lengths.mean()), 3)}

    def used(self):
        """Its qubits."""
        return [qubit for chain in self.chains.values() for qubit in chain]

    def to_json(self):
        """The file's text. Chains stand in the order of the variables."""
        chains = [self.chains[variable] for variable in range(len(self.chains))]
        return json.dumps({**HEAD, **asdict(self), **self.figures(), "chains": chains}) + "\n"


def faults(source, chip, chains):
    """The variables whose chain or couplings are no embedding, by Ocean's own check: a set."""
    from dwave.embedding import diagnose_embedding, exceptions

    wrong = set()
    for kind, *where in diagnose_embedding(chains, source.graph, chip.graph):
        # An overlap names the qubit first, a wrong qubit stands last.
        wrong.update(where[1:] if kind is exceptions.ChainOverlapError else
                     where[:1] if kind is exceptions.InvalidNodeError else where)
    return wrong


def find(source, chip, seed=None, timeout=TIMEOUT, progress=lambda text: None):
    """An Embedding of a Source into a Chip. Raises NoEmbedding.

    A grid is laid out in the chip's own tiles where it fits (tiles.py), and connected parts side by
    side (packing.py); everything else, and the chains that missing qubits break, are minorminer's
    work. One seed gives one embedding as long as `timeout` does not cut it short.
    """
    began, asked, seed = (time.monotonic(), seed,
                          secrets.randbelow(2**31) if seed is None else seed)
    qubits, couplers = len(chip.graph), chip.graph.number_of_edges()
    variables, pairs = len(source.graph), source.graph.number_of_edges()
    what = f"{variables:,} variables and {pairs:,} couplings"
    if variables > qubits or pairs > couplers:
        raise Hopeless(f"{what} cannot fit on {chip.name} with its {qubits:,} qubits and "
                       f"{couplers:,} couplers")
    method, chains = "tiles", tiles.lay_out(source, chip)
    if broken := faults(source, chip, chains) if chains else ():
        # Many are not the chip's doing: the couplings are others than the tiles have.
        sound = {variable: chain for variable, chain in chains.items() if variable not in broken}
        method, chains = "tiles, mended", 2 * len(broken) <= variables and search(
            source, chip, seed, timeout / 2, progress, fixed_chains=sound)
    if not chains:
        def of_part(search):
            def chains_of(part, where):
                with contextlib.suppress(NoEmbedding):
                    return search(part, where, asked, timeout, progress).chains
            return chains_of
        method, chains = "parts", packing.lay_out(source, chip, of_part(obtain), of_part(find),
                                                  progress)
    if not chains:
        method, chains = "minorminer", search(source, chip, seed,
                                              timeout - (time.monotonic() - began), progress)
        if max(map(len, chains.values()), default=2) > 1 and (
                found := subgraph(source, chip, seed, timeout, progress)):
            method, chains = "subgraph", found
    if not chains:
        raise NoEmbedding(f"no embedding found on {chip.name} within {timeout:g} s ({what}; "
                          f"{qubits:,} qubits)")
    return Embedding(chip.name, method, seed, round(time.monotonic() - began, 3), source.digest,
                     chip.digest, chains)


def search(source, chip, seed, timeout, progress=lambda text: None, **hints):
    """{variable: [qubits]} by minorminer, empty where it finds none. `hints` are further arguments
    of its find_embedding."""
    import minorminer

    return interruptible(lambda: minorminer.find_embedding(
        source.graph, chip.graph, random_seed=seed, timeout=timeout, **hints),
        lambda: progress("minorminer"))


def subgraph(source, chip, seed, timeout, progress=lambda text: None):
    """{variable: [qubit]}, chains of one, by the Glasgow Subgraph Solver; empty where it finds
    none. In a process of its own, as it does not let Ctrl-C through to Python.
    """
    given = json.dumps([*([list(of.graph), list(of.graph.edges)] for of in (source, chip)),
                        {"seed": seed, "timeout": max(1, math.ceil(timeout))}])
    with subprocess.Popen([sys.executable, "-c", SUBGRAPH], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE, start_new_session=True) as child:
        searching.add(child)
        try:
            said, _ = interruptible(lambda: child.communicate(given.encode()),
                                    lambda: progress("chains of one"))
        except BaseException:
            child.kill()
            raise
        finally:
            searching.discard(child)
    return {variable: [qubit] for variable, qubit in json.loads(said or "[]")}


def find_copies(source, chip, copies, first, seed=None, timeout=TIMEOUT,
                progress=lambda text: None):
    """The Embedding of `copies` copies of a Source ("auto": as many as are found), each on qubits
    that those before it leave; `first` is the first copy's. Raises SolverError where fewer are
    found."""
    from minorminer.utils.parallel_embeddings import find_multiple_embeddings

    began, chains = time.monotonic(), [first.chains]

    def another(_, rest):
        left = timeout - (time.monotonic() - began)
        with contextlib.suppress(NoEmbedding):
            chains.append(find(source, replace(chip, graph=rest), seed, left, lambda text: progress(
                f"copy {len(chains) + 1}, {text}")).chains)
            return chains[-1]
        return {}
    free = chip.graph.copy()
    free.remove_nodes_from(first.used())
    find_multiple_embeddings(source.graph, free, embedder=another, use_filter=False,
                             timeout=timeout, one_to_iterable=True,
                             max_num_emb=None if copies == "auto" else copies - 1)
    if copies not in ("auto", len(chains)):
        raise SolverError(f"{len(chains):,} of {copies:,} copies found on {chip.name} within "
                          f"{timeout:g} s; take fewer --copies, or --copies auto for as many as "
                          "are found")
    every = [one[v] for one in chains for v in range(len(source.graph))]
    return replace(first, seconds=round(first.seconds + time.monotonic() - began, 3),
                   problem=source.times(len(chains)).digest, chains=dict(enumerate(every)))


def read(path):
    """The Embedding in a file. Raises OSError, NotThisOne."""
    with open(path, "rb") as stream:
        try:
            found = parse(stream.read())
            told, chains = {name: found[name] for name in HEAD}, found["chains"]
            if told != HEAD:
                raise ValueError(str(told))
            if not all(type(q) is int and 0 <= q < 2**31 for chain in chains for q in chain):
                raise ValueError("a chain holds something else than qubits")
            return Embedding(**{one.name: found[one.name] for one in fields(Embedding)[:-1]},
                             chains=dict(enumerate(chains)))
        except (ValueError, KeyError, TypeError) as error:
            raise NotThisOne(f"no embedding file ({type(error).__name__}: {error}); make one with "
                             "`qstereo-bridge embed`") from None


def check(embedding, source, chip):
    """Raises NotThisOne unless `embedding` embeds this source into this chip as it is today."""
    if len(embedding.chains) != len(source.graph) or embedding.problem != source.digest:
        raise NotThisOne(f"an embedding of another problem graph ({len(embedding.chains):,} "
                         f"variables, this one has {len(source.graph):,}); embed this problem")
    if wrong := faults(source, chip, embedding.chains):
        raise NotThisOne(f"on {chip.name} {len(wrong):,} of its chains or their couplings are "
                         f"broken; it was made for {embedding.topology}: embed the problem on this "
                         "chip again")


def _cache_path(source, chip, copies):
    """Where the embedding of so many copies is kept. The folder may be deleted at any time."""
    base = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return os.path.join(base, "qstereo",
                        f"embedding-{source.digest[:32]}-{chip.digest[:32]}-{copies}.json")


def kept(source, chip, copies=1):
    """The Embedding that the cache has for these two graphs, or None."""
    with contextlib.suppress(OSError, NotThisOne):
        found = read(_cache_path(source, chip, copies))
        count = max(1, len(found.chains) // len(source.graph)) if copies == "auto" else copies
        check(found, source.times(count), chip)
        return found
    return None


def keep(embedding, source, chip, copies=1):
    """Put an Embedding into the cache, unless a shorter one is there. A cache that cannot be
    written is none."""
    before, path = kept(source, chip, copies), _cache_path(source, chip, copies)
    if before is None or len(before.used()) > len(embedding.used()):
        with contextlib.suppress(OSError, FileError):
            os.makedirs(os.path.dirname(path), exist_ok=True)
            save(path, embedding.to_json().encode())


def obtain(source, chip, seed=None, timeout=TIMEOUT, progress=lambda text: None, copies=1):
    """The Embedding of a Source, or of copies of it, into a Chip: the one kept, else a new one,
    which is kept. A `seed` asks for its own. Raises NoEmbedding, SolverError."""
    found = kept(source, chip, copies) if seed is None else None
    if found is None:
        found = (find(source, chip, seed, timeout, progress) if copies == 1 else
                 find_copies(source, chip, copies, obtain(source, chip, seed, timeout, progress),
                             seed, timeout, progress))
        keep(found, source, chip, copies)
    return found
