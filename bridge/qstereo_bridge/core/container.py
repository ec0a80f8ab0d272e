"""The container of both file formats: a header of 64 bytes, then chunks, each under a CRC-32C."""

import collections
import struct

import google_crc32c
import numpy as np

from .failure import IO, Error

VERSION = 1
HEADER = struct.Struct("<8sIIQ36sI")
CHUNK_HEAD = struct.Struct("<4sIQ")
CRC = struct.Struct("<I")
MIB = 1 << 20
MAX_COUNT = 2**31 - 1
# Bytes that the work on a file may take, unless the caller says otherwise.
DEFAULT_LIMIT = 8 << 30

# What both formats' headers have; `fields` are the 36 bytes of the format's own.
Header = collections.namedtuple("Header", "chunks size fields")


class FormatError(Error):
    """A file that a reader refuses. The message gives the byte or chunk and the reason."""


class NotOurFormat(FormatError):
    """The first bytes are another format's."""


class Truncated(FormatError):
    """The file ends too early."""


class Corrupt(FormatError):
    """The file contradicts itself or the format."""


class Unsupported(FormatError):
    """A version or a chunk that came later."""


class OverLimit(FormatError):
    """The work needs more memory than the caller allows. The file itself may be sound."""

    status = IO


def check_memory(needed, limit, what):
    """Raise OverLimit when `needed` bytes for `what` are more than `limit`."""
    if needed > limit:
        raise OverLimit(f"{what} would need {-(-needed // MIB):,} MiB, the limit is "
                        f"{limit // MIB:,} MiB; raise it with --memory-limit, or solve a smaller "
                        "problem")


def read_header(data, magic, suffix, length=None):
    """The Header at the beginning of a file that is `length` bytes long (None: not known)."""
    if data[:8] != magic[:len(data)]:
        raise NotOurFormat(f"byte 0: this is not a {suffix} file (it does not begin like one)")
    if len(data) < HEADER.size:
        raise Truncated(f"byte {len(data)}: the file ends inside its header of {HEADER.size} "
                        "bytes; copy it again")
    _, version, chunks, size, fields, crc = HEADER.unpack_from(data)
    if google_crc32c.value(bytes(data[:HEADER.size - CRC.size])) != crc:
        raise Corrupt("byte 60: the header's CRC-32C does not agree with the header; copy the "
                      "file again")
    if version != VERSION:
        raise Unsupported(f"byte 8: version {version} of the format; this program reads version "
                          f"{VERSION}")
    if length is not None and length < size:
        raise Truncated(f"byte {length}: the file ends here, its header says {size} bytes; copy it "
                        "again")
    if length is not None and length > size:
        raise Corrupt(f"byte {size}: {length - size} bytes after the end that the header gives")
    return Header(chunks, size, fields)


def read_stream(stream, magic, suffix, limit):
    """The bytes of one whole file in a binary stream, of which no more is read than its header
    admits. Raises FormatError, OverLimit, OSError."""
    data, length = stream.read(HEADER.size), None
    if stream.seekable():
        length = stream.seek(0, 2)
        stream.seek(len(data))
    size = read_header(data, magic, suffix, length).size
    check_memory(size, limit, "reading the file")
    data += stream.read(max(size - len(data), 0) + 1)
    read_header(data, magic, suffix, len(data))
    return data


class Payload:
    """Reads one chunk from front to back; all that is wrong is a Corrupt that names the place."""

    def __init__(self, name, view):
        self.name, self.view, self.at = name, view, 0

    def need(self, sound, reason):
        if not sound:
            raise Corrupt(f"chunk {self.name}, byte {self.at}: {reason}")

    def array(self, dtype, count=None):
        """`count` values, or all that are left."""
        left, size = len(self.view) - self.at, np.dtype(dtype).itemsize
        count = left // size if count is None else count
        self.need(count * size <= left, f"the chunk ends too early for {count} values")
        values = np.frombuffer(self.view, dtype, count, self.at)
        self.at += count * size
        return values

    def unpack(self, layout):
        return struct.unpack(layout, self.array("u1", struct.calcsize(layout)))

    def width(self):
        """The width of the integers that follow, checked, with its reserved field."""
        width, zero = self.unpack("<II")
        self.need(width in (1, 2, 4, 8) and zero == 0, f"width {width}, or a reserved field in use")
        return width

    def runs(self, *kinds):
        """All records that are left, of these kinds of numbers: an i64 array for each kind."""
        found = self.array([(str(at), kind) for at, kind in enumerate(kinds)])
        return [found[name].astype(np.int64) for name in found.dtype.names]

    def end(self):
        self.need(self.at == len(self.view), f"{len(self.view) - self.at} bytes too many")


def read_chunks(data, header, required):
    """({type: Payload} of the required chunks, [(type, bytes)] of the side chunks), checked.

    `required` lists the upper-case types in their order. Payloads are views of `data`.
    """
    view, found, sides, at = memoryview(data), {}, [], HEADER.size
    for number in range(header.chunks):
        if at + CHUNK_HEAD.size + CRC.size > len(data):
            raise Corrupt(f"byte {at}: the header promises {header.chunks} chunks, chunk {number} "
                          "is not there")
        kind, zero, length = CHUNK_HEAD.unpack_from(data, at)
        end = at + CHUNK_HEAD.size + length
        if end + CRC.size > len(data):
            raise Corrupt(f"byte {at + 8}: chunk {number} is longer than the rest of the file")
        if google_crc32c.value(bytes(view[at:end])) != CRC.unpack_from(data, end)[0]:
            raise Corrupt(f"byte {end}: the CRC-32C of chunk {number} does not agree with it; copy "
                          "the file again")
        if not kind.isalpha() or zero:
            raise Corrupt(f"byte {at}: chunk {number} has a type that is not four letters, or a "
                          "reserved field in use")
        name, payload = kind.decode("ascii"), view[at + CHUNK_HEAD.size:end]
        if name[0].islower():
            sides.append((name, bytes(payload)))
        elif name not in required:
            raise Unsupported(f"byte {at}: chunk {name} is unknown to this program")
        elif sides or [*found, name] != required[:len(found) + 1]:
            raise Corrupt(f"byte {at}: chunk {name} is repeated or out of order")
        else:
            found[name] = Payload(name, payload)
        at = end + CRC.size
    if at != len(data) or len(found) < len(required):
        raise Corrupt(f"byte {at}: chunk {required[len(found)]} is missing" if at == len(data) else
                      f"byte {at}: {len(data) - at} bytes follow the last chunk")
    return found, sides


def pack(magic, fields, chunks):
    """The bytes of a file: `fields` are the format's own 36 of the header, `chunks` a list of
    (type, payload)."""
    packed = []
    for name, payload in chunks:
        body = CHUNK_HEAD.pack(name.encode("ascii"), 0, len(payload)) + payload
        packed += [body, CRC.pack(google_crc32c.value(body))]
    size = HEADER.size + sum(map(len, packed))
    head = HEADER.pack(magic, VERSION, len(chunks), size, fields, 0)[:-CRC.size]
    return b"".join([head, CRC.pack(google_crc32c.value(head)), *packed])
