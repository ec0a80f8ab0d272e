"""The two checkers of certificates, in C and by numpy, agree: on golden files, on those that solve
and reduce write, and on the same with bytes changed."""

import itertools
import json
import os
import struct
import subprocess
from hashlib import sha256
from pathlib import Path

import google_crc32c
import numpy as np
import pytest
from qstereo_bridge.core import container
from qstereo_bridge.verify import certificate as checker
from qstereo_bridge.verify.certificate import FIELDS, MAGIC
from qstereo_bridge.core.container import FormatError
from qstereo_bridge.core.failure import Error
from qstereo_bridge.verify import verify

ROOT = Path(__file__).parents[2]
QSTEREO = os.environ.get("QSTEREO_PNM") or os.environ.get("QSTEREO", str(ROOT / "build/qstereo"))
GOLDEN = sorted((ROOT / "tests" / "golden").glob("*.qpf"))
HEADER, FRAME = 64, 16


def run(*words):
    return subprocess.run([QSTEREO, *map(str, words)], capture_output=True, timeout=60)


def by_c(*files):
    """What the command says: whether it is valid, or None if it refuses a file; and the bound."""
    done = run("verify", *files, "--json")
    if done.returncode not in (0, 1):
        assert done.returncode == 3, done.stderr
        return None, None
    facts = json.loads(done.stdout)
    assert facts["valid"] == (done.returncode == 0)
    return facts["valid"], facts["lower_bound"]


def by_numpy(*files):
    try:
        found = verify(*files)
    except (FormatError, Error):
        return None, None
    return found.valid, found.lower_bound


@pytest.mark.parametrize("path", GOLDEN, ids=lambda path: path.stem)
def test_golden_certificates(path):
    problem = path.with_suffix(".qcf")
    assert by_c(problem, problem, path) == by_numpy(problem, problem, path)
    assert by_c(problem, problem, path)[0]


def write_pair(folder, seed):
    rng = np.random.default_rng(seed)
    grey = rng.integers(0, 256, (2, 5, 9)).astype(np.uint8)
    for name, rows in zip(("left.pgm", "right.pgm"), grey):
        (folder / name).write_bytes(b"P5\n9 5\n255\n" + rows.tobytes())


def mended(data):
    """The bytes with right checksums."""
    data = bytearray(data)
    struct.pack_into("<I", data, 60, google_crc32c.value(bytes(data[:60])))
    at = HEADER
    while at < len(data):
        end = at + FRAME + struct.unpack_from("<Q", data, at + 8)[0]
        struct.pack_into("<I", data, end, google_crc32c.value(bytes(data[at:end])))
        at = end + 4
    return bytes(data)


def example_of_parts():
    """The stage that docs/FORMAT.md writes out, of tests/golden/good-smallest.qcf."""
    text = (ROOT / "docs/FORMAT.md").read_text().split("as one part, is the whole stage")[1]
    rows = [row.strip() for row in text.split("The table of site 0")[0].strip().splitlines()]
    return bytes.fromhex("".join(row.split("  ")[1] for row in rows))


@pytest.mark.parametrize("bound, valid", [(9, True), (10, False)])
def test_the_worked_example(tmp_path, bound, valid):
    problem = ROOT / "tests/golden/good-smallest.qcf"
    chunks = [("PROB", sha256(problem.read_bytes()).digest()),
              ("BEST", struct.pack("<I", 1) + bytes(2)), ("STGS", example_of_parts())]
    proof = tmp_path / "c.qpf"
    proof.write_bytes(container.pack(MAGIC, FIELDS.pack(2, 1, bound, 9, bytes(12)), chunks))
    assert by_c(problem, problem, proof)[0] == by_numpy(problem, problem, proof)[0] == valid


