"""How far problems shrink with their optima proven unchanged, what that takes, and what is left for
an annealer: figures `reduce`.

    python tests/bench/bench_reduce.py [--data DIR] [--figures DIR]

Potts, lambda 20, one core. Central windows: variables left at the proof, and the first problem of
at most so many variables. Whole pictures: `reduce` until it is proven or out of time, then an
integer program for what is left: seconds and peak memory of each.
"""

import tempfile
from pathlib import Path

from scenes import LAMBDA, WINDOW, Figures, arguments, call, measured_call, pair, scenes_of

TARGETS = (2000, 500, 100)
ENCODINGS = ("one-hot-sparse", "domain-wall")
TIME_LIMIT = 120


def window(scene, qstereo, folder):
    whole, small = Path(folder, "p.qcf"), Path(folder, "small.qcf")
    call(qstereo, "encode", *pair(scene, window=True), "-o", whole)
    at_proof = call(qstereo, "reduce", whole, "-o", small)
    targets = {
        encoding: [call(qstereo, "reduce", whole, "-o", small, "--target", target,
                        "--encoding", encoding)["variables_after"] for target in TARGETS]
        for encoding in ENCODINGS
    }
    return {"scene": scene.name, "variables": at_proof["variables_before"],
            "left": at_proof["variables_after"], "seconds": at_proof["seconds"],
            "proven": at_proof["proven_optimal"], "targets": targets}


def whole(scene, options, folder):
    names = ("p.qcf", "small.qcf", "s.qsf", "map.pgm")
    problem, small, samples, disparity = (Path(folder, name) for name in names)
    call(options.qstereo, "encode", *pair(scene), "-o", problem)
    reduced, reduce_seconds, reduce_mib = measured_call(
        options.qstereo, "reduce", problem, "-o", small, "--time-limit", TIME_LIMIT)
    solved, ilp_seconds, ilp_mib = measured_call(
        options.bridge, "solve", small, "-o", samples, "--solver", "ilp")
    decoded = call(options.qstereo, "decode", small, samples, "-o", disparity)
    return {"scene": scene.name, "variables": reduced["variables_before"],
            "left": reduced["variables_after"], "lower_bound": reduced["lower_bound"],
            "upper_bound": reduced["upper_bound"], "reduce_seconds": reduce_seconds,
            "reduce_mib": reduce_mib, "ilp_seconds": ilp_seconds, "ilp_mib": ilp_mib,
            "energy": decoded["energy"], "proven": solved["proven_optimal"]}


def units(scene, qstereo, folder):
    """The paper's Table 1 for a real window: what each encoding asks of a chip."""
    problem = Path(folder, "p.qcf")
    call(qstereo, "encode", *pair(scene, window=True), "-o", problem)
    return {"scene": scene.name, "encodings": call(qstereo, "info", "--complexity",
                                                   problem)["encodings"]}


def main():
    options = arguments(__doc__)
    scenes = scenes_of(options.data)
    with tempfile.TemporaryDirectory() as folder, Figures(options.figures, "reduce") as figures:
        figures.update(weight=LAMBDA, window=WINDOW, targets=TARGETS, time_limit=TIME_LIMIT)
        figures["windows"] = [window(scene, options.qstereo, folder) for scene in scenes]
        figures["whole"] = [whole(scene, options, folder) for scene in scenes]
        shown = next((scene for scene in scenes if scene.name == "tsukuba"), scenes[-1])
        figures["units"] = units(shown, options.qstereo, folder)


if __name__ == "__main__":
    main()
