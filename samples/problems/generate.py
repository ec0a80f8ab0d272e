#!/usr/bin/env python3
"""Make one small input with its truth for each problem beside stereo.

    generate.py              write the files beside this file
    generate.py --pnm DIR    write the pictures as PGM and PPM into DIR, with the other files

Always the same: numpy's RandomState is frozen, and no function that differs from one mathematics
library to the next touches a number.
"""
import argparse
import pathlib

import numpy as np
from PIL import Image

SIZE = 64
HERE = pathlib.Path(__file__).resolve().parent


def texture(seed, height=SIZE, width=SIZE, cell=8):
    """Smooth noise from 0 to 1: a random lattice, interpolated bilinearly, and a finer one."""
    total = np.zeros((height, width))
    for octave, (step, weight) in enumerate([(cell, 0.6), (max(cell // 3, 2), 0.4)]):
        lattice = np.random.RandomState(100 * seed + octave).random_sample(
            (height // step + 2, width // step + 2)
        )
        y, x = np.mgrid[:height, :width] / step
        i, j = y.astype(int), x.astype(int)
        v, u = y - i, x - j
        total += weight * (
            (lattice[i, j] * (1 - u) + lattice[i, j + 1] * u) * (1 - v)
            + (lattice[i + 1, j] * (1 - u) + lattice[i + 1, j + 1] * u) * v
        )
    return total


def bell(seed, shape, spread):
    """Noise with about that standard deviation: a sum of uniform numbers."""
    return (np.random.RandomState(seed).random_sample((12, *shape)).sum(axis=0) - 6) * spread


def to_bytes(picture):
    return np.clip(np.floor(picture + 0.5), 0, 255).astype(np.uint8)


def disc(x, y, radius):
    rows, columns = np.mgrid[:SIZE, :SIZE]
    return (columns - x) ** 2 + (rows - y) ** 2 < radius * radius


def restore():
    """A few flat shapes with noise, a scratch through them, and the clean picture."""
    true = np.full((SIZE, SIZE), 80)
    true[disc(22, 24, 15)] = 200
    true[34:58, 36:56] = 140
    hole = np.zeros((SIZE, SIZE), bool)
    rows = np.arange(SIZE)
    for shift in range(3):
        hole[rows, np.clip(rows // 2 + 12 + shift, 0, SIZE - 1)] = True
    noisy = np.where(hole, 255, true + bell(1, true.shape, 18))
    return {"restore-noisy": noisy, "restore-hole": hole * 255, "restore-true": true}


def segment():
    """A patterned disc on a patterned ground, strokes on both, and the classes 1 and 2."""
    inside = disc(34, 30, 19)
    ground, body = texture(2), texture(3)
    photo = np.stack([60 + 70 * ground, 90 + 90 * ground, 50 + 60 * ground], axis=-1)
    photo[inside] = np.stack([120 + 110 * body, 70 + 70 * body, 60 + 60 * body], axis=-1)[inside]
    photo += bell(4, photo.shape, 12)
    strokes = np.zeros((SIZE, SIZE))
    strokes[4:7, 6:50] = strokes[56:59, 10:60] = 1
    strokes[24:38, 32:35] = 2
    return {"segment-photo": photo, "segment-strokes": strokes, "segment-true": 1 + inside}


def flow():
    """A ground that moves by (-1, 0), and a square on it by (3, -2): first(x) = second(x + d)."""
    ground, square = (255 * texture(seed, 96, 96, 5) for seed in (5, 6))
    first, second = ground[16:80, 16:80].copy(), ground[16:80, 17:81].copy()
    first[22:46, 18:42] = square[22:46, 18:42]
    second[20:44, 21:45] = square[22:46, 18:42]
    field = np.tile([-1.0, 0.0], (SIZE, SIZE, 1))
    field[22:46, 18:42] = [3, -2]
    return {"flow-first": first, "flow-second": second, "flow-true": field}


def sample(picture, x, y):
    i, j = np.floor(y).astype(int), np.floor(x).astype(int)
    v, u = y - i, x - j
    return (picture[i, j] * (1 - u) + picture[i, j + 1] * u) * (1 - v) + (
        picture[i + 1, j] * (1 - u) + picture[i + 1, j + 1] * u
    ) * v


def register():
    """A picture, bent by a smooth field: fixed(x) = moving(x + d)."""
    moving = 255 * texture(7, 96, 96, 7)
    y, x = np.mgrid[:SIZE, :SIZE] / (SIZE - 1) - 0.5
    field = np.stack([3 - 14 * y * y + 3 * x, -2 + 12 * x * x * x - 4 * x * y - 3 * y], axis=-1)
    rows, columns = np.mgrid[:SIZE, :SIZE] + 16.0
    fixed = sample(moving, columns + field[..., 0], rows + field[..., 1])
    return {
        "register-fixed": fixed + bell(8, fixed.shape, 2),
        "register-moving": moving[16:80, 16:80] + bell(9, fixed.shape, 2),
        "register-true": field,
    }


def detect():
    """True boxes in three pictures, and what a detector might make of them."""
    random = np.random.RandomState(10)
    truth, found = [], []
    for picture in range(1, 4):
        for _ in range(2 + picture):
            x, y = random.randint(0, 260), random.randint(0, 160)
            width, height = random.randint(30, 60), random.randint(50, 90)
            truth.append([picture, x, y, width, height])
            for _ in range(random.randint(2, 7)):
                off = random.randint(-9, 10, 4)
                score = 1.5 - 0.04 * abs(off).sum() + random.randint(-20, 21) / 100
                found.append([picture, x + off[0], y + off[1], width + off[2], height + off[3],
                              f"{score:.2f}"])
        for _ in range(4):
            found.append([picture, *random.randint(0, 250, 2), *random.randint(30, 80, 2),
                          f"{random.randint(-30, 40) / 100:.2f}"])
    names = "picture,x,y,width,height"
    return {
        "detect-boxes": (names + ",score", found),
        "detect-true": (names, truth),
    }


def label():
    """Costs of 4 labels at each cell: how far its noisy grey is from 4 greys. And a chain of three
    variables, as the UAI format has it."""
    greys = np.array([40, 100, 160, 220])
    noisy = 40 + 60 * np.floor(4 * texture(11, 24, 32)) + bell(12, (24, 32), 30)
    network = """\
MARKOV
3
2 2 2
5
1 0
1 1
1 2
2 0 1
2 1 2

2
 0.9 0.1

2
 0.4 0.6

2
 0.3 0.7

4
 0.8 0.2
 0.2 0.8

4
 0.7 0.3
 0.3 0.7
"""
    return {"label-costs": np.abs(np.floor(noisy)[..., None] - greys).astype("<i4"),
            "label-network": network}


def write(folder, name, made, pnm):
    if isinstance(made, str):
        (folder / f"{name}.uai").write_text(made)
    elif isinstance(made, tuple):
        rows = [made[0], *(",".join(map(str, row)) for row in made[1])]
        (folder / f"{name}.csv").write_text("\n".join(rows) + "\n")
    elif made.dtype == np.dtype("<i4"):
        np.save(folder / f"{name}.npy", made)
    elif made.shape[-1] == 2:
        head = b"PIEH" + np.array(made.shape[1::-1], "<i4").tobytes()
        (folder / f"{name}.flo").write_bytes(head + made.astype("<f4").tobytes())
    else:
        ending = "png" if not pnm else "pgm" if made.ndim == 2 else "ppm"
        Image.fromarray(to_bytes(made)).save(folder / f"{name}.{ending}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pnm", metavar="DIR", type=pathlib.Path)
    asked = parser.parse_args()
    for problem in (restore, segment, flow, register, detect, label):
        for name, made in problem().items():
            write(asked.pnm or HERE, name, made, asked.pnm)


if __name__ == "__main__":
    main()
