"""compare: the paper's table, its numbers held against the commands that make them one by one."""

import json
import re
import signal

import numpy as np
import pytest
from cli_tools import (
    LONG,
    ROOT,
    SOLVERS,
    random_pair,
    run,
    signal_at_output,
    started,
    succeed,
    with_chunk,
    without_chunk,
    write_pgm,
    write_qsf,
)

GOLDEN = ROOT / "tests" / "golden"
KEYS = {
    "solver",
    "usable",
    "energy",
    "gap",
    "lower_bound",
    "feasible",
    "samples",
    "proven_optimal",
    "pixels",
    "rms",
    "bad_0_5",
    "bad_1_0",
    "seconds",
    "map",
    "file",
}


def compare(problem, *options):
    done = succeed("compare", problem, "--json", *options)
    facts = json.loads(done.out)
    assert set(facts) == {"schema", "lower_bound", "trace", "results"} and all(
        set(result) == KEYS for result in facts["results"]
    )
    return facts


@pytest.fixture
def truth(tmp_path, pair):
    return write_pgm(
        tmp_path / "truth.pgm", np.random.default_rng(5).integers(0, 80, pair.left.shape)
    )


def test_all_solvers_and_a_samples_file(tmp_path, folder, solved, truth):
    facts = compare(
        solved.problem,
        "--truth",
        truth,
        "--truth-scale",
        "16",
        "--samples",
        solved.samples,
        "--seed",
        "2",
    )
    *ours, other = facts["results"]
    assert [result["solver"] for result in ours] == SOLVERS
    bounds = []
    for result in ours:
        search = ["--solver", result["solver"], "--seed", "2"]
        alone = json.loads(
            run("solve", solved.problem, "-o", tmp_path / "o.qsf", "--json", *search).out
        )
        assert (result["energy"], result["lower_bound"]) == (alone["energy"], alone["lower_bound"])
        assert (result["feasible"], result["samples"], result["usable"], result["map"]) == (
            1,
            1,
            True,
            None,
        )
        assert result["seconds"] >= 0
        run("decode", solved.problem, tmp_path / "o.qsf", "-o", tmp_path / "m.pgm")
        scored = json.loads(
            run("score", tmp_path / "m.pgm", truth, "--truth-scale", "16", "--json").out
        )
        errors = ("pixels", "rms", "bad_0_5", "bad_1_0")
        assert {key: scored[key] for key in errors} == {key: result[key] for key in errors}
        bounds += [alone["lower_bound"]] * (alone["lower_bound"] is not None)
    assert facts["lower_bound"] == max(bounds)
    for result in facts["results"]:
        assert result["gap"] == result["energy"] - facts["lower_bound"]
        assert result["proven_optimal"] == (result["gap"] == 0)
    assert (other["solver"], other["feasible"], other["samples"], other["energy"]) == (
        'test "solver"',
        2,
        3,
        solved.energies[1],
    )
    assert (other["seconds"], other["lower_bound"]) == (None, None)
    assert other["pixels"] == scored["pixels"]


def test_a_solver_that_cannot_be_used():
    problem = GOLDEN / "good-grid-sparse.qcf"
    facts = compare(problem, "--solvers", "cut,icm")
    refused, used = facts["results"]
    assert (
        refused["usable"],
        refused["energy"],
        refused["feasible"],
        refused["samples"],
        refused["seconds"],
    ) == (False, None, 0, 0, None)
    assert used["usable"] and (facts["lower_bound"], used["gap"]) == (None, None)
    table = run("compare", problem, "--solvers", "cut,icm").out.decode()
    assert re.search(r"^cut( +-)+ +not for this pairwise cost$", table, re.M)
    assert "no lower bound" in table


def test_the_table(solved, truth):
    facts = compare(solved.problem, "--solvers", "icm,trws", "--samples", solved.samples)
    lines = (
        run("compare", solved.problem, "--solvers", "icm,trws", "--samples", solved.samples)
        .out.decode()
        .splitlines()
    )
    assert lines[0].split() == ["method", "energy", "gap", "gap", "%", "feasible", "seconds"]
    for line, result in zip(lines[1:], facts["results"]):
        assert line.startswith(result["solver"])
        cells = line.removeprefix(result["solver"]).split()
        assert (float(cells[0]), float(cells[1])) == (result["energy"], result["gap"])
        assert cells[3] == f"{result['feasible']}/{result['samples']}"
        assert float(cells[2]) == pytest.approx(100 * result["gap"] / result["energy"], abs=1e-4)
        assert ("optimal" in line) == result["proven_optimal"]
        last = "optimal" if result["proven_optimal"] else cells[-1]
        assert line.endswith(result["file"] or last)
    assert [result["file"] for result in facts["results"]] == [None, None, str(solved.samples)]
    assert (
        lines[-1] == f"best lower bound {facts['lower_bound']:g}: no labelling has a lower energy"
    )
    scored = (
        run("compare", solved.problem, "--solvers", "icm", "--truth", truth)
        .out.decode()
        .splitlines()
    )
    assert scored[0].split()[-4:] == ["rms", "bad-0.5", "bad-1.0", "seconds"]


