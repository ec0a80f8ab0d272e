"""Minor embedding: every variable of a problem becomes a chain of qubits of a chip.

    source = embedding.Source.of(problem)
    chip = embedding.Chip.named("zephyr:12")
    found = embedding.obtain(source, chip)        # from the cache, else find() and into the cache
    found.chains                                  # {variable: [qubits]}, as Ocean's FixedEmbeddingComposite takes it

An embedding depends on which pairs of variables are coupled and on nothing else: the frames of one camera share theirs.
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
from dataclasses import asdict, dataclass, replace

import numpy as np

from . import models, services
from .qcf import DEFAULT_LIMIT
from .solvers import SolverError, interruptible

TIMEOUT = 100.0
SCHEMA = 1
SMALLEST, LARGEST = 2, 32


class NoEmbedding(Exception):
    """A well-posed no: the problem does not fit, or no embedding was found in the time."""


class NotThisOne(Exception):
    """A file that holds no embedding, or not one of this problem into this chip."""


def _digest(*arrays):
    """SHA-256 of arrays of 32-bit integers, each after its length."""
    found = hashlib.sha256()
    for array in arrays:
        found.update(np.int64(array.size).astype("<i8").tobytes() + np.ascontiguousarray(array, "<i4").tobytes())
    return found.hexdigest()


@dataclass(frozen=True)
class Source:
    """A problem's graph: `rows` < `columns`, sorted, are the coupled variables; group g has the variables starts[g] .. starts[g + 1] - 1."""

    rows: np.ndarray
    columns: np.ndarray
    starts: np.ndarray

    @classmethod
    def of(cls, problem, limit=DEFAULT_LIMIT):
        """The graph of a Problem's QUBO, penalties included. Raises OverLimit."""
        _, (rows, columns, _), _ = models.expand(problem, limit=limit)
        return cls(rows, columns, problem.starts())

    @property
    def variables(self):
        return int(self.starts[-1])

    @functools.cached_property
    def digest(self):
        """Of the graph alone, whatever its groups."""
        return _digest(np.array([self.variables]), self.rows, self.columns)

    def times(self, copies):
        """The graph of so many copies side by side: variable v of copy c is c * variables + v."""
        shift = self.variables * np.arange(copies)[:, None]
        return Source((self.rows + shift).ravel(), (self.columns + shift).ravel(), np.append(0, (self.starts[1:] + shift).ravel()))


@dataclass(frozen=True)
class Chip:
    """A chip's working graph: its `qubits`, sorted, and its couplers (array (.., 2) of qubits), as Ocean numbers them.

    family, size    "pegasus", "zephyr" or "chimera", and m of the full graph that it is a part of; None where its tiles are not of the usual size
    """

    name: str
    family: str
    size: int
    qubits: np.ndarray
    couplers: np.ndarray

    @classmethod
    def named(cls, name):
        """pegasus:M and zephyr:M: all qubits work; another name: the solver of this name at the user's account.

        Raises ValueError where there can be none of this name, SolverError where the service does not give its graph.
        """
        shape = re.fullmatch(r"(pegasus|zephyr):([0-9]+)", name)
        if shape is None and ":" not in name:
            with services.connect("qpu", name) as session:
                return cls.of_solver(session.solver)
        if shape is None or not SMALLEST <= int(shape[2]) <= LARGEST:
            raise ValueError(f"no topology is called {name}; give pegasus:16 or zephyr:12 (sizes {SMALLEST} to {LARGEST}), or the name of a "
                             "solver of your account")
        import dwave.graphs

        family, size = shape[1], int(shape[2])
        return cls.of(name, {"pegasus": dwave.graphs.pegasus_graph, "zephyr": dwave.graphs.zephyr_graph}[family](size))

    @classmethod
    def of(cls, name, graph):
        """From one of Ocean's graphs, its qubits numbered."""
        family, tile = graph.graph["family"], graph.graph["tile"]
        couplers = np.sort(np.array(graph.edges, np.int32).reshape(-1, 2), axis=1)
        return cls(name, family if tile == {"pegasus": 12}.get(family, 4) else None, graph.graph["rows"], np.sort(np.array(graph, np.int32)),
                   couplers[np.lexsort((couplers[:, 1], couplers[:, 0]))])

    @classmethod
    def of_solver(cls, solver):
        """The qubits and couplers that work in one of D-Wave's solvers."""
        topology = solver.properties.get("topology", {})
        family, shape = topology.get("type"), topology.get("shape", [None])
        usual = family == "pegasus" or shape[1:] == [4]
        couplers = np.sort(np.array(sorted(solver.undirected_edges), np.int32).reshape(-1, 2), axis=1)
        return cls(solver.name, family if usual else None, shape[0], np.array(sorted(solver.nodes), np.int32),
                   couplers[np.lexsort((couplers[:, 1], couplers[:, 0]))])

    @functools.cached_property
    def digest(self):
        return _digest(self.qubits, self.couplers)

    def without(self, qubits):
        """The rest of the chip."""
        return replace(self, qubits=self.qubits[~np.isin(self.qubits, qubits)],
                       couplers=self.couplers[~np.isin(self.couplers, qubits).any(axis=1)])


