"""info: what it says of both files, and how it refuses damaged ones."""

import json
import struct
from concurrent.futures import ThreadPoolExecutor
from hashlib import sha256

import numpy as np
import pytest
from cli_tools import random_pair, reseal, run, succeed, with_chunk, write_pgm, write_qsf


def test_problem_of_two_sites(tmp_path):
    """Greys 10 and 50 against 13 and 40, disparity 0 only at the first pixel's neighbour: all by
    hand.
    """
    left = write_pgm(tmp_path / "l.pgm", np.array([[0, 10, 50]]))
    right = write_pgm(tmp_path / "r.pgm", np.array([[4, 13, 40]]))
    done = run(
        "encode",
        left,
        right,
        "-o",
        tmp_path / "p.qcf",
        "--disparity",
        "0:1",
        "--lambda",
        "1.5",
        "--penalty",
        "local",
    )
    assert done.status == 0
    facts = json.loads(run("info", tmp_path / "p.qcf", "--json").out)
    data = (tmp_path / "p.qcf").read_bytes()
    # Costs of site 1: |10-13|=3, |10-4|=6; of site 2: |50-40|=10, |50-13|=37. Minima 3 + 10 and
    # one edge of 1.5 are constant;
    # a = gap = 0.5 a site, b = 0.5 + 1.5 + 0.5.
    assert facts == {
        "schema": 1,
        "format": "qcf",
        "version": 1,
        "file_bytes": len(data),
        "digest": sha256(data).hexdigest(),
        "variables": 4,
        "groups": 2,
        "couplings": 1,
        "scale": 2,
        "width": 2,
        "height": 1,
        "x": 1,
        "y": 0,
        "picture_width": 3,
        "picture_height": 1,
        "sites": 2,
        "sites_open": 2,
        "labels": 2,
        "meaning": "disparity",
        "disparity_min": 0,
        "disparity_max": 1,
        "encoding": "one-hot-sparse",
        "smoothness": "potts",
        "truncation": 0,
        "penalty": "local",
        "gap": 1,
        "truncated": False,
        "lambda": 1.5,
        "quadratic_terms": 2 + 2,
        "penalty_min": 0.5,
        "penalty_max": 0.5,
        "pair_penalty_min": 2.5,
        "pair_penalty_max": 2.5,
        "offset": 3 + 10 + 1.5 + 2 * 0.5,
        "linear_min": -0.5,
        "linear_max": 27 - 0.5,
        "quadratic_min": -1.5,
        "quadratic_max": 2.5,
        "known_energy": None,
        "stated_lower_bound": None,
    }


def test_problem_in_words(solved):
    text = run("info", solved.problem).out.decode()
    for words in (
        "40, grid 8 x 5 at (4, 0) of a picture 12 x 5",
        "4, disparities 1 to 4",
        "potts, lambda 2.5",
        "1/2",
        "one-hot-sparse, penalty local, gap 1",
        "160 in 40 groups",
        solved.facts["digest"],
        f"{solved.facts['file_bytes']} bytes",
    ):
        assert words in text


def test_standard_input(solved):
    done = run("info", "-", "--json", input=solved.problem.read_bytes())
    assert json.loads(done.out) == json.loads(run("info", solved.problem, "--json").out)


def test_samples(solved):
    facts = json.loads(run("info", "--json", solved.samples).out)
    assert facts == {
        "schema": 1,
        "format": "qsf",
        "version": 1,
        "file_bytes": solved.samples.stat().st_size,
        "samples": 3,
        "variables": 160,
        "solver": 'test "solver"',
        "best_energy": 2 * min(solved.broken_energy, *solved.energies),
        "info": {"reads": 3},
        "problem_digest": solved.facts["digest"],
    }
    text = run("info", solved.samples).out.decode()
    assert "integer units of its .qcf" in text and '{"reads": 3}' in text


