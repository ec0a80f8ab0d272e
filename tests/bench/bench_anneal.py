"""Energies that D-Wave's local annealer reaches through each encoding and penalty, on windows of real or sample pairs.

    python tests/bench/bench_anneal.py [--data DIR]      DIR: scenes in folders with left.png and right.png

The same problem each time, the same reads and sweeps; what differs is what the annealer is given.
"""

import argparse
import tempfile
import time
from pathlib import Path

from scenes import SAMPLES, call

FORMS = [("one-hot", "paper"), ("one-hot", "local"), ("one-hot-sparse", "paper"), ("one-hot-sparse", "local")]
READS, SWEEPS = 20, 1000


def window(pair, roi, labels, qstereo, bridge):
    print(f"\n{pair.name}, window {roi}, disparities 0:{labels - 1}, lambda 20; {READS} reads of {SWEEPS} sweeps, seed 1")
    print(f"  {'encoding':15} {'penalty':7} {'terms':>9} {'b at most':>9} {'feasible':>8} {'best F':>8} {'seconds':>8}")
    with tempfile.TemporaryDirectory() as folder:
        for encoding, penalty in FORMS:
            p, s = Path(folder, "p.qcf"), Path(folder, "s.qsf")
            info = call(qstereo, "encode", pair / "left.png", pair / "right.png", "-o", p, "--roi", roi, "--disparity", f"0:{labels - 1}",
                        "--encoding", encoding, "--penalty", penalty)
            begin = time.perf_counter()
            solved = call(bridge, "solve", p, "-o", s, "--num-reads", READS, "--num-sweeps", SWEEPS, "--seed", 1)
            seconds = time.perf_counter() - begin
            best = "-" if solved["best_energy"] is None else solved["best_energy"]
            print(f"  {encoding:15} {penalty:7} {info['quadratic_terms']:9,} {info['pair_penalty_max']:9,} {solved['feasible']:5}/{READS} "
                  f"{best:>8} {seconds:8.1f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, help="folder of scenes; without it the sample pair")
    parser.add_argument("--qstereo", default="build/qstereo")
    parser.add_argument("--bridge", default=".venv/bin/qstereo-bridge")
    options = parser.parse_args()
    if options.data:
        windows = [(options.data / "tsukuba", "180,130", 16), (options.data / "venus", "200,150", 20)]
    else:
        windows = [(SAMPLES, "90,60", 16)]
    for pair, corner, labels in windows:
        for size in (24, 40):
            window(pair, f"{corner},{size},{size}", labels, options.qstereo, options.bridge)


if __name__ == "__main__":
    main()
