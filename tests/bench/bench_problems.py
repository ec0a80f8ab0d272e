"""Every problem beside stereo, in one command each: energy, bound, score and time; and how greedy
suppression of boxes fares beside `detect`; and the samples the whole way of an annealer: figures
`problems`.

    python tests/bench/bench_problems.py [--data DIR] [--figures DIR]

The inputs are samples/problems, and with --data the real ones in the folders beside it:
segmentation, registration, flow, detection, mrf.
"""

import csv
import json
import tempfile
from pathlib import Path

import maxflow
import numpy as np
import qstereo_bridge as qb
from PIL import Image
from scenes import ROOT, Figures, arguments, call
from whole_way import split, whole_way

SAMPLES = ROOT / "samples" / "problems"
TIME_LIMIT = 60
SCORES = ("psnr", "hole_psnr", "ssim", "iou", "error_rate", "aepe", "aae", "tre_before", "tre",
          "mse_before", "mse", "precision", "recall", "ap")
THRESHOLDS = (0.2, 0.3, 0.4)


def samples(folder):
    """Rows of (input, command and arguments)."""
    of = {name: str(SAMPLES / name) for name in (path.name for path in SAMPLES.iterdir())}
    return [
        ("sample", ["label", of["label-costs.npy"], "-o", folder / "o.npy", "--smoothness",
                    "linear", "--lambda", "30"]),
        ("sample", ["restore", of["restore-noisy.png"], "-o", folder / "o.png", "--step", "4",
                    "--lambda", "32", "--truncation", "50", "--hole", of["restore-hole.png"],
                    "--truth", of["restore-true.png"]]),
        ("sample", ["segment", of["segment-photo.png"], of["segment-strokes.png"], "-o",
                    folder / "o.png", "--truth", of["segment-true.png"]]),
        ("sample", ["flow", of["flow-first.png"], of["flow-second.png"], "-o", folder / "o.flo",
                    "--truth", of["flow-true.flo"]]),
        ("sample", ["register", of["register-fixed.png"], of["register-moving.png"], "-o",
                    folder / "o.flo", "--truth", of["register-true.flo"]]),
        ("sample", ["detect", of["detect-boxes.csv"], "-o", folder / "o.csv", "--truth",
                    of["detect-true.csv"]]),
    ]


def pedestrians(data, name, folder):
    """Class 1 outside of the boxes, and the truth as classes 1 and 2."""
    photo = data / "segmentation" / name / "photo.png"
    truth = np.array(Image.open(photo.with_name("truth.png")))
    strokes = np.ones_like(truth)
    for x, y, width, height in json.loads(photo.with_name("boxes.json").read_text())["boxes"]:
        strokes[y : y + height, x : x + width] = 0
    files = [folder / f"{name}-strokes.png", folder / f"{name}-true.png"]
    for path, numbers in zip(files, (strokes, 1 + (truth > 0)), strict=True):
        Image.fromarray(numbers.astype(np.uint8)).save(path)
    return (f"{name}, --rounds 3", ["segment", photo, files[0], "-o", folder / "o.png",
                                    "--rounds", "3", "--truth", files[1]])


def brain(data, folder):
    """The truth counts where there is brain."""
    fixed = data / "registration" / "brain" / "fixed.png"
    truth = np.load(fixed.with_name("truth.npy")).astype(np.float32)
    truth[np.array(Image.open(fixed)) <= 20] = np.nan
    np.save(folder / "brain.npy", truth)
    return ("brain slice", ["register", fixed, fixed.with_name("moving.png"), "-o",
                            folder / "o.flo", "--truth", folder / "brain.npy"])


def house(data, folder):
    picture = data / "mrf" / "house" / "input.png"
    mask = np.array(Image.open(picture.with_name("mask.png")))
    Image.fromarray(((mask == 0) * 255).astype(np.uint8)).save(folder / "hole.png")
    return ("house", ["restore", picture, "-o", folder / "o.png", "--lambda", "5", "--hole",
                      folder / "hole.png"])


def real(data, folder):
    boxes = data / "detection" / "pedestrians" / "boxes.csv"
    rubber = data / "flow" / "rubberwhale"
    return [
        house(data, folder),
        pedestrians(data, "ped1", folder),
        pedestrians(data, "ped2", folder),
        ("RubberWhale", ["flow", rubber / "first.png", rubber / "second.png", "-o",
                         folder / "o.flo"]),
        brain(data, folder),
        ("20 photographs", ["detect", boxes, "-o", folder / "kept.csv", "--truth",
                            boxes.with_name("truth.csv")]),
    ]


def way(options, command, folder):
    found = whole_way(options.qstereo, options.bridge, command, folder)
    found["scores"] = {key: found["scores"][key] for key in SCORES if key in found["scores"]}
    return found


