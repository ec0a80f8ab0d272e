"""The example for a Cortex-M4 writes the same files as the command, within the memory that it
promises.

QSTEREO_CORTEX_M names its program; qemu-system-arm runs it.
"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "cli"))
from cli_tools import ROOT, run, write_pgm  # noqa: E402

PROGRAM = os.environ.get("QSTEREO_CORTEX_M")
EMULATOR = [
    "qemu-system-arm",
    "-machine",
    "mps2-an386",
    "-nographic",
    "-monitor",
    "none",
    "-serial",
    "none",
    "-semihosting-config",
    "enable=on,target=native",
    "-kernel",
]


def pattern():
    """The pictures that the program draws."""
    state, right = 1, np.empty(48 * 64, int)
    for i in range(right.size):
        state = (state * 1664525 + 1013904223) % 2**32
        right[i] = state >> 24
    right = right.reshape(48, 64)
    y, x = np.mgrid[:48, :64]
    return right[y, np.where(x < y % 8, 0, x - y % 8)], right


@pytest.mark.skipif(PROGRAM is None, reason="QSTEREO_CORTEX_M names no program")
def test_same_files(tmp_path):
    here = tmp_path / "here"
    here.mkdir()
    done = subprocess.run(
        [*EMULATOR, PROGRAM],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        timeout=600,
    )
    print(done.stderr + done.stdout)
    assert done.returncode == 0, done.stderr + done.stdout
    paper = ROOT / "samples" / "paper"
    assert (
        run(
            "encode",
            paper / "left.pgm",
            paper / "right.pgm",
            "-o",
            here / "paper.qcf",
            "--disparity",
            "0:1",
            "--lambda",
            "10",
            "--encoding",
            "one-hot",
            "--penalty",
            "200",
        ).status
        == 0
    )
    for name, grey in zip(["left.pgm", "right.pgm"], pattern()):
        write_pgm(here / name, grey)
    assert (
        run(
            "encode",
            here / "left.pgm",
            here / "right.pgm",
            "-o",
            here / "pattern.qcf",
            "--disparity",
            "0:7",
        ).status
        == 0
    )
    for name in ["paper.qcf", "pattern.qcf"]:
        assert (tmp_path / name).read_bytes() == (here / name).read_bytes()