def test_a_bound_proves_the_answers_of_others(tmp_path, solved):
    """A labelling from a file, and one of a solver without bounds, are optimal if another solver's
    bound says so.
    """
    best = json.loads(run("solve", solved.problem, "-o", tmp_path / "o.qsf", "--json").out)
    facts = compare(solved.problem, "--solvers", "best", "--samples", tmp_path / "o.qsf")
    assert [result["proven_optimal"] for result in facts["results"]] == 2 * [best["proven_optimal"]]
    assert facts["results"][1]["seconds"] == best["seconds"]
    # The file's own bound is only said, not shown.
    assert (
        compare(solved.problem, "--solvers", "icm", "--samples", tmp_path / "o.qsf")["lower_bound"]
        is None
    )


def test_maps(tmp_path, folder, solved, pnm_only):
    maps = folder / "maps"
    options = [
        "--solvers",
        "icm,bp,icm",
        "--samples",
        solved.samples,
        "--samples",
        solved.samples,
        "--maps",
        maps,
        "--scale",
        "4",
    ]
    done = run("compare", solved.problem, "--json", *options, program=pnm_only)
    results = json.loads(done.out)["results"]
    names = ["icm.pgm", "bp.pgm", "icm-2.pgm", "test__solver_.pgm", "test__solver_-2.pgm"]
    assert [result["map"] for result in results] == [str(maps / name) for name in names]
    assert sorted(path.name for path in maps.iterdir()) == sorted(names)
    for name, samples in (("test__solver_", solved.samples), ("icm", None)):
        if samples is None:
            samples = tmp_path / "i.qsf"
            run("solve", solved.problem, "-o", samples, "--solver", "icm")
        run("decode", solved.problem, samples, "-o", tmp_path / "m.pgm", "--scale", "4")
        assert (maps / f"{name}.pgm").read_bytes() == (tmp_path / "m.pgm").read_bytes()


def test_maps_as_png(folder, solved, opencv):
    from PIL import Image

    compare(solved.problem, "--solvers", "icm", "--maps", folder)
    assert [path.name for path in folder.iterdir()] == ["icm.png"]
    assert Image.open(folder / "icm.png").size == (12, 5)


def test_no_feasible_sample(tmp_path, folder, solved):
    samples = write_qsf(
        tmp_path / "n.qsf", solved.problem, solved.broken, [2 * solved.broken_energy]
    )
    facts = compare(solved.problem, "--solvers", "icm", "--samples", samples, "--maps", folder)
    other = facts["results"][1]
    assert (other["energy"], other["gap"], other["feasible"], other["samples"], other["map"]) == (
        None,
        None,
        0,
        1,
        None,
    )
    assert len(list(folder.iterdir())) == 1
    empty = write_qsf(tmp_path / "e.qsf", solved.problem, np.zeros((0, 160)), [])
    assert (
        compare(solved.problem, "--solvers", "icm", "--samples", empty)["results"][1]["samples"]
        == 0
    )


@pytest.mark.parametrize("fault", ["energy", "problem", "missing", "damaged"])
def test_bad_samples_leave_nothing(tmp_path, folder, pair, solved, fault):
    """Of several files one is bad; that is known before a solver runs."""
    bad = tmp_path / "bad.qsf"
    if fault == "energy":
        write_qsf(
            bad, solved.problem, solved.bits, [2 * solved.energies[0] + 1, 2 * solved.energies[1]]
        )
    elif fault == "problem":
        assert (
            run("encode", *pair.paths, "-o", tmp_path / "q.qcf", "--disparity", "1:4").status == 0
        )
        write_qsf(bad, tmp_path / "q.qcf", solved.bits, [2 * e for e in solved.energies])
    elif fault == "damaged":
        bad.write_bytes(solved.samples.read_bytes()[:-1])
    done = run(
        "compare",
        solved.problem,
        "--solvers",
        "icm",
        "--samples",
        solved.samples,
        "--samples",
        bad,
        "--maps",
        folder / "maps",
    )
    assert (done.status, done.out) == (4 if fault == "missing" else 3, b"")
    assert str(bad) in done.err
    assert not list(folder.iterdir())


def test_an_existing_folder_stays(tmp_path, folder, solved):
    (folder / "icm.pgm").write_text("as it was")
    (folder / "icm.png").write_text("as it was")
    done = run(
        "compare",
        solved.problem,
        "--solvers",
        "icm",
        "--samples",
        tmp_path / "none.qsf",
        "--maps",
        folder,
    )
    assert done.status == 4
    assert (
        all(path.read_text() == "as it was" for path in folder.iterdir())
        and len(list(folder.iterdir())) == 2
    )


def test_a_folder_that_cannot_be(tmp_path, solved):
    for folder in (tmp_path / "none" / "maps", solved.problem):
        done = run("compare", solved.problem, "--solvers", "icm", "--maps", folder)
        assert (done.status, f"{folder}: cannot be made" in done.err) == (4, True)


