"""The two formats: round trips, and everything that a reader must refuse."""

import io
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from problems import (Table, Toeplitz, altered, carrying, grid, make, nothing, pack_qcf,
                      random_problem)
from qstereo_bridge.core import container, models, qcf, qsf
from qstereo_bridge.core.container import Corrupt, NotOurFormat, OverLimit, Truncated, Unsupported

SEEDS = st.integers(0, 2**32 - 1)


def samples(seed=0, count=3, n=11):
    rng = np.random.default_rng(seed)
    records = np.zeros(count, qsf.RECORD)
    records["energy"], records["occurrences"] = rng.integers(
        -(2**52), 2**52, count
    ), rng.integers(1, 9, count)
    records["broken"] = rng.choice([0, 5, qsf.BROKEN_UNITS, qsf.NO_CHAINS], count)
    return qsf.Samples(
        rng.bytes(32),
        "anneal",
        records,
        rng.integers(0, 2, (count, n)).astype(np.uint8),
        {"timing": {"µs": 1.5}, "seed": seed},
        [("note", b"kept")] * (seed % 2),
    )


def rebuild(data, magic, changed=(), fields=None):
    """The file again, with sound CRCs, some chunks changed ({type: bytes, or None to leave it
    out}).
    """
    chunks = [(name, dict(changed).get(name, payload)) for name, payload in walk(data)]
    fields = fields or container.HEADER.unpack_from(data)[4]
    return container.pack(magic, fields, [chunk for chunk in chunks if chunk[1] is not None])


def with_header(data, **values):
    """The file with other header values and a sound CRC of the header."""
    names = ["magic", "version", "chunks", "size", "fields", "crc"]
    header = {**dict(zip(names, container.HEADER.unpack_from(data))), **values}
    head = container.HEADER.pack(*header.values())[:60]
    return head + struct.pack("<I", container.google_crc32c.value(head)) + data[64:]


def walk(data):
    at = 64
    while at < len(data):
        kind, _, length = container.CHUNK_HEAD.unpack_from(data, at)
        yield kind.decode(), data[at + 16 : at + 16 + length]
        at += 20 + length


def test_crc_is_castagnoli():
    assert container.google_crc32c.value(b"123456789") == 0xE3069283


@settings(deadline=None, max_examples=200)
@given(SEEDS)
def test_a_qcf_is_read_as_it_was_written(seed):
    problem = random_problem(seed)
    data = pack_qcf(problem)
    read = qcf.parse_qcf(data)
    raw = problem.raw
    assert (read.linear == raw.linear).all() and (read.offset, read.sides) == (
        raw.offset,
        raw.sides,
    )
    assert list(zip(read.sizes, read.a, read.b)) == [
        (size, *pair) for size, pair in zip(raw.sizes, raw.penalties)
    ]
    expected = []
    for run in raw.couplings:
        steps = [r * run["stride"] + c for r in range(run["repeat"]) for c in range(run["count"])]
        pairs = (
            np.array(run["pairs"]).reshape(-1, 2).tolist()
            if run["form"]
            else [(run["g"] + step, run["h"] + step) for step in steps]
        )
        weights = run["weights"] if run["width"] else [run["weight"]] * len(steps)
        expected += [(g, h, run["block"], weight) for (g, h), weight in zip(pairs, weights)]
    assert list(map(tuple, read.couplings.T)) == expected
    for block, written in zip(read.blocks, raw.blocks):
        assert (
            block
            == [[written.entry(i, j) for j in range(block.shape[1])] for i in range(block.shape[0])]
        ).all()


@settings(deadline=None)
@given(SEEDS, st.integers(0, 4), st.integers(1, 40))
def test_qsf_round_trip(seed, count, n):
    data = qsf.pack_qsf(samples(seed, count, n))
    read = qsf.read_qsf(io.BytesIO(data))
    assert qsf.pack_qsf(read) == data and read.bits.shape == (count, n)
    assert (read.bits == samples(seed, count, n).bits).all()


