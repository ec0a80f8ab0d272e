"""The page "From Python": its scripts run, and the page shows the scripts as they are."""

import os
import subprocess
import sys

import qstereo_bridge as qb
from library import QSTEREO, ROOT

PAPER = ROOT / "samples" / "paper"
SCRIPT = ROOT / "examples" / "from_python.py"
LABELS = ROOT / "examples" / "labels_from_python.py"


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


def test_page_shows_the_scripts():
    page = (ROOT / "docs" / "PYTHON.md").read_text()
    for script in (SCRIPT, LABELS):
        assert f"```python\n{script.read_text()}```" in page
