"""Minor embedding: every variable of a problem becomes a chain of qubits of a chip.

    source = embedding.Source.of(problem)
    chip = embedding.Chip.named("zephyr:12")
    found = embedding.obtain(source, chip)        # from the cache, else find() and into the cache
    found.chains            # {variable: [qubits]}, as Ocean's FixedEmbeddingComposite takes it

An embedding depends on which pairs of variables are coupled and on nothing else: the frames of one
camera share theirs.
"""

import contextlib
import functools
import hashlib
import json
import os
import re
import secrets
import threading
import time
from dataclasses import asdict, dataclass, fields, replace

import networkx as nx
import numpy as np

from . import models, services, tiles
from .failure import NO, Error, SolverError
from .output import temporary
from .qcf import DEFAULT_LIMIT
from .solvers import interruptible

TIMEOUT = 100.0
HEAD = {"schema": 1, "format": "qstereo-embedding"}
SMALLEST, LARGEST = 2, 32


class NoEmbedding(Error):
    """No embedding was found."""

    status = NO


class Hopeless(NoEmbedding):
    """No search can find one: the chip is too small."""


class NotThisOne(Error):
    """A file that holds no embedding, or not one of this problem into this chip."""


def _digest(*arrays):
    """SHA-256 of arrays of 32-bit integers, each after its length."""
    found = hashlib.sha256()
    for array in arrays:
        found.update(np.array(array.size, "<i8").tobytes() + array.astype("<i4").tobytes())
    return found.hexdigest()


def _graph(nodes, edges):
    """A graph whose nodes and edges stand in order: minorminer's result depends on it."""
    graph = nx.Graph()
    graph.add_nodes_from(sorted(nodes))
    graph.add_edges_from(sorted((min(edge), max(edge)) for edge in edges))
    return graph


@dataclass(frozen=True)
class Source:
    """A problem's graph: `rows` < `columns`, sorted, are the coupled variables; group g has the
    variables starts[g] .. starts[g + 1] - 1."""

    rows: np.ndarray
    columns: np.ndarray
    starts: np.ndarray

    @classmethod
    def of(cls, problem, limit=DEFAULT_LIMIT):
        """The graph of a Problem's QUBO, penalties included. Raises OverLimit."""
        _, (rows, columns, _), _ = models.expand(problem, limit=limit)
        return cls(rows, columns, problem.starts)

    @property
    def variables(self):
        return int(self.starts[-1])

    @functools.cached_property
    def graph(self):
        return _graph(range(self.variables), zip(self.rows.tolist(), self.columns.tolist()))

    @functools.cached_property
    def digest(self):
        """Of the graph alone, whatever its groups."""
        return _digest(np.array([self.variables]), self.rows, self.columns)

    def times(self, copies):
        """The graph of copies side by side: variable v of copy c is c * variables + v."""
        shift = self.variables * np.arange(copies)[:, None]
        return Source((self.rows + shift).ravel(), (self.columns + shift).ravel(),
                      np.append(0, (self.starts[1:] + shift).ravel()))


@dataclass(frozen=True)
class Chip:
    """A chip's working graph, its qubits as Ocean numbers them.

    family, size    "pegasus", "zephyr" or "chimera", and m of the full graph that it is a part of;
                    None where its tiles are not of the usual size
    """

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

        return cls.of(name, getattr(dwave.graphs, f"{shape[1]}_graph")(int(shape[2])))

    @classmethod
    def of(cls, name, graph):
        """From one of Ocean's graphs, its qubits numbered."""
        family = graph.graph["family"]
        usual = graph.graph["tile"] == {"pegasus": 12}.get(family, 4)
        return cls(name, family if usual else None, graph.graph["rows"],
                   _graph(graph, graph.edges))

    @classmethod
    def of_solver(cls, solver):
        """The qubits and couplers that work in one of D-Wave's solvers."""
        topology = solver.properties.get("topology", {})
        family, shape = topology.get("type"), topology.get("shape", [None])
        usual = family == "pegasus" or shape[1:] == [4]
        return cls(solver.name, family if usual else None, shape[0],
                   _graph(solver.nodes, solver.undirected_edges))

    @functools.cached_property
    def qubits(self):
        """The qubits, sorted: i32 array."""
        return np.array(self.graph, np.int32)

    @functools.cached_property
    def couplers(self):
        """The couplers, sorted, the lesser qubit first: i32 array (.., 2)."""
        return np.array(self.graph.edges, np.int32).reshape(-1, 2)

    @functools.cached_property
    def digest(self):
        return _digest(self.qubits, self.couplers)

    def without(self, qubits):
        """The rest of the chip."""
        graph = self.graph.copy()
        graph.remove_nodes_from(qubits)
        return replace(self, graph=graph)


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
    from . import packing

    began, asked, seed = (time.monotonic(), seed,
                          secrets.randbelow(2**31) if seed is None else seed)
    qubits, couplers = len(chip.graph), chip.graph.number_of_edges()
    what = f"{source.variables:,} variables and {source.rows.size:,} couplings"
    if source.variables > qubits or source.rows.size > couplers:
        raise Hopeless(f"{what} cannot fit on {chip.name} with its {qubits:,} qubits and "
                       f"{couplers:,} couplers")
    method, chains = "tiles", tiles.lay_out(source, chip)
    if broken := faults(source, chip, chains) if chains else ():
        # Many are not the chip's doing: the couplings are others than the tiles have.
        sound = {variable: chain for variable, chain in chains.items() if variable not in broken}
        method, chains = "tiles, mended", 2 * len(broken) <= source.variables and search(
            source, chip, seed, timeout / 2, progress, fixed_chains=sound)
    if not chains:
        method, chains = "parts", packing.lay_out(source, chip, asked, timeout, progress)
    if not chains:
        method, chains = "minorminer", search(source, chip, seed,
                                              timeout - (time.monotonic() - began), progress)
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
    if copies != 1:
        find_multiple_embeddings(
            source.graph, chip.without(first.used()).graph, embedder=another, use_filter=False,
            one_to_iterable=True, max_num_emb=None if copies == "auto" else copies - 1,
            timeout=timeout)
    if copies not in ("auto", len(chains)):
        raise SolverError(f"{len(chains):,} of {copies:,} copies found on {chip.name} within "
                          f"{timeout:g} s; take fewer --copies, or --copies auto for as many as "
                          "are found")
    every = [one[v] for one in chains for v in range(source.variables)]
    return replace(first, seconds=round(first.seconds + time.monotonic() - began, 3),
                   problem=source.times(len(chains)).digest, chains=dict(enumerate(every)))