def test_nothing_left_to_decide():
    problem = nothing(-7, [("labl", bytes(16) + b"\2" + bytes(47)), ("kept", b"x")])
    data = pack_qcf(problem)
    read = qcf.parse_qcf(data)
    assert (read.linear.size, read.sizes.size, read.couplings.size, read.offset) == (0, 0, 0, -7)
    parts = dict(walk(data))
    assert parts["GRPS"] == b"" and parts["BLKS"] == parts["CPLS"] == bytes(4)
    assert parts["LINR"] == struct.pack("<qII", 0, 1, 0) and parts["PNLT"] == struct.pack(
        "<II", 1, 0
    )
    assert container.HEADER.unpack_from(data)[4] == bytes(36)


@settings(deadline=None, max_examples=20)
@given(SEEDS, st.integers(0, 4))
def test_samples_of_nothing(seed, count):
    data = qsf.pack_qsf(samples(seed, count, 0))
    read = qsf.parse_qsf(data)
    assert (
        dict(walk(data))["BITS"] == b""
        and read.bits.shape == (count, 0)
        and qsf.pack_qsf(read) == data
    )


@pytest.mark.parametrize(
    "name, payload",
    [
        ("GRPS", struct.pack("<II", 1, 1)),
        ("GRPS", struct.pack("<II", 0, 1)),
        ("GRPS", struct.pack("<II", 1, 0)),
        ("LINR", struct.pack("<qIIB", 0, 1, 0, 0)),
        ("LINR", struct.pack("<qII", 0, 0, 0)),
        ("PNLT", struct.pack("<II", 2, 0)),
        ("PNLT", struct.pack("<IIIBB", 1, 0, 1, 1, 1)),
        ("OFFS", struct.pack("<q", 2**53 + 1)),
        ("CPLS", struct.pack("<IIIIiIIIII", 1, 0, 0, 0, 1, 0, 0, 1, 1, 0)),
        ("CPLS", struct.pack("<IIIIiIIIIIII", 1, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 0)),
    ],
)
def test_broken_nothing(name, payload):
    changed = {name: payload, "BLKS": struct.pack("<IIIIi", 1, 1, 1, 0, 5)}
    fields = qcf.FIELDS.pack(0, 0, int(name == "CPLS"), bytes(20))
    with pytest.raises(Corrupt, match=f"chunk {name}" if name != "OFFS" else "2\\^53"):
        qcf.parse_qcf(rebuild(pack_qcf(nothing()), qcf.MAGIC, changed, fields))


def test_broken_samples_of_nothing():
    data = qsf.pack_qsf(samples(0, 3, 0))
    with pytest.raises(Corrupt, match="BITS"):
        qsf.parse_qsf(rebuild(data, qsf.MAGIC, {"BITS": b"\0"}))


@pytest.mark.parametrize("code", [0, 3, 6, 99, 2**32 - 1])
def test_a_solver_looks_at_the_scale_alone(code):
    """Encodings that came later, and side chunks of theirs, change nothing."""
    labl = struct.pack("<IIIII", code, 9, 9, 0, 5) + bytes([255] * 44)
    problem = altered(everything(), sides=[("labl", labl), ("kept", bytes(9)), ("trnc", b"")])
    read = qcf.parse_qcf(pack_qcf(problem))
    assert read.scale == 5 and read.sides == problem.sides


def everything():
    """A small problem with every feature, so that every byte of it matters."""
    blocks = [
        Table(np.array([[1, 0], [-2, 3]], "<i4")),
        Toeplitz((2, 2), 1, -1, np.array([2, 0], "<i4")),
    ]
    return make(
        [2, 2, 2, 1],
        blocks,
        [
            {"weight": 2, "h": 1, "count": 2},
            {
                "block": 1,
                "form": 1,
                "width": 1,
                "count": 2,
                "pairs": [0, 2, 2, 2],
                "weights": [1, -1],
            },
        ],
        [5, 0, 300, 1, 2, 3, 4],
        [(3, 5), (3, 5), (0, 0), (1, 0)],
        -7,
        [("labl", bytes(16) + b"\2" + bytes(47))],
    )