def test_timing_parameters_and_broken_chains(tmp_path, solved):
    """Prints only the numbers directly in the two objects, and no title if there are none."""
    info = (
        b'{"a": {"timing": {"wrong": 1}}, "timing": {"qpu_sampling_time": 80000.5, '
        b'"nested": {"no": [1, {"x": "}"}]}, "s": "\\"3",'
        b' "qpu_access_time" : 94072 , "none": null}, "parameters": {"num_reads": 1000, '
        b'"label": "x", "chain_strength": 1.5e-3}}'
    )
    samples = write_qsf(
        tmp_path / "s.qsf",
        solved.problem,
        np.zeros((3, 160)),
        [0] * 3,
        info,
        [1, 2, 1],
        [0, 250_000_000, 10**9],
    )
    lines = [line.split() for line in run("info", samples).out.decode().splitlines()]
    at = lines.index(["parameters"])
    assert lines[at : at + 6] == [
        ["parameters"],
        ["num_reads", "1000"],
        ["chain_strength", "0.0015"],
        ["timing"],
        ["qpu_sampling_time", "80000.5", "us"],
        ["qpu_access_time", "94072", "us"],
    ]
    assert (
        lines[at - 1] == "broken chains 37.50 % on average; none in 1 of 4 reads".split()
        and lines[at + 6][0] == "info"
    )
    for info in (b"{}", b'{"timing": 3, "parameters": {}}', b'{"timing": {"sampling": {"ns": 1}}}'):
        text = run(
            "info", write_qsf(tmp_path / "t.qsf", solved.problem, np.zeros((1, 160)), [0], info)
        ).out.decode()
        assert "\ntiming\n" not in text and "\nparameters\n" not in text and "broken" not in text


def test_samples_of_no_sample(tmp_path, solved):
    samples = write_qsf(tmp_path / "none.qsf", solved.problem, np.zeros((0, 160)), [])
    assert json.loads(run("info", samples, "--json").out)["best_energy"] is None


def statuses(folder, variants):
    """Exit status and message of info for each of many files, run side by side."""

    def look(numbered):
        path = folder / f"{numbered[0]}.file"
        path.write_bytes(numbered[1])
        done = run("info", path)
        path.unlink()
        return done.status, done.out, done.err

    with ThreadPoolExecutor(4) as pool:
        return list(pool.map(look, enumerate(variants)))


@pytest.fixture
def smallest(tmp_path):
    _, _, left, right = random_pair(tmp_path, 2, 1)
    problem = tmp_path / "p.qcf"
    succeed("encode", left, right, "-o", problem, "--disparity", "0:0")
    samples = write_qsf(tmp_path / "s.qsf", problem, [[1, 1]], [0])
    return {"qcf": problem.read_bytes(), "qsf": samples.read_bytes()}


@pytest.mark.parametrize("kind", ["qcf", "qsf"])
def test_every_truncation(folder, smallest, kind):
    whole = smallest[kind]
    for status, out, err in statuses(folder, [whole[:size] for size in range(1, len(whole))]):
        assert (status, out) == (3, b"")
        assert "cut short" in err, err


@pytest.mark.parametrize("kind", ["qcf", "qsf"])
def test_a_flipped_bit_of_every_byte(folder, smallest, kind):
    whole = smallest[kind]
    flipped = [
        whole[:at] + bytes([whole[at] ^ 1 << at % 8]) + whole[at + 1 :] for at in range(len(whole))
    ]
    for at, (status, out, err) in enumerate(statuses(folder, flipped)):
        assert (status, out) == (3, b""), f"byte {at}: {err}"
        assert err.startswith("qstereo info: ") and err.count("\n") == 1


@pytest.mark.parametrize("kind", ["qcf", "qsf"])
def test_a_transfer_as_text(tmp_path, smallest, kind):
    """Line ends were changed: then it is no file of ours, and is not said to be one."""
    (tmp_path / "mangled").write_bytes(smallest[kind].replace(b"\r\n", b"\n"))
    done = run("info", tmp_path / "mangled")
    assert (done.status, done.out) == (3, b"")
    assert done.err == f"qstereo info: {tmp_path}/mangled: is not a .qcf or .qsf file\n"


@pytest.mark.parametrize("kind", ["qcf", "qsf"])
def test_newer_version(tmp_path, smallest, kind):
    newer = bytearray(smallest[kind])
    newer[8:12] = struct.pack("<I", 2)
    (tmp_path / "newer").write_bytes(reseal(bytes(newer)))
    done = run("info", tmp_path / "newer")
    assert done.status == 3
    assert "version" in done.err


def test_something_after_the_end(tmp_path, smallest):
    (tmp_path / "longer").write_bytes(smallest["qcf"] + b"\0")
    assert run("info", tmp_path / "longer").status == 3


def block_of(rows, columns):
    """The payload of a BLKS chunk of one block: a run of -1 on its diagonal."""
    return struct.pack("<IIIIiiIi", 1, rows, columns, 1, 0, 0, 1, -1)