def test_a_solver_that_solves_parts(tmp_path, monkeypatch):
    problem, samples, proof = (tmp_path / name for name in ("p.qcf", "s.qsf", "c.qpf"))
    costs = np.random.default_rng(0).integers(0, 12, (20, 20, 4), dtype=np.int32)
    np.save(tmp_path / "costs.npy", costs)
    done = run("encode", "--problem", "label", tmp_path / "costs.npy", "-o", problem,
               "--lambda", "3", "--encoding", "one-hot-sparse")
    assert done.returncode == 0, done.stderr
    done = run("solve", problem, "-o", samples, "--certificate", proof, "--json")
    facts, solve, parts = json.loads(done.stdout), checker._solve_part, []
    monkeypatch.setattr(checker, "_solve_part", lambda *part: parts.append(part) or solve(*part))
    assert facts["proven_optimal"] and facts["lower_bound"] == facts["energy"]
    assert by_numpy(problem, samples, proof) == by_c(problem, samples, proof)
    assert by_c(problem, samples, proof) == (True, facts["energy"]) and parts


def both_refuse_what_is_not_so(problem, other, proof):
    """Bits changed under new checksums: the checkers agree, and some they refuse."""
    assert by_c(problem, other, proof) == by_numpy(problem, other, proof)
    assert by_c(problem, other, proof)[0]
    whole, rng, seen = proof.read_bytes(), np.random.default_rng(2), set()
    first = HEADER + FRAME + 36  # behind the digest
    best = first + FRAME + struct.unpack_from("<Q", whole, first + 8)[0] + 4
    for _ in range(12):
        data = bytearray(whole)
        at = int(rng.choice([rng.integers(32, 48), rng.integers(first + FRAME + 4, best - 4),
                             rng.integers(best + FRAME, len(whole) - 4)], p=[0.1, 0.1, 0.8]))
        data[at] ^= 1 << rng.integers(0, 8)
        proof.write_bytes(mended(data))
        verdict = by_c(problem, other, proof)
        assert verdict == by_numpy(problem, other, proof), at
        seen.add(verdict[0])
    assert len(seen) > 1


FORMS = [("potts", "one-hot-sparse"), ("potts", "domain-wall"), ("linear", "domain-wall"),
         ("quadratic", "one-hot")]


@pytest.mark.parametrize("smoothness, encoding", FORMS)
@pytest.mark.parametrize("command", ["solve", "reduce"])
def test_changed_certificates(tmp_path, smoothness, encoding, command):
    write_pair(tmp_path, 1)
    more = [] if smoothness == "potts" else ["--truncation", "2"]
    problem, other, proof = (tmp_path / name for name in ("p.qcf", "other", "c.qpf"))
    done = run("encode", tmp_path / "left.pgm", tmp_path / "right.pgm", "-o", problem,
               "--disparity", "0:3", "--lambda", "30", "--smoothness", smoothness, *more,
               "--encoding", encoding)
    assert done.returncode == 0, done.stderr
    done = run(command, problem, "-o", other, "--iterations", "3", "--certificate", proof,
               *(["--solver", "trws"] if command == "solve" else []))
    assert done.returncode == 0, done.stderr
    both_refuse_what_is_not_so(problem, other, proof)


def test_changed_certificates_of_large_costs(tmp_path):
    """Messages and shares of 64 bits."""
    problem, samples, proof = (tmp_path / name for name in ("p.qcf", "s.qsf", "c.qpf"))
    costs = np.random.default_rng(1).integers(0, 2**29, (5, 5, 3), dtype=np.int32)
    np.save(tmp_path / "costs.npy", costs)
    done = run("encode", "--problem", "label", tmp_path / "costs.npy", "-o", problem,
               "--lambda", str(2**29), "--encoding", "one-hot")
    assert done.returncode == 0, done.stderr
    done = run("solve", problem, "-o", samples, "--solver", "trws", "--certificate", proof)
    assert done.returncode == 0, done.stderr
    stages = checker.parse_qpf(proof.read_bytes())[5]
    assert stages.unpack("<4I")[3] == 8
    both_refuse_what_is_not_so(problem, samples, proof)


