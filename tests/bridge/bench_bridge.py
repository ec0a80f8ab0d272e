"""Benchmarks of the bridge: `python tests/bridge/bench_bridge.py`. Prints figures, asserts nothing.

Each measurement runs in a process of its own: seconds are the least of three runs, memory is the growth of the peak
resident set over what the imports alone take.
"""

import os
import subprocess
import sys
import tempfile
import time

import numpy as np

SIZE, LABELS, RUNS = 177, 16, 3


def memory(key):
    """A line of /proc/self/status in MiB: VmRSS now, VmHWM at its peak (getrusage would count the parent's as well)."""
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith(key)) / 1024


def bridge(folder):
    import dimod  # noqa: F401 - both sides have it imported before the clock starts
    from qstereo_bridge import models, qcf

    before, began = memory("VmRSS"), time.perf_counter()
    with open(os.path.join(folder, "p.qcf"), "rb") as stream:
        bqm = models.to_bqm(qcf.read_qcf(stream)[0])
    print(time.perf_counter() - began, memory("VmHWM") - before, len(bqm))


def alone(folder):
    """from_numpy_vectors on ready arrays: these count in its memory, not in its time."""
    import dimod

    before = memory("VmRSS")
    linear, rows, columns, values = (np.load(os.path.join(folder, f"{name}.npy")) for name in ("l", "r", "c", "v"))
    began = time.perf_counter()
    bqm = dimod.BinaryQuadraticModel.from_numpy_vectors(linear, (rows, columns, values), 0.0, "BINARY")
    print(time.perf_counter() - began, memory("VmHWM") - before, len(bqm))


def best(mode, folder):
    found = [[float(word) for word in subprocess.run([sys.executable, __file__, mode, folder], check=True, text=True,
                                                     capture_output=True).stdout.split()[:2]] for _ in range(RUNS)]
    return min(seconds for seconds, _ in found), min(memory for _, memory in found)


def main():
    from problems import grid
    from qstereo_bridge import models, qcf

    for dense in (True, False):
        with tempfile.TemporaryDirectory() as folder:
            problem = grid(SIZE, SIZE, LABELS, dense)
            data = qcf.pack_qcf(problem)
            with open(os.path.join(folder, "p.qcf"), "wb") as stream:
                stream.write(data)
            linear, (rows, columns, values), _ = models.expand(problem)
            for name, array in (("l", linear.astype(float)), ("r", rows), ("c", columns), ("v", values.astype(float))):
                np.save(os.path.join(folder, f"{name}.npy"), array)
            print(f"{SIZE} x {SIZE} x {LABELS}, {'one-hot' if dense else 'one-hot-sparse'}: {rows.size:,} quadratic terms")
            (ours, our_memory), (theirs, their_memory) = best("bridge", folder), best("alone", folder)
            print(f"  .qcf -> BQM {ours:.2f} s, from_numpy_vectors alone {theirs:.2f} s: ratio {ours / theirs:.2f}")
            print(f"  peak {our_memory:,.0f} MiB, alone {their_memory:,.0f} MiB: ratio {our_memory / their_memory:.2f}")
            bqm_bytes = 200 + 12 * linear.size + 24 * rows.size
            print(f"  .qcf {len(data):,} bytes, dimod .bqm {bqm_bytes:,} bytes: ratio {bqm_bytes / len(data):.0f}")


if __name__ == "__main__":
    {"bridge": bridge, "alone": alone}[sys.argv[1]](sys.argv[2]) if len(sys.argv) > 1 else main()
