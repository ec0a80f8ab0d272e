"""Certificates: solve and reduce write them, verify checks them."""

import itertools
import json
import struct

import numpy as np
import pytest
from cli_tools import _crc32c, random_pair, run


@pytest.fixture
def folder(tmp_path):
    """A problem of 10 x 6 sites and three labels."""
    _, _, left, right = random_pair(tmp_path, 12, 6)
    done = run(
        "encode", left, right, "-o", tmp_path / "p.qcf", "--disparity", "0:2", "--lambda", "62.5"
    )
    assert done.status == 0, done.err
    return tmp_path


def solve(folder, *more):
    done = run(
        "solve",
        *[folder / "p.qcf", "-o", folder / "s.qsf", "--certificate", folder / "c.qpf", "--json"],
        *more,
    )
    assert done.status == 0, done.err
    return json.loads(done.out)


def verify(folder, second="s.qsf", certificate="c.qpf"):
    done = run("verify", folder / "p.qcf", folder / second, folder / certificate, "--json")
    return done, json.loads(done.out) if done.out else None


def changed(folder, at, more):
    """The certificate with a number of its header changed, under a new checksum."""
    whole = bytearray((folder / "c.qpf").read_bytes())
    number = struct.unpack_from("<q", whole, at)[0] + more
    struct.pack_into("<q", whole, at, number)
    struct.pack_into("<I", whole, 60, _crc32c(bytes(whole[:60])))
    (folder / "changed.qpf").write_bytes(whole)
    return verify(folder, certificate="changed.qpf")


@pytest.mark.parametrize("solver", ["trws", "best"])
def test_of_a_solver(folder, solver):
    said = solve(folder, "--solver", solver)
    done, facts = verify(folder)
    assert (done.status, done.err) == (0, "")
    stages = facts.pop("stages")
    assert facts == {
        "schema": 1,
        "valid": True,
        "why": None,
        "energy": said["energy"],
        "lower_bound": said["lower_bound"],
        "proven_optimal": said["proven_optimal"],
    }
    assert stages == 1 if solver == "trws" else stages > 1  # labels leave on the way
    text = run("verify", folder / "p.qcf", folder / "s.qsf", folder / "c.qpf").out.decode()
    assert text.startswith("valid: energy ")


BOUND, ENERGY = 32, 40


def test_a_bound_raised_by_one(folder):
    solve(folder)
    done, facts = changed(folder, BOUND, 1)
    assert (done.status, facts["valid"]) == (1, False)
    assert "higher bound than it proves" in facts["why"] and facts["why"] in done.err
    assert changed(folder, BOUND, -1)[1]["valid"]


def test_another_energy(folder):
    solve(folder)
    for more in (1, -1):
        done, facts = changed(folder, ENERGY, more)
        assert (done.status, facts["valid"]) == (1, False)


def test_a_labelling_that_is_worse(folder):
    said = solve(folder)
    done = run("solve", folder / "p.qcf", "-o", folder / "s.qsf", "--solver", "icm", "--json")
    worse = json.loads(done.out)["energy"]
    if worse == said["energy"]:
        pytest.fail("icm has found the optimum: choose another pair")
    done, facts = verify(folder)
    assert (done.status, facts["valid"], facts["energy"]) == (1, False, worse)
    assert "best sample costs more" in facts["why"]


def test_every_flipped_byte_is_refused(folder):
    solve(folder)
    whole = (folder / "c.qpf").read_bytes()
    for at in range(0, len(whole), 41):
        damaged = bytearray(whole)
        damaged[at] ^= 1
        (folder / "d.qpf").write_bytes(damaged)
        done, facts = verify(folder, certificate="d.qpf")
        assert (done.status, facts) == (3, None)
        assert "d.qpf: " in done.err


