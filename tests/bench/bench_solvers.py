"""The library's solvers: seconds beside PyMaxflow on the same problems, seconds until optima are
proven, energies of whole scenes, memory. Figures `solvers`.

    python tests/bench/bench_solvers.py [--data DIR] [--figures DIR]

Potts, lambda 20, from the labelling of cheapest labels; medians of three runs, taken in turn, on
one core. Seconds are of the solvers alone. With DIR, also larger scenes in it, and instances of the
MRF benchmark in the folder `mrf` beside it.
"""

import ctypes
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import numpy as np
from maxflow.fastmin import aexpansion_grid
from PIL import Image
from scenes import LAMBDA, WINDOW, Figures, arguments, call, disparities, pair, scenes_of

RUNS = 3
# Solvers that run to their end, or as many iterations as it takes to tell what one costs.
LIMITS = {"expansion": [], "trws": ["--iterations", 50], "bp": ["--iterations", 20]}
BEST_ITERATIONS = 2000
LIMIT = 60  # seconds of the whole command
# Larger scenes, where they are, and their largest disparity.
LARGE = {"moebius": 73, "reindeer": 67}
INSTANCES = ("house", "tsukuba", "venus", "pano")
WORKSPACES = ("icm", "anneal", "expansion", "swap", "trws", "bp", "best", "reduce")


def grey(path):
    channels = np.moveaxis(np.asarray(Image.open(path).convert("RGB")).astype(np.int64), -1, 0)
    return (299 * channels[0] + 587 * channels[1] + 114 * channels[2] + 500) // 1000


def unary_of(scene, least, most):
    """The costs as `encode` makes them: without the columns that have no match in the right
    picture for every disparity."""
    left, right = grey(scene / "left.png"), grey(scene / "right.png")
    width = left.shape[1]
    costs = [np.abs(left[:, most:] - right[:, most - d:width - d]) for d in range(least, most + 1)]
    return np.stack(costs, axis=-1)


def energy_of(unary, labels):
    data = np.take_along_axis(unary, labels[..., None].astype(np.int64), axis=-1).sum()
    cuts = (labels[1:] != labels[:-1]).sum() + (labels[:, 1:] != labels[:, :-1]).sum()
    return int(data + LAMBDA * cuts)


def pymaxflow(unary):
    """(seconds, energy) of PyMaxflow's alpha-expansion."""
    costs, pairwise = unary.astype(np.float64), LAMBDA * (1.0 - np.eye(unary.shape[-1]))
    begin = time.perf_counter()
    labels = aexpansion_grid(costs, pairwise)
    return time.perf_counter() - begin, energy_of(unary, labels)


def whole(scene, qstereo, folder):
    """Runs all of them in turn, so that what else the machine does meets each alike."""
    problem, samples = Path(folder, "p.qcf"), Path(folder, "s.qsf")
    call(qstereo, "encode", *pair(scene), "-o", problem)
    unary = unary_of(scene, *disparities(scene))
    theirs, runs = [], {solver: [] for solver in LIMITS}
    for _ in range(RUNS):
        theirs.append(pymaxflow(unary))
        for solver, limit in LIMITS.items():
            runs[solver].append(call(qstereo, "solve", problem, "-o", samples,
                                     "--solver", solver, *limit))
    seconds = {solver: median(run["seconds"] for run in of) for solver, of in runs.items()}
    best = call(qstereo, "solve", problem, "-o", samples, "--iterations", BEST_ITERATIONS)
    height, width, labels = unary.shape
    return {
        "scene": scene.name, "width": width, "height": height, "labels": labels,
        "expansion_seconds": seconds["expansion"],
        "expansion_energy": runs["expansion"][0]["energy"],
        "pymaxflow_seconds": median(of for of, _ in theirs),
        "pymaxflow_energy": theirs[0][1],
        "trws_seconds_an_iteration": seconds["trws"] / runs["trws"][0]["iterations"],
        "bp_seconds_an_iteration": seconds["bp"] / runs["bp"][0]["iterations"],
        "best": {key: best[key] for key in ("energy", "lower_bound", "proven_optimal",
                                            "iterations", "seconds")},
    }