def cut_energy(qstereo, command, folder):
    """The optimum of a problem of two classes by PyMaxflow, from the coefficients of its file: in a
    domain wall a class is one bit, and all couplings are below 0."""
    file, (words, _) = folder / "cut.qcf", split(command)
    call(qstereo, "encode", "--problem", *words, "--encoding", "domain-wall", "-o", file)
    p = qb.load(file)
    linear, (row, column, bias), offset = p.to_bqm().to_numpy_vectors(range(len(p)))
    linear = np.array(linear)
    np.add.at(linear, row, bias)  # b x y = -b x (1 - y) + b x
    graph = maxflow.Graph[float](len(p), len(row))
    graph.add_nodes(len(p))
    graph.add_edges(row, column, -np.array(bias), np.zeros(len(row)))
    graph.add_grid_tedges(np.arange(len(p)), np.maximum(0, -linear), np.maximum(0, linear))
    return float(graph.maxflow() + np.minimum(0, linear).sum() + offset) / p.scale


def grab_cut(data, name):
    """The mean IoU of both classes by cv2.grabCut from the same boxes, or None without OpenCV."""
    try:
        import cv2
    except ImportError:
        return None
    folder = data / "segmentation" / name
    truth = np.array(Image.open(folder / "truth.png")) > 0
    mask = np.full(truth.shape, cv2.GC_BGD, np.uint8)
    for x, y, width, height in json.loads((folder / "boxes.json").read_text())["boxes"]:
        mask[y : y + height, x : x + width] = cv2.GC_PR_FGD
    cv2.setRNGSeed(0)
    cv2.grabCut(cv2.imread(str(folder / "photo.png")), mask, None, np.zeros((1, 65)),
                np.zeros((1, 65)), 3, cv2.GC_INIT_WITH_MASK)
    found = mask % 2 == 1
    return [float((a & b).sum() / (a | b).sum()) for a, b in ((~found, ~truth), (found, truth))]


def segmentation(qstereo, data, name, folder):
    """`segment` beside the other programs, on one photograph."""
    _, command = pedestrians(data, name, folder)
    at = command.index("--rounds")
    once = call(qstereo, *command[:at], *command[at + 2 :])
    thrice = call(qstereo, *command)
    return {"input": name, "energy": once["energy"],
            "pymaxflow_energy": cut_energy(qstereo, command[:at] + command[at + 2 :], folder),
            "iou": [of["iou"] for of in thrice["classes"]], "grab_cut_iou": grab_cut(data, name)}


def solve(qstereo, name, command):
    facts = call(qstereo, *command, "--time-limit", TIME_LIMIT)
    keys = ("energy", "lower_bound", "proven_optimal", "seconds")
    return {"input": name, "problem": command[0], **{key: facts[key] for key in keys},
            "kept": facts.get("kept"),
            "scores": {key: facts[key] for key in SCORES if facts.get(key) is not None}}


def iou(a, b):
    width = min(a[0] + a[2], b[0] + b[2]) - max(a[0], b[0])
    height = min(a[1] + a[3], b[1] + b[3]) - max(a[1], b[1])
    shared = max(0, width) * max(0, height)
    return shared / (a[2] * a[3] + b[2] * b[3] - shared)


def suppress(rows, threshold):
    """Greedy: by falling score, drop what overlaps a kept box; boxes of score 0 and less too."""
    kept = []
    for row in sorted(rows, key=lambda row: -float(row["score"])):
        box = [float(row[name]) for name in ("x", "y", "width", "height")]
        if float(row["score"]) > 0 and all(
            other["picture"] != row["picture"] or iou(box, place) <= threshold
            for other, place in kept
        ):
            kept.append((row, box))
    return [row for row, _ in kept]


def greedy(qstereo, data, folder):
    boxes = data / "detection" / "pedestrians" / "boxes.csv"
    with boxes.open() as file:
        rows = list(csv.DictReader(file))
    found = []
    for threshold in THRESHOLDS:
        with (folder / "greedy.csv").open("w") as file:
            writer = csv.DictWriter(file, rows[0])
            writer.writeheader()
            writer.writerows(suppress(rows, threshold))
        facts = call(qstereo, "score", folder / "greedy.csv", boxes.with_name("truth.csv"), "--as",
                     "boxes")
        found.append({"threshold": threshold,
                      **{key: facts[key] for key in ("boxes", "precision", "recall", "ap")}})
    return found


def main():
    options = arguments(__doc__)
    with tempfile.TemporaryDirectory() as name, Figures(options.figures, "problems") as figures:
        folder = Path(name)
        figures["runs"] = [solve(options.qstereo, *run) for run in samples(folder)]
        figures["ways"] = [way(options, command, folder) for _, command in samples(folder)]
        data = options.data.parent if options.data else None
        if data and (data / "segmentation").is_dir():
            figures["runs"] += [solve(options.qstereo, *run) for run in real(data, folder)]
            figures["cuts"] = [segmentation(options.qstereo, data, name, folder)
                               for name in ("ped1", "ped2")]
            figures["greedy"] = greedy(options.qstereo, data, folder)


if __name__ == "__main__":
    main()