@pytest.mark.parametrize("command", ["solve", "reduce"])
def test_changed_certificates_of_wide_parts(tmp_path, command):
    """30 choices that exclude each other are too wide for exact tables: solve searches them; for
    reduce labels leave by trials."""
    problem, other, proof = (tmp_path / name for name in ("p.qcf", "other", "c.qpf"))
    edges = np.array(list(itertools.combinations(range(30), 2)))
    near = 40 - (edges[:, 1] - edges[:, 0])  # of boxes 40 wide, what two of them share
    arrays = {"costs": np.full((30, 2), (90, 0)), "pairs": [[0, 0], [0, 1]], "edges": edges,
              "weights": 400 * near // (80 - near)}
    for name, array in arrays.items():
        np.save(tmp_path / f"{name}.npy", np.array(array, np.int32))
    done = run("encode", "--problem", "label", tmp_path / "costs.npy", "-o", problem,
               "--pairwise", tmp_path / "pairs.npy", "--edges", tmp_path / "edges.npy",
               "--weights", tmp_path / "weights.npy")
    assert done.returncode == 0, done.stderr
    done = run(command, problem, "-o", other, "--certificate", proof, "--json")
    said = json.loads(done.stdout)
    assert said["lower_bound"] == said["energy" if command == "solve" else "upper_bound"]
    searched = struct.pack("<5I", 8, 0, 0, 0, 30) in proof.read_bytes()
    assert searched == (command == "solve")
    assert searched or checker.parse_qpf(proof.read_bytes())[4] > 2
    both_refuse_what_is_not_so(problem, other, proof)


def is_worse(problem, sets, p, d, e):
    """Goldstein's criterion: label d of a site costs more than e, whatever the neighbours have."""
    costs, edges, table = problem
    more = costs[p, d] - costs[p, e]
    for q in (sum(edge) - p for edge in edges if p in edge):
        more += min(table[d, b] - table[e, b] for b in sets[q])
    return more > 0


def compared(sets, gone):
    """A round in which labels leave: of sites (label to compare with, those that leave)."""
    bits = [d not in gone[p][1] for p in sorted(gone) for d in sorted(sets[p])]
    return (struct.pack("<I", len(gone)) + np.array(sorted(gone), "<u4").tobytes()
            + bytes(gone[p][0] for p in sorted(gone))
            + np.packbits(np.array(bits, bool), bitorder="little").tobytes())


@pytest.mark.parametrize("seed", range(12))
def test_labels_that_leave_by_comparison(tmp_path, seed):
    """Round after round all that are worse than some label; then one that is not."""
    rng, problem, samples, proof = np.random.default_rng(seed), *(
        tmp_path / name for name in ("p.qcf", "s.qsf", "c.qpf"))
    costs, label = rng.integers(0, 12, (1, 4, 5), dtype=np.int32), np.arange(5)
    np.save(tmp_path / "costs.npy", costs)
    done = run("encode", "--problem", "label", tmp_path / "costs.npy", "-o", problem, "--lambda",
               "1", "--smoothness", "quadratic", "--truncation", "6", "--encoding", "one-hot")
    assert done.returncode == 0, done.stderr
    done = run("solve", problem, "-o", samples, "--certificate", proof)
    assert done.returncode == 0, done.stderr
    digest, _, energy, labelling, _, _ = checker.parse_qpf(proof.read_bytes())
    facts = (costs[0].astype(int), [(0, 1), (1, 2), (2, 3)],
             np.minimum((label - label[:, None])**2, 6))

    def verdicts(rounds):
        chunks = [("PROB", digest), ("BEST", struct.pack("<I", 1) + labelling.tobytes()),
                  ("STGS", struct.pack("<4I", 2, 0, 0, 0) + b"".join(rounds) + bytes(4))]
        fields = FIELDS.pack(4, 1, checker.NO_BOUND, energy, bytes(12))
        proof.write_bytes(container.pack(MAGIC, fields, chunks))
        return by_c(problem, samples, proof)[0], by_numpy(problem, samples, proof)[0]

    sets, rounds = [set(range(5)) for _ in range(4)], []
    while True:
        found = {(p, e): {d for d in sets[p] if is_worse(facts, sets, p, d, e)}
                 for p in range(4) for e in sets[p] if len(sets[p]) > 1}
        gone = {p: (e, leave) for (p, e), leave in found.items() if leave}
        if not gone:
            break
        rounds.append(compared(sets, gone))
        for p, (_, leave) in gone.items():
            sets[p] -= leave
    assert rounds and verdicts(rounds) == (True, True)
    wrong = [(p, d, e) for p, own in enumerate(sets) for d in own for e in own - {d}]
    if wrong:
        p, d, e = wrong[rng.integers(len(wrong))]
        assert verdicts([*rounds, compared(sets, {p: (e, {d})})]) == (False, False)
