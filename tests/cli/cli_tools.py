"""What the tests of the command share: small pairs, their energies by numpy, files and processes.

Nothing here uses the project's code, so that it can be held against it.
"""

import os
import pty
import signal
import struct
import subprocess
import time
from hashlib import sha256
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
QSTEREO = os.environ.get("QSTEREO", str(ROOT / "build" / "qstereo"))
# A build without OpenCV is the same command, and it starts in a hundredth of the CPU time: tests
# that need no OpenCV run it. The fixture `opencv` switches to the other one.
QSTEREO_PNM = os.environ.get("QSTEREO_PNM")
PROGRAM = QSTEREO_PNM or QSTEREO


class Result:
    """What a run of the command left: its exit status and what it printed."""

    def __init__(self, process):
        self.status = process.returncode
        self.out = process.stdout
        self.err = process.stderr.decode()


# Seconds. No test is this slow, however busy the machine is: only one that hangs.
LONG = 600


def run(*arguments, program=None, **options):
    """Runs qstereo and returns its Result."""
    options = {"capture_output": True, "timeout": LONG, "stdin": subprocess.DEVNULL, **options}
    if "input" in options:
        del options["stdin"]
    return Result(subprocess.run([program or PROGRAM, *map(str, arguments)], **options))


def succeed(*arguments, **options):
    """Runs qstereo, which has to succeed, and returns its Result."""
    done = run(*arguments, **options)
    assert done.status == 0, done.err
    return done


def has_opencv():
    """Whether the command under test reads PNG, JPEG and TIFF."""
    return b"OpenCV" in run("--version", program=QSTEREO).out


def write_pgm(path, grey, maxval=255):
    """Writes a binary PGM, of 16 bits where maxval is above 255."""
    kind = ">u2" if maxval > 255 else "u1"
    header = f"P5\n{grey.shape[1]} {grey.shape[0]}\n{maxval}\n".encode()
    path.write_bytes(header + np.asarray(grey).astype(kind).tobytes())
    return path


def read_pnm(data):
    """Reads a binary PGM or PPM without comments."""
    kind, size, maxval, pixels = data.split(b"\n", 3)
    width, height = size.split()
    dtype = ">u2" if int(maxval) > 255 else "u1"
    shape = (int(height), int(width), 3) if kind == b"P6" else (int(height), int(width))
    return np.frombuffer(pixels, dtype).reshape(shape).astype(int), int(maxval)


def read_pfm(data):
    """Reads a little-endian PFM, rows from the top."""
    kind, size, scale, pixels = data.split(b"\n", 3)
    assert kind == b"Pf" and float(scale) < 0
    width, height = map(int, size.split())
    return np.frombuffer(pixels, "<f4").reshape(height, width)[::-1]