def window(scene, qstereo, folder):
    """The central window, solved by best."""
    problem, samples = Path(folder, "p.qcf"), Path(folder, "s.qsf")
    call(qstereo, "encode", *pair(scene, window=True), "-o", problem)
    runs = [call(qstereo, "solve", problem, "-o", samples) for _ in range(RUNS)]
    return {"scene": scene.name, "seconds": median(run["seconds"] for run in runs),
            **{key: runs[0][key] for key in ("energy", "iterations", "proven_optimal", "gap")}}


def large(scene, qstereo, folder):
    """A larger scene, solved by best within a minute."""
    most = LARGE[scene.name]
    found = call(qstereo, "match", scene / "left.png", scene / "right.png", "-o",
                 Path(folder, "d.png"), "--disparity", f"0:{most}", "--lambda", LAMBDA,
                 "--time-limit", LIMIT)
    return {"scene": scene.name, "labels": most + 1,
            **{key: found[key] for key in ("energy", "lower_bound", "proven_optimal",
                                           "iterations", "seconds")}}


def benchmark(name, options, folder):
    """An instance of the Middlebury MRF benchmark, solved by best within a minute."""
    pictures, problem = (options.data.parent / "mrf" / name).resolve(), Path(folder, "m.qcf")
    tool = Path(__file__).with_name("mrf_problem.py")
    pack = options.build / "pack_problem"
    if name == "pano":
        command = [sys.executable, tool, name, pictures, "--arrays", folder]
        said = subprocess.run(command, check=True, capture_output=True, text=True, cwd=folder)
        found = call(options.qstereo, "label", *said.stdout.split(), "-o", Path(folder, "m.npy"),
                     "--time-limit", LIMIT)
    else:
        subprocess.run([sys.executable, tool, name, pictures, "-o", problem, "--pack", pack],
                       check=True)
        found = call(options.qstereo, "solve", problem, "-o", Path(folder, "s.qsf"),
                     "--time-limit", LIMIT)
    return {"instance": name, **{key: found[key] for key in ("energy", "lower_bound",
                                                             "proven_optimal", "seconds")}}


def bytes_a_cost(scene, options, folder):
    """Bytes of each solver's workspace for a site and label, asked of the library."""
    problem = Path(folder, "p.qcf")
    facts = call(options.qstereo, "encode", *pair(scene, window=True), "-o", problem)
    data = problem.read_bytes()
    lib, word = ctypes.CDLL(str(options.build / "libqstereo.so")), ctypes.c_size_t

    def size(name, of):
        function = lib[f"qs_{name}_workspace"]
        function.restype = word
        return function(of)

    # The structs' sizes are C's affair: these are larger than any of them.
    view, index, model = (ctypes.create_string_buffer(4096) for _ in range(3))
    if lib.qs_qubo_open(data, word(len(data)), ctypes.c_uint64(2**40), view, None) != 0:
        raise SystemExit("bench_solvers: the library refuses its own file")
    indexing = size("index", view)
    index_memory = ctypes.create_string_buffer(indexing)
    assert lib.qs_index_build(view, index_memory, word(indexing), index) == 0
    modelling = size("model", view)
    model_memory = ctypes.create_string_buffer(modelling)
    assert lib.qs_model_build(index, model_memory, word(modelling), model) == 0
    costs = facts["sites"] * facts["labels"]
    return {"model": modelling / costs, **{name: size(name, model) / costs for name in WORKSPACES}}


def main():
    options = arguments(__doc__)
    scenes = scenes_of(options.data)
    with tempfile.TemporaryDirectory() as folder, Figures(options.figures, "solvers") as figures:
        figures.update(weight=LAMBDA, window=WINDOW, runs=RUNS, best_iterations=BEST_ITERATIONS)
        figures["whole"] = [whole(scene, options.qstereo, folder) for scene in scenes]
        figures["windows"] = [window(scene, options.qstereo, folder) for scene in scenes]
        if options.data:
            figures["large"] = [large(options.data / name, options.qstereo, folder)
                                for name in LARGE if (options.data / name).is_dir()]
            figures["benchmark"] = [benchmark(name, options, folder) for name in INSTANCES
                                    if (options.data.parent / "mrf" / name).is_dir()]
        figures["bytes_a_cost"] = bytes_a_cost(scenes[0], options, folder)


if __name__ == "__main__":
    main()
