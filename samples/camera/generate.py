#!/usr/bin/env python3
"""Render a sequence of a pair of calibrated cameras, as the cameras themselves take it, with the
exact disparities of the rectified left picture.

    generate.py              write the pictures, stereo.yml and the truth beside this file
    generate.py --pnm DIR    write PGM files and stereo.yml into DIR instead

The scene stands in the rectified left camera's space, in metres: x right, y down, z forward. It is
a wall, a floor and two balls of which one rolls. Each pixel of a camera sends rays out through its
lens, and a ray meets a surface where the surface says, so nothing is interpolated.
"""
import argparse
import pathlib

import numpy as np
from PIL import Image

WIDTH, HEIGHT, FRAMES = 160, 120, 3
FOCAL, CENTRE, BASELINE = 150.0, (79.5, 59.5), 0.1  # of the rectified cameras
TRUTH_SCALE = 256
BRIGHTNESS = {1: 130, 2: 90, 3: 220, 4: 190}  # of the surfaces, by the seeds of their textures
HERE = pathlib.Path(__file__).resolve().parent
CAMERAS = [  # matrix, distortion, and the angles by which the rectified camera turns from this one
    (np.array([[141.0, 0, 81.0], [0, 140.0, 58.0], [0, 0, 1]]),
     np.array([-0.21, 0.06, 0.0012, -0.0009, 0.0]), (0.011, -0.016, 0.009)),
    (np.array([[143.0, 0, 77.5], [0, 142.5, 61.0], [0, 0, 1]]),
     np.array([-0.19, 0.05, -0.0008, 0.0011, 0.0]), (-0.009, 0.013, -0.012)),
]


def turn(angles):
    """The rotation about x, then y, then z."""
    result = np.eye(3)
    for axis, angle in enumerate(angles):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        step = np.eye(3)
        step[i, i] = step[j, j] = np.cos(angle)
        step[j, i] = np.sin(angle)
        step[i, j] = -step[j, i]
        result = step @ result
    return result


def calibration():
    """The matrices by the names that OpenCV's samples give them."""
    first, second = (turn(angles) for _, _, angles in CAMERAS)
    shift = np.array([-BASELINE, 0, 0])
    projection = np.array([[FOCAL, 0, CENTRE[0], 0], [0, FOCAL, CENTRE[1], 0], [0, 0, 1.0, 0]])
    moved = projection.copy()
    moved[0, 3] = -FOCAL * BASELINE
    return {
        "K1": CAMERAS[0][0], "D1": CAMERAS[0][1][None], "K2": CAMERAS[1][0],
        "D2": CAMERAS[1][1][None], "R": second.T @ first, "T": (second.T @ shift)[:, None],
        "R1": first, "R2": second, "P1": projection, "P2": moved,
    }


def storage(matrices):
    """The text of a file of OpenCV's FileStorage."""
    lines = ["%YAML:1.0", "---", f"image_width: {WIDTH}", f"image_height: {HEIGHT}"]
    for name, matrix in matrices.items():
        rows, columns = matrix.shape
        numbers = [repr(float(value)) for value in matrix.ravel()]
        lines += [f"{name}: !!opencv-matrix", f"   rows: {rows}", f"   cols: {columns}",
                  "   dt: d", "   data: [ " + ",\n       ".join(numbers) + " ]"]
    return "\n".join(lines) + "\n"


def rays(side, x, y):
    """The directions, in the rectified camera, of what a camera sees at pixels of its picture."""
    (k, (k1, k2, p1, p2, k3), _), rotation = CAMERAS[side], turn(CAMERAS[side][2])
    bent = (x - k[0, 2]) / k[0, 0], (y - k[1, 2]) / k[1, 1]
    u, v = bent
    for _ in range(60):  # far more than a fixed point needs
        r2 = u * u + v * v
        factor = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        u, v = ((bent[0] - 2 * p1 * u * v - p2 * (r2 + 2 * u * u)) / factor,
                (bent[1] - p1 * (r2 + 2 * v * v) - 2 * p2 * u * v) / factor)
    return np.stack([u, v, np.ones_like(u)], axis=-1) @ rotation.T