@pytest.mark.parametrize("encoding", ["one-hot-sparse", "domain-wall"])
def test_of_a_reduction(folder, encoding):
    done = run(
        "reduce",
        *[folder / "p.qcf", "-o", folder / "small.qcf", "--certificate", folder / "c.qpf"],
        *["--encoding", encoding, "--json"],
    )
    assert done.status == 0, done.err
    said = json.loads(done.out)
    done, facts = verify(folder, "small.qcf")
    assert (done.status, facts["valid"]) == (0, True)
    assert (facts["energy"], facts["lower_bound"]) == (said["upper_bound"], said["lower_bound"])


def test_a_label_that_has_left_without_proof(folder):
    done = run("reduce", folder / "p.qcf", "-o", folder / "small.qcf")
    assert done.status == 0, done.err
    solve(folder, "--solver", "trws")  # a certificate by which no label leaves
    done, facts = verify(folder, "small.qcf")
    assert (done.status, facts["valid"]) == (1, False)
    assert "has left the reduced problem" in facts["why"]


def test_of_another_problem(folder):
    solve(folder)
    (folder / "p.qcf").rename(folder / "other.qcf")
    done = run("reduce", folder / "other.qcf", "-o", folder / "p.qcf", "--iterations", "1")
    assert done.status == 0, done.err
    done = run("solve", folder / "p.qcf", "-o", folder / "s.qsf")
    done, facts = verify(folder)
    assert done.status == 1 and "another problem" in facts["why"]


@pytest.mark.parametrize("solver", ["icm", "expansion", "swap", "bp", "anneal"])
def test_solvers_without_a_certificate(folder, solver):
    done = run(
        "solve",
        *[folder / "p.qcf", "-o", folder / "n.qsf", "--certificate", folder / "n.qpf"],
        *["--solver", solver],
    )
    assert (done.status, done.out) == (3, b"")
    assert f"{solver} writes no certificate" in done.err
    assert not (folder / "n.qsf").exists() and not (folder / "n.qpf").exists()


@pytest.mark.parametrize(
    "words",
    [
        ["solve", "--solver", "best"],
        ["solve", "--solver", "trws"],
        ["reduce"],
    ],
)
def test_costs_of_64_bits(tmp_path, words):
    costs = np.random.default_rng(1).integers(0, 2**29, (6, 6, 3), dtype=np.int32)
    np.save(tmp_path / "costs.npy", costs)
    problem, proof = tmp_path / "p.qcf", tmp_path / "c.qpf"
    made = run(
        *["encode", "--problem", "label", tmp_path / "costs.npy", "-o", problem],
        *["--lambda", str(2**29), "--encoding", "one-hot"],
    )
    assert made.status == 0, made.err
    out = tmp_path / "out"
    alone = run(words[0], problem, "-o", out, *words[1:], "--json")
    done = run(words[0], problem, "-o", out, "--certificate", proof, *words[1:], "--json")
    assert (done.status, done.err) == (0, "")
    said, bound = json.loads(done.out), json.loads(alone.out)["lower_bound"]
    assert said["lower_bound"] >= bound
    done, facts = verify(tmp_path, second="out")
    assert done.status == 0 and facts["lower_bound"] == said["lower_bound"]


def test_expansion_from_messages_has_no_certificate(folder):
    """With a time limit it begins with messages, whose proof would not be its own."""
    words = ["--solver", "expansion", "--time-limit", "9", "--certificate", folder / "c.qpf"]
    done = run("solve", folder / "p.qcf", "-o", folder / "s.qsf", *words)
    assert done.status == 3
    assert "expansion writes no certificate" in done.err
    assert not (folder / "c.qpf").exists()


def make_crowd(tmp_path, boxes, side):
    """A choice among boxes that overlap so much that no exact table of them fits."""
    at = np.random.default_rng(1).integers(0, side, (boxes, 2)).tolist()
    rows = [f"a,{x},{y},40,40,0.{5 + i % 3}" for i, (x, y) in enumerate(at)]
    csv = tmp_path / "boxes.csv"
    csv.write_text("\n".join(["picture,x,y,width,height,score", *rows]) + "\n")
    done = run("encode", "--problem", "detect", csv, "-o", tmp_path / "p.qcf")
    assert done.status == 0, done.err
    return tmp_path


