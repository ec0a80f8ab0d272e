#!/usr/bin/env python3
"""Render the sample stereo pair and its exact disparities.

    generate.py              write left.png, right.png and truth.png beside this file
    generate.py --pnm DIR    write left.ppm, right.ppm and truth.pgm into DIR instead

Every surface is a plane, d = a x + b y + c in pixels of the left picture, cut out by a mask. A
scene point seen at (x, y) on the left is seen at (x - d, y) on the right; where several surfaces
meet a pixel, the nearest (largest d) hides the others. So the disparities are exact and occlusion
is real.

The pixels are meant to outlive library versions: numpy's RandomState is frozen, and no sine, root
or power, which differ from one mathematics library to the next, touches a colour.
"""
import argparse
import pathlib

import numpy as np
from PIL import Image

WIDTH, HEIGHT, SCALE = 200, 150, 8
HORIZON, CENTRE = 72.0, 100.0       # the point that the camera looks at
LIGHT = (-50.0, -45.0, 27.0)        # x, y and disparity of the lamp
HERE = pathlib.Path(__file__).resolve().parent


# Textures: colour (r, g, b) at the surface coordinates (u, v)

def noise(seed, u, v, octaves=4, roughness=0.6):
    """Band-limited noise in about -1..1; the first octave has one lattice cell per unit."""
    total, amplitude, norm = 0.0, 1.0, 0.0
    for octave in range(octaves):
        lattice = np.random.RandomState(100 * seed + octave).random_sample((64, 64)) * 2 - 1
        i, j = np.floor(u).astype(int), np.floor(v).astype(int)
        s, t = u - i, v - j
        s, t = s * s * (3 - 2 * s), t * t * (3 - 2 * t)
        at = lambda di, dj: lattice[(j + dj) % 64, (i + di) % 64]
        total = total + amplitude * ((at(0, 0) * (1 - s) + at(1, 0) * s) * (1 - t)
                                     + (at(0, 1) * (1 - s) + at(1, 1) * s) * t)
        norm += amplitude
        amplitude *= roughness
        u, v = 2 * u + 17.3, 2 * v + 5.7    # the shift keeps octaves from sharing lattice points
    return total * (1.6 / norm)


def mix(t, *colours):
    """The colour at t in 0..1 along a list of colours."""
    t = np.clip(t, 0, 1) * (len(colours) - 1)
    return tuple(np.interp(t, range(len(colours)), channel) for channel in zip(*colours))


def times(colour, factor):
    """A colour made darker or brighter."""
    return tuple(channel * factor for channel in colour)


def plaster(u, v):
    """The wall: little texture, which leaves the matcher to the smoothness term."""
    t = 0.5 + 0.22 * noise(1, u / 9, v / 9, 3) + 0.20 * noise(2, u * 0.9, v * 0.9, 2)
    return mix(t, (52, 88, 104), (92, 136, 146), (136, 172, 172))


def planks(u, v):
    row = np.floor(u / 2.6)
    along = v + 3.7 * (row % 5)
    tone = 0.5 + 0.35 * noise(3, row * 1.618, np.floor(along / 5.0) * 2.414, 1) \
        + 0.42 * noise(4, u * 2.2, along * 2.0, 4, 0.75)
    gap = (u / 2.6 - row < 0.06) | (along / 5.0 - np.floor(along / 5.0) < 0.03)
    return times(mix(tone, (88, 50, 28), (164, 106, 62), (222, 172, 116)), np.where(gap, 0.45, 1.0))


def picture(u, v):
    """A painting of coloured contour bands, in a frame."""
    height = 2.6 * noise(5, u / 5 + 3.1, v / 5, 4, 0.5) + 0.12 * v
    band = mix((height / 4) % 1.0, (246, 226, 172), (232, 142, 70), (176, 54, 58), (62, 44, 92),
               (246, 226, 172))
    return times(band, 1 + 0.14 * noise(6, u * 1.5, v * 1.5, 2))


def wood_frame(u, v):
    return mix(0.5 + 0.5 * noise(7, u * 1.5, v * 1.5, 3), (40, 26, 22), (98, 66, 44))