def noise(seed, u, v):
    """Smooth noise of four octaves in 0..1."""
    total = np.zeros(np.shape(u))
    for octave in range(4):
        lattice = np.random.RandomState(100 * seed + octave).random_sample((64, 64))
        i, j = np.floor(u).astype(int), np.floor(v).astype(int)
        s, t = u - i, v - j
        at = lambda di, dj: lattice[(j + dj) % 64, (i + di) % 64]
        total += 0.25 * ((at(0, 0) * (1 - s) + at(1, 0) * s) * (1 - t)
                         + (at(0, 1) * (1 - s) + at(1, 1) * s) * t)
        u, v = 2 * u + 17.3, 2 * v + 5.7
    return total


def scene(frame):
    """Surfaces of a frame: the distance along a ray (infinite = not met) and the texture's seed."""
    def plane(normal, offset):
        def meet(start, ray):
            slope = ray @ normal
            with np.errstate(divide="ignore", invalid="ignore"):
                t = (offset - start @ normal) / slope
            return np.where(t > 0, t, np.inf)
        return meet

    def ball(centre, radius):
        def meet(start, ray):
            away = start - centre
            a, b, c = (ray * ray).sum(-1), ray @ away, away @ away - radius**2
            root = b * b - a * c
            t = (-b - np.sqrt(np.maximum(root, 0))) / a
            return np.where((root > 0) & (t > 0), t, np.inf)
        return meet

    return [(plane(np.array([0.12, 0, 1.0]), 2.4), 1), (plane(np.array([0, 1.0, 0]), 0.42), 2),
            (ball(np.array([-0.38 + 0.1 * frame, 0.2, 1.3]), 0.22), 3),
            (ball(np.array([0.36, 0.12, 1.7]), 0.3), 4)]


def look(frame, start, ray):
    """The distance along rays, and the grey that is seen there."""
    nearest = np.full(ray.shape[:-1], np.inf)
    grey = np.zeros(ray.shape[:-1])
    for meet, seed in scene(frame):
        t = meet(start, ray)
        front = t < nearest
        x, y, z = (start + ray[front] * t[front][:, None]).T
        u, v = (x, z) if seed == 2 else (x + 0.3 * z, y)
        tone = np.clip(1.7 * noise(seed, 14 * u + 9, 14 * v + 9) - 0.35, 0, 1)
        grey[front] = 25 + BRIGHTNESS[seed] * tone
        nearest = np.where(front, t, nearest)
    return nearest, grey


def photograph(frame, side):
    """What a camera takes: a mean of 3 x 3 rays a pixel, and some grain."""
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(float)
    start = np.array([side * BASELINE, 0, 0])
    total = sum(look(frame, start, rays(side, x + (k % 3 - 1) / 3, y + (k // 3 - 1) / 3))[1]
                for k in range(9)) / 9
    grain = np.random.RandomState(10 * frame + side).random_sample((HEIGHT, WIDTH)) * 3 - 1.5
    return np.floor(np.clip(total + grain, 0, 255) + 0.5).astype(np.uint8)


def disparities(frame):
    """Those of the rectified left picture, in pixels."""
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(float)
    ray = np.stack([(x - CENTRE[0]) / FOCAL, (y - CENTRE[1]) / FOCAL, np.ones_like(x)], axis=-1)
    return FOCAL * BASELINE / look(frame, np.zeros(3), ray)[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--pnm", metavar="DIR", type=pathlib.Path, help="write PGM files into DIR")
    options = parser.parse_args()
    folder, kind = options.pnm or HERE, "pgm" if options.pnm else "png"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "stereo.yml").write_text(storage(calibration()))
    for frame in range(FRAMES):
        held = np.floor(disparities(frame) * TRUTH_SCALE + 0.5).astype(np.uint16)
        for name, pixels in (("left", photograph(frame, 0)), ("right", photograph(frame, 1)),
                             ("truth", held)):
            Image.fromarray(pixels).save(folder / f"{name}_{frame + 1:04}.{kind}", optimize=True)


if __name__ == "__main__":
    main()