def read(path):
    """The Embedding in a file. Raises OSError, NotThisOne."""
    with open(path, "rb") as stream:
        try:
            found = json.load(stream)
            told, chains = {name: found[name] for name in HEAD}, found["chains"]
            if told != HEAD:
                raise ValueError(str(told))
            if not all(type(q) is int and 0 <= q < 2**31 for chain in chains for q in chain):
                raise ValueError("a chain holds something else than qubits")
            return Embedding(**{one.name: found[one.name] for one in fields(Embedding)[:-1]},
                             chains=dict(enumerate(chains)))
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise NotThisOne(f"no embedding file ({type(error).__name__}: {error}); make one with "
                             "`qstereo-bridge embed`") from None


def check(embedding, source, chip):
    """Raises NotThisOne unless `embedding` embeds this source into this chip as it is today."""
    if len(embedding.chains) != source.variables or embedding.problem != source.digest:
        raise NotThisOne(f"an embedding of another problem graph ({len(embedding.chains):,} "
                         f"variables, this one has {source.variables:,}); embed this problem")
    if wrong := faults(source, chip, embedding.chains):
        raise NotThisOne(f"on {chip.name} {len(wrong):,} of its chains or their couplings are "
                         f"broken; it was made for {embedding.topology}: embed the problem on this "
                         "chip again")


def _cache_path(source, chip, copies):
    """Where the embedding of so many copies ("auto": of those that were found) is kept. The folder
    may be deleted at any time."""
    base = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    more = "" if copies == 1 else f"-{copies}"
    return os.path.join(base, "qstereo",
                        f"embedding-{source.digest[:32]}-{chip.digest[:32]}{more}.json")


def kept(source, chip, copies=1):
    """The Embedding that the cache has for these two graphs, or None."""
    with contextlib.suppress(OSError, NotThisOne):
        found = read(_cache_path(source, chip, copies))
        count = max(1, len(found.chains) // source.variables) if copies == "auto" else copies
        check(found, source.times(count), chip)
        return found
    return None


def keep(embedding, source, chip, copies=1):
    """Put an Embedding into the cache, unless a shorter one is there. A cache that cannot be
    written is none."""
    before, path = kept(source, chip, copies), _cache_path(source, chip, copies)
    if before is None or len(before.used()) > len(embedding.used()):
        with contextlib.suppress(OSError):
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with temporary(path) as (name, stream), stream:
                stream.write(embedding.to_json().encode())
                os.replace(name, path)


# Of this process: a lock for each search, and what the searches of a given seed have found.
_searching, _seeded = {}, {}


def obtain(source, chip, seed=None, timeout=TIMEOUT, progress=lambda text: None, copies=1):
    """The Embedding of a Source, or of copies of it, into a Chip: the one kept, else a new one,
    which is kept. Raises NoEmbedding, SolverError.

    A `seed` asks for its own embedding: the one kept is not used. Threads that want the same one
    wait for the first to find it.
    """
    graphs, key = (source.digest, chip.digest, copies), (source.digest, chip.digest, copies, seed)
    with _searching.setdefault(graphs, threading.Lock()):
        found = kept(source, chip, copies) if seed is None else _seeded.get(key)
        if found is None:
            found = (find(source, chip, seed, timeout, progress) if copies == 1 else
                     find_copies(source, chip, copies,
                                 obtain(source, chip, seed, timeout, progress), seed, timeout,
                                 progress))
        if seed is not None:
            _seeded[key] = found
        keep(found, source, chip, copies)
    return found
