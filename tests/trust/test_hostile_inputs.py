"""Streams, arrays, networks and fields whose headers promise more than there is: refused at once,
in little memory, with a message that names the file, and with nothing written."""

import os
import resource
import struct
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "cli"))
from cli_tools import run  # noqa: E402

MUCH = "9" * 60000


def y4m(words, frames=b"FRAME\n" + bytes(32)):
    return b"YUV4MPEG2 " + words.encode() + b"\n" + frames


def npy(shape, kind="<f4", body=bytes(16), length=None, version=1):
    head = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    size = struct.pack("<H" if version == 1 else "<I", len(head) if length is None else length)
    return b"\x93NUMPY" + bytes([version, 0]) + size + head + body


def uai(*lines):
    return "\n".join(("MARKOV", *lines)).encode()


def flo(width, height, body=bytes(64)):
    return struct.pack("<fii", 202021.25, width, height) + body


# name: (status, bytes)
STREAMS = {
    "2e9 x 2e9": (3, y4m("W2000000000 H2000000000 Cmono")),
    "2^32 + 1 wide": (3, y4m("W4294967297 H1 Cmono")),
    "100,000 x 100,000": (4, y4m("W100000 H100000 Cmono")),
    "below 0": (3, y4m("W-4 H4 Cmono")),
    "nothing": (3, y4m("W0 H0 Cmono")),
    "a header without end": (3, y4m("X" * 10**6)),
    "a frame's header without end": (3, y4m("W8 H4 Cmono", b"FRAME " + b"X" * 10**6)),
    "a depth without end": (3, y4m(f"W8 H4 Cmono{MUCH[:900]}")),
    "no samples": (3, y4m("W8 H4 Cmono", b"FRAME\n")),
    "colours cut short": (3, y4m("W8 H4 C444")),
    "a picture of 2e9 x 2e9": (3, b"P5\n2000000000 2000000000\n255\n"),
    "a picture of 100,000 x 100,000": (4, b"P5\n100000 100000\n255\n"),
}
ARRAYS = {
    "2^32 x 2^32 x 2": (3, npy("(4294967296, 4294967296, 2)")),
    "a product that is 4 in 64 bits": (3, npy("(6148914691236517206, 3, 2)")),
    "a size without end": (3, npy(f"({MUCH}, 2, 2)")),
    "below 0": (3, npy("(-1, 2, 2)")),
    "nothing": (3, npy("(0, 4294967296, 4294967296)", body=b"")),
    "no labels": (3, npy("(2, 2, 0)", body=b"")),
    "20,000 dimensions": (3, npy(f"({'1,' * 20000})")),
    "1e10 elements": (3, npy("(100000, 100000, 1)", "|i1")),
    "a header of 2^32 - 1 bytes": (3, npy("(2, 2, 1)", length=2**32 - 1, version=2)),
    "objects": (3, npy("(2, 1, 1)", "|O")),
    "lists in lists": (3, npy("[" * 50000)),
    "70,000 labels": (3, npy("(1, 1, 70000)", "|u1", bytes(70000))),
}
NETWORKS = {
    "2^32 - 1 variables": (3, uai("4294967295", "2")),
    "2^31 - 1 variables": (3, uai("2147483647", "2 2", "0")),
    "2^32 - 1 values": (3, uai("1", "4294967295", "0")),
    "a table of 3.6e9": (3, uai("2", "60000 60000", "1", "2 0 1", "3600000000", "1 1")),
    "2^31 - 1 factors": (3, uai("2", "2 2", "2147483647", "1 0")),
    "a factor of 2^32 - 1": (3, uai("2", "2 2", "1", "4294967295 0 1", "4", "1 1 1 1")),
    "a variable below 0": (3, uai("2", "2 2", "1", "2 0 -1", "4", "1 1 1 1")),
    "a number without end": (3, uai("1", "2", "1", "1 0", "2", f"1 {MUCH}")),
    "entries without end": (3, uai("2", "2 2", "1", "2 0 1", MUCH, "1 1 1 1")),
}
FIELDS = {
    "2^31 - 1 x 2^31 - 1": (3, flo(2**31 - 1, 2**31 - 1)),
    "a product that is 0 in 32 bits": (3, flo(65536, 65536)),
    "30,000 x 30,000": (3, flo(30000, 30000)),
    "below 0": (3, flo(-1, 4)),
    "nothing": (3, flo(0, 0, b"")),
    "a byte more": (3, flo(2, 4, bytes(65))),
    "a header cut short": (3, flo(2, 4)[:10]),
}
LINES = {
    "in.y4m": (STREAMS, ["match", "--sbs", "in.y4m", "-o", "out/d_%d.pgm", "--disparity", "0:1"]),
    "in.npy": (ARRAYS, ["label", "in.npy", "-o", "out.npy"]),
    "in.uai": (NETWORKS, ["encode", "--problem", "uai", "in.uai", "-o", "out.qcf"]),
    "in.flo": (FIELDS, ["score", "in.flo", "in.flo", "--as", "flow"]),
}
CASES = [(path, name) for path, (cases, _) in LINES.items() for name in cases]


def little():
    """Seconds of work and bytes of memory: more than any of these files is worth."""
    resource.setrlimit(resource.RLIMIT_CPU, (2, 2))
    resource.setrlimit(resource.RLIMIT_AS, (1 << 29, 1 << 29))


@pytest.mark.parametrize("path, name", CASES)
def test_refused(path, name, tmp_path):
    cases, line = LINES[path]
    status, data = cases[name]
    (tmp_path / path).write_bytes(data)
    done = run(*line, program=os.environ.get("QSTEREO_PNM"), cwd=tmp_path, preexec_fn=little)
    assert done.status == status, done.err
    assert path in done.err and done.err.count("\n") == 1
    # More memory is the advice only where it would help.
    assert ("--memory-limit" in done.err) == (status == 4)
    assert [found.name for found in tmp_path.iterdir()] == [path]
