"""C and Python, the two implementations of FORMAT.md, agree on golden and on random files."""

import re
import struct
import sys

import google_crc32c
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from library import Qubo, ROOT
from qstereo_bridge.core import models, qcf, qsf
from qstereo_bridge.core.container import Corrupt

sys.path.insert(0, str(ROOT / "tests" / "bridge"))

from problems import pack_qcf, random_problem

GOLDEN = sorted((ROOT / "tests" / "golden").glob("good-*.qcf"))


def python_terms(problem):
    linear, (rows, columns, values), offset = models.expand(problem)
    return linear.tolist(), dict(zip(zip(rows.tolist(), columns.tolist()), values.tolist())), offset


def agree(data):
    problem = qcf.parse_qcf(data)
    n = problem.linear.size
    c = Qubo(data)
    assert c.terms(n) == python_terms(problem)
    bits = np.random.default_rng(n).integers(0, 2, (20, n), dtype=np.uint8)
    assert [c.energy(sample) for sample in bits] == models.energies(problem, bits).tolist()
    bqm = models.to_bqm(problem)
    assert bqm.energies((bits, range(n))).tolist() == [c.energy(sample) for sample in bits]
    return problem, c


@pytest.mark.parametrize("path", GOLDEN, ids=lambda path: path.stem)
def test_golden_problems(path):
    data = path.read_bytes()
    problem, c = agree(data)
    samples = qsf.parse_qsf(path.with_suffix(".qsf").read_bytes())
    assert samples.records["energy"].tolist() == models.energies(problem, samples.bits).tolist()
    assert models.feasible(problem, samples.bits).tolist() == [True, True, False]
    packed = qsf.pack_qsf(samples).replace(b'{"by":"hand"}', b'{"by": "hand"}')
    assert packed[-50:] == path.with_suffix(".qsf").read_bytes()[-50:]
    # The constrained model's objective is H on every feasible state.
    cqm = models.to_cqm(problem)
    for sample in samples.bits[:2]:
        assert cqm.objective.energy(dict(enumerate(sample.tolist()))) == c.energy(sample)
        assert cqm.check_feasible(dict(enumerate(sample.tolist())))
    if "quadratic" not in path.stem:
        assert c.energy(c.repair(samples.bits[2])) <= c.energy(samples.bits[2])
    assert models.feasible(problem, c.repair(samples.bits[2])[None]).all()


@pytest.mark.parametrize("path",
                         sorted((ROOT / "tests" / "golden").glob("recoded-*.qcf")),
                         ids=lambda path: path.stem)
def test_golden_problems_of_every_encoding(path):
    data = path.read_bytes()
    problem, c = agree(data)
    samples = qsf.parse_qsf(path.with_suffix(".qsf").read_bytes())
    energies = samples.records["energy"].tolist()
    assert energies == models.energies(problem, samples.bits).tolist()
    assert energies == [c.energy(bits) for bits in samples.bits]
    assert all(c.energy(c.repair(bits)) <= energy for bits, energy in zip(samples.bits, energies))
    assert c.repair(samples.bits[0]).tolist() == samples.bits[0].tolist()


def test_both_read_what_a_file_carries(run):
    """Truncated costs are not in H: C adds what was trimmed where the labelling pays it."""
    path = ROOT / "tests" / "golden" / "recoded-known.qcf"
    problem, facts = qcf.parse_qcf(path.read_bytes()), run("qstereo", "info", path, "--json")
    assert problem.stated_bound == facts["stated_lower_bound"] == 200
    trimmed = models.energies(problem, problem.known[None])[0]
    assert 200 <= trimmed <= facts["known_energy"] == 698


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 2**32))
def test_random_problems_written_by_python(seed):
    problem = random_problem(seed)
    # Side chunks are made up; C reads the labels' chunk, and would refuse it.
    agree(pack_qcf(problem, sides=[]))


