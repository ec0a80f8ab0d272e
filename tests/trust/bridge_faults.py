"""bridge_faults.py LIBRARY P.qcf: runs the bridge's commands once for each call that may fail, and
once more with a kill before it, each run in a child of this process, which has imported everything
before. Prints a JSON object a run: {command, call, k, killed, counted, status, old, whole, files,
err}."""

import ctypes
import io
import json
import os
import shutil
import signal
import sys
import tempfile

import qstereo_bridge.samplers.solvers  # noqa: F401
from qstereo_bridge.desk import cli
from qstereo_bridge.core import qsf
from qstereo_bridge.core.container import FormatError

COMMANDS = [
    ["solve", "p.qcf", "-o", "out", "--solver", "exact", "--quiet"],
    [
        "solve",
        "p.qcf",
        "-o",
        "out",
        "--solver",
        "anneal",
        "--num-reads",
        "2",
        "--num-sweeps",
        "2",
        "--seed",
        "1",
        "--quiet",
    ],
    ["solve", "p.qcf", "-o", "-", "--solver", "exact", "--quiet"],
]
CALLS = ["write", "close", "rename", "fsync"]
NO_SPACE = 28


def child(library, arguments, call, k, reason):
    """Runs one command here and ends the process."""
    with open("err", "wb") as err, open("stdout", "wb") as out:
        os.dup2(err.fileno(), 2)
        os.dup2(out.fileno(), 1)
    os.environ.update(FAULT=f"{call}:{k}:{reason}", FAULT_COUNT="count")
    faults = ctypes.CDLL(library)
    status = 70
    try:
        status = cli.main(arguments) or 0
        sys.stdout.flush()
    except SystemExit as end:
        status = end.code or 0
    finally:
        faults.faults_end()
        os._exit(status)


def is_samples(data):
    try:
        qsf.read_qsf(io.BytesIO(data))
    except FormatError:
        return False
    return True


def run(library, problem, arguments, call, k, reason=NO_SPACE):
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(problem, folder + "/p.qcf")
        with open(folder + "/out", "w") as old:
            old.write("old")
        pid = os.fork()
        if pid == 0:
            os.chdir(folder)
            child(library, arguments, call, k, reason)
        status = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
        read = lambda name: (
            open(f"{folder}/{name}", "rb").read() if os.path.exists(f"{folder}/{name}") else b""
        )
        target = read("stdout") if "-" in arguments else read("out")
        return {
            "command": " ".join(arguments),
            "call": call,
            "k": k,
            "status": status,
            "counted": int(read("count") or 0),
            "old": read("out") == b"old",
            "killed": reason < 0,
            "whole": is_samples(target),
            "files": sorted(os.listdir(folder)),
            "err": read("err").decode(errors="replace"),
        }


def main(library, problem):
    for arguments in COMMANDS:
        for call in CALLS:
            found, k = run(library, problem, arguments, call, 0), 0
            print(json.dumps(found))
            while k < found["counted"]:
                k += 1
                print(json.dumps(run(library, problem, arguments, call, k)))
                print(json.dumps(run(library, problem, arguments, call, k, -signal.SIGKILL)))


main(*map(os.path.abspath, sys.argv[1:]))
