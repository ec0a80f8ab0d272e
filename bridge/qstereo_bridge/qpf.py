"""The certificate file, .qpf: a proof of a lower bound (docs/FORMAT.md, section 4)."""

import struct
from dataclasses import dataclass

import numpy as np

from .container import DEFAULT_LIMIT, Corrupt, read_chunks, read_header, read_stream

MAGIC = b"\x89QPF\r\n\x1a\n"
FIELDS = struct.Struct("<IIqq12s")
REQUIRED = ["PROB", "BEST", "STGS"]
NO_BOUND = -2**63


@dataclass
class Certificate:
    """What a .qpf states, and the bytes that prove it.

    digest          SHA-256 of the whole .qcf, 32 bytes
    lower_bound     int, None = none
    energy          int: of the labelling
    labelling       array: of each undecided site the number of its label
    stages          how many stages `proof` has
    proof           memoryview of the stages
    """

    digest: bytes
    lower_bound: int | None
    energy: int
    labelling: np.ndarray
    stages: int
    proof: memoryview


class Stages:
    """Reads the stages from front to back. Raises Corrupt, which names the place."""

    def __init__(self, certificate):
        self.view, self.at = certificate.proof, 0
        self.label = certificate.labelling.dtype

    def array(self, dtype, count):
        size = count * np.dtype(dtype).itemsize
        self.need(size <= len(self.view) - self.at, "the stages end too early")
        values = np.frombuffer(self.view, dtype, count, self.at)
        self.at += size
        return values

    def need(self, sound, reason):
        if not sound:
            raise Corrupt(f"chunk STGS, byte {self.at}: {reason}")


def parse_qpf(data):
    """The Certificate in `data`, the bytes of a whole .qpf. Raises FormatError."""
    header = read_header(data, MAGIC, ".qpf", len(data))
    sites, stages, bound, energy, zero = FIELDS.unpack(header.fields)
    if zero != bytes(12):
        raise Corrupt("byte 48: a reserved field is in use")
    chunks, _ = read_chunks(data, header, REQUIRED)
    best, width = chunks["BEST"], int.from_bytes(chunks["BEST"][:4], "little")
    if len(chunks["PROB"]) != 32 or width not in (1, 2) or len(best) != 4 + sites * width:
        raise Corrupt("chunk PROB or BEST: a length or a width is not what it must be")
    return Certificate(bytes(chunks["PROB"]), None if bound == NO_BOUND else bound, energy,
                       np.frombuffer(best, f"<u{width}", offset=4), stages, chunks["STGS"])


def read_qpf(stream, limit=DEFAULT_LIMIT):
    """The Certificate in a binary stream. Raises FormatError, OSError."""
    return parse_qpf(read_stream(stream, MAGIC, ".qpf", limit))
