"""The samples file, .qsf: what a solver returned for one .qcf."""

from __future__ import annotations

import json
import math
import os
import struct
import unicodedata
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from .container import (DEFAULT_LIMIT, MAX_COUNT, Corrupt, check_memory, pack, read_chunks,
                        read_header, read_stream)
from .failure import InputError
from .output import save
from .text import parse

if TYPE_CHECKING:
    import dimod

    from .qcf import Coefficients

MAGIC = b"\x89QSF\r\n\x1a\n"
FIELDS = struct.Struct("<II28s")
REQUIRED = ["PROB", "SOLV", "INFO", "RECS", "BITS"]
RECORD = np.dtype([("energy", "<i8"), ("occurrences", "<u4"), ("broken", "<u4")])
BROKEN_UNITS, NO_CHAINS = 10**9, 0xFFFFFFFF


def plain(value):
    """`value` as JSON can hold it: numpy's numbers and arrays as Python's, the unknown as text."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, set, np.ndarray)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value if isinstance(value, (bool, int, float, str, type(None))) else str(value)


@dataclass
class Samples:
    """Samples of one problem.

    digest      SHA-256 of the whole .qcf, 32 bytes
    solver      the solver's name, 1 to 255 bytes of UTF-8
    records     RECORD array: energy (H in the .qcf's integer units), occurrences, share of broken
                chains in 1e-9 or NO_CHAINS
    bits        u8 array (samples, n) of 0 and 1
    info        dict that JSON can hold: what the solver says of itself
    sides       list of (type, bytes): side chunks, kept as they are
    """

    digest: bytes
    solver: str
    records: np.ndarray
    bits: np.ndarray
    info: dict = field(default_factory=dict)
    sides: list = field(default_factory=list)

    def save(self, file: str | os.PathLike | BinaryIO) -> None:
        """Write a .qsf to a path, whole or not at all, or to a binary stream. Raises FileError."""
        save(file, pack_qsf(self))

    def sampleset(self, problem: Coefficients) -> dimod.SampleSet:
        """dimod's SampleSet over the problem's variables 0 .. n - 1, BINARY, energies in the
        .qcf's integer units. Raises InputError where the samples are of another problem."""
        import dimod

        if problem.digest != self.digest:
            raise InputError("these samples are of another problem: the SHA-256 of its file "
                             "differs")
        more, broken = {}, self.records["broken"]
        if (broken != NO_CHAINS).any():
            more["chain_break_fraction"] = np.where(broken == NO_CHAINS, 0, broken / BROKEN_UNITS)
        return dimod.SampleSet.from_samples(
            (self.bits.astype(np.int8), range(self.bits.shape[1])), "BINARY", info=self.info,
            energy=self.records["energy"].astype(float),
            num_occurrences=self.records["occurrences"].astype(np.int64), sort_labels=False, **more)


def _text(part):
    try:
        return bytes(part.view).decode("utf-8")
    except UnicodeDecodeError as error:
        raise Corrupt(f"chunk {part.name}, byte {error.start}: not UTF-8") from None


def _number(text):
    """A number of JSON that a double holds, of at most 1,000 characters; NaN is none."""
    if len(text) > 1000 or not math.isfinite(float(text)):
        raise ValueError("a number that no double holds")
    return float(text) if set(text) & set(".eE") else int(text)


def _info(part):
    try:
        info = parse(_text(part), parse_constant=_number, parse_int=_number, parse_float=_number)
    except ValueError as error:
        raise Corrupt(f"chunk INFO: {error}") from None
    part.need(isinstance(info, dict), "not a JSON object")
    return info


def parse_qsf(data, limit=DEFAULT_LIMIT):
    """The Samples in `data`, the bytes of a whole .qsf. Raises FormatError."""
    header = read_header(data, MAGIC, ".qsf", len(data))
    n, count, zero = FIELDS.unpack(header.fields)
    if n > MAX_COUNT or zero != bytes(28):
        raise Corrupt("byte 24: the number of variables is impossible, or a reserved field is in "
                      "use")
    check_memory(header.size + n * count, limit, f"{count:,} samples of {n:,} variables")
    chunks, sides = read_chunks(data, header, REQUIRED)
    digest, name, info, recs, bits = chunks.values()
    records, row = recs.array(RECORD, count), -(-n // 8)
    packed = bits.array(np.uint8, count * row).reshape(count, row)
    digest.array(np.uint8, 32)
    for part in (digest, recs, bits):
        part.end()
    solver = _text(name)
    name.need(1 <= len(name.view) <= 255 and not any(map(_is_control, solver)),
              "the solver's name is empty, too long, or has control characters")
    recs.need((records["occurrences"] > 0).all(), "a record without occurrences")
    broken = records["broken"]
    recs.need(((broken <= BROKEN_UNITS) | (broken == NO_CHAINS)).all(),
              "a record with more than all chains broken")
    bits.need(n % 8 == 0 or not (packed[:, -1] >> n % 8).any(), "spare bits are in use")
    return Samples(bytes(digest.view), solver, records,
                   np.unpackbits(packed, 1, n, "little"), _info(info), sides)


def _is_control(letter):
    return unicodedata.category(letter) == "Cc"


def read_qsf(stream, limit=DEFAULT_LIMIT):
    """Read a .qsf from a binary stream: its Samples. Raises FormatError, OSError."""
    return parse_qsf(read_stream(stream, MAGIC, ".qsf", limit), limit)


def pack_qsf(samples):
    """The bytes of `samples` as a .qsf. Nothing is checked but that `info` is JSON (ValueError)."""
    # A service's JSON may hold halves of surrogate pairs, which UTF-8 cannot.
    info = json.dumps(samples.info, ensure_ascii=False, allow_nan=False).encode("utf-8", "replace")
    count, n = samples.bits.shape
    return pack(MAGIC, FIELDS.pack(n, count, bytes(28)), [
        ("PROB", samples.digest),
        ("SOLV", samples.solver.encode("utf-8")),
        ("INFO", info),
        ("RECS", samples.records.astype(RECORD).tobytes()),
        ("BITS", np.packbits(samples.bits, axis=1, bitorder="little").tobytes()),
        *samples.sides,
    ])