def gift(u, v):
    """Wrapping paper: diagonal stripes on a mottled ground."""
    stripe = ((u + 0.7 * v) / 1.7) % 1.0
    ground = mix(0.5 + 0.6 * noise(8, u * 1.1, v * 1.1, 5, 0.7), (150, 30, 38), (208, 58, 52),
                 (240, 112, 84))
    ribbon = mix(0.5 + 0.6 * noise(9, u * 1.4, v * 1.4, 4), (222, 190, 120), (252, 240, 204))
    return tuple(np.where(stripe < 0.3, r, g) for r, g in zip(ribbon, ground))


def crate(u, v):
    check = (np.floor(u / 1.1) + np.floor(v / 1.1)) % 2
    tone = 0.18 + 0.44 * check + 0.40 * noise(10, u * 1.6, v * 1.6, 4, 0.7)
    return mix(tone, (26, 40, 92), (58, 96, 166), (220, 226, 232))


def plate(u, v):
    r2 = (u - 4.72) ** 2 + (v - 1.10) ** 2
    ring = mix(r2 / 5.4, (250, 214, 96), (244, 232, 206), (70, 130, 96), (244, 232, 206),
               (214, 96, 60), (120, 40, 40))
    return times(ring, 1 + 0.42 * noise(11, u * 1.6, v * 1.6, 4, 0.8))


def leaf(u, v):
    vein = np.where((u * 1.5 + v * 2.2) % 1 < 0.25, 1, 0)
    tone = 0.45 + 0.55 * noise(12, u * 2.5, v * 1.2, 5, 0.7) + 0.15 * vein
    return mix(tone, (18, 58, 26), (66, 128, 44), (190, 214, 96))


# Masks: which points of a plane are there

def polygon(*points):
    """Even-odd rule."""
    def inside(x, y):
        odd = np.zeros(np.shape(x), bool)
        for (x0, y0), (x1, y1) in zip(points, points[1:] + points[:1]):
            if y0 != y1:
                odd ^= ((y < y0) != (y < y1)) & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
        return odd
    return inside


def ellipse(cx, cy, rx, ry):
    return lambda x, y: ((x - cx) / rx) ** 2 + ((y - cy) / ry) ** 2 < 1


def upright(x0, x1, a, c, top, texture):
    """A standing face between two columns. Its top is level in space, so it keeps top * d above the
    horizon; its foot is wherever the floor comes to lie before it."""
    y0, y1 = (HORIZON - top * (a * x + c) for x in (x0, x1))
    return (a, 0, c), polygon((x0, y0), (x1, y1), (x1, 400), (x0, 400)), texture, (0, 1)


# The scene: plane (a, b, c), mask, texture, and the two axes of space (X, Y, Z) of the texture
FLOOR, LID = 0.150, 0.245     # disparity per row below the horizon, of two level planes
EVERYWHERE = ellipse(0, 0, 1e6, 1e6)
SCENE = [
    ((0.010, 0, 2.3), EVERYWHERE, plaster, (0, 1)),
    ((0, FLOOR, -FLOOR * HORIZON), EVERYWHERE, planks, (0, 2)),
    ((0.010, 0, 2.6), polygon((108, 12), (172, 9), (172, 56), (108, 54)), wood_frame, (0, 1)),
    ((0.010, 0, 2.6), polygon((112, 16), (168, 13.4), (168, 52), (112, 50.2)), picture, (0, 1)),
    upright(38, 62, 0.090, 2.92, 5.4, gift),
    upright(62, 92, -0.050, 11.6, 5.4, gift),
    upright(112, 166, -0.006, 10.2, -1 / LID, crate),
    ((0, LID, -LID * HORIZON),
     polygon((112, 110.89), (166, 109.57), (155, 99), (117, 100)), crate, (0, 2)),
    ((0.020, 0.01, 4.6), ellipse(137, 81, 19, 24), plate, (0, 1)),
    ((0.030, -0.02, 10.0),
     polygon((196, 160), (178, 128), (172, 104), (174, 82), (184, 100), (192, 124), (206, 160)),
     leaf, (0, 1)),
    ((-0.020, 0.02, 14.6),
     polygon((190, 160), (186, 132), (189, 108), (198, 90), (212, 80), (208, 112), (202, 160)),
     leaf, (0, 1)),
    ((0.050, -0.02, 14.0),
     polygon((22, 160), (15, 132), (17, 112), (25, 96), (31, 116), (30, 138), (36, 160)),
     leaf, (0, 1)),
    ((0.020, -0.01, 12.6),
     polygon((26, 160), (32, 138), (42, 124), (57, 116), (53, 134), (44, 148), (36, 160)),
     leaf, (0, 1)),
]


