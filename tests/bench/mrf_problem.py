"""An instance of the Middlebury MRF benchmark as a .qcf, or as arrays for `qstereo label`.

    python tests/bench/mrf_problem.py NAME FOLDER -o P.qcf [--pack build/pack_problem]
    python tests/bench/mrf_problem.py NAME FOLDER --arrays OUT

NAME is house, tsukuba, venus or pano. FOLDER has the instance's pictures (house: input.png,
mask.png; pano: NQIMG_*; the others: left.png, right.png). The energies are those of the benchmark
(Szeliski et al., PAMI 30(6), 2008). --arrays writes them into the folder OUT as .npy files, and
prints the arguments of `qstereo label`; pano needs it. Other benchmarks import `write` with arrays
of their own. `make build/pack_problem` first.
"""

import argparse
import subprocess
from pathlib import Path

import numpy as np
from PIL import Image

POTTS, LINEAR, QUADRATIC, TABLE = range(4)


def write(
    path,
    costs,
    smoothness,
    weight,
    truncation=0,
    table=None,
    right=None,
    down=None,
    pack="build/pack_problem",
):
    """Writes a grid problem as a .qcf.

    costs        (height, width, labels), integers
    smoothness   POTTS, LINEAR, QUADRATIC or TABLE, with truncation (0 = none) or table
                 (labels, labels)
    weight       of every edge, unless there are
    right, down  (height, width) each: weight of the edge to the right neighbour (last column
                 unused), and to the lower one
    """
    height, width, labels = costs.shape
    header = [width, height, labels, smoothness, truncation, weight, right is not None]
    parts = [np.array(header), costs]
    parts += [part for part in (table, right, down) if part is not None]
    with open(path, "wb") as out:
        data = b"".join(np.ascontiguousarray(part, np.int32).tobytes() for part in parts)
        subprocess.run([str(pack)], input=data, stdout=out, check=True)


def picture(path):
    return np.asarray(Image.open(path)).astype(np.int64)


def colours(path):
    return np.asarray(Image.open(path).convert("RGB")).astype(np.int64)


def house(folder):
    """Restoration: 256 greys, squared differences, all convex. No data where the mask is 0."""
    grey = picture(folder / "input.png")
    seen = picture(folder / "mask.png") > 0
    costs = (grey[..., None] - np.arange(256)) ** 2 * seen[..., None]
    return {"costs": costs, "smoothness": QUADRATIC, "weight": 5}


def halves(row):
    """Least and largest of each pixel and the points half way to its neighbours in its row."""
    between = (row[:, 1:] + row[:, :-1]) // 2
    before = np.concatenate([row[:, :1], between], axis=1)
    after = np.concatenate([between, row[:, -1:]], axis=1)
    three = np.stack([row, before, after])
    return three.min(axis=0), three.max(axis=0)


def birchfield_tomasi(left, right, d):
    """Birchfield and Tomasi's measure of each channel at disparity d, for the columns from d on."""
    low_left, high_left = halves(left)
    low_right, high_right = halves(right)
    end = right.shape[1] - d
    l, r = left[:, d:], right[:, :end]
    there = np.maximum(0, np.maximum(l - high_right[:, :end], low_right[:, :end] - l))
    back = np.maximum(0, np.maximum(r - high_left[:, d:], low_left[:, d:] - r))
    return np.minimum(there, back)


def stereo(folder, labels, power, most):
    left, right = colours(folder / "left.png"), colours(folder / "right.png")
    costs = np.full((*left.shape[:2], labels), most)
    for d in range(labels):
        apart = (birchfield_tomasi(left, right, d) ** power).sum(axis=-1)
        costs[:, d:, d] = np.minimum(most, apart)
    return left, costs


def tsukuba(folder):
    left, costs = stereo(folder, 16, 1, 765)
    right, down = (np.full(left.shape[:2], 20) for _ in range(2))
    right[:, :-1][((left[:, 1:] - left[:, :-1]) ** 2).sum(axis=-1) < 3 * 8**2] = 40
    down[:-1][((left[1:] - left[:-1]) ** 2).sum(axis=-1) < 3 * 8**2] = 40
    weights = {"weight": 0, "right": right, "down": down}
    return {"costs": costs, "smoothness": LINEAR, "truncation": 2, **weights}


def venus(folder):
    _, costs = stereo(folder, 20, 2, 256)
    return {"costs": costs, "smoothness": QUADRATIC, "truncation": 7, "weight": 50}


def pano(folder):
    """Stitching: a label a picture, and a table an edge: how far two pictures' colours are apart
    at both its ends."""
    seen = np.stack([colours(path) for path in sorted(folder.glob("NQIMG_*"))]).astype(np.float32)
    missing = (seen == 0).all(axis=-1)
    nowhere = missing.all(axis=0)
    count = len(seen)
    apart = np.stack([np.sqrt(((seen - other) ** 2).sum(axis=-1)) for other in seen])

    def tables(p, q):
        costs = (np.floor(apart[:, :, *p] + apart[:, :, *q]) + 1).astype(np.int32)
        at_p, at_q = missing[:, *p], missing[:, *q]
        costs[at_p[:, None] | at_p[None] | at_q[:, None] | at_q[None]] = 100_000
        costs[at_p[:, None] & at_q[None]] = 0
        costs[:, :, nowhere[p] | nowhere[q]] = 0
        costs[range(count), range(count)] = 0
        return costs.transpose(2, 3, 0, 1)

    every, first, last = slice(None), slice(None, -1), slice(1, None)
    costs = np.where(missing & ~nowhere, 100_000, 0).transpose(1, 2, 0)
    both = (tables((every, first), (every, last)), tables((first, every), (last, every)))
    return {"costs": costs, "tables": both}


INSTANCES = {"house": house, "tsukuba": tsukuba, "venus": venus, "pano": pano}
KINDS = {POTTS: "potts", LINEAR: "linear", QUADRATIC: "quadratic"}


def arrays(out, costs, smoothness=None, weight=1, truncation=0, right=None, down=None, tables=None):
    """Writes the instance as arrays. Returns the arguments of `qstereo label`."""

    def save(name, array):
        np.save(out / f"{name}.npy", np.ascontiguousarray(array, np.int32))
        return str(out / f"{name}.npy")

    arguments = [save("costs", costs)]
    if smoothness is not None:
        arguments += ["--smoothness", KINDS[smoothness]]
    if truncation:
        arguments += ["--truncation", str(truncation)]
    if right is not None:
        both = save("right", right[:, :-1]), save("down", down[:-1])
        arguments += ["--weights", ",".join(both)]
    elif weight != 1:
        arguments += ["--lambda", str(weight)]
    if tables is not None:
        both = save("right", tables[0]), save("down", tables[1])
        arguments += ["--tables", ",".join(both)]
    return arguments


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("name", choices=INSTANCES)
    parser.add_argument("folder", type=Path)
    to = parser.add_mutually_exclusive_group(required=True)
    to.add_argument("-o", "--output", type=Path, help="the .qcf to write")
    to.add_argument("--arrays", type=Path, help="the folder to write arrays into")
    parser.add_argument("--pack", default="build/pack_problem", help="the built pack_problem.c")
    given = parser.parse_args()
    instance = INSTANCES[given.name](given.folder)
    if given.arrays:
        print(*arrays(given.arrays, **instance))
        return
    if "tables" in instance:
        parser.error(f"{given.name} has tables, which -o cannot hold: give --arrays")
    write(given.output, **instance, pack=given.pack)


if __name__ == "__main__":
    main()
