"""How long a problem of 500,000 variables takes from its .qcf to the first byte sent: figures
`upload`.

    python tests/bench/bench_upload.py [--figures DIR]

For each hybrid solver, in a process of its own: seconds from reading the .qcf to a file that is
ready to be uploaded, and the growth of the peak resident set; beside what dimod needs for the same
file from ready, sorted arrays.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from bench_bridge import memory
from scenes import Figures, arguments

SHAPES = {"hybrid-bqm": (177, 177, 16), "hybrid-cqm": (177, 177, 16), "hybrid-nl": (450, 375, 60)}
LIMIT = 1 << 34


def problem_in(folder):
    from qstereo_bridge.core import qcf

    with open(Path(folder, "p.qcf"), "rb") as stream:
        return qcf.read_qcf(stream, LIMIT)


def ours(name, folder):
    import dimod  # noqa: F401 - imported before the clock starts on either side
    import dwave.optimization  # noqa: F401
    from qstereo_bridge.runs import registry

    before, began = memory("VmRSS"), time.perf_counter()
    solver = registry.find(name)
    file = solver.run(problem_in(folder), None).file()
    print(time.perf_counter() - began, memory("VmHWM") - before, file.seek(0, 2))


def dimods(name, folder):
    import dimod
    from qstereo_bridge.core import models

    problem = problem_in(folder)
    linear, quadratic, offset = models.expand(problem, penalties=name == "hybrid-bqm")
    before, began = memory("VmRSS"), time.perf_counter()
    bqm = dimod.BinaryQuadraticModel.from_numpy_vectors(linear, quadratic, offset, "BINARY")
    model = bqm
    if name == "hybrid-cqm":
        model, starts = dimod.ConstrainedQuadraticModel(), problem.starts.tolist()
        model.set_objective(bqm)
        for group, (low, high) in enumerate(zip(starts, starts[1:])):
            model.add_discrete(range(low, high), label=group, check_overlaps=False)
    file = model.to_file()
    print(time.perf_counter() - began, memory("VmHWM") - before, file.seek(0, 2))


def measure(name, shape, dense):
    from problems import grid, pack_qcf
    from qstereo_bridge.core import qcf

    encoding = "one-hot" if dense else "one-hot-sparse"
    measured = {"solver": name, "shape": shape, "encoding": encoding}
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "p.qcf").write_bytes(pack_qcf(grid(*shape, dense)))
        for whose in ["ours"] if name == "hybrid-nl" else ["ours", "dimods"]:
            command = [sys.executable, __file__, whose, name, folder]
            said = subprocess.run(command, check=True, text=True, capture_output=True).stdout
            seconds, mebibytes, size = map(float, said.split())
            measured[whose] = {"seconds": seconds, "mib": mebibytes, "bytes": int(size)}
    return measured


def main():
    options = arguments(__doc__)
    with Figures(options.figures, "upload") as figures:
        figures["runs"] = [measure(name, shape, dense) for name, shape in SHAPES.items()
                           for dense in (True, False)]


if __name__ == "__main__":
    if sys.argv[1:2] in (["ours"], ["dimods"]):
        {"ours": ours, "dimods": dimods}[sys.argv[1]](*sys.argv[2:])
    else:
        main()
