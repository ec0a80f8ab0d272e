"""The largest n x n window that embeds into a chip, in each encoding: figures `embedding`.

    python tests/bench/bench_embedding.py [--figures DIR] [--timeout 100] [--seed 1]

By our layout in tiles, and by minorminer alone. The graphs are built here from the formulas of
docs/MATHS.md; those of one-hot and one-hot-sparse are compared with what qstereo writes. Every
embedding is checked with Ocean's verify_embedding. About an hour.
"""

import argparse
import itertools
import subprocess
import tempfile
import time
from pathlib import Path

import dwave.embedding
import dwave.graphs
import numpy as np
from PIL import Image
from qstereo_bridge.ocean import embedding, tiles
from qstereo_bridge.core import qcf
from scenes import ROOT, Figures

CHIPS = {"pegasus:16": dwave.graphs.pegasus_graph(16), "zephyr:12": dwave.graphs.zephyr_graph(12)}
# Where minorminer's search for the largest window begins, by encoding and number of labels.
STARTS = {("one-hot-sparse", 8): 8, ("one-hot-sparse", 16): 5, ("domain-wall", 8): 8,
          ("domain-wall", 16): 4, ("one-hot", 8): 6, ("one-hot", 16): 4}


def source_of(encoding, n, labels):
    """The graph of an n x n window.

    Inside a site all pairs are coupled, of a domain wall's those that follow each other. Between
    neighbouring sites: all different labels (one-hot), the same label (one-hot-sparse), or labels
    that differ by at most one (domain-wall).
    """
    size = labels - (encoding == "domain-wall")
    i, j = np.indices((size, size))
    inside = (j == i + 1) if encoding == "domain-wall" else (j > i)
    between = {"one-hot": i != j, "one-hot-sparse": i == j,
               "domain-wall": abs(i - j) <= 1}[encoding]
    site = np.arange(n * n).reshape(n, n)
    pairs = [(site.ravel(), site.ravel(), inside),
             (site[:, :-1].ravel(), site[:, 1:].ravel(), between),
             (site[:-1].ravel(), site[1:].ravel(), between)]
    edges = np.concatenate([
        np.stack([p[:, None] * size + i[which], q[:, None] * size + j[which]], -1).reshape(-1, 2)
        for p, q, which in pairs
    ])
    return embedding.Source(embedding.graph_of(range(n * n * size), edges.tolist()),
                            np.arange(0, n * n * size + 1, size))


def compare(qstereo):
    """The formulas against the files that qstereo writes."""
    rng = np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as folder:
        left, right, path = (Path(folder, name) for name in ("left.pgm", "right.pgm", "p.qcf"))
        for picture in (left, right):
            Image.fromarray(rng.integers(0, 256, (40, 40), np.uint8)).save(picture)
        shapes = itertools.product(("one-hot", "one-hot-sparse"), (2, 5), (2, 8, 16))
        for encoding, n, labels in shapes:
            subprocess.run([qstereo, "encode", left, right, "-o", path,
                            "--roi", f"20,10,{n},{n}", "--disparity", f"0:{labels - 1}",
                            "--encoding", encoding], check=True, capture_output=True)
            with open(path, "rb") as stream:
                written = embedding.Source.of(qcf.read_qcf(stream))
            formula = source_of(encoding, n, labels)
            assert written.digest == formula.digest, (encoding, n, labels)


def facts_of(n, source, chip, chains, seconds):
    """What the file holds of one embedding, once Ocean has checked it; None where there is none."""
    if not chains:
        return None
    dwave.embedding.verify_embedding(chains, source.graph, CHIPS[chip.name])
    lengths = [len(chain) for chain in chains.values()]
    return {"size": n, "variables": len(source.graph), "couplers": source.graph.number_of_edges(),
            "qubits": sum(lengths), "longest": max(lengths),
            "mean": sum(lengths) / len(lengths), "seconds": seconds}


def in_tiles(chip, encoding, labels):
    """The largest window that the layout in tiles takes; None where it takes none."""
    for n in range(chip.size, 0, -1):
        source, began = source_of(encoding, n, labels), time.perf_counter()
        chains = tiles.lay_out(source, chip)
        seconds = time.perf_counter() - began
        faults = chains and embedding.faults(source, chip, chains)
        if chains and not faults:
            return facts_of(n, source, chip, chains, seconds)
    return None


def by_minorminer(chip, encoding, labels, options):
    """The largest window that minorminer finds, going up or down from the start, one try each."""
    def attempt(n):
        source, began = source_of(encoding, n, labels), time.perf_counter()
        chains = embedding.search(source, chip, options.seed, options.timeout)
        return facts_of(n, source, chip, chains, time.perf_counter() - began)

    n = STARTS[encoding, labels]
    found = attempt(n)
    if found:
        while larger := attempt(found["size"] + 1):
            found = larger
    while not found and n > 1:
        n -= 1
        found = attempt(n)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--timeout", type=float, default=100, help="seconds of a try (100)")
    parser.add_argument("--seed", type=int, default=1, help="minorminer's seed (1)")
    parser.add_argument("--build", type=Path, default=ROOT / "build")
    parser.add_argument("--figures", type=Path, default=ROOT / "build" / "figures")
    options = parser.parse_args()
    compare(options.build / "qstereo")
    with Figures(options.figures, "embedding", "make bench-embedding") as figures:
        figures.update(timeout=options.timeout, seed=options.seed, rows=[])
        for (encoding, labels), name in itertools.product(STARTS, CHIPS):
            chip = embedding.Chip.named(name)
            figures["rows"].append({
                "encoding": encoding, "labels": labels, "chip": name,
                "tiles": in_tiles(chip, encoding, labels),
                "minorminer": by_minorminer(chip, encoding, labels, options)})


if __name__ == "__main__":
    main()
