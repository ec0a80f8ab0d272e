"""The page "From Python": its script runs, and the page shows the script as it is."""

import subprocess
import sys

import qstereo_bridge as qb
from library import QSTEREO, ROOT

PAPER = ROOT / "samples" / "paper"
SCRIPT = ROOT / "examples" / "from_python.py"


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


def test_page_shows_the_script():
    assert f"```python\n{SCRIPT.read_text()}```" in (ROOT / "docs" / "PYTHON.md").read_text()