@pytest.mark.parametrize("seed", range(20))
def test_random_pictures_encoded_by_c(seed, run, tmp_path):
    """H of the file on labellings beside F computed here from the pictures."""
    random = np.random.default_rng(seed)
    width, height, labels = random.integers(4, 9), random.integers(1, 5), random.integers(1, 4)
    left, right = random.integers(0, 256, (2, height, width), dtype=np.uint8)
    for name, picture in (("left.pgm", left), ("right.pgm", right)):
        (tmp_path / name).write_bytes(b"P5 %d %d 255\n" % (width, height) + picture.tobytes())
    smoothness = ["potts", "linear", "quadratic"][seed % 3]
    bound = [] if smoothness == "potts" else ["--truncation", "1" if seed % 2 else "3"]
    encoding = ["--encoding", "one-hot"] if seed % 4 == 0 else []
    weight = ["20", "12.5", "0.3", "0"][seed % 4]
    run("qstereo", "encode", "left.pgm", "right.pgm", "-o", "p.qcf", "--disparity",
        f"0:{labels - 1}", "--lambda", weight, "--smoothness", smoothness, *bound, *encoding,
        "--penalty", "paper" if seed % 5 == 0 else "local")
    data = (tmp_path / "p.qcf").read_bytes()
    small = width * height * labels < 100
    problem, c = agree(data) if small else (qcf.parse_qcf(data), Qubo(data))
    scale = problem.scale
    columns = np.arange(labels - 1, width)
    theta = [np.abs(left[:, columns].astype(int) - right[:, columns - d]) for d in range(labels)]
    theta = np.stack(theta, axis=-1)
    for _ in range(20):
        w = random.integers(0, labels, theta.shape[:2])
        apart = np.concatenate([(w[:, 1:] - w[:, :-1]).ravel(), (w[1:] - w[:-1]).ravel()])
        cost = {"potts": apart != 0, "linear": np.abs(apart), "quadratic": apart**2}[smoothness]
        pairwise = np.minimum(cost, int(bound[1])) if bound else cost
        f = np.take_along_axis(theta, w[..., None], -1).sum() * scale
        f += round(float(weight) * scale) * pairwise.sum()
        bits = (w.reshape(-1, 1) == np.arange(labels)).astype(np.uint8).ravel()
        assert c.energy(bits) == f
        assert models.energies(problem, bits[None]).tolist() == [f]


@pytest.mark.parametrize("seed", range(24))
def test_every_encoding_of_random_pictures(seed, run, tmp_path):
    random = np.random.default_rng(seed)
    width, height, labels = random.integers(3, 5), random.integers(1, 4), random.integers(2, 4)
    left, right = random.integers(0, 256, (2, height, width + labels - 1), dtype=np.uint8)
    for name, picture in (("left.pgm", left), ("right.pgm", right)):
        (tmp_path / name).write_bytes(b"P5 %d %d 255\n" % picture.shape[::-1] + picture.tobytes())
    encoding, smoothness = [("one-hot", "potts"), ("one-hot-sparse", "linear"),
                            ("domain-wall", "potts"), ("domain-wall", "linear"),
                            ("multiway-cut", "potts"), ("st-cut", "linear"),
                            ("st-cut-arcs", "linear"), ("one-hot-sparse", "potts")][seed % 8]
    small = seed % 8 in (4, 6)  # encodings with many variables
    roi = ["--roi", f"{labels - 1},0,2,1"] if small else []
    reduce = ["--reduce", *(["--target", "12"] if "hot" in encoding or "wall" in encoding else [])]
    options = [*(["--truncate"] if seed % 3 == 0 else []), *(reduce if seed % 3 == 1 else [])]
    run("qstereo", "encode", "left.pgm", "right.pgm", "-o", "p.qcf", "--disparity",
        f"0:{labels - 1}", "--smoothness", smoothness, *roi, "--encoding", encoding, "--lambda",
        "0.5" if seed % 5 == 0 else "7", *options)
    agree((tmp_path / "p.qcf").read_bytes())