@dataclass(frozen=True)
class Embedding:
    """An embedding and where it comes from. `chains` is {variable: [qubits]}; the digests are those of the two graphs."""

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
        return {"qubits": int(lengths.sum()), "longest_chain": int(lengths.max()), "mean_chain": round(float(lengths.mean()), 3)}

    def to_json(self):
        """The file's text. Chains stand in the order of the variables."""
        chains = [self.chains[variable] for variable in range(len(self.chains))]
        return json.dumps({"schema": SCHEMA, "format": "qstereo-embedding", **asdict(self), **self.figures(), "chains": chains}) + "\n"


def faults(source, chip, chains):
    """What is wrong with `chains`: (variables, couplings), both empty in an embedding.

    variables: those without a chain of working qubits of their own that hang together; couplings: indices into
    source.rows of those that no coupler can carry.
    """
    n = source.variables
    lengths = np.array([len(chains.get(variable, ())) for variable in range(n)])
    members = np.repeat(np.arange(n), lengths)
    qubits = np.fromiter((qubit for variable in range(n) for qubit in chains.get(variable, ())), np.int64, lengths.sum())
    working, wrong = np.isin(qubits, chip.qubits), lengths == 0
    wrong[members[~working]] = True
    qubits, members = qubits[working], members[working]
    owner = np.full(int(chip.qubits.max(initial=0)) + 1, -1)
    owner[qubits] = members
    # A qubit in two chains has one owner; the other chain is at fault.
    wrong[members[owner[qubits] != members]] = True
    ends = owner[chip.couplers]
    inside, across = (ends[:, 0] == ends[:, 1]) & (ends[:, 0] >= 0), (ends[:, 0] != ends[:, 1]) & (ends >= 0).all(axis=1)
    low, high = ends[across].min(axis=1), ends[across].max(axis=1)
    missing = ~np.isin(source.rows.astype(np.int64) * n + source.columns, low * n + high)
    wrong |= _pieces(qubits, members, chip.couplers[inside], owner, n) > 1
    return np.flatnonzero(wrong), np.flatnonzero(missing)


def _pieces(qubits, members, couplers, owner, n):
    """The number of connected pieces of each chain."""
    import networkx as nx

    graph = nx.Graph()
    graph.add_nodes_from(qubits.tolist())
    graph.add_edges_from(couplers.tolist())
    return np.bincount([owner[next(iter(piece))] for piece in nx.connected_components(graph)], minlength=n)


