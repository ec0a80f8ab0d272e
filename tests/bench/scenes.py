"""What the benchmarks share: scenes, calls of the commands, and the files that hold the figures."""

import argparse
import datetime
import json
import os
import platform
import subprocess
import time
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).parents[2]
SAMPLES = ROOT / "samples" / "rendered"
# Of each scene the least and the largest disparity.
DISPARITIES = {"tsukuba": (0, 15), "venus": (0, 19), "bull": (0, 19), "sawtooth": (0, 19),
               "barn1": (0, 19), "rendered": (2, 14)}
LAMBDA, WINDOW = 20, 100


def arguments(description, **more):
    """The options of every benchmark, parsed. `more` names options of this one, with their help."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--data", type=Path,
                        help="folder of scenes with left.png and right.png (default: the sample)")
    parser.add_argument("--figures", type=Path, default=ROOT / "build" / "figures",
                        help="folder that the file of figures goes to (default build/figures)")
    parser.add_argument("--build", type=Path, default=ROOT / "build",
                        help="where make has built (default build)")
    parser.add_argument("--bridge", type=Path, default=ROOT / ".venv" / "bin" / "qstereo-bridge")
    for name, words in more.items():
        parser.add_argument(f"--{name}", help=words)
    options = parser.parse_args()
    options.qstereo = options.build / "qstereo"
    return options


def scenes_of(data):
    """The folders of `data` whose disparities are known; without data the sample pair alone."""
    if not data:
        return [SAMPLES]
    return [data / name for name in DISPARITIES if (data / name / "left.png").exists()]


def disparities(scene):
    return DISPARITIES[scene.name]


def pair(scene, window=False):
    """The arguments of `encode` for a scene, or for its central window."""
    least, most = disparities(scene)
    chosen = [scene / "left.png", scene / "right.png", "--disparity", f"{least}:{most}",
              "--lambda", LAMBDA]
    if window:
        width, height = Image.open(scene / "left.png").size
        corner = f"{(width - WINDOW) // 2},{(height - WINDOW) // 2}"
        chosen += ["--roi", f"{corner},{WINDOW},{WINDOW}"]
    return chosen


def call(*words):
    """What a command says as JSON."""
    command = [str(word) for word in (*words, "--json")]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def measured_call(*words):
    """(what a command says as JSON, its seconds, its peak memory in MiB)."""
    command = [str(word) for word in (*words, "--json")]
    begin = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    said, errors = process.stdout.read(), process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise subprocess.CalledProcessError(process.returncode, command, said, errors)
    return json.loads(said), time.perf_counter() - begin, usage.ru_maxrss / 1024


def machine():
    """Where the figures come from. The load says how much else the machine did at the beginning."""
    cpu = Path("/proc/cpuinfo")
    names = [line.split(":", 1)[1].strip() for line in cpu.read_text().splitlines()
             if line.startswith("model name")] if cpu.exists() else []
    compiler = subprocess.run(["cc", "--version"], capture_output=True, text=True).stdout
    return {"processor": names[0] if names else platform.machine(), "cores": os.cpu_count(),
            "system": platform.system(), "compiler": (compiler.splitlines() or ["unknown"])[0],
            "python": platform.python_version(), "load": round(os.getloadavg()[0], 1)}


class Figures:
    """The figures of one benchmark. `with Figures(...) as figures` writes them at the end, unless
    the benchmark failed."""

    def __init__(self, folder, name, command="make bench"):
        self.path = folder / f"{name}.json"
        self.head = {"date": datetime.date.today().isoformat(), "command": command,
                     "machine": machine()}
        self.values = {}

    def __enter__(self):
        print(f"{self.path.stem} ...", flush=True)
        return self.values

    def __exit__(self, failure, *_):
        if failure is None:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            text = json.dumps({**self.head, "figures": self.values}, indent=1)
            self.path.write_text(text + "\n")


def figures_of_program(name, description):
    """A benchmark whose program build/bench_NAME prints its runs as JSON."""
    options = arguments(description)
    with Figures(options.figures, name) as figures:
        done = subprocess.run([options.build / f"bench_{name}"], check=True, capture_output=True)
        figures["runs"] = json.loads(done.stdout)
