"""How far problems shrink with their optima proven unchanged, what that takes, and what is left for an annealer.

    python tests/bench/bench_reduce.py [--data DIR] [--time-limit S]      DIR: scenes in folders with left.png and right.png

Potts, lambda 20. Central windows: variables left at the proof, and the first problem of at most 2,000, 500 and 100 variables. Whole pictures:
`reduce` until it is proven or out of time, then an integer program for what is left (`--solver ilp`): seconds and peak memory of each. One core. Prints figures, asserts nothing.
"""

import argparse
import subprocess
import tempfile
from pathlib import Path

from scenes import LAMBDA, WINDOW, call, measured_call, pair, scenes_of

TARGETS = (2000, 500, 100)
ENCODINGS = ("one-hot-sparse", "domain-wall")


def show_window(scene, qstereo, folder):
    whole, small = Path(folder, "p.qcf"), Path(folder, "small.qcf")
    call(qstereo, "encode", *pair(scene, window=True), "-o", whole)
    at_proof = call(qstereo, "reduce", whole, "-o", small)
    cells = [f"{scene.name:10} {at_proof['variables_before']:9,} {at_proof['variables_after']:6,}"
             f" {100 * at_proof['variables_after'] / at_proof['variables_before']:6.3f} {at_proof['seconds']:7.3f}"
             f" {'proven' if at_proof['lower_bound'] == at_proof['upper_bound'] else 'open':7}"]
    for target in TARGETS:
        left = [call(qstereo, "reduce", whole, "-o", small, "--target", target, "--encoding", encoding)["variables_after"] for encoding in ENCODINGS]
        cells.append(f"{left[0]:6,} {left[1]:6,}")
    print("  " + "  ".join(cells))


def show_units(scene, qstereo, folder):
    whole = Path(folder, "p.qcf")
    call(qstereo, "encode", *pair(scene, window=True), "-o", whole)
    print(subprocess.run([qstereo, "info", "--complexity", whole], check=True, capture_output=True, text=True).stdout)


def show_whole(scene, qstereo, bridge, limit, folder):
    whole, small, samples, disparity = (Path(folder, name) for name in ("p.qcf", "small.qcf", "s.qsf", "map.pgm"))
    call(qstereo, "encode", *pair(scene), "-o", whole)
    reduced, reduce_seconds, reduce_memory = measured_call(qstereo, "reduce", whole, "-o", small, "--time-limit", limit)
    solved, ilp_seconds, ilp_memory = measured_call(bridge, "solve", small, "-o", samples, "--solver", "ilp")
    decoded = call(qstereo, "decode", small, samples, "-o", disparity)
    print(f"  {scene.name:10} {reduced['variables_before']:9,} {reduced['variables_after']:7,} {reduced['lower_bound']:9} {reduced['upper_bound']:9}"
          f" {reduce_seconds:8.2f} {reduce_memory:7.0f} {ilp_seconds:8.2f} {ilp_memory:7.0f}  {decoded['energy']:9}"
          f" {'proven' if solved['proven_optimal'] else 'not proven'}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, help="folder of scenes; without it the sample pair")
    parser.add_argument("--qstereo", default="build/qstereo")
    parser.add_argument("--bridge", default=".venv/bin/qstereo-bridge")
    parser.add_argument("--time-limit", type=float, default=20, help="seconds for reduce on a whole picture (20)")
    options = parser.parse_args()
    scenes = scenes_of(options.data)
    with tempfile.TemporaryDirectory() as folder:
        print(f"reduce, potts, lambda {LAMBDA}, windows of {WINDOW} x {WINDOW}; then variables left at targets, one-hot-sparse and domain-wall")
        print(f"  {'scene':10} {'variables':>9} {'left':>6} {'%':>6} {'seconds':>7} {'':7}  " + "  ".join(f"{f'at {target:,}':>13}" for target in TARGETS))
        for scene in scenes:
            show_window(scene, options.qstereo, folder)
        print(f"\nwhole pictures: reduce for at most {options.time_limit:g} s, then ilp")
        print(f"  {'scene':10} {'variables':>9} {'left':>7} {'bound':>9} {'energy':>9} {'reduce s':>8} {'MiB':>7} {'ilp s':>8} {'MiB':>7}  {'optimum':>9}")
        for scene in scenes:
            show_whole(scene, options.qstereo, options.bridge, options.time_limit, folder)
        print(f"\nthe central window of {scenes[-1].name if len(scenes) == 1 else 'tsukuba'} in every encoding:")
        show_units(next((scene for scene in scenes if scene.name == "tsukuba"), scenes[-1]), options.qstereo, folder)


if __name__ == "__main__":
    main()