@pytest.mark.parametrize("rows, columns, status", [(2, 2, 0), (2, 3, 3), (3, 2, 3), (3, 3, 3)])
def test_a_block_that_fits_no_groups(tmp_path, rows, columns, status):
    _, _, left, right = random_pair(tmp_path, 3, 1)
    succeed("encode", left, right, "-o", tmp_path / "p.qcf", "--disparity", "0:1")
    done = run(
        "info", with_chunk(tmp_path / "p.qcf", "BLKS", block_of(rows, columns), tmp_path / "q.qcf")
    )
    assert (done.status, done.out == b"") == (status, status != 0), done.err
    assert done.err.count(".qcf damaged: its couplings do not fit its groups\n") == (status != 0)


def test_other_files(tmp_path, pair, solved):
    done = run("info", pair.paths[0])
    assert (done.status, done.err) == (
        3,
        f"qstereo info: {pair.paths[0]}: is not a .qcf or .qsf file\n",
    )
    (tmp_path / "empty").touch()
    done = run("info", tmp_path / "empty")
    assert (done.status, done.err) == (
        3,
        f"qstereo info: {tmp_path / 'empty'}: is empty: a .qcf or .qsf file is needed here\n",
    )
    succeed("solve", solved.problem, "-o", tmp_path / "s.qsf", "--certificate", tmp_path / "c.qpf")
    for command in (["info"], ["solve", "-o", tmp_path / "t.qsf"]):
        done = run(*command, tmp_path / "c.qpf")
        assert done.status == 3 and "file but a .qpf: a certificate" in done.err
    done = run("info", tmp_path / "none")
    assert (done.status, done.err) == (
        4,
        f"qstereo info: {tmp_path / 'none'}: cannot be opened: No such file or directory\n",
    )
    done = run("validate", solved.samples, solved.problem)
    assert done.status == 3
    assert f"{solved.samples}: is not a .qcf file but a .qsf" in done.err


def test_memory_limit_before_trusting_counts(tmp_path, smallest):
    """A header that promises 2^31 - 1 variables is refused for its counts, before anything is
    allocated.
    """
    vast = bytearray(smallest["qcf"])
    vast[24:32] = struct.pack("<II", 2**31 - 1, 2**31 - 1)
    vast[32:40] = struct.pack("<Q", 2**31 - 1)
    (tmp_path / "vast.qcf").write_bytes(reseal(bytes(vast)))
    done = run("info", tmp_path / "vast.qcf")
    assert done.status == 4
    assert "memory limit of 4096 MiB: raise --memory-limit" in done.err


def test_memory_limit_of_files(tmp_path):
    (tmp_path / "large").write_bytes(bytes(2 << 20))
    done = run("info", tmp_path / "large", "--memory-limit", "1")
    assert (done.status, "memory limit of 1 MiB" in done.err) == (4, True)
    done = run("info", "/dev/zero", "--memory-limit", "1")
    assert (done.status, "memory limit of 1 MiB" in done.err) == (4, True)
    assert run("info", tmp_path / "large", "--memory-limit", "3").status == 3


GOOD_JSON = [
    "{}",
    "{ \n}",
    '{"a": {"b": [1, -2.5e+3, true, false, null, "\\u00e4\\n", [], {}]}, "c": 0}',
    '{"":""}',
    '{"a": ' + 40 * "[" + 40 * "]" + "}",
]
BAD_JSON = [
    "{a: 1}",
    '{"a" 1}',
    '{"a": 1,}',
    '{"a": 01}',
    '{"a": .5}',
    '{"a": 1.}',
    '{"a": 1e}',
    '{"a": [1 2]}',
    '{"a": [1}',
    '{"a": tru}',
    '{"a": "\\x"}',
    '{"a": "\\u12g4"}',
    '{"a": "\t"}',
    '{"a": 1}{}',
    '{"a": [}',
    '{"a": }',
    "{,}",
    '{"a"}',
    '{"a": ' + 70 * "[" + 70 * "]" + "}",
]


@pytest.mark.parametrize("text", GOOD_JSON)
def test_the_solvers_json_is_passed_on(tmp_path, solved, text):
    samples = write_qsf(tmp_path / "i.qsf", solved.problem, solved.bits, [0, 0], info=text.encode())
    done = succeed("info", samples, "--json")
    assert json.loads(done.out)["info"] == json.loads(text)


@pytest.mark.parametrize("text", BAD_JSON)
def test_what_is_no_json_is_not(tmp_path, solved, text):
    samples = write_qsf(tmp_path / "i.qsf", solved.problem, solved.bits, [0, 0], info=text.encode())
    done = run("info", samples, "--json")
    assert (done.status, done.out) == (3, b"")
    assert "INFO" in done.err