def test_what_packing_proves_is_searched_again(tmp_path):
    crowd = make_crowd(tmp_path, 80, 50)
    words = ["solve", crowd / "p.qcf", "-o", crowd / "s.qsf", "--certificate", crowd / "c.qpf"]
    done = run(*words, "--json")
    said = json.loads(done.out)
    assert (said["proven_optimal"], done.err) == (True, "")
    done, facts = verify(crowd)
    assert done.status == 0 and facts["lower_bound"] == said["lower_bound"]


def test_what_reduce_leaves_is_searched(tmp_path):
    crowd = make_crowd(tmp_path, 80, 50)
    done = run("solve", crowd / "p.qcf", "-o", crowd / "s.qsf", "--json")
    least = json.loads(done.out)["energy"]
    words = ["reduce", crowd / "p.qcf", "-o", crowd / "r.qcf", "--certificate", crowd / "c.qpf"]
    done = run(*words, "--iterations", "20", "--json")
    said = json.loads(done.out)
    assert (said["lower_bound"], said["sites_after"], done.err) == (least, 80, "")
    done, facts = verify(crowd, second="r.qcf")
    assert done.status == 0 and facts["lower_bound"] == least


def test_what_takes_packing_too_long_is_in_no_certificate(tmp_path):
    crowd = make_crowd(tmp_path, 120, 100)
    done = run("solve", crowd / "p.qcf", "-o", crowd / "s.qsf", "--json")
    alone = json.loads(done.out)
    assert (alone["proven_optimal"], done.err) == (True, "")
    done = run(
        *["solve", crowd / "p.qcf", "-o", crowd / "s.qsf", "--certificate", crowd / "c.qpf"],
        *["--iterations", "20", "--json"],
    )
    said = json.loads(done.out)
    assert said["energy"] == alone["energy"]
    assert said["lower_bound"] < alone["lower_bound"] and not said["proven_optimal"]
    for words in (
        f"warning: the solver found the lower bound {alone['lower_bound']:g},",
        f"the certificate cannot hold it and proves {said['lower_bound']:g}:",
    ):
        assert words in done.err
    done, facts = verify(crowd)
    assert done.status == 0 and facts["lower_bound"] == said["lower_bound"]


@pytest.mark.parametrize("command, bound", [("solve", "energy"), ("reduce", "upper_bound")])
def test_a_part_that_is_too_wide_for_a_certificate(tmp_path, command, bound):
    """What is proven without one is more, or may be."""
    rng, edges = np.random.default_rng(1), np.array(list(itertools.combinations(range(24), 2)))
    arrays = {"costs": rng.integers(0, 60, (24, 3)), "edges": edges, "pairs": 9 * np.eye(3),
              "weights": rng.integers(1, 20, len(edges))}
    for name, array in arrays.items():
        np.save(tmp_path / f"{name}.npy", array.astype(np.int32))
    names = [tmp_path / f"{name}.npy" for name in arrays]
    done = run("encode", "--problem", "label", names[0], "--edges", names[1], "--pairwise",
               names[2], "--weights", names[3], "-o", tmp_path / "p.qcf")
    assert done.status == 0, done.err
    line = [command, tmp_path / "p.qcf", "-o", tmp_path / "out", "--iterations", "20", "--json"]
    assert run(*line).err == ""
    done = run(*line, "--certificate", tmp_path / "c.qpf")
    said = json.loads(done.out)
    assert said["lower_bound"] < said[bound]
    assert "p.qcf: warning: a part of the problem is too wide for a certificate" in done.err