def find(source, chip, seed=None, timeout=TIMEOUT, progress=lambda text: None):
    """An Embedding of a Source into a Chip. Raises NoEmbedding.

    A grid is laid out in the chip's own tiles where it fits (tiles.py); everything else, and the chains that missing qubits
    break, are minorminer's work. One seed gives one embedding as long as `timeout` does not cut it short.
    """
    began, seed = time.monotonic(), secrets.randbelow(2**31) if seed is None else seed
    if source.variables > chip.qubits.size or source.rows.size > len(chip.couplers):
        raise NoEmbedding(f"{source.variables:,} variables and {source.rows.size:,} couplings cannot fit on {chip.name} with its "
                          f"{chip.qubits.size:,} qubits and {len(chip.couplers):,} couplers")
    method, chains = _tiled(source, chip, seed, timeout / 2, progress)
    if not chains:
        method, chains = "minorminer", search(source, chip, seed, timeout - (time.monotonic() - began), progress)
    if not chains:
        raise NoEmbedding(f"no embedding found on {chip.name} within {timeout:g} s ({source.variables:,} variables, "
                          f"{source.rows.size:,} couplings; {chip.qubits.size:,} qubits)")
    return Embedding(chip.name, method, seed, round(time.monotonic() - began, 3), source.digest, chip.digest, chains)


def find_copies(source, chip, copies, first, seed=None, timeout=TIMEOUT, progress=lambda text: None):
    """The Embedding of `copies` copies of a Source ("auto": as many as are found), each on qubits of its own; `first` is the first copy's.

    Each further copy is found on the qubits that those before it leave. Raises SolverError where fewer are found.
    """
    began, rest, last = time.monotonic(), chip, first.chains
    chains = list(map(last.get, range(source.variables)))
    count, left = 1, timeout
    while count != copies and left > 0:
        rest = rest.without([qubit for chain in last.values() for qubit in chain])
        try:
            last = find(source, rest, seed, left, lambda text: progress(f"copy {count + 1}, {text}")).chains
        except NoEmbedding:
            break
        chains += map(last.get, range(source.variables))
        count, left = count + 1, timeout - (time.monotonic() - began)
    if copies not in ("auto", count):
        raise SolverError(f"{count:,} of {copies:,} copies found on {chip.name} within {timeout:g} s; take fewer --copies, or --copies auto "
                          "for as many as are found")
    return replace(first, seconds=round(first.seconds + time.monotonic() - began, 3), problem=source.times(count).digest,
                   chains=dict(enumerate(chains)))


def _tiled(source, chip, seed, timeout, progress):
    """A layout in tiles and how it was made. What missing qubits and couplers break in it minorminer mends, all other chains fixed."""
    from . import tiles

    chains = tiles.lay_out(source, chip)
    if chains is None:
        return None, None
    variables, couplings = faults(source, chip, chains)
    broken = set(variables.tolist()).union(source.rows[couplings].tolist(), source.columns[couplings].tolist())
    if not broken:
        return "tiles", chains
    # As many as this are not the chip's doing: the couplings are others than the tiles have.
    if 2 * len(broken) > source.variables:
        return None, None
    sound = {variable: chain for variable, chain in chains.items() if variable not in broken}
    return "tiles, mended", search(source, chip, seed, timeout, progress, fixed_chains=sound)


def search(source, chip, seed, timeout, progress=lambda text: None, **hints):
    """{variable: [qubits]} by minorminer, empty where it finds none. `hints` are further arguments of its find_embedding."""
    import minorminer
    import networkx as nx

    graph, target = nx.Graph(), nx.Graph()
    graph.add_nodes_from(range(source.variables))
    graph.add_edges_from(zip(source.rows.tolist(), source.columns.tolist()))
    target.add_nodes_from(chip.qubits.tolist())
    target.add_edges_from(chip.couplers.tolist())
    return interruptible(lambda: minorminer.find_embedding(graph, target, random_seed=seed, timeout=timeout, **hints),
                         lambda: progress("minorminer"))