def resealed(data, changes):
    """A .qcf with the payloads of some chunks replaced and every checksum mended."""
    body, at = b"", 64
    while at < len(data):
        name, length = data[at:at + 4], int.from_bytes(data[at + 8:at + 16], "little")
        payload = changes.get(name.decode(), data[at + 16:at + 16 + length])
        chunk = name + bytes(4) + len(payload).to_bytes(8, "little") + payload
        body += chunk + google_crc32c.value(chunk).to_bytes(4, "little")
        at += 20 + length
    header = data[:16] + (64 + len(body)).to_bytes(8, "little") + data[24:60]
    return header + google_crc32c.value(header).to_bytes(4, "little") + body


def run_of_couplings(block, g, h, weight=1):
    return struct.pack("<IIIiIIIII", block, 0, 0, weight, g, h, 1, 1, 0)


BROKEN = [
    # A width of 2 where 1 would do.
    {"PNLT": struct.pack("<IIIHH", 2, 0, 2, 1, 5)},
    # Neighbouring runs alike.
    {"PNLT": struct.pack("<IIIBBIBB", 1, 0, 1, 1, 5, 1, 1, 5)},
    # A penalised group coupled with itself.
    {"CPLS": struct.pack("<I", 1) + run_of_couplings(0, 1, 1)},
    # No such block.
    {"CPLS": struct.pack("<I", 1) + run_of_couplings(1, 0, 1)},
    # A weight of 0 for all.
    {"CPLS": struct.pack("<I", 1) + run_of_couplings(0, 0, 1, 0)},
    # A block that fits no groups.
    {"BLKS": struct.pack("<IIIIiiIi", 1, 2, 3, 1, 0, 0, 1, -1)},
    # Neighbouring runs alike.
    {"GRPS": struct.pack("<IIII", 1, 2, 1, 2)},
]


@pytest.mark.parametrize("changes", BROKEN, ids=lambda changes: next(iter(changes)))
def test_both_refuse(changes):
    data = (ROOT / "tests" / "golden" / "good-smallest.qcf").read_bytes()
    agree(resealed(data, {}))
    broken = resealed(data, changes)
    with pytest.raises(Corrupt):
        qcf.parse_qcf(broken)
    with pytest.raises(ValueError, match="7"):  # QS_E_CORRUPT
        Qubo(broken)


def test_blocks_stand_in_order():
    data = (ROOT / "tests" / "golden" / "good-edges-table.qcf").read_bytes()
    block = data[data.index(b"BLKS") + 20:][:48]
    for order, good in (((0, 1), True), ((1, 0), False)):
        runs = b"".join(
            struct.pack("<IIIiIIIII", block, 0, 0, 1, g, g + 1, 2 - g, 1, 0)
            for block, g in zip(order, (0, 1)))
        changed = resealed(data, {
            "BLKS": struct.pack("<I", 2) + 2*block,
            "CPLS": struct.pack("<I", 2) + runs
        })
        changed = changed[:32] + (3).to_bytes(8, "little") + changed[40:]
        changed = resealed(changed, {})
        if good:
            agree(changed)
        else:
            with pytest.raises(Corrupt):
                qcf.parse_qcf(changed)
            with pytest.raises(ValueError, match="7"):
                Qubo(changed)


def test_worked_example_of_the_specification():
    """The hex dump in FORMAT.md is the golden file, byte for byte."""
    text = (ROOT / "docs" / "FORMAT.md").read_text()
    lines = text.split("A worked example\n")[1].splitlines()
    found = [re.match(r"    ([0-9A-F]{3})  ((?:[0-9A-F]{2} ?)+)", line) for line in lines]
    dump = b"".join(bytes.fromhex(match[2]) for match in found if match)
    assert dump == (ROOT / "tests" / "golden" / "good-smallest.qcf").read_bytes()
    at = 0
    for match in filter(None, found):
        assert int(match[1], 16) == at
        at += len(bytes.fromhex(match[2]))
