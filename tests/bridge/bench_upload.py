"""How long a problem of 500,000 variables takes from its .qcf to the first byte sent:
`python tests/bridge/bench_upload.py`.

For each hybrid solver, in a process of its own: seconds from reading the .qcf to a file that is
ready to be uploaded, and the growth of the peak resident set; beside what dimod needs for the same
file from ready, sorted arrays.
"""

import os
import subprocess
import sys
import tempfile
import time
from types import SimpleNamespace

from bench_bridge import memory

SHAPES = {"hybrid-bqm": (177, 177, 16), "hybrid-cqm": (177, 177, 16), "hybrid-nl": (450, 375, 60)}


def ours(name, folder):
    import dimod  # noqa: F401 - imported before the clock starts on either side
    import dwave.optimization  # noqa: F401
    from qstereo_bridge import cli, qcf
    before, began = memory("VmRSS"), time.perf_counter()
    with open(os.path.join(folder, "p.qcf"), "rb") as stream:
        problem = qcf.read_qcf(stream)[0]
    file = cli.SOLVERS[name].run(name, problem, SimpleNamespace(memory_limit=1 << 34)).file()
    print(time.perf_counter() - began, memory("VmHWM") - before, file.seek(0, 2))


def dimods(name, folder):
    import dimod
    from qstereo_bridge import models, qcf
    with open(os.path.join(folder, "p.qcf"), "rb") as stream:
        problem = qcf.read_qcf(stream)[0]
    linear, quadratic, offset = models.expand(problem, penalties=name == "hybrid-bqm",
                                              limit=1 << 34)
    before, began = memory("VmRSS"), time.perf_counter()
    model = bqm = dimod.BinaryQuadraticModel.from_numpy_vectors(linear, quadratic, offset, "BINARY")
    if name == "hybrid-cqm":
        model, starts = dimod.ConstrainedQuadraticModel(), problem.starts().tolist()
        model.set_objective(bqm)
        for group, (low, high) in enumerate(zip(starts, starts[1:])):
            model.add_discrete(range(low, high), label=group, check_overlaps=False)
    file = model.to_file()
    print(time.perf_counter() - began, memory("VmHWM") - before, file.seek(0, 2))


def main():
    from problems import grid
    from qstereo_bridge import qcf
    for name, shape in SHAPES.items():
        for dense in (True, False):
            with tempfile.TemporaryDirectory() as folder:
                with open(os.path.join(folder, "p.qcf"), "wb") as stream:
                    stream.write(qcf.pack_qcf(grid(*shape, dense)))
                print(f"{name}, {' x '.join(map(str, shape))}, "
                      f"{'one-hot' if dense else 'one-hot-sparse'}")
                for whose in ["ours", "dimods"][:1 if name == "hybrid-nl" else 2]:
                    found = subprocess.run([sys.executable, __file__, whose, name, folder],
                                           check=True, text=True, capture_output=True).stdout
                    seconds, mebibytes, size = map(float, found.split())
                    what = "from the .qcf" if whose == "ours" else "dimod, from ready arrays"
                    print(f"  {what}: {seconds:.2f} s, {mebibytes:,.0f} MiB more at the peak, "
                          f"{size:,.0f} bytes to send")


if __name__ == "__main__":
    {"ours": ours, "dimods": dimods}[sys.argv[1]](*sys.argv[2:]) if len(sys.argv) > 1 else main()
