"""Fuzzes the bridge's readers of .qcf and .qsf: whatever the bytes are, they are read or refused
with a FormatError.

As a program it looks for inputs that do otherwise: readers.py [--seconds N] [--seed N] [--keep
FOLDER].
"""

import argparse
import io
import random
import struct
import tarfile
import time
import warnings
from pathlib import Path

import google_crc32c
from qstereo_bridge.core import models, qcf, qsf
from qstereo_bridge.core.container import FormatError, OverLimit

CORPUS = Path(__file__).with_name("corpus")
LIMIT = 64 << 20


def corpus(name):
    """[(name, bytes)] of the inputs that the C target `name` is run over."""
    with tarfile.open(CORPUS / f"{name}.tar.xz") as archive:
        return [
            (member.name, archive.extractfile(member).read())
            for member in archive
            if member.isfile()
        ]


def read(name, data):
    """Whether the reader takes the file; None = it would need too much memory. A warning of
    numpy's is a fault too.
    """
    try:
        warnings.simplefilter("error")
        if name == "qcf":
            models.check_known(qcf.parse_qcf(data, LIMIT))
        else:
            qsf.read_qsf(io.BytesIO(data))
    except OverLimit:
        return None
    except FormatError:
        return False
    return True


def mend(data):
    """The file with sound sizes and checksums."""
    file, at, chunks = bytearray(data), 64, 0
    if len(file) < 64:
        return bytes(file)
    while len(file) - at >= 20:
        length = min(struct.unpack_from("<Q", file, at + 8)[0], len(file) - at - 20)
        struct.pack_into("<Q", file, at + 8, length)
        struct.pack_into(
            "<I", file, at + 16 + length, google_crc32c.value(bytes(file[at : at + 16 + length]))
        )
        at, chunks = at + 20 + length, chunks + 1
    struct.pack_into("<IIQ", file, 8, 1, chunks, len(file))
    struct.pack_into("<I", file, 60, google_crc32c.value(bytes(file[:60])))
    return bytes(file)


def mutate(data, rng):
    """Another file: some bytes, or a whole number, are others; checksums are sound again."""
    file = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 4])):
        at = rng.randrange(24, len(file)) if len(file) > 24 else 0
        kind = rng.random()
        if kind < 0.5 and at + 4 <= len(file):
            struct.pack_into(
                "<I",
                file,
                at,
                rng.choice(
                    [0, 1, 2, 255, 256, 65535, 2**31 - 1, 2**31, 2**32 - 1, rng.getrandbits(32)]
                ),
            )
        elif kind < 0.8 and file:
            file[at] = rng.getrandbits(8)
        elif kind < 0.9:
            file[at:at] = bytes(rng.getrandbits(8) for _ in range(rng.choice([1, 4, 8])))
        else:
            del file[at : at + rng.choice([1, 4, 8])]
    return mend(file)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", default=".", help="folder for an input that breaks a reader")
    args = parser.parse_args()
    rng, runs, end = random.Random(args.seed), 0, time.monotonic() + args.seconds
    seeds = [(name, data) for name in ("qcf", "qsf") for _, data in corpus(name)]
    while time.monotonic() < end:
        name, data = rng.choice(seeds)
        data, runs = mutate(data, rng), runs + 1
        try:
            read(name, data)
        except Exception:
            Path(args.keep, f"bad-reader.{name}").write_bytes(data)
            raise
    print(f"readers: {runs} inputs")


if __name__ == "__main__":
    main()
