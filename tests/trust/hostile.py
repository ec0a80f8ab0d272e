"""Files that were made to hurt: problems and certificates, each sound in all its checksums and
wrong in one promise of docs/FORMAT.md."""

import hashlib
import struct
import sys
from pathlib import Path

import numpy as np
from qstereo_bridge.verify import certificate
from qstereo_bridge.core import container

sys.path.insert(0, str(Path(__file__).parents[1] / "bridge"))
from problems import RUN, Raw, Toeplitz  # noqa: E402

GRID, MASK, TRUNCATION, GAP, PENALTY, PICTURE = 32, 60, 8, 24, 20, 40


def labl(labels, width=0, height=0, mask=b"", **fields):
    """The payload of labl: Potts, one-hot, local; `fields` are u32 values by their names above."""
    values = bytearray(
        struct.pack(
            "<IIIIIIIiIIIIIIII",
            1,
            0,
            0,
            labels,
            1,
            0,
            1,
            1,
            width,
            height,
            width,
            height,
            0,
            0,
            0,
            int(bool(mask)),
        )
    )
    for name, value in fields.items():
        struct.pack_into("<I", values, globals()[name], value)
    return bytes(values) + mask


def kept(sites, width=0, rest=b""):
    return struct.pack("<II", sites, width) + rest


def best(labels, bound=-(2**63), width=1, zero=0):
    """The payload of best: a label of each group."""
    return struct.pack("<qII", bound, width, zero) + bytes(labels)


def problem(groups, size=2, runs=(), sides=()):
    """Groups of `size` one-hot variables, coupled by lattice runs as Potts is: what to pack()."""
    made = [
        dict(zip(RUN, (0, 0, 0, 1, g, h, count, repeat, stride)))
        for g, h, count, repeat, stride in runs
    ]
    block = Toeplitz((size, size), 1, 0, np.array([0], "<i4"))
    return Raw(
        [size] * groups,
        [block],
        made,
        np.zeros(groups * size, np.int64),
        [(9, 9)] * groups,
        0,
        list(sides),
    )


def with_couplings(data, couplings):
    """The file with another number of couplings in its header."""
    fields = bytearray(data[24:60])
    struct.pack_into("<Q", fields, 8, couplings)
    head = data[:24] + bytes(fields)
    return head + struct.pack("<I", container.google_crc32c.value(head)) + data[64:]


def chain(groups):
    return [(0, 1, groups - 1, 1, 0)]


def sound():
    """Files that every reader takes: the ones below differ from them in one place."""
    yield "chain", problem(6, runs=chain(6), sides=[("labl", labl(2))]).pack()
    yield "grid", problem(6, runs=[(0, 1, 2, 2, 3)], sides=[("labl", labl(2, 3, 2))]).pack()
    yield "masked", problem(6, sides=[("labl", labl(2, 4, 2, b"\x7e"))]).pack()
    cuts = ("trnc", struct.pack("<II", 1, 0) + bytes(12))
    mean = ("mean", struct.pack("<6I", 1, 0, 0, 0, 0, 0))
    every = [("labl", labl(2)), ("more", b"?"), mean, ("kept", kept(6)), ("more", b""), cuts]
    yield "all side chunks, and unknown ones among them", problem(6, sides=every).pack()
    yield "kept", problem(6, sides=[("labl", labl(2)), ("kept", kept(6))]).pack()
    carried = [("labl", labl(2)), ("best", best([0, 1, 0, 1, 1, 0], 2))]
    yield "best", problem(6, runs=chain(6), sides=carried).pack()
    yield "pairs as many as 16 a byte", problem(2000, 1, [(0, 1, 1999, 1, 0)] * 25).pack()