def test_a_signal_leaves_no_folder(folder, large):
    process = started(
        "compare",
        large,
        "--solvers",
        "icm,anneal",
        "--iterations",
        10**9,
        "--maps",
        folder / "maps",
    )
    signal_at_output(process, folder, 2, signal.SIGINT)
    out, _ = process.communicate(timeout=LONG)
    assert (process.returncode, out) == (130, b"")
    assert not list(folder.iterdir())


def test_the_time_limit_is_of_each_solver(large):
    facts = compare(
        large, "--solvers", "anneal,trws", "--iterations", 10**9, "--time-limit", "0.05"
    )
    assert all(result["seconds"] >= 0.05 for result in facts["results"])


def test_no_grid(folder, truth):
    problem = GOLDEN / "good-edges-table.qcf"
    assert compare(problem, "--solvers", "icm,trws")["lower_bound"] is not None
    for options in (["--truth", truth], ["--maps", folder / "maps"]):
        done = run("compare", problem, *options)
        assert (done.status, "is not a problem on a grid" in done.err) == (3, True)
    assert not list(folder.iterdir())


def test_a_problem_without_meaning(tmp_path, solved):
    done = run("compare", without_chunk(solved.problem, "labl", tmp_path / "bare.qcf"))
    assert (done.status, "does not say which labels" in done.err) == (3, True)


def test_a_truth_that_does_not_fit(tmp_path, solved):
    small = write_pgm(tmp_path / "small.pgm", np.zeros((3, 3), int))
    done = run("compare", solved.problem, "--truth", small)
    assert (done.status, done.out) == (3, b"")
    assert "is 3 x 3 pixels, but the left picture is 12 x 5" in done.err


def test_memory_limit(tmp_path):
    _, _, *paths = random_pair(tmp_path, 400, 300)
    succeed("encode", *paths, "-o", tmp_path / "p.qcf")
    done = run("compare", tmp_path / "p.qcf", "--solvers", "icm", "--memory-limit", "10")
    assert (done.status, done.out, "raise --memory-limit" in done.err) == (4, b"", True)


@pytest.mark.parametrize(
    "options, words",
    [
        (
            ["--solvers", "icm,bst"],
            "--solvers bst is unknown: did you mean best? It can be: icm anneal",
        ),
        (["--solvers", "icm,"], "is unknown"),
        (["--solvers", ",".join(["icm"] * 65)], "--solvers: 64 solvers are the most"),
        (["--solvers", ""], "is empty"),
        (["--time-limit", "0"], "above 0"),
        (["--maps", "m", "--scale", "1"], "from 2"),
        (["--scale", "4"], "--scale goes with --maps: add --maps"),
        (["--truth", "t.pgm", "--truth-scale", "x"], "whole"),
    ],
)
def test_usage_errors(solved, options, words):
    done = run("compare", solved.problem, *options)
    assert (done.status, done.out) == (2, b"")
    assert words in done.err


def test_too_many_results(solved):
    done = run("compare", solved.problem, "--solvers", "icm", *["--samples", solved.samples] * 64)
    assert (done.status, "64 solvers and samples files are the most" in done.err) == (2, True)
    assert (
        len(
            compare(solved.problem, "--solvers", "icm", *["--samples", solved.samples] * 63)[
                "results"
            ]
        )
        == 64
    )
    done = run("compare", solved.problem, *["--samples", solved.samples] * 257)
    assert (done.status, "more than 256 options" in done.err) == (2, True)


def test_maps_of_a_solver_with_a_long_name(tmp_path, folder, solved, pnm_only):
    """A solver's name may have 255 bytes, as the name of a file may with its ending."""
    for letter in "ab":
        with_chunk(solved.samples, "SOLV", b"x" * 254 + letter.encode(), tmp_path / letter)
    options = ["--solvers", "icm", "--samples", tmp_path / "a", "--samples", tmp_path / "b"]
    done = run("compare", solved.problem, *options, "--maps", folder, program=pnm_only)
    assert done.status == 0, done.err
    assert sorted(path.name for path in folder.iterdir()) == [
        "icm.pgm",
        "x" * 200 + "-2.pgm",
        "x" * 200 + ".pgm",
    ]


def test_names_of_solvers_cannot_steer_a_terminal(tmp_path, solved):
    """The format forbids C0 in them, but not the marks that turn the direction of writing."""
    samples = with_chunk(
        solved.samples, "SOLV", "a\u202eb\u2066c".encode(), tmp_path / "named.qsf"
    )
    for line in (
        ["compare", solved.problem, "--solvers", "icm", "--samples", samples],
        ["validate", solved.problem, samples],
        ["info", samples],
    ):
        for options in ([], ["--json"]):
            text = run(*line, *options).out.decode()
            assert "a\\u202eb\\u2066c" in text or (line[0], options) == ("validate", ["--json"])
            assert not {"\u202e", "\u2066"} & set(text)
