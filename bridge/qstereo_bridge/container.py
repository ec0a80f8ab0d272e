"""The container of both file formats: a header of 64 bytes, then chunks, each under a CRC-32C."""

import struct
from dataclasses import dataclass

import google_crc32c

from .failure import IO, Error

VERSION = 1
HEADER = struct.Struct("<8sIIQ36sI")
CHUNK_HEAD = struct.Struct("<4sIQ")
CRC = struct.Struct("<I")
MIB = 1 << 20
MAX_COUNT = 2**31 - 1
# Bytes that the work on a file may take, unless the caller says otherwise.
DEFAULT_LIMIT = 8 << 30


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


@dataclass(frozen=True)
class Header:
    """What both formats' headers have; `fields` are the 36 bytes of the format's own."""

    chunks: int
    size: int
    fields: bytes


def read_header(head, magic, suffix):
    """The Header in the first 64 bytes of a file (fewer where the file is shorter), checked."""
    if head[:8] != magic[:len(head)]:
        raise NotOurFormat(f"byte 0: this is no {suffix} file (its first eight bytes are others)")
    if len(head) < HEADER.size:
        raise Truncated(f"byte {len(head)}: the file ends inside its header of {HEADER.size} "
                        "bytes; copy it again")
    _, version, chunks, size, fields, crc = HEADER.unpack(head[:HEADER.size])
    if google_crc32c.value(bytes(head[:HEADER.size - CRC.size])) != crc:
        raise Corrupt("byte 60: the header's CRC-32C does not agree with the header; copy the "
                      "file again")
    if version != VERSION:
        raise Unsupported(f"byte 8: version {version} of the format; this program reads version "
                          f"{VERSION}")
    return Header(chunks, size, fields)


def check_size(actual, declared):
    """Compare a file's size with the size that its header gives."""
    if actual < declared:
        raise Truncated(f"byte {actual}: the file ends here, its header says {declared} bytes; "
                        "copy it again")
    if actual > declared:
        raise Corrupt(f"byte {declared}: {actual - declared} bytes after the end that the header "
                      "gives")


def read_stream(stream, magic, suffix, limit):
    """Read one whole file from a binary stream, of which no more is read than its header admits.

    Returns the bytes. Raises FormatError, OverLimit, OSError.
    """
    head = stream.read(HEADER.size)
    header = read_header(head, magic, suffix)
    if stream.seekable():
        check_size(stream.seek(0, 2), header.size)
        stream.seek(len(head))
    check_memory(header.size, limit, "reading the file")
    data = head + stream.read(max(header.size - len(head), 0) + 1)
    check_size(len(data), header.size)
    return data


def read_chunks(data, header, required):
    """({type: payload} of the required chunks, [(type, payload)] of the side chunks), checked.

    `required` lists the upper-case types in their order. Payloads are memoryviews into `data`.
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
            sides.append((name, payload))
        elif name not in required:
            raise Unsupported(f"byte {at}: chunk {name} is unknown to this program")
        elif sides or len(found) == len(required) or name != required[len(found)]:
            raise Corrupt(f"byte {at}: chunk {name} is repeated or out of order")
        else:
            found[name] = payload
        at = end + CRC.size
    if at != len(data):
        raise Corrupt(f"byte {at}: {len(data) - at} bytes follow the last chunk")
    if len(found) < len(required):
        raise Corrupt(f"byte {at}: chunk {required[len(found)]} is missing")
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
