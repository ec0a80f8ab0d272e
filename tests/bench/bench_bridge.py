"""The bridge's way from a .qcf to a BQM beside dimod's own from ready arrays: figures `bridge`.

    python tests/bench/bench_bridge.py [--figures DIR]

Each measurement runs in a process of its own. Seconds are the least of three runs. Memory is the
growth of the peak resident set over what the imports alone take.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scenes import ROOT, Figures, arguments

sys.path.insert(0, str(ROOT / "tests" / "bridge"))

SIZE, LABELS, RUNS = 177, 16, 3


def memory(key):
    """A line of /proc/self/status in MiB: VmRSS is now, VmHWM the peak.

    getrusage would count what the parent process had.
    """
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith(key)) / 1024


def bridge(folder):
    import dimod  # noqa: F401 - imported before the clock starts on either side
    from qstereo_bridge.core import models, qcf

    before, began = memory("VmRSS"), time.perf_counter()
    with open(Path(folder, "p.qcf"), "rb") as stream:
        bqm = models.to_bqm(qcf.read_qcf(stream))
    print(time.perf_counter() - began, memory("VmHWM") - before, len(bqm))


def alone(folder):
    """from_numpy_vectors on ready arrays, which count in its memory and not in its time."""
    import dimod

    before = memory("VmRSS")
    linear, rows, columns, values = (np.load(Path(folder, f"{name}.npy")) for name in "lrcv")
    began = time.perf_counter()
    bqm = dimod.BinaryQuadraticModel.from_numpy_vectors(linear, (rows, columns, values), 0.0,
                                                        "BINARY")
    print(time.perf_counter() - began, memory("VmHWM") - before, len(bqm))


def best(mode, folder):
    """(least seconds, least MiB) of RUNS runs."""
    command = [sys.executable, __file__, mode, folder]
    said = [subprocess.run(command, check=True, text=True, capture_output=True).stdout.split()
            for _ in range(RUNS)]
    return tuple(min(float(words[at]) for words in said) for at in (0, 1))


def measure(dense, folder):
    from problems import grid, pack_qcf
    from qstereo_bridge.core import models, qcf

    problem = grid(SIZE, SIZE, LABELS, dense)
    data = pack_qcf(problem)
    Path(folder, "p.qcf").write_bytes(data)
    linear, (rows, columns, values), _ = models.expand(problem)
    arrays = {"l": linear.astype(float), "r": rows, "c": columns, "v": values.astype(float)}
    for name, array in arrays.items():
        np.save(Path(folder, f"{name}.npy"), array)
    (ours, our_memory), (theirs, their_memory) = best("bridge", folder), best("alone", folder)
    return {"size": SIZE, "labels": LABELS, "encoding": "one-hot" if dense else "one-hot-sparse",
            "variables": int(linear.size), "terms": int(rows.size), "qcf_bytes": len(data),
            "bqm_bytes": 200 + 12 * int(linear.size) + 24 * int(rows.size),
            "seconds": ours, "dimod_seconds": theirs, "mib": our_memory, "dimod_mib": their_memory}


def main():
    options = arguments(__doc__)
    with Figures(options.figures, "bridge") as figures:
        figures["runs"] = []
        for dense in (True, False):
            with tempfile.TemporaryDirectory() as folder:
                figures["runs"].append(measure(dense, folder))


if __name__ == "__main__":
    if sys.argv[1:2] in (["bridge"], ["alone"]):
        {"bridge": bridge, "alone": alone}[sys.argv[1]](sys.argv[2])
    else:
        main()
