"""Seconds of the library's solvers beside PyMaxflow on the same problems, and seconds until optima are proven.

    python tests/bench/bench_solvers.py [--data DIR]      DIR: scenes in folders with left.png and right.png

Potts, lambda 20, whole pictures from the winner-take-all start; medians of three runs, taken in turn, on one core. Seconds are of the
solvers alone. Prints figures, asserts nothing.
"""

import argparse
import tempfile
import time
from pathlib import Path
from statistics import median

import numpy as np
from PIL import Image
from scenes import LAMBDA, WINDOW, call, disparities, pair, scenes_of

try:
    from maxflow.fastmin import aexpansion_grid
except ImportError:
    aexpansion_grid = None

RUNS = 3
TRWS_ITERATIONS, BP_ITERATIONS = 50, 20


def grey(path):
    red, green, blue = np.moveaxis(np.asarray(Image.open(path).convert("RGB")).astype(np.int64), -1, 0)
    return (299 * red + 587 * green + 114 * blue + 500) // 1000


def unary_of(scene, least, most):
    """The costs as `encode` makes them: without the columns whose matches fall outside the right picture."""
    left, right = grey(scene / "left.png"), grey(scene / "right.png")
    width = left.shape[1]
    return np.stack([np.abs(left[:, most:] - right[:, most - d:width - d]) for d in range(least, most + 1)], axis=-1)


def energy_of(unary, labels):
    data = np.take_along_axis(unary, labels[..., None].astype(np.int64), axis=-1).sum()
    return int(data + LAMBDA * ((labels[1:] != labels[:-1]).sum() + (labels[:, 1:] != labels[:, :-1]).sum()))


def pymaxflow(unary):
    count = unary.shape[-1]
    costs, pairwise = unary.astype(np.float64), LAMBDA * (1.0 - np.eye(count))
    begin = time.perf_counter()
    labels = aexpansion_grid(costs, pairwise)
    return time.perf_counter() - begin, energy_of(unary, labels)


def whole(scene, qstereo, folder):
    """Runs all of them RUNS times in turn, so that what else the machine does meets each alike."""
    problem, samples = Path(folder, "p.qcf"), Path(folder, "s.qsf")
    call(qstereo, "encode", *pair(scene), "-o", problem)
    unary = unary_of(scene, *disparities(scene))
    theirs, runs = [], {"expansion": [], "trws": [], "bp": []}
    limits = {"expansion": [], "trws": ["--iterations", TRWS_ITERATIONS], "bp": ["--iterations", BP_ITERATIONS]}
    for _ in range(RUNS):
        if aexpansion_grid:
            theirs.append(pymaxflow(unary))
        for solver, limit in limits.items():
            runs[solver].append(call(qstereo, "solve", problem, "-o", samples, "--solver", solver, *limit))
    ours = {solver: (median(run["seconds"] for run in of), of[0]) for solver, of in runs.items()}
    return unary.shape, median(seconds for seconds, _ in theirs) if theirs else None, theirs[0][1] if theirs else None, ours


def show_whole(scene, qstereo, folder):
    (height, width, labels), seconds, energy, ours = whole(scene, qstereo, folder)
    expansion, facts = ours["expansion"]
    beside = f"{seconds:9.3f} {energy:9}  {seconds / expansion:5.1f}x" if seconds else f"{'-':>9} {'-':>9}  {'-':>6}"
    each = [1000 * ours[solver][0] / ours[solver][1]["iterations"] for solver in ("trws", "bp")]
    print(f"  {scene.name:10} {width:4} x {height:3} x {labels:2}  {expansion:9.3f} {facts['energy']:9}  {beside}"
          f"  {each[0]:8.2f} {each[1]:8.2f}")


def show_crop(scene, qstereo, folder):
    """The central window, solved by best."""
    problem, samples = Path(folder, "p.qcf"), Path(folder, "s.qsf")
    call(qstereo, "encode", *pair(scene, window=True), "-o", problem)
    runs = [call(qstereo, "solve", problem, "-o", samples) for _ in range(RUNS)]
    proven = "proven" if runs[0]["proven_optimal"] else f"not proven, gap {runs[0]['gap']}"
    seconds = median(run["seconds"] for run in runs)
    print(f"  {scene.name:10} {seconds:8.3f} s  {runs[0]['energy']:9}  {runs[0]['iterations']:5} iterations  {proven}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, help="folder of scenes; without it the sample pair")
    parser.add_argument("--qstereo", default="build/qstereo")
    options = parser.parse_args()
    scenes = scenes_of(options.data)
    print(f"solvers, potts, lambda {LAMBDA}, medians of {RUNS}; PyMaxflow is its aexpansion_grid, trws and bp are per iteration")
    if not aexpansion_grid:
        print("PyMaxflow is not installed (pip install PyMaxflow): nothing stands beside expansion")
    with tempfile.TemporaryDirectory() as folder:
        print(f"  {'scene':10} {'sites x labels':>15}  {'expansion':>9} {'energy':>9}  {'PyMaxflow':>9} {'energy':>9}  {'ratio':>6}"
              f"  {'trws ms':>8} {'bp ms':>8}")
        for scene in scenes:
            show_whole(scene, options.qstereo, folder)
        print(f"\nbest, until the optimum of the central {WINDOW} x {WINDOW} window is proven:")
        for scene in scenes:
            show_crop(scene, options.qstereo, folder)


if __name__ == "__main__":
    main()