def hostile():
    """(name, bytes, whether the bridge, which reads no labels, refuses it too)."""
    fixed = kept(6, 1, bytes([255] * 6 + [3] * 6))
    sides = {
        "a mask without a grid": (labl(2, MASK=1), True),
        "a mask without a grid and sites in kept": (labl(2, MASK=1), True, fixed),
        "a mask of kind 2": (labl(2, 3, 2, MASK=2), False),
        "bytes after labl": (labl(2, 3, 2) + b"\0", False),
        "a mask that is cut short": (labl(2, 8, 2, b"\x7e"), True),
        "a mask that is too long": (labl(2, 3, 2, b"\x3f\0"), True),
        "a grid without a mask, sites fewer": (labl(2, 4, 2), False),
        "a picture without a grid": (labl(2, PICTURE=5), False),
        "a truncation of Potts": (labl(2, TRUNCATION=1), False),
        "a gap of the paper's penalty": (labl(2, PENALTY=1, GAP=2), False),
        "more sites than groups": (labl(2), False, kept(7)),
        "sites without end": (labl(2), False, kept(2**32 - 1)),
        "a grid without end": (labl(2, 65535, 32767), False),
    }
    for name, (labels, both, *more) in sides.items():
        chunks = [("labl", labels), *(("kept", chunk) for chunk in more)]
        yield name, problem(6, runs=chain(6), sides=chunks).pack(), both
    six = [0, 1, 0, 1, 1, 0]
    known = {
        "best with a label that is none": [best([0, 1, 2, 0, 0, 0])],
        "best with a label too few": [best(six[:5])],
        "best with a label too many": [best([*six, 0])],
        "best in wide numbers": [best(12 * [0], width=2)],
        "best without a width": [best([], width=0)],
        "best with its reserved field in use": [best(six, zero=1)],
        "best with a bound beyond 2^53": [best(six, 2**53 + 1)],
        "best that ends in its head": [best(six)[:15]],
        "best twice": [best(six), best(six)],
    }
    for name, chunks in known.items():
        chunks = [("labl", labl(2)), *(("best", chunk) for chunk in chunks)]
        yield name, problem(6, runs=chain(6), sides=chunks).pack(), True
    yield (
        "best before kept",
        problem(6, sides=[("labl", labl(2)), ("best", best(six)), ("kept", kept(6))]).pack(),
        True,
    )
    yield "best without labl", problem(6, sides=[("best", best(six))]).pack(), True
    cut = struct.pack("<II", 1, 0)
    yield (
        "trnc of a grid without end",
        problem(6, sides=[("labl", labl(2, 65535, 32767)), ("trnc", cut)]).pack(),
        False,
    )
    yield (
        "trnc before kept",
        problem(
            6,
            sides=[
                ("labl", labl(2, 65535, 32767)),
                ("trnc", cut + bytes(12)),
                ("kept", kept(6)),
            ],
        ).pack(),
        True,
    )
    labels, mean, keeps, cuts = (
        ("labl", labl(2)),
        ("mean", struct.pack("<6I", 1, 0, 0, 0, 0, 0)),
        ("kept", kept(6)),
        ("trnc", cut + bytes(12)),
    )
    for name, order in {
        "kept before labl": [keeps, labels],
        "mean before labl": [mean, labels],
        "mean after kept": [labels, keeps, mean],
        "trnc before mean": [labels, cuts, mean],
        "trnc before kept, all else right": [labels, cuts, keeps],
        "labl twice": [labels, labels],
        "mean twice": [labels, mean, mean],
        "kept twice": [labels, keeps, keeps],
        "trnc twice": [labels, cuts, cuts],
        "kept without labl": [keeps],
        "trnc without labl": [cuts],
    }.items():
        yield name, problem(6, sides=order).pack(), True
    for name, runs in {
        "a lattice on the spot": [(0, 1, 1, 2**24, 0)],
        "a lattice with short steps": [(0, 1, 3, 3, 1)],
        "more pairs than 16 a byte": [(0, 1, 1999, 1, 0)] * 100,
    }.items():
        size = 1 if len(runs) > 1 else 2
        made = problem(2000 if len(runs) > 1 else 6, size, runs)
        yield name, made.pack(), True
    yield "pairs in the header alone", with_couplings(problem(6).pack(), 2**31 - 1), True


SITES = 6  # of the problem that the certificates below are about: a chain of free choices


def proof(held=b"", bound=-(2**63), energy=0, about=None, **other):
    """A certificate of the sound problem `chain`, or of another of (file, sites). `other` replaces
    fields by their names."""
    problem_file, sites = about or (dict(sound())["chain"], SITES)
    found = {
        "sites": sites,
        "stages": 1 if held else 0,
        "digest": hashlib.sha256(problem_file).digest(),
        "best": struct.pack("<I", 1) + bytes(sites),
        **other,
    }
    return container.pack(
        certificate.MAGIC,
        certificate.FIELDS.pack(found["sites"], found["stages"], bound, energy, bytes(12)),
        [("PROB", found["digest"]), ("BEST", found["best"]), ("STGS", held)],
    )


def parts(*sites, value=0, end=True):
    """A stage that solves one part."""
    return struct.pack(f"<IIIIIq{len(sites)}I", 4, 0, 0, 0, len(sites), value, *sites) + (
        bytes(4) if end else b""
    )


def searched(*sites, bounds, end=True):
    """A stage that searches one part."""
    return struct.pack(
        f"<IIIII{len(sites)}I{len(bounds)}q", 8, 0, 0, 0, len(sites), *sites, *bounds
    ) + (bytes(4) if end else b"")


def split(scale=1, slot_width=1, share_width=4, has=1, rest=bytes(2 * (SITES - 1))):
    """A stage with a split: in the chain each edge has the one slot of its sites, and no shares."""
    return struct.pack("<IIII", has, scale, slot_width, share_width) + rest


