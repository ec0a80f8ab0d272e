"""The largest n x n window whose QUBO embeds into a chip, in each encoding: laid out in tiles, and by minorminer alone.

    python tests/bench/bench_embedding.py [--timeout 100] [--seed 1] [--qstereo build/qstereo]

The graphs are built here from the formulas of docs/MATHS.md, and those of one-hot and one-hot-sparse compared with qstereo's.
Every embedding is checked with Ocean's verify_embedding. About an hour with minorminer, seconds with --tiles.
"""

import argparse
import itertools
import subprocess
import tempfile
import time
from pathlib import Path

import dwave.embedding
import dwave.graphs
import networkx as nx
import numpy as np
from qstereo_bridge import embedding, qcf, tiles

CHIPS = {"pegasus:16": dwave.graphs.pegasus_graph(16), "zephyr:12": dwave.graphs.zephyr_graph(12)}
# Where minorminer's search for the largest window begins.
STARTS = {("one-hot", 8): 6, ("one-hot", 16): 4, ("one-hot-sparse", 8): 8, ("one-hot-sparse", 16): 5, ("domain-wall", 8): 8,
          ("domain-wall", 16): 4}


def source_of(encoding, n, labels):
    """The Source of an n x n window: all pairs inside a site but for domain-wall's chain; between neighbours other labels, the same, or
    those that differ by one at most."""
    size = labels - (encoding == "domain-wall")
    i, j = np.indices((size, size))
    inside = (j == i + 1) if encoding == "domain-wall" else (j > i)
    between = {"one-hot": i != j, "one-hot-sparse": i == j, "domain-wall": abs(i - j) <= 1}[encoding]
    site = np.arange(n * n).reshape(n, n)
    pairs = [(site.ravel(), site.ravel(), inside), (site[:, :-1].ravel(), site[:, 1:].ravel(), between),
             (site[:-1].ravel(), site[1:].ravel(), between)]
    edges = np.concatenate([np.stack([p[:, None] * size + i[which], q[:, None] * size + j[which]], axis=-1).reshape(-1, 2)
                            for p, q, which in pairs])
    edges = edges[np.lexsort((edges[:, 1], edges[:, 0]))].astype(np.int32)
    return embedding.Source(edges[:, 0], edges[:, 1], np.arange(0, n * n * size + 1, size))


def compare(qstereo):
    """The formulas against the files that qstereo writes."""
    from PIL import Image

    rng = np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as folder:
        left, right, path = (Path(folder, name) for name in ("left.png", "right.png", "p.qcf"))
        for picture in (left, right):
            Image.fromarray(rng.integers(0, 256, (40, 40), np.uint8)).save(picture)
        for encoding, n, labels in itertools.product(("one-hot", "one-hot-sparse"), (2, 5), (2, 8, 16)):
            subprocess.run([qstereo, "encode", left, right, "-o", path, "--roi", f"20,10,{n},{n}", "--disparity", f"0:{labels - 1}",
                            "--encoding", encoding], check=True, capture_output=True)
            with open(path, "rb") as stream:
                written = embedding.Source.of(qcf.read_qcf(stream)[0])
            assert written.digest == source_of(encoding, n, labels).digest, (encoding, n, labels)


def row(how, chip, encoding, labels, n, source, chains, seconds):
    """One line of the table, the embedding verified; False where there is none."""
    if chains:
        graph = nx.Graph(zip(source.rows.tolist(), source.columns.tolist()))
        dwave.embedding.verify_embedding(chains, graph, CHIPS[chip.name])
        lengths = [len(chain) for chain in chains.values()]
        found = f"{sum(lengths):,} | {max(lengths)} | {sum(lengths) / len(lengths):.2f}"
    else:
        found = "none | |"
    print(f"| {encoding} | {labels} | {chip.name} | {how} | {n} x {n} | {source.variables:,} | {source.rows.size:,} | {found} | {seconds:.1f} |",
          flush=True)
    return bool(chains)


def by_tiles(chip, encoding, labels, n):
    source, began = source_of(encoding, n, labels), time.perf_counter()
    chains = tiles.lay_out(source, chip)
    if chains is None or any(wrong.size for wrong in embedding.faults(source, chip, chains)):
        return False
    return row("tiles", chip, encoding, labels, n, source, chains, time.perf_counter() - began)


def by_minorminer(chip, encoding, labels, n, options):
    source, began = source_of(encoding, n, labels), time.perf_counter()
    chains = embedding.search(source, chip, options.seed, options.timeout)
    return row("minorminer", chip, encoding, labels, n, source, chains, time.perf_counter() - began)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--timeout", type=float, default=100, help="seconds of minorminer a try (100)")
    parser.add_argument("--seed", type=int, default=1, help="minorminer's seed (1)")
    parser.add_argument("--tiles", action="store_true", help="without minorminer")
    parser.add_argument("--qstereo", help="compare the graphs with those of this command")
    options = parser.parse_args()
    if options.qstereo:
        compare(options.qstereo)
    print("| encoding | labels | chip | how | window | variables | couplers | qubits | longest chain | mean chain | seconds |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for (encoding, labels), start in STARTS.items():
        for name in CHIPS:
            chip = embedding.Chip.named(name)
            next(filter(lambda n: by_tiles(chip, encoding, labels, n), range(chip.size, 0, -1)), None)
            if options.tiles:
                continue
            n = start
            if by_minorminer(chip, encoding, labels, n, options):
                while by_minorminer(chip, encoding, labels, n := n + 1, options):
                    pass
            else:
                while n > 1 and not by_minorminer(chip, encoding, labels, n := n - 1, options):
                    pass


if __name__ == "__main__":
    main()
