"""What the benchmarks share: the scenes, their disparities and windows, and calls of the commands."""

import json
import os
import subprocess
import time
from pathlib import Path

from PIL import Image

SAMPLES = Path(__file__).parents[2] / "samples" / "rendered"
# Of each scene the disparities; the others have 0 to 19.
DISPARITIES = {"tsukuba": (0, 15), "rendered": (2, 14)}
OTHERS = (0, 19)
LAMBDA, WINDOW = 20, 100


def scenes_of(data):
    """The folders of `data` that hold a pair; without data the sample pair alone."""
    return sorted(path.parent for path in data.glob("*/left.png")) if data else [SAMPLES]


def disparities(scene):
    return DISPARITIES.get(scene.name, OTHERS)


def pair(scene, window=False):
    """The arguments of `encode` for a scene, or for its central window."""
    least, most = disparities(scene)
    width, height = Image.open(scene / "left.png").size
    roi = ["--roi", f"{(width - WINDOW) // 2},{(height - WINDOW) // 2},{WINDOW},{WINDOW}"] if window else []
    return [scene / "left.png", scene / "right.png", "--disparity", f"{least}:{most}", "--lambda", LAMBDA, *roi]


def call(*arguments):
    """What a command says as JSON."""
    return json.loads(subprocess.run([str(a) for a in (*arguments, "--json")], check=True, capture_output=True, text=True).stdout)


def measured_call(*arguments):
    """(what a command says as JSON, its seconds, its peak memory in MiB)."""
    begin = time.perf_counter()
    process = subprocess.Popen([str(a) for a in (*arguments, "--json")], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    said = process.stdout.read()
    errors = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise subprocess.CalledProcessError(process.returncode, arguments, said, errors)
    return json.loads(said), time.perf_counter() - begin, usage.ru_maxrss / 1024