def compared(site, label, bits):
    """A stage in which labels leave a site as worse than one label; bits tell which stay."""
    return struct.pack("<IIIIIIBB", 2, 0, 0, 0, 1, site, label, bits)


def sound_proofs():
    every = tuple(range(SITES))
    yield "of nothing", proof()
    yield "of a part", proof(parts(*every), bound=0)
    yield "of a split", proof(split(), bound=0)
    yield "of a split with wide shares", proof(split(share_width=8), bound=0)
    yield "of a search", proof(searched(*every, bounds=[0] * SITES), bound=0)
    yield "of the largest scale", proof(split(2**30), bound=0)
    yield "of 4096 stages", proof(split() * 4096, stages=4096, bound=0)


def hostile_proofs():
    """(name, bytes, whether the file is sound and only what it states is wrong)."""
    every = tuple(range(SITES))
    for name, stages, is_sound in (
        ("a part without end", parts(*every, end=False), False),
        ("a part of more sites than there are", parts(*every, 0), False),
        ("a part of 2^32 - 1 sites", struct.pack("<IIIIIq", 4, 0, 0, 0, 2**32 - 1, 0), False),
        ("a part with a site that there is not", parts(*every[:-1], 2**32 - 1), False),
        ("a part whose neighbours are outside", parts(0), False),
        ("no part", struct.pack("<IIIII", 4, 0, 0, 0, 0), False),
        ("a part twice", parts(*every, end=False) + parts(*every)[16:], False),
        ("a part of the largest energy", parts(*every, value=2**63 - 1), True),
        ("a part of the least energy", parts(*every, value=-(2**63)), True),
        ("a search of no sites", searched(bounds=[]), False),
        ("a search without end", searched(*every, bounds=[0] * SITES, end=False), False),
        ("a search of too few bounds", searched(*every, bounds=[0] * (SITES - 1)), False),
        ("a search of a site twice", searched(*every[:-1], 0, bounds=[0] * SITES), False),
        ("a search with neighbours outside", searched(0, bounds=[0]), False),
        ("a search of 2^32 - 1 sites", struct.pack("<IIIII", 8, 0, 0, 0, 2**32 - 1), False),
        ("a search of a bound of 2^53 + 1", searched(*every, bounds=[2**53 + 1] * SITES), False),
        ("a search of a bound of -2^63", searched(*every, bounds=[-(2**63)] * SITES), False),
        ("a search of the largest bound", searched(*every, bounds=[2**53] * SITES), True),
        ("a search of a bound 1 too high", searched(*every, bounds=[1] + [0] * (SITES - 1)), True),
        ("a scale of 2^32 - 1", split(2**32 - 1), False),
        ("a scale of 2^30 + 1", split(2**30 + 1), False),
        ("a scale of 0", split(0), False),
        ("slots of 3 bytes", split(slot_width=3), False),
        ("shares of 16 bytes", split(share_width=16), False),
        ("slots beyond the last", split(rest=bytes([255]) * 2 * (SITES - 1)), False),
        ("a split cut short", split()[:-1], False),
        ("a split and a part", split(has=5) + parts(*every)[16:], False),
        ("a stage of another kind", split(has=2**31), False),
        ("labels that leave all", split(0, 0, 0, 2, bytes(SITES)), False),
        ("labels that leave without a reason", compared(0, label=0, bits=1), True),
        ("a comparison with a label that there is not", compared(0, label=2, bits=1), False),
        ("a comparison at a site that there is not", compared(SITES, label=0, bits=1), False),
        ("a comparison after which no label is left", compared(0, label=0, bits=0), False),
        ("bytes after the last stage", parts(*every) + b"\0", False),
    ):
        yield name, proof(stages), is_sound
    yield "more stages than bytes", proof(parts(*every), stages=4096), False
    yield "4097 stages", proof(split() * 4097, stages=4097), False
    yield "stages without end", proof(parts(*every), stages=2**32 - 1), False
    yield "sites without end", proof(sites=2**32 - 1), False
    yield "a label too few", proof(best=struct.pack("<I", 1) + bytes(SITES - 1)), False
    yield "a label that there is not", proof(best=struct.pack("<I", 1) + b"\2" * SITES), False
    yield "labels of 2^31 bytes", proof(best=struct.pack("<I", 2**31) + bytes(SITES)), False
    yield "a digest too short", proof(digest=bytes(31)), False
    yield "another problem", proof(digest=bytes(32)), True
    yield "a bound of 2^63 - 1", proof(parts(*every), bound=2**63 - 1), True
    yield "an energy of -2^63", proof(parts(*every), energy=-(2**63)), True