def tiff(values, tile=None):
    """A little-endian TIFF of one value a pixel without compression, in one strip or in tiles."""
    height, width = values.shape
    kind = {"u": 1, "i": 2, "f": 3}[values.dtype.kind]
    side_y, side_x = (tile, tile) if tile else values.shape
    padded = np.zeros((-(-height // side_y) * side_y, -(-width // side_x) * side_x), values.dtype)
    padded[:height, :width] = values
    parts = [
        padded[y : y + side_y, x : x + side_x].tobytes()
        for y in range(0, padded.shape[0], side_y)
        for x in range(0, padded.shape[1], side_x)
    ]
    size, count = len(parts[0]), len(parts)
    offsets = [8 + i * size for i in range(count)]
    end = 8 + count * size
    lists = struct.pack(f"<{2 * count}I", *offsets, *[size] * count)
    places = (offsets[0], size) if count == 1 else (end, end + 4 * count)
    tags = [(256, width), (257, height), (258, 8 * values.itemsize), (259, 1), (262, 1), (277, 1)]
    tags += [(322, tile), (323, tile)] if tile else [(278, height)]
    tags += [(339, kind)]
    rows = [(tag, 4, 1, value) for tag, value in tags]
    names = (324, 325) if tile else (273, 279)
    rows += [(name, 4, count, place) for name, place in zip(names, places)]
    folder = b"".join(struct.pack("<HHII", *row) for row in sorted(rows))
    head = struct.pack("<2sHI", b"II", 42, end + len(lists))
    return head + b"".join(parts) + lists + struct.pack("<H", len(rows)) + folder + bytes(4)


def random_pair(folder, width, height, seed=1):
    """Writes left.pgm and right.pgm; returns them as arrays and their names."""
    random = np.random.default_rng(seed)
    left, right = (random.integers(0, 256, (height, width)) for _ in range(2))
    return left, right, write_pgm(folder / "left.pgm", left), write_pgm(folder / "right.pgm", right)


def energy(left, right, disparities, lam, smooth=lambda step: (step != 0) * 1):
    """F of a map of disparities of the right-most columns, in real units."""
    height, width = disparities.shape
    first = left.shape[1] - width
    y, x = np.mgrid[:height, first : first + width]
    data = np.abs(left[y, x] - right[y, x - disparities]).sum()
    steps = smooth(np.diff(disparities, axis=1)).sum() + smooth(np.diff(disparities, axis=0)).sum()
    return data + lam * steps


def one_hot(indices, labels):
    """The bits of a labelling, a row of numbers 0 and 1."""
    return (np.asarray(indices).reshape(-1, 1) == np.arange(labels)).astype(int).ravel()


def bits_of(indices, labels, encoding):
    """The bits of a labelling of all open sites with all labels, as docs/FORMAT.md has them."""
    indices = np.asarray(indices).reshape(-1, 1)
    if encoding == "domain-wall":
        return (indices > np.arange(labels - 1)).astype(int).ravel()
    if encoding == "st-cut":
        return np.append((indices >= np.arange(labels + 1)).astype(int).ravel(), [1, 0])
    terminals = np.eye(labels, dtype=int).ravel() if encoding == "multiway-cut" else []
    return np.append(one_hot(indices, labels), terminals).astype(int)


def _crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = CRC_TABLE[(crc ^ byte) & 255] ^ (crc >> 8)
    return crc ^ 0xFFFFFFFF


def _crc_row(byte):
    for _ in range(8):
        byte = (byte >> 1) ^ (0x82F63B78 if byte & 1 else 0)
    return byte


CRC_TABLE = [_crc_row(byte) for byte in range(256)]


def _chunk(kind, payload):
    head = struct.pack("<4sIQ", kind, 0, len(payload)) + payload
    return head + struct.pack("<I", _crc32c(head))


def write_qsf(
    path, problem, samples, energies, info=b'{"reads": 3}', occurrences=None, broken=None
):
    """Writes samples (rows of 0 and 1) of the .qcf named `problem`, with their energies in integer
    units, and 1e-9 of broken chains.
    """
    samples = np.atleast_2d(samples)
    count, variables = samples.shape
    occurrences = occurrences or [1] * count
    broken = broken or [0xFFFFFFFF] * count
    records = b"".join(
        struct.pack("<qII", int(e), o, b) for e, o, b in zip(energies, occurrences, broken)
    )
    body = b"".join(
        [
            _chunk(b"PROB", sha256(Path(problem).read_bytes()).digest()),
            _chunk(b"SOLV", b'test "solver"'),
            _chunk(b"INFO", info),
            _chunk(b"RECS", records),
            _chunk(
                b"BITS", np.packbits(samples.astype(np.uint8), axis=1, bitorder="little").tobytes()
            ),
        ]
    )
    head = struct.pack("<8sIIQII28x", b"\x89QSF\r\n\x1a\n", 1, 5, 64 + len(body), variables, count)
    path.write_bytes(head + struct.pack("<I", _crc32c(head)) + body)
    return path


def chunks_of(path):
    """The payloads of a .qcf or .qsf by their types."""
    data, found, at = Path(path).read_bytes(), {}, 64
    while at < len(data):
        kind, _, size = struct.unpack_from("<4sIQ", data, at)
        found[kind.decode()] = data[at + 16 : at + 16 + size]
        at += 20 + size
    return found


def with_chunk(source, kind, payload, path):
    """Writes a .qcf or .qsf again with another payload in one of its chunks; None leaves the chunk
    out.
    """
    data = Path(source).read_bytes()
    found = {**chunks_of(source), kind: payload}
    found = {name: held for name, held in found.items() if held is not None}
    body = b"".join(_chunk(name.encode(), payload) for name, payload in found.items())
    head = data[:12] + struct.pack("<IQ", len(found), 64 + len(body)) + data[24:60]
    path.write_bytes(reseal(head + bytes(4)) + body)
    return path


def without_chunk(source, kind, path):
    """Writes a .qcf or .qsf again without one of its chunks."""
    return with_chunk(source, kind, None, path)


SOLVERS = ["icm", "anneal", "swap", "expansion", "bp", "trws", "best"]


def best_of_all(left, right, labels, lam, smooth):
    """The least F of all maps of the right-most columns with disparities 0 .. labels - 1, by
    trying each.
    """
    height, width = left.shape[0], left.shape[1] - labels + 1
    maps = np.indices([labels] * (height * width)).reshape(height, width, -1)
    y, x = np.mgrid[:height, labels - 1 : left.shape[1]]
    data = np.abs(left[y, x][..., None] - right[y[..., None], x[..., None] - maps]).sum(axis=(0, 1))
    steps = smooth(np.abs(np.diff(maps, axis=0))).sum(axis=(0, 1)) + smooth(
        np.abs(np.diff(maps, axis=1))
    ).sum(axis=(0, 1))
    return (data + lam * steps).min()


def started(*arguments, **options):
    """Starts qstereo and returns its process."""
    return subprocess.Popen(
        [PROGRAM, *map(str, arguments)],
        **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options},
    )


def signal_at_output(process, folder, files, number):
    """Sends a signal as soon as `folder` and its folders hold so many files and temporaries."""
    while len(list(folder.rglob("*"))) < files and process.poll() is None:
        time.sleep(0.001)  # between two looks; how long it takes does not matter
    process.send_signal(number)


def on_terminal(*arguments, interrupt_at=None, signals=(signal.SIGINT,)):
    """Runs qstereo with standard error on a terminal; returns its status and what was shown.

    interrupt_at  what has to be shown before the signals are sent; None = nothing is sent
    signals       they are all there when the command goes on
    """
    master, terminal = pty.openpty()
    process = started(*arguments, stdout=subprocess.DEVNULL, stderr=terminal)
    os.close(terminal)
    shown = b""
    try:
        while data := os.read(master, 65536):
            shown += data
            if interrupt_at is not None and interrupt_at in shown:
                for sent in (signal.SIGSTOP, *signals, signal.SIGCONT):
                    process.send_signal(sent)
                interrupt_at = None
    except OSError:  # Linux ends a terminal that nobody has open with EIO
        pass
    os.close(master)
    return process.wait(LONG), shown.decode()


def reseal(data):
    """The bytes of a .qcf or .qsf with its header's CRC made right again."""
    return data[:60] + struct.pack("<I", _crc32c(data[:60])) + data[64:]
