"""Energies that D-Wave's local annealer reaches, by encoding and penalty: figures `anneal`.

    python tests/bench/bench_anneal.py [--data DIR] [--figures DIR]

The same windows each time, the same reads and sweeps; what differs is what the annealer is given.
"""

import tempfile
import time
from pathlib import Path

import qstereo_bridge as qb
from scenes import LAMBDA, SAMPLES, Figures, arguments, call

FORMS = [("one-hot", "paper"), ("one-hot", "local"), ("one-hot-sparse", "paper"),
         ("one-hot-sparse", "local")]
READS, SWEEPS = 20, 1000


def anneal(pair, roi, labels, form, options, folder):
    """One window in one form: what the annealer is given and what it finds."""
    problem, samples = Path(folder, "p.qcf"), Path(folder, "s.qsf")
    encoding, penalty = form
    info = call(options.qstereo, "encode", pair / "left.png", pair / "right.png", "-o", problem,
                "--roi", roi, "--disparity", f"0:{labels - 1}", "--lambda", LAMBDA,
                "--encoding", encoding, "--penalty", penalty)
    begin = time.perf_counter()
    solved = call(options.bridge, "solve", problem, "-o", samples, "--num-reads", READS,
                  "--num-sweeps", SWEEPS, "--seed", 1)
    took = time.perf_counter() - begin
    read = qb.load_samples(samples)
    reads = read.records["energy"][:read.info["result"]["reads"]]
    return {"encoding": encoding, "penalty": penalty, "terms": info["quadratic_terms"],
            "pair_penalty_max": info["pair_penalty_max"], "feasible": solved["feasible"],
            "best_read": int(reads.min()), "energy": solved["best_energy"], "seconds": took}


def window(pair, corner, size, labels, options):
    roi = f"{corner},{size},{size}"
    with tempfile.TemporaryDirectory() as folder:
        forms = [anneal(pair, roi, labels, form, options, folder) for form in FORMS]
        # The last form's problem has the same optimum.
        proof = call(options.qstereo, "solve", Path(folder, "p.qcf"), "-o", Path(folder, "s.qsf"))
    return {"scene": pair.name, "size": size, "labels": labels, "forms": forms,
            "optimum": proof["energy"] if proof["proven_optimal"] else None}


def main():
    options = arguments(__doc__)
    windows = [(SAMPLES, "90,60", 16)]
    if options.data:
        windows = [(options.data / "tsukuba", "180,130", 16),
                   (options.data / "venus", "200,150", 20)]
    with Figures(options.figures, "anneal") as figures:
        figures.update(reads=READS, sweeps=SWEEPS)
        figures["windows"] = [window(pair, corner, size, labels, options)
                              for pair, corner, labels in windows for size in (24, 40)]


if __name__ == "__main__":
    main()