def visible(x_view, y, right):
    """The nearest surface at each pixel of a view: its number, left-view x and disparity."""
    number, at_x, nearest = np.zeros(y.shape, int), np.zeros(y.shape), np.full(y.shape, -1.0)
    for n, ((a, b, c), mask, _, _) in enumerate(SCENE):
        x = (x_view + b * y + c) / (1 - a) if right else x_view     # solves x_view = x - d(x, y)
        d = a * x + b * y + c
        front = mask(x, y) & (d >= nearest)     # of equals, the later one (a painting in its frame)
        number[front], at_x[front], nearest[front] = n, x[front], d[front]
    return number, at_x, nearest


def lit(number, x, y, d, light):
    """Where no surface stands between a point and the light. Straight lines of space are straight
    in (x, y, disparity) too, so the shadow ray meets a plane by one division."""
    free = np.ones(x.shape, bool)
    for n, ((a, b, c), mask, _, _) in enumerate(SCENE):
        here, there = d - (a * x + b * y + c), light[2] - (a * light[0] + b * light[1] + c)
        t = here / np.where(here == there, 1, here - there)
        between = (number != n) & (t > 1e-3) & (t < 1)
        free &= ~(between & mask(x + t * (light[0] - x), y + t * (light[1] - y)))
    return free


def render(right):
    """One view's colours. Each of the 4 x 4 samples of a pixel sees its own part of the lamp."""
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    total = np.zeros((HEIGHT, WIDTH, 3))
    # What faces left faces the lamp.
    shade = np.array([0.94 + 1.6 * plane[0] for plane, _, _, _ in SCENE])
    for k in range(16):
        y = rows + (k // 4 - 1.5) / 4
        number, x, d = visible(columns + (k % 4 - 1.5) / 4, y, right)
        part = 7 * k % 16
        lamp = (LIGHT[0] + 6 * (part // 4 - 1.5), LIGHT[1] + 6 * (part % 4 - 1.5), LIGHT[2])
        light = np.where(lit(number, x, y, d, lamp), 1.0, 0.58) * shade[number]
        space = (x - CENTRE) / d, (y - HORIZON) / d, 100 / d
        for n, (_, _, texture, (i, j)) in enumerate(SCENE):
            here = number == n
            colour = texture(space[i][here], space[j][here])
            for channel in range(3):
                total[here, channel] += colour[channel] * light[here] / 16
    return total


def develop(colours, seed, gain, offset):
    """8-bit picture of a camera with its own gain, offset and sensor noise (of 1.2 grey levels)."""
    grain = np.random.RandomState(seed).random_sample((3,) + colours.shape)
    grain = 2.4 * (grain[0] + grain[1] + grain[2] - 1.5)
    return np.floor(np.clip(gain * colours + offset + grain, 0, 255) + 0.5).astype(np.uint8)


def pictures():
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    truth = visible(columns, rows, False)[2]
    return {"left": develop(render(False), 1, 1.0, 0.0),
            "right": develop(render(True), 2, 1.01, -1.0),
            "truth": np.floor(truth * SCALE + 0.5).astype(np.uint8)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--pnm", metavar="DIR", type=pathlib.Path,
                        help="write PPM and PGM files into DIR")
    options = parser.parse_args()
    folder = options.pnm or HERE
    folder.mkdir(parents=True, exist_ok=True)
    for name, pixels in pictures().items():
        pnm = ".ppm" if pixels.ndim == 3 else ".pgm"
        Image.fromarray(pixels).save(folder / (name + (pnm if options.pnm else ".png")),
                                     optimize=True)


if __name__ == "__main__":
    main()
