"""Every call that may fail does so once, in every command: the exit status says it, and nothing
half-written is left.

QSTEREO_FAULTS names the library that lets calls fail (faults.c).
"""

import itertools
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "cli"))
from cli_tools import ROOT, random_pair, run, write_pgm  # noqa: E402

FAULTS = os.environ.get("QSTEREO_FAULTS")
PNM = os.environ.get("QSTEREO_PNM")
pytestmark = pytest.mark.skipif(
    FAULTS is None or PNM is None, reason="QSTEREO_FAULTS or QSTEREO_PNM names nothing"
)
CALLS = ["write", "close", "rename", "fsync", "malloc"]
# With the names of the files that each writes.
COMMANDS = {
    "encode": ("encode l.pgm r.pgm -o out --disparity 0:3", ["out"]),
    "encode to a pipe": ("encode l.pgm r.pgm -o - --disparity 0:3", []),
    "encode, cut": (
        "encode l.pgm r.pgm -o out --disparity 0:3 --encoding multiway-cut --truncate --json",
        ["out"],
    ),
    "reduce": ("reduce p.qcf -o out --encoding domain-wall", ["out"]),
    "info": ("info p.qcf", []),
    "info of samples": ("info s.qsf --json", []),
    "solve": ("solve p.qcf -o out --solver expansion", ["out"]),
    "reduce, certified": ("reduce p.qcf -o out --certificate /dev/null", ["out"]),
    "solve, certified": (
        "solve p.qcf -o out --certificate proof --solver trws",
        ["out", "proof"],
    ),
    "verify": ("verify p.qcf s.qsf c.qpf", []),
    "validate": ("validate p.qcf s.qsf", []),
    "decode": ("decode p.qcf s.qsf -o out.pfm --repair", ["out.pfm"]),
    "score": ("score m.pgm m.pgm", []),
    "match": ("match l.pgm r.pgm -o out.pgm --disparity 0:3 --json", ["out.pgm"]),
    "compare": ("compare p.qcf --samples s.qsf --solvers icm,trws", []),
    "help": ("help", []),
}


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    made = tmp_path_factory.mktemp("inputs")
    left, *_ = random_pair(made, 9, 4)
    for old, new in (("left.pgm", "l.pgm"), ("right.pgm", "r.pgm")):
        (made / old).rename(made / new)
    write_pgm(made / "m.pgm", left % 3 * 8)
    for line in (
        "encode l.pgm r.pgm -o p.qcf --disparity 0:3",
        "solve p.qcf -o s.qsf --certificate c.qpf",
    ):
        assert run(*line.split(), cwd=made).status == 0
    return made


def with_fault(line, folder, call, k, reason=28, killed=False):
    """(exit status, standard output, standard error, calls that were counted unless it was killed)
    """
    variables = {
        **os.environ,
        "LD_PRELOAD": FAULTS,
        "FAULT": f"{call}:{k}:{reason}",
        "FAULT_COUNT": str(folder / "count"),
    }
    done = subprocess.run(
        [PNM, *line.split()],
        cwd=folder,
        env=variables,
        capture_output=True,
        stdin=subprocess.DEVNULL,
        timeout=600,
    )
    counted = 0
    if not killed:
        counted = int((folder / "count").read_text())
    (folder / "count").unlink(missing_ok=True)
    return done.returncode, done.stdout, done.stderr.decode(), counted


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def alike(found, expected):
    """The same files; of samples, which hold the time that they took, the same beginning."""
    return found.keys() == expected.keys() and all(
        held[:12] == expected[name][:12] if held[:4] == b"\x89QSF" else held == expected[name]
        for name, held in found.items()
    )


@pytest.mark.parametrize("name, call", list(itertools.product(COMMANDS, CALLS)))
def test_each_call_fails_once(name, call, inputs, tmp_path):
    line, written = COMMANDS[name]
    folder = tmp_path / "work"
    shutil.copytree(inputs, folder)
    before = contents(folder)
    status, printed, err, calls = with_fault(line, folder, call, 0)
    assert status == 0, err
    assert call != "fsync" or calls == 2 * len(written)  # the file and its folder
    expected = contents(folder)
    assert set(expected) == {*before, *written}
    failed = 0
    for k in range(1, calls + 1):
        for output in written:
            (folder / output).write_bytes(b"old")
        status, out, err, _ = with_fault(line, folder, call, k)
        if status == 0:
            assert alike(contents(folder), expected) and len(out) >= len(printed) - 20, k
            continue
        failed += 1
        assert status == 4 and err.startswith("qstereo"), (k, status, err)
        assert contents(folder) == {**before, **dict.fromkeys(written, b"old")}, k
    # Without memory for a buffer of an output that is written straight the C library writes byte by
    # byte: the answer is whole.
    buffers = 2 + ("/dev/null" in line)
    assert failed == calls if call != "malloc" else failed >= calls - buffers, (failed, calls)
    print(f"{name}, {call}: {calls} calls")


def test_the_bridge(inputs):
    paper = ROOT / "samples" / "paper"
    small = inputs / "small.qcf"
    assert (
        run(
            "encode", paper / "left.pgm", paper / "right.pgm", "-o", small, "--disparity", "0:1"
        ).status
        == 0
    )
    done = subprocess.run(
        [sys.executable, Path(__file__).with_name("bridge_faults.py"), FAULTS, small],
        capture_output=True,
        text=True,
        timeout=600,
        env={**os.environ, "DWAVE_CONFIG_FILE": "/dev/null"},
    )
    assert done.returncode == 0, done.stderr
    runs = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(runs) > 20
    kills = [found for found in runs if found["killed"] and "-o out" in found["command"]]
    assert len(kills) > 8
    for found in kills:  # never a half
        assert found["status"] == -9 and found["old"] != found["whole"], found
    assert any(found["old"] for found in kills)
    for found in [found for found in runs if not found["killed"]]:
        assert not [name for name in found["files"] if name.endswith(".tmp")], found
        if found["status"] == 0:
            assert found["whole"], found
        else:
            assert (
                found["status"] == 4
                and found["k"] > 0
                and found["old"]
                and found["err"].startswith("qstereo-bridge")
            ), found