FILES = [
    (pack_qcf(everything()), qcf.MAGIC, qcf.parse_qcf, qcf.read_qcf),
    (qsf.pack_qsf(samples(1)), qsf.MAGIC, qsf.parse_qsf, qsf.read_qsf),
    (pack_qcf(nothing(5)), qcf.MAGIC, qcf.parse_qcf, qcf.read_qcf),
    (qsf.pack_qsf(samples(1, 2, 0)), qsf.MAGIC, qsf.parse_qsf, qsf.read_qsf),
]
BOTH = pytest.mark.parametrize(
    "data, magic, parse, read", FILES, ids=["qcf", "qsf", "qcf of nothing", "qsf of nothing"]
)


@BOTH
def test_every_truncation(data, magic, parse, read):
    parse(data)
    for length in range(len(data)):
        for way in (parse, lambda part: read(io.BytesIO(part))):
            with pytest.raises(Truncated):
                way(data[:length])


@BOTH
def test_every_flipped_bit(data, magic, parse, read):
    for bit in range(8 * len(data)):
        flipped = bytearray(data)
        flipped[bit // 8] ^= 1 << bit % 8
        with pytest.raises(NotOurFormat if bit < 64 else Corrupt):
            parse(bytes(flipped))


@BOTH
def test_header(data, magic, parse, read):
    with pytest.raises(NotOurFormat):
        parse(b"PNG" + data)
    with pytest.raises(NotOurFormat):
        parse(b"\x89PNG")
    with pytest.raises(Unsupported, match="version 2"):
        parse(with_header(data, version=2))
    for more in (data + b"\0", data + data):
        with pytest.raises(Corrupt):
            parse(more)
        with pytest.raises(Corrupt):
            read(io.BytesIO(more))
    with pytest.raises(Truncated):
        parse(with_header(data, size=2**63))
    for chunks in (0, 1, container.HEADER.unpack_from(data)[2] - 1, 99, 2**32 - 1):
        with pytest.raises(Corrupt):
            parse(with_header(data, chunks=chunks))
    fields = bytearray(container.HEADER.unpack_from(data)[4])
    fields[-1] = 1
    with pytest.raises(Corrupt):
        parse(with_header(data, fields=bytes(fields)))


@BOTH
def test_chunks(data, magic, parse, read):
    fields, chunks = container.HEADER.unpack_from(data)[4], list(walk(data))
    upper = [part for part in chunks if part[0].isupper()]
    for at in range(len(upper)):
        with pytest.raises(Corrupt):
            parse(container.pack(magic, fields, upper[:at] + upper[at + 1 :]))
        with pytest.raises(Corrupt):
            parse(container.pack(magic, fields, upper[: at + 1] + upper[at:]))
        with pytest.raises(Corrupt):
            parse(container.pack(magic, fields, upper[:at] + [("side", b"")] + upper[at:]))
        with pytest.raises(Corrupt):
            parse(container.pack(magic, fields, upper[1:] + upper[:1]))
        with pytest.raises(Unsupported):
            parse(container.pack(magic, fields, upper[:at] + [("NEWS", b"")] + upper[at:]))
    with pytest.raises(Corrupt):
        parse(container.pack(magic, fields, upper + [("s1de", b"")]))
    assert parse(container.pack(magic, fields, upper + [("side", b"x"), ("more", b"")])).sides == [
        ("side", b"x"),
        ("more", b""),
    ]
    body = bytearray(data)
    body[68] = 1
    length = container.CHUNK_HEAD.unpack_from(data, 64)[2]
    body[80 + length : 84 + length] = struct.pack(
        "<I", container.google_crc32c.value(bytes(body[64 : 80 + length]))
    )
    with pytest.raises(Corrupt, match="reserved"):
        parse(bytes(body))


def test_memory_limits():
    data = FILES[0][0]
    with pytest.raises(OverLimit, match="MiB"):
        qcf.parse_qcf(
            with_header(data, fields=qcf.FIELDS.pack(2**31 - 1, 2**31 - 1, 2**31 - 1, bytes(20)))
        )
    with pytest.raises(OverLimit):
        qcf.parse_qcf(data, limit=100)
    with pytest.raises(Corrupt):
        qcf.parse_qcf(with_header(data, fields=qcf.FIELDS.pack(2**24, 4, 4, bytes(20))))
    with pytest.raises(OverLimit):
        qsf.parse_qsf(
            with_header(FILES[1][0], fields=qsf.FIELDS.pack(2**31 - 1, 2**32 - 1, bytes(28)))
        )

    class Pipe(io.BytesIO):
        def seekable(self):
            return False

    with pytest.raises(OverLimit):
        qcf.read_qcf(Pipe(with_header(data, size=2**60)))
    assert qcf.read_qcf(Pipe(data)).data == data


def run(**fields):
    defaults = {
        "block": 0,
        "form": 0,
        "width": 0,
        "weight": 1,
        "g": 0,
        "h": 1,
        "count": 1,
        "repeat": 1,
        "stride": 0,
    }
    return struct.pack("<IIIiIIIII", *{**defaults, **fields}.values())


def runs(*parts):
    return struct.pack("<I", len(parts)) + b"".join(parts)


def table(rows, columns, *entries):
    return struct.pack(f"<III{len(entries)}i", rows, columns, 0, *entries)


def toeplitz(rows, columns, fill, first, *values, kind=1):
    return struct.pack(
        f"<IIIiiI{len(values)}i", rows, columns, kind, fill, first, len(values), *values
    )


# A base of three groups of two variables and one coupling; each line changes one chunk against one
# MUST.
THREE = make(
    [2, 2, 2],
    [Table(np.ones((2, 2), "<i4"))],
    [{"weight": 1, "h": 1}],
    range(6),
    [(1, 1), (0, 0), (1, 2)],
)
BASE = pack_qcf(THREE)
BROKEN = {
    "groups: none": ("GRPS", b""),
    "groups: half a run": ("GRPS", struct.pack("<III", 3, 2, 0)),
    "groups: empty run": ("GRPS", struct.pack("<IIII", 3, 2, 0, 1)),
    "groups: no variables": ("GRPS", struct.pack("<IIII", 2, 3, 1, 0)),
    "groups: same size twice": ("GRPS", struct.pack("<IIII", 2, 2, 1, 2)),
    "groups: too many": ("GRPS", struct.pack("<IIII", 2, 2, 2, 1)),
    "groups: variables": ("GRPS", struct.pack("<II", 3, 3)),
    "groups: variables overflow": ("GRPS", struct.pack("<II", 3, 2**32 - 1)),
    "blocks: nothing": ("BLKS", b""),
    "blocks: one missing": ("BLKS", runs(table(2, 2, 1, 1, 1, 1)).replace(b"\1", b"\2", 1)),
    "blocks: no rows": ("BLKS", runs(table(2, 2, 1, 1, 1, 1), table(0, 2))),
    "blocks: no columns": ("BLKS", runs(table(2, 2, 1, 1, 1, 1), table(2, 0))),
    "blocks: kind": ("BLKS", runs(toeplitz(2, 2, 0, 0, 1, kind=2))),
    "blocks: short": ("BLKS", runs(table(2, 2, 1, 1, 1))),
    "blocks: huge": ("BLKS", runs(table(2**32 - 1, 2**32 - 1, 1))),
    "blocks: rest": ("BLKS", runs(table(2, 2, 1, 1, 1, 1)) + b"\0"),
    "blocks: toeplitz low": ("BLKS", runs(toeplitz(2, 2, 0, -2, 1))),
    "blocks: toeplitz high": ("BLKS", runs(toeplitz(2, 2, 0, 1, 1, 1))),
    "blocks: toeplitz empty": ("BLKS", runs(toeplitz(2, 2, 1, 1))),
    "blocks: toeplitz short": ("BLKS", runs(toeplitz(2, 2, 1, 0, 1)[:-1])),
    "couplings: nothing": ("CPLS", b""),
    "couplings: none": ("CPLS", runs()),
    "couplings: too many": ("CPLS", runs(run(), run())),
    "couplings: rest": ("CPLS", runs(run()) + b"\0"),
    "couplings: short": ("CPLS", runs(run())[:-1]),
    "couplings: block": ("CPLS", runs(run(block=1))),
    "couplings: form": ("CPLS", runs(run(form=2))),
    "couplings: width": ("CPLS", runs(run(width=3, weight=0) + bytes(3))),
    "couplings: weight 0": ("CPLS", runs(run(weight=0))),
    "couplings: two weights": ("CPLS", runs(run(width=1) + b"\1")),
    "couplings: count 0": ("CPLS", runs(run(), run(count=0))),
    "couplings: repeat 0": ("CPLS", runs(run(), run(repeat=0))),
    "couplings: stride": ("CPLS", runs(run(stride=1))),
    "couplings: g above h": ("CPLS", runs(run(g=2, h=1))),
    "couplings: no group": ("CPLS", runs(run(g=0, h=3))),
    "couplings: overflow": ("CPLS", runs(run(count=2**32 - 1, repeat=2**32 - 1, stride=2**32 - 1))),
    "couplings: no weights": ("CPLS", runs(run(width=4, weight=0))),
    "couplings: list in use": ("CPLS", runs(run(form=1) + struct.pack("<II", 0, 1))),
    "couplings: list repeated": (
        "CPLS",
        runs(run(form=1, h=0, repeat=2) + struct.pack("<IIII", 0, 1, 0, 1)),
    ),
    "couplings: list short": ("CPLS", runs(run(form=1, h=0) + struct.pack("<I", 0))),
    "couplings: list g above h": ("CPLS", runs(run(form=1, h=0) + struct.pack("<II", 2, 1))),
    "couplings: list no group": ("CPLS", runs(run(form=1, h=0) + struct.pack("<II", 0, 3))),
    "couplings: inside one-hot": ("CPLS", runs(run(g=2, h=2))),
    "couplings: block's size": ("BLKS", runs(table(2, 1, 1, 1))),
    "linear: width": ("LINR", struct.pack("<qII", 0, 3, 0) + bytes(18)),
    "linear: reserved": ("LINR", struct.pack("<qII", 0, 1, 1) + bytes(6)),
    "linear: short": ("LINR", struct.pack("<qII", 0, 1, 0) + bytes(5)),
    "linear: long": ("LINR", struct.pack("<qII", 0, 1, 0) + bytes(7)),
    "linear: head": ("LINR", bytes(15)),
    "linear: large": ("LINR", struct.pack("<qII", 2**62, 8, 0) + bytes(48)),
    "linear: overflow": ("LINR", struct.pack("<qII6Q", 2**63 - 1, 8, 0, *[2**64 - 1] * 6)),
    "linear: around 2^64": ("LINR", struct.pack("<qII6Q", 2**63 - 1, 8, 0, *[2**63 + 1] * 6)),
    "penalties: width": ("PNLT", struct.pack("<II", 3, 0) + bytes(10)),
    "penalties: reserved": ("PNLT", struct.pack("<IIIBB", 1, 1, 3, 1, 1)),
    "penalties: not least": ("PNLT", struct.pack("<IIIHH", 2, 0, 3, 1, 1)),
    "penalties: none": ("PNLT", struct.pack("<II", 1, 0)),
    "penalties: count 0": ("PNLT", struct.pack("<IIIBBIBB", 1, 0, 3, 1, 1, 0, 2, 2)),
    "penalties: too few": ("PNLT", struct.pack("<IIIBB", 1, 0, 2, 1, 1)),
    "penalties: same twice": ("PNLT", struct.pack("<IIIBBIBB", 1, 0, 2, 1, 1, 1, 1, 1)),
    "penalties: half a run": ("PNLT", struct.pack("<IIIB", 1, 0, 3, 1)),
    "penalties: large": ("PNLT", struct.pack("<IIIQQ", 8, 0, 3, 2**64 - 1, 2**64 - 1)),
    "offset: short": ("OFFS", bytes(7)),
    "offset: long": ("OFFS", bytes(9)),
    "offset: large": ("OFFS", struct.pack("<q", 2**53)),
    "offset: least": ("OFFS", struct.pack("<q", -(2**63))),
}


@pytest.mark.parametrize("what", BROKEN)
def test_broken_qcf(what):
    name, payload = BROKEN[what]
    with pytest.raises(Corrupt):
        qcf.parse_qcf(rebuild(BASE, qcf.MAGIC, {name: payload}))


@pytest.mark.parametrize(
    "counts",
    [
        (0, 0, 0),
        (0, 0, 1),
        (0, 1, 0),
        (6, 0, 1),
        (6, 7, 1),
        (2**31, 3, 1),
        (6, 3, 2**31),
        (7, 3, 1),
        (6, 3, 2),
    ],
)
def test_broken_counts(counts):
    with pytest.raises(Corrupt):
        qcf.parse_qcf(with_header(BASE, fields=qcf.FIELDS.pack(*counts, bytes(20))), limit=2**60)


def test_impossible_counts_are_seen_before_their_size():
    with pytest.raises(Corrupt, match="counts"):
        qcf.parse_qcf(with_header(BASE, fields=qcf.FIELDS.pack(2**31 - 1, 0, 0, bytes(20))))


def test_largest_sound_numbers():
    """M of 2^53 is sound and one more is not; a base and its u may each be far from their sum."""
    problem = THREE
    used = int(problem.magnitude(np.int64)) - abs(problem.offset)
    for offset in (2**53 - used, -(2**53 - used)):
        sound = pack_qcf(problem, offset=offset)
        assert qcf.parse_qcf(sound).magnitude(np.int64) == 2**53
        with pytest.raises(Corrupt, match="2\\^53"):
            qcf.parse_qcf(pack_qcf(problem, offset=offset + (1 if offset > 0 else -1)))
    far = struct.pack("<qII6Q", -(2**63), 8, 0, *[2**63 + k for k in range(6)])
    assert (qcf.parse_qcf(rebuild(BASE, qcf.MAGIC, {"LINR": far})).linear == np.arange(6)).all()


def test_blocks_of_runs_do_not_fall():
    problem = everything()
    assert problem.couplings[2].tolist() == [0, 0, 1, 1]
    with pytest.raises(Corrupt, match="block 0 after block 1"):
        qcf.parse_qcf(pack_qcf(problem, couplings=problem.raw.couplings[::-1]))


def test_labl_twice():
    with pytest.raises(Corrupt, match="each may be there once"):
        qcf.parse_qcf(pack_qcf(everything(), sides=everything().sides * 2))


def test_labl_without_scale():
    for labl in (b"", bytes(64), bytes(16) + b"\1\0\0"):
        with pytest.raises(Corrupt, match="labl"):
            qcf.parse_qcf(pack_qcf(everything(), sides=[("labl", labl)]))
    assert qcf.parse_qcf(FILES[0][0]).scale == 2 and qcf.parse_qcf(BASE).scale == 1


def record(energy=0, occurrences=1, broken=0):
    return struct.pack("<qII", energy, occurrences, broken) * 3


@pytest.mark.parametrize(
    "name, payload",
    [
        ("PROB", bytes(31)),
        ("PROB", bytes(33)),
        ("SOLV", b""),
        ("SOLV", b"a" * 256),
        ("SOLV", b"a\n"),
        ("SOLV", b"\xff"),
        ("SOLV", "a\x85".encode()),
        ("INFO", b""),
        ("INFO", b"[]"),
        ("INFO", b"{"),
        ("INFO", b'{"a": NaN}'),
        ("INFO", b"\xff"),
        ("INFO", b"[" * 100000),
        ("RECS", record()[:-1]),
        ("RECS", record() + record()),
        ("RECS", record(occurrences=0)),
        ("RECS", record(broken=10**9 + 1)),
        ("RECS", record(broken=2**32 - 2)),
        ("BITS", bytes(5)),
        ("BITS", bytes(7)),
        ("BITS", bytes(5) + b"\x08"),
    ],
)
def test_broken_qsf(name, payload):
    with pytest.raises(Corrupt, match=name):
        qsf.parse_qsf(rebuild(FILES[1][0], qsf.MAGIC, {name: payload}))


@pytest.mark.parametrize("n", [0, 2**31])
def test_broken_qsf_variables(n):
    with pytest.raises(Corrupt):
        qsf.parse_qsf(
            with_header(FILES[1][0], fields=qsf.FIELDS.pack(n, 3, bytes(28))), limit=2**60
        )


TWO = make([3, 3], [Table(np.ones((3, 3), "<i4"))], [{"weight": 1, "h": 1}], range(6),
           [(1, 1), (1, 2)])


@pytest.mark.parametrize("encoding, numbers, bits", [
    (1, [0, 2], [1, 0, 0, 0, 0, 1]), (2, [1, 1], [0, 1, 0, 0, 1, 0]),
    (3, [0, 3], [0, 0, 0, 1, 1, 1]), (3, [2, 1], [1, 1, 0, 1, 0, 0])])
@pytest.mark.parametrize("labels", [4, 256])
def test_best_is_a_state_and_a_bound(encoding, numbers, bits, labels):
    for bound in (-7, None):
        sides = carrying(encoding, labels, numbers, -2**63 if bound is None else bound)
        read = qcf.parse_qcf(pack_qcf(TWO, sides=[*sides, ("note", b"")]))
        assert read.known.tolist() == bits and read.stated_bound == bound
    assert qcf.parse_qcf(pack_qcf(TWO, sides=sides[:1])).known is None


@pytest.mark.parametrize("sides", [
    carrying(1, 4, [0, 3]), carrying(3, 4, [0, 4]), carrying(1, 4, [0]), carrying(1, 4, [0, 0, 0]),
    carrying(1, 4, [0, 0], 2**53 + 1), carrying(1, 4, [0, 0], -2**53 - 1),
    carrying(4, 4, [0, 0]), carrying(6, 4, [0, 0]), carrying(1, 4, [0, 0])[1:],
    carrying(1, 4, [0, 0])[::-1], carrying(1, 4, [0, 0]) + carrying(1, 4, [0, 0])[1:],
    [*carrying(1, 4, [0, 0]), ("kept", bytes(8))], [*carrying(1, 4, [0, 0]), ("mean", bytes(24))],
    [carrying(1, 256, [0, 0])[0], carrying(1, 4, [0, 0])[1]],
    [carrying(1, 4, [0, 0])[0], ("best", b"")]])
def test_best_that_is_nonsense(sides):
    with pytest.raises(Corrupt, match="chunk best|the side chunks are"):
        qcf.parse_qcf(pack_qcf(TWO, sides=sides))


def test_best_of_nothing():
    with pytest.raises(Corrupt, match="chunk best"):
        qcf.parse_qcf(pack_qcf(nothing(0, carrying(3, 4, []))))


def test_a_bound_above_the_labelling_beside_it():
    energy = int(models.energies(TWO, np.array([[1, 0, 0, 0, 0, 1]], np.uint8))[0])
    for above in (0, 1):
        read = qcf.parse_qcf(pack_qcf(TWO, sides=carrying(1, 4, [0, 2], energy + above)))
        if not above:
            models.check_known(read)
    with pytest.raises(Corrupt, match="one of them is wrong"):
        models.check_known(read)