@pytest.mark.parametrize("command, bound", [("solve", "energy"), ("reduce", "upper_bound")])
def test_windows_of_large_grids_are_in_no_certificate(tmp_path, command, bound):
    """Their searches prove more without one."""
    costs = np.random.default_rng(1).integers(0, 100, (80, 80, 4))
    np.save(tmp_path / "costs.npy", costs.astype(np.int32))
    done = run("encode", "--problem", "label", tmp_path / "costs.npy", "--lambda", "40",
               "-o", tmp_path / "p.qcf")
    assert done.status == 0, done.err
    line = [command, tmp_path / "p.qcf", "-o", tmp_path / "out", "--iterations", "300", "--json"]
    done = run(*line)
    alone = json.loads(done.out)
    assert done.err == ""
    done = run(*line, "--certificate", tmp_path / "c.qpf")
    said = json.loads(done.out)
    assert said["lower_bound"] < alone["lower_bound"] <= min(said[bound], alone[bound])
    assert "p.qcf: warning: a part of the problem is too wide for a certificate" in done.err


def test_labels_that_leave_one_after_another(tmp_path):
    """A chain whose labels leave from one end on, each for the one before it: one stage has more
    rounds than a file has stages."""
    costs = np.zeros((1, 5000, 2), np.int32)
    costs[..., 1] = 1
    costs[0, 0, 1] = 100
    np.save(tmp_path / "c.npy", costs)
    words = ["encode", "--problem", "label", tmp_path / "c.npy", "--lambda", "10"]
    assert run(*words, "-o", tmp_path / "p.qcf").status == 0
    words = ["reduce", tmp_path / "p.qcf", "-o", tmp_path / "r.qcf"]
    done = run(*words, "--certificate", tmp_path / "c.qpf")
    assert (done.status, done.err) == (0, "")
    done, facts = verify(tmp_path, "r.qcf")
    assert facts["valid"] and facts["proven_optimal"] and facts["stages"] < 5


@pytest.mark.parametrize("words", ["solve --solver cut", "solve --solver best", "reduce"])
def test_what_is_stopped_at_once_proves_a_bound(tmp_path, words):
    np.save(tmp_path / "c.npy", np.random.default_rng(5).integers(3, 50, (160, 160, 12)))
    encode = ["encode", "--problem", "label", tmp_path / "c.npy", "--smoothness", "linear"]
    assert run(*encode, "-o", tmp_path / "p.qcf").status == 0
    done = run(*words.split(), tmp_path / "p.qcf", "-o", tmp_path / "other", "--certificate",
               tmp_path / "c.qpf", "--time-limit", "0.000001")
    assert done.status == 0 and b"0 iterations" in done.out, done.err
    done, facts = verify(tmp_path, "other")
    assert facts["valid"] and 3 * 160**2 <= facts["lower_bound"] < facts["energy"]


def test_a_site_with_too_many_neighbours(tmp_path):
    """Its slots have numbers of two bytes."""
    most = 2**16
    lines = ["MARKOV", str(most + 2), "2 " * (most + 2), str(most + 1)]
    lines += [f"2 0 {other}" for other in range(1, most + 2)]
    lines += ["4 .8 .2 .2 .8"] * (most + 1)
    (tmp_path / "star.uai").write_text("\n".join(lines) + "\n")
    done = run("encode", "--problem", "uai", tmp_path / "star.uai", "-o", tmp_path / "p.qcf")
    assert done.status == 0, done.err
    line = ["solve", tmp_path / "p.qcf", "-o", tmp_path / "s.qsf", "--solver", "trws"]
    done = run(*line, "--certificate", tmp_path / "c.qpf")
    assert done.status == 3
    assert "p.qcf: has a site with more than 65536 neighbours" in done.err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["p.qcf", "star.uai"]
    assert run(*line).status == 0


def test_files_of_other_kinds(folder):
    solve(folder)
    done, _ = verify(folder, certificate="s.qsf")
    assert done.status == 3 and "is not a .qpf file but a .qsf" in done.err
    done, _ = verify(folder, second="c.qpf")
    assert done.status == 3 and "is not a .qsf file" in done.err
