"""The page "From Python": its scripts run, and the page shows the scripts as they are."""

import os
import subprocess
import sys

import dimod
import pytest
import qstereo_bridge as qb
from library import QSTEREO, ROOT

PAPER = ROOT / "samples" / "paper"
SCRIPT = ROOT / "examples" / "from_python.py"
LABELS = ROOT / "examples" / "labels_from_python.py"
WINDOWS = [ROOT / "examples" / f"windows_{engine}.py" for engine in ("hybrid", "ray")]
# Of Ray, which is large, what the example uses: tasks run in threads.
RAY = """\
import concurrent.futures
pool = concurrent.futures.ThreadPoolExecutor(2)


class remote:
    def __init__(self, work):
        self.work = work

    def remote(self, *arguments):
        return pool.submit(self.work, *arguments)


def init():
    pass


def get(tasks):
    return [task.result() for task in tasks]
"""


def test_script(run, tmp_path):
    run("qstereo", "encode", PAPER / "left.pgm", PAPER / "right.pgm", "-o", "p.qcf",
        "--disparity", "0:1", "--lambda", "10")
    command = [sys.executable, SCRIPT, "p.qcf", "--qstereo", QSTEREO]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for sampler in ("SimulatedAnnealingSampler", "TabuSampler"):
        assert f"{sampler}: least energy 50" in done.stdout
    energies = qb.load_samples(tmp_path / "s.qsf").records["energy"]
    assert energies.min() == 50 * qb.load(tmp_path / "p.qcf").scale
    assert (tmp_path / "map.pgm").read_bytes().startswith(b"P5")
    assert (tmp_path / "map.png").read_bytes()[1:4] == b"PNG"


def test_script_of_labels(tmp_path):
    done = subprocess.run([sys.executable, LABELS], cwd=tmp_path, capture_output=True, text=True,
                          env={**os.environ, "QSTEREO": str(QSTEREO)})
    assert done.returncode == 0, done.stderr
    head, *rows = done.stdout.splitlines()
    assert head == "384 variables, energies in units of 1/100"
    right = sum(row[:8].count(".") + row[8:].count("#") for row in rows)
    assert len(rows) == 12 and right > 0.95 * 12 * 16
    assert len(qb.load(tmp_path / "p.qcf")) == 384


@pytest.mark.parametrize("script", WINDOWS, ids=lambda path: path.stem)
def test_windows_on_other_engines(script, run, tmp_path):
    """From a poor state to the proven optimum, and never up."""
    if "hybrid" in script.name:
        pytest.importorskip("hybrid")
    (tmp_path / "ray.py").write_text(RAY)
    run("qstereo", "encode", PAPER / "left.pgm", PAPER / "right.pgm", "-o", "p.qcf",
        "--disparity", "0:3", "--lambda", "10", "--encoding", "domain-wall")
    p = qb.load(tmp_path / "p.qcf")
    start = p.samples(dimod.SampleSet.from_samples([1] * len(p), "BINARY", 0), "none")
    start.save(tmp_path / "start.qsf")
    command = [sys.executable, script, "p.qcf", "start.qsf", "s.qsf", str(len(p) // 2)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": str(tmp_path)})
    assert done.returncode == 0, done.stderr
    energies = [int(line.split()[-1]) for line in done.stdout.splitlines() if "energy" in line]
    assert energies == sorted(energies, reverse=True) and len(energies) >= 3
    assert energies[-1] < start.records["energy"][0]
    run("qstereo-bridge", "solve", "p.qcf", "-o", "least.qsf", "--solver", "ilp")
    least = qb.load_samples(tmp_path / "least.qsf").records["energy"].min()
    saved = qb.load_samples(tmp_path / "s.qsf").records["energy"].tolist()
    assert saved == [energies[-1]] == [least]


def test_page_shows_the_scripts():
    page = (ROOT / "docs" / "PYTHON.md").read_text()
    for script in (SCRIPT, LABELS, *WINDOWS):
        assert f"```python\n{script.read_text()}```" in page