def read(path):
    """The Embedding in a file. Raises OSError, NotThisOne."""
    with open(path, "rb") as stream:
        try:
            return _parse(json.load(stream))
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            said = f"{type(error).__name__}: {error}"
            raise NotThisOne(f"{path}: no embedding file ({said}); make one with `qstereo-bridge embed`") from None


def _parse(found):
    if found["format"] != "qstereo-embedding" or found["schema"] != SCHEMA:
        raise ValueError(f"format {found['format']!r}, schema {found['schema']!r}")
    chains = found["chains"]
    if not all(type(qubit) is int and 0 <= qubit < 2**31 for chain in chains for qubit in chain):
        raise ValueError("a chain holds something else than qubits")
    fields = {name: found[name] for name in ("topology", "method", "seed", "seconds", "problem", "chip")}
    return Embedding(**fields, chains=dict(enumerate(chains)))


def check(embedding, source, chip):
    """Raises NotThisOne unless `embedding` embeds this source into this chip as it is today."""
    if len(embedding.chains) != source.variables or embedding.problem != source.digest:
        raise NotThisOne(f"an embedding of another problem graph ({len(embedding.chains):,} variables, this one has "
                         f"{source.variables:,}); embed this problem")
    variables, couplings = faults(source, chip, embedding.chains)
    if variables.size or couplings.size:
        raise NotThisOne(f"on {chip.name} {variables.size:,} of its chains and {couplings.size:,} couplings are broken; it was made "
                         f"for {embedding.topology}: embed the problem on this chip anew")


def _cache_path(source, chip, copies):
    """Where the embedding of so many copies ("auto": of those that were found) is kept. The folder may be deleted at any time."""
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    name = f"embedding-{source.digest[:32]}-{chip.digest[:32]}" + (f"-{copies}" if copies != 1 else "")
    return os.path.join(base, "qstereo", f"{name}.json")


def kept(source, chip, copies=1):
    """The Embedding that the cache has for these two graphs, or None."""
    with contextlib.suppress(OSError, NotThisOne):
        found = read(_cache_path(source, chip, copies))
        check(found, source.times(max(1, len(found.chains) // source.variables) if copies == "auto" else copies), chip)
        return found
    return None


def keep(embedding, source, chip, copies=1):
    """Put an Embedding into the cache, unless a shorter one is there. A cache that cannot be written is none."""
    before = kept(source, chip, copies)
    if before is not None and before.figures()["qubits"] <= embedding.figures()["qubits"]:
        return
    path = _cache_path(source, chip, copies)
    temporary = f"{path}.{secrets.token_hex(8)}.tmp"
    with contextlib.suppress(OSError):
        os.makedirs(os.path.dirname(path), exist_ok=True)
        try:
            with open(temporary, "w", encoding="ascii") as stream:
                stream.write(embedding.to_json())
            os.replace(temporary, path)
        except OSError:
            os.remove(temporary)


# Of this process: a lock for each search, and what the searches of a given seed have found.
_searching, _seeded = {}, {}


def obtain(source, chip, seed=None, timeout=TIMEOUT, progress=lambda text: None, copies=1):
    """The Embedding of a Source, or of copies of it, into a Chip: the one kept, else a new one, which is kept. Raises NoEmbedding, SolverError.

    A `seed` asks for its own embedding: the one kept is passed by. Threads that want the same one wait for the first to find it.
    """
    graphs = source.digest, chip.digest, copies
    with _searching.setdefault(graphs, threading.Lock()):
        found = kept(source, chip, copies) if seed is None else _seeded.get((graphs, seed, timeout))
        if found is not None and seed is None:
            return found
        if found is None:
            found = find(source, chip, seed, timeout, progress) if copies == 1 else find_copies(
                source, chip, copies, obtain(source, chip, seed, timeout, progress), seed, timeout, progress)
        if seed is not None:
            _seeded[graphs, seed, timeout] = found
        keep(found, source, chip, copies)
    return found
