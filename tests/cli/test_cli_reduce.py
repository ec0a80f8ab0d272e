"""reduce and encode --reduce: what is left out is proven, and decode gives the whole map."""

import json
import re

import numpy as np
import pytest
from cli_tools import (
    SOLVERS,
    best_of_all,
    energy,
    on_terminal,
    random_pair,
    read_pnm,
    run,
    succeed,
    without_chunk,
    write_pgm,
    write_qsf,
)

KEYS = {
    "schema",
    "variables_before",
    "variables_after",
    "sites_before",
    "sites_after",
    "labels_before",
    "labels_after",
    "variables_left",
    "lower_bound",
    "upper_bound",
    "proven_optimal",
    "target",
    "target_reached",
    "ended",
    "iterations",
    "seconds",
}
SMOOTH = {"potts": lambda t: (t != 0) * 1, "linear": np.abs, "quadratic": np.square}


def call(*arguments, status=0):
    done = run(*arguments, "--json")
    assert done.status == status, done.err
    return json.loads(done.out)


def decoded(problem, samples, folder, labels):
    """Energy and map of an answer; `samples` may be None."""
    facts = call(
        "decode", problem, *([samples] if samples else []), "-o", folder / "m.pgm", "--scale", "2"
    )
    return facts["energy"], read_pnm((folder / "m.pgm").read_bytes())[0][:, labels - 1 :] // 2


@pytest.fixture
def shifted(tmp_path):
    """A pair of which the right picture is the left one, moved by a pixel: nothing but disparity 1
    costs nothing.
    """
    left = np.random.default_rng(5).permutation(255)[: 6 * 20].reshape(6, 20)
    right = np.roll(left, -1, axis=1)
    return (
        left,
        right,
        write_pgm(tmp_path / "left.pgm", left),
        write_pgm(tmp_path / "right.pgm", right),
    )


@pytest.fixture
def decided(tmp_path, shifted):
    """A problem in which nothing is left."""
    succeed("encode", *shifted[2:], "-o", tmp_path / "p.qcf", "--disparity", "0:3", "--lambda", "1")
    facts = call("reduce", tmp_path / "p.qcf", "-o", tmp_path / "none.qcf")
    return tmp_path / "none.qcf", facts


@pytest.mark.parametrize("smoothness", SMOOTH)
@pytest.mark.parametrize("seed", range(4))
def test_the_optimum_stays(folder, smoothness, seed):
    """Of tiny problems by trying each labelling; small greys and lambda bring ties."""
    random = np.random.default_rng(seed)
    left, right = (random.integers(0, 5 if seed % 2 else 60, (2, 5)) for _ in range(2))
    paths = [write_pgm(folder / f"{name}.pgm", grey) for name, grey in (("l", left), ("r", right))]
    lam = [1.5, 2, 20, 3][seed]
    best = best_of_all(left, right, 3, lam, SMOOTH[smoothness])
    options = ["--disparity", "0:2", "--lambda", lam, "--smoothness", smoothness]
    succeed("encode", *paths, "-o", folder / "p.qcf", *options)
    reduced = call("reduce", folder / "p.qcf", "-o", folder / "small.qcf")
    assert set(reduced) == KEYS
    assert reduced["lower_bound"] <= best <= reduced["upper_bound"]
    assert reduced["proven_optimal"] == (reduced["lower_bound"] == reduced["upper_bound"])
    at_once = call("encode", *paths, "-o", folder / "once.qcf", *options, "--reduce")
    assert KEYS < set(at_once) and at_once["sites_open"] == at_once["sites_after"]
    again = call("info", folder / "once.qcf")
    assert again == {key: at_once[key] for key in again}
    for small in ("small.qcf", "once.qcf"):
        solved = call("solve", folder / small, "-o", folder / "s.qsf")
        assert solved["energy"] == best
        seen = call("validate", folder / small, folder / "s.qsf")
        assert seen["energies_agree"] and seen["best_energy"] == best
        found, disparities = decoded(folder / small, folder / "s.qsf", folder, 3)
        assert found == best == energy(left, right, disparities, lam, SMOOTH[smoothness])


@pytest.mark.parametrize("encoding", ["one-hot", "one-hot-sparse", "domain-wall", "multiway-cut"])
@pytest.mark.parametrize("truncate", [[], ["--truncate"]])
def test_what_is_written(folder, pair, encoding, truncate):
    """Counts agree between the command, the file and the formulas of what is left."""
    succeed("encode", *pair.paths, "-o", folder / "p.qcf", "--disparity", "0:3", "--lambda", "60")
    facts = call(
        "reduce",
        folder / "p.qcf",
        "-o",
        folder / "s.qcf",
        "--iterations",
        "2",
        "--encoding",
        encoding,
        "--penalty",
        "minimal",
        "--gap",
        "7",
        *truncate,
    )
    info = call("info", folder / "s.qcf")
    assert (facts["variables_before"], facts["sites_before"], facts["labels_before"]) == (
        180,
        45,
        180,
    )
    assert 0 < facts["sites_after"] < 45
    open_labels = facts["labels_after"] - (45 - facts["sites_after"])
    count = {
        "domain-wall": open_labels - facts["sites_after"],
        "multiway-cut": open_labels + 16,
    }.get(encoding, open_labels)
    assert (info["variables"], info["sites"], info["sites_open"]) == (
        count,
        45,
        facts["sites_after"],
    )
    assert facts["variables_after"] == count
    assert (info["encoding"], info["penalty"], info["gap"]) == (encoding, "minimal", 7)
    assert info["lambda"] == 60
    text = run("info", folder / "s.qcf").out.decode()
    assert f"{facts['sites_after']}, fixed {45 - facts['sites_after']}" in text


def test_defaults_are_those_of_the_file(folder, pair):
    for encoding in ("one-hot", "one-hot-sparse", "domain-wall"):
        succeed(
            "encode", *pair.paths, "-o", folder / "p.qcf", "--disparity", "0:3", "--encoding",
            encoding, "--gap", "5"
        )
        call("reduce", folder / "p.qcf", "-o", folder / "s.qcf")
        info = call("info", folder / "s.qcf")
        assert (info["encoding"], info["penalty"], info["gap"], info["truncated"]) == (
            encoding,
            "local",
            5,
            False,
        )
        call(
            "reduce",
            folder / "p.qcf",
            "-o",
            folder / "t.qcf",
            "--penalty",
            "local",
            "--encoding",
            encoding,
            "--gap",
            "5",
        )
        assert (folder / "t.qcf").read_bytes() == (folder / "s.qcf").read_bytes()


@pytest.mark.parametrize(
    "made, options, penalty, gap",
    [
        (["--penalty", "minimal", "--gap", "5"], ["--encoding", "domain-wall"], "minimal", 5),
        (["--penalty", "minimal", "--gap", "5"], ["--penalty", "local"], "local", 5),
        (["--penalty", "minimal", "--gap", "5"], ["--penalty", "paper"], "paper", 1),
        (["--gap", "5"], ["--gap", "3"], "local", 3),
        (["--penalty", "paper"], [], "paper", 1),
        (["--penalty", "paper"], ["--encoding", "domain-wall"], "local", 1),
        (
            ["--penalty", "paper", "--smoothness", "linear", "--encoding", "one-hot"],
            ["--encoding", "one-hot-sparse"],
            "local",
            1,
        ),
        (["--penalty", "3000"], [], "local", 1),
    ],
)
def test_penalty_and_gap_of_the_file(folder, pair, made, options, penalty, gap):
    succeed(
        "encode", *pair.paths, "-o", folder / "p.qcf", "--disparity", "0:3", "--lambda", "60", *made
    )
    facts = call("reduce", folder / "p.qcf", "-o", folder / "s.qcf", "--iterations", "1", *options)
    info = call("info", folder / "s.qcf")
    assert facts["sites_after"] > 0 and (info["penalty"], info["gap"]) == (penalty, gap)


def test_what_is_truncated_stays_so(folder, pair):
    """Of linear smoothness stopped at once, for what no optimum pays has soon left."""
    options = ["--disparity", "0:3", "--lambda", "10", "--smoothness", "linear"]
    for truncate in ([], ["--truncate"]):
        assert call("encode", *pair.paths, "-o", folder / "p.qcf", *options, *truncate)[
            "truncated"
        ] == bool(truncate)
        call("reduce", folder / "p.qcf", "-o", folder / "s.qcf", "--target", "1000")
        assert call("info", folder / "s.qcf")["truncated"] == bool(truncate)


@pytest.mark.parametrize(
    "encoding, target", [("one-hot", 1000), ("one-hot-sparse", 1000), ("domain-wall", 700)]
)
def test_target(folder, encoding, target):
    """The target counts the variables that are written, of which there are fewer than labels."""
    _, _, left, right = random_pair(folder, 40, 12, seed=3)
    arguments = [
        "encode",
        left,
        right,
        "-o",
        folder / "p.qcf",
        "--disparity",
        "0:7",
        "--encoding",
        encoding,
        "--reduce",
    ]
    whole, facts = call(*arguments), call(*arguments, "--target", target)
    assert (
        0
        <= whole["variables_after"]
        < 100
        < facts["variables_after"]
        == facts["variables"]
        <= target
    )
    assert facts["iterations"] < whole["iterations"]
    assert (facts["target"], facts["target_reached"], whole["target"], whole["target_reached"]) == (
        target,
        True,
        None,
        None,
    )
    if encoding == "domain-wall":
        assert facts["variables_after"] + facts["sites_after"] > target
    call("encode", left, right, "-o", folder / "q.qcf", "--disparity", "0:7")
    again = call(
        "reduce",
        folder / "q.qcf",
        "-o",
        folder / "r.qcf",
        "--encoding",
        encoding,
        "--target",
        target,
    )
    assert (folder / "r.qcf").read_bytes() == (folder / "p.qcf").read_bytes()
    assert {**again, "seconds": 0} == {**{key: facts[key] for key in again}, "seconds": 0}


def test_one_label(folder, pair):
    """There is nothing that a proof could decide."""
    done = run(
        "encode",
        *pair.paths,
        "-o",
        folder / "p.qcf",
        "--disparity",
        "0:0",
        "--reduce",
        "--encoding",
        "domain-wall",
    )
    text = done.out.decode()
    assert (
        f"{folder / 'p.qcf'}: 60 sites x 1 label, 0 variables in domain-wall, " in text
        and "\n1 iteration, " in text
    )
    assert "\nvariables   0 (domain-wall), 60 before (sites x labels)\n" in text
    assert "\nsites       0 undecided, 60 before: each of all 60 has only one label\n" in text
    text = run("reduce", folder / "p.qcf", "-o", folder / "s.qcf").out.decode()
    assert (
        "\nvariables   0 (domain-wall), 0 before (domain-wall)\nsites       0 undecided, "
        "0 before: each of all 60 has only one label" in text
    )


MISSED = {
    "ties": ([], "the proof is complete, and only labels that may tie are left"),
    "iteration": (["--iterations", "1"], "stopped after 1 iteration"),
    "iterations": (["--iterations", "2"], "stopped after 2 iterations"),
    "time": (["--time-limit", "0.000001"], "the time limit stopped the reduction"),
}


@pytest.mark.parametrize("case", MISSED)
def test_a_missed_target(folder, case):
    options, words = MISSED[case]
    _, _, *paths = random_pair(folder, 20, 6)
    if case == "ties":
        paths = [write_pgm(folder / "flat.pgm", np.full((6, 20), 9))] * 2
    succeed("encode", *paths, "-o", folder / "p.qcf", "--disparity", "0:3", "--lambda", "90")
    facts = call("reduce", folder / "p.qcf", "-o", folder / "s.qcf", "--target", "1", *options)
    assert (facts["target"], facts["target_reached"]) == (1, False) and facts["variables_after"] > 1
    assert facts["proven_optimal"] == (case == "ties")
    ended = {"ties": "proven", "time": "time"}
    assert facts["ended"] == ended.get(case, "iterations")
    done = run("reduce", folder / "p.qcf", "-o", folder / "s.qcf", "--target", "1", *options)
    assert (done.status, done.out.decode().count(f"\ntarget      1 not reached: {words}\n")) == (
        0,
        1,
    )
    done = run(
        "reduce",
        folder / "p.qcf",
        "-o",
        folder / "s.qcf",
        "--target",
        facts["variables_after"],
        *options,
    )
    assert (done.status, "target " in done.out.decode()) == (0, False)


def test_reduced_again(folder, pair):
    """A reduced file is a problem like others: it can be reduced again, from what was left."""
    succeed("encode", *pair.paths, "-o", folder / "p.qcf", "--disparity", "0:3", "--lambda", "60")
    proven = call("reduce", folder / "p.qcf", "-o", folder / "whole.qcf")
    for encoding in ("one-hot", "one-hot-sparse", "domain-wall"):
        first = call(
            "reduce",
            folder / "p.qcf",
            "-o",
            folder / "s.qcf",
            "--iterations",
            "1",
            "--encoding",
            encoding,
        )
        assert first["variables_after"] > proven["variables_after"]
        second = call(
            "reduce", folder / "s.qcf", "-o", folder / "t.qcf", "--encoding", "one-hot-sparse"
        )
        assert (second["variables_before"], second["sites_before"], second["labels_before"]) == (
            first["variables_after"],
            first["sites_after"],
            first["labels_after"],
        )
        assert second["upper_bound"] == proven["upper_bound"] and second["proven_optimal"]


def test_nothing_left(folder, decided, shifted):
    problem, facts = decided
    assert (
        facts["variables_after"],
        facts["sites_after"],
        facts["labels_after"],
        facts["proven_optimal"],
    ) == (0, 0, 6 * 17, True)
    best = energy(shifted[0], shifted[1], np.ones((6, 17), int), 1)
    assert facts["upper_bound"] == facts["lower_bound"] == best == 0
    info = call("info", problem)
    assert (
        info["variables"],
        info["groups"],
        info["sites"],
        info["sites_open"],
        info["offset"],
    ) == (0, 0, 6 * 17, 0, best)
    assert "variables        0 in 0 groups" in run("info", problem).out.decode()
    found, disparities = decoded(problem, None, folder, 4)
    assert found == best and (disparities == 1).all()
    done = run("decode", problem, "-o", folder / "n.pgm", "--color")
    assert f"every site was decided, energy {best:g}" in done.out.decode()
    assert call("decode", problem, "-o", folder / "n.pgm")["sample"] is None


@pytest.mark.parametrize("solver", SOLVERS)
def test_nothing_left_for_solvers(folder, decided, solver):
    problem, facts = decided
    solved = call("solve", problem, "-o", folder / "s.qsf", "--solver", solver)
    assert solved["energy"] == facts["upper_bound"]
    assert call("validate", problem, folder / "s.qsf")["best_energy"] == facts["upper_bound"]
    assert call("info", folder / "s.qsf")["variables"] == 0
    found, disparities = decoded(problem, folder / "s.qsf", folder, 4)
    assert found == facts["upper_bound"] and (disparities == 1).all()


def test_nothing_left_for_the_other_commands(folder, decided):
    problem, facts = decided
    samples = write_qsf(folder / "w.qsf", problem, np.zeros((2, 0)), [facts["upper_bound"]] * 2)
    for repair in ([], ["--repair"], ["--sample", "1"]):
        assert (
            call("decode", problem, samples, "-o", folder / "m.pgm", *repair)["energy"]
            == facts["upper_bound"]
        )
    compared = call("compare", problem, "--samples", samples, "--maps", folder / "maps")
    assert [result["energy"] for result in compared["results"]] == [facts["upper_bound"]] * (
        len(SOLVERS) + 1
    )
    again = call("reduce", problem, "-o", folder / "again.qcf")
    assert (again["variables_before"], again["variables_after"], again["sites_before"]) == (0, 0, 0)
    assert again["upper_bound"] == facts["upper_bound"] and again["proven_optimal"]
    assert (folder / "again.qcf").read_bytes() == problem.read_bytes()
    rows = call("info", problem, "--complexity")["encodings"]
    assert all(
        row["variables"] in (0, None) or row["encoding"] == "multiway-cut" or row["why_not"]
        for row in rows
    )


def test_compare_on_a_reduced_problem(folder, pair):
    succeed("encode", *pair.paths, "-o", folder / "p.qcf", "--disparity", "0:3", "--lambda", "60")
    whole = call("solve", folder / "p.qcf", "-o", folder / "s.qsf")
    call(
        "reduce",
        folder / "p.qcf",
        "-o",
        folder / "r.qcf",
        "--iterations",
        "2",
        "--encoding",
        "domain-wall",
        "--truncate",
    )
    call("solve", folder / "r.qcf", "-o", folder / "r.qsf", "--solver", "icm")
    compared = call(
        "compare", folder / "r.qcf", "--samples", folder / "r.qsf", "--maps", folder / "maps"
    )
    best = [result for result in compared["results"] if result["solver"] == "best"][0]
    assert best["energy"] == whole["energy"]
    icm = [result["energy"] for result in compared["results"] if result["solver"] == "icm"]
    # That of solve began with the labelling that the file carries, which is a row, too.
    (known,) = [row["energy"] for row in compared["results"] if row["solver"] == "known"]
    assert len(icm) == 2 and icm[1] <= min(icm[0], known)
    assert all(result["map"] for result in compared["results"])


WORDS = {
    "nothing": (
        "left        nothing: the optimum is proven, and there is no other",
        lambda n: n == 0,
    ),
    "ties": (
        "left        labels that may tie: the best labelling is proven optimal",
        lambda n: n > 0,
    ),
    "open": ("left        an open problem: the optimum lies between", lambda n: n > 0),
}


@pytest.mark.parametrize("case", WORDS)
def test_what_is_left_in_words(folder, shifted, case):
    paths, options = shifted[2:], []
    if case == "ties":
        paths = [write_pgm(folder / "flat.pgm", np.full((6, 20), 9))] * 2
    if case == "open":
        _, _, *paths = random_pair(folder, 20, 6)
        options = ["--iterations", "1"]
    succeed(
        "encode", *paths, "-o", folder / "p.qcf", "--disparity", "0:3", "--lambda", "1" if case ==
        "nothing" else "90"
    )
    facts = call("reduce", folder / "p.qcf", "-o", folder / "s.qcf", *options)
    done = run("reduce", folder / "p.qcf", "-o", folder / "s.qcf", *options)
    text, words = done.out.decode(), WORDS[case]
    assert done.err == "" and words[0] in text and words[1](facts["variables_after"])
    assert facts["proven_optimal"] == (case != "open")
    assert f"{folder / 's.qcf'}: {(folder / 's.qcf').stat().st_size} bytes" in text
    assert (
        f"variables   {facts['variables_after']} (one-hot-sparse), 408 before (one-hot-sparse)"
        in text
    )
    share = 100 * (102 - facts["sites_after"]) / 102
    assert (
        f"sites       {facts['sites_after']} undecided, 102 before: "
        f"{share:.4g} % of all 102 are decided" in text
    )
    assert f"labels      {facts['labels_after']} left, 408 before" in text
    assert f"lower {facts['lower_bound']:g}, upper {facts['upper_bound']:g}, gap" in text
    if case == "open":
        assert f"between {facts['lower_bound']:g} and {facts['upper_bound']:g}\n" in text
    if case == "ties":
        assert f"that is left costs less than {facts['upper_bound']:g}\n" in text
    once = run(
        "encode",
        *paths,
        "-o",
        folder / "o.qcf",
        "--disparity",
        "0:3",
        "--lambda",
        "1" if case == "nothing" else "90",
        "--reduce",
    )
    assert ("102 sites x 4 labels" in once.out.decode()) and (
        words[0] in once.out.decode() or case == "open"
    )


def test_standard_output_and_input(folder, solved):
    call("reduce", solved.problem, "-o", folder / "s.qcf")
    done = run("reduce", "-", "-o", "-", input=solved.problem.read_bytes())
    assert done.out == (folder / "s.qcf").read_bytes()
    assert run("reduce", solved.problem, "-o", "-", "--json").status == 2


def test_time_limit_and_progress(folder, large):
    status, shown = on_terminal("reduce", large, "-o", folder / "s.qcf", "--time-limit", "0.5")
    assert status == 0 and (folder / "s.qcf").exists()
    lines = shown.split("\r\033[K")
    assert lines[0] == lines[-1] == "" and 1 <= len(lines) - 2 <= 4
    for line in lines[1:-1]:
        assert (
            re.fullmatch(
                r"reduce: \d+\.\d s, iteration \d+, \d+ variables left, gap \d+\.\d{4} %", line
            )
            and len(line) < 80
        )
    facts = call("reduce", large, "-o", folder / "s.qcf", "--time-limit", "0.05")
    assert facts["lower_bound"] <= facts["upper_bound"]


def test_the_time_limit_does_not_cut_the_files_short(folder):
    """It is over before the first look, and what is written is whole, with the proof so far."""
    _, _, *paths = random_pair(folder, 20, 6)
    p, s, a, c = (folder / name for name in ("p.qcf", "s.qcf", "a.qsf", "c.qpf"))
    succeed("encode", *paths, "-o", p, "--disparity", "0:3", "--lambda", "90")
    written = ["-o", s, "--answer", a, "--certificate", c]
    facts = call("reduce", p, *written, "--time-limit", "0.000001")
    assert not facts["proven_optimal"]
    assert json.loads(succeed("verify", p, a, c, "--json").out)["valid"]
    best = [json.loads(succeed("solve", of, "-o", a, "--json").out) for of in (p, s)]
    assert best[0]["proven_optimal"] and best[0]["energy"] == best[1]["energy"]


def test_an_interrupt_leaves_nothing(folder, large):
    status, _ = on_terminal("reduce", large, "-o", folder / "s.qcf", interrupt_at=b"reduce: ")
    assert status == 130
    assert not list(folder.iterdir())


USAGE = {
    "no output": ([], "-o SMALLER.qcf is missing"),
    "target zero": (["-o", "s", "--target", "0"], "--target 0 is not a whole number from 1"),
    "target of a cut": (
        ["-o", "s", "--target", "9", "--encoding", "multiway-cut"],
        "--target does not go with --encoding multiway-cut, but with these: one-hot, "
        "one-hot-sparse, domain-wall",
    ),
    "time limit": (["-o", "s", "--time-limit", "-1"], "--time-limit -1"),
    "iterations": (["-o", "s", "--iterations", "0"], "--iterations 0 is not a whole number from 1"),
    "encoding": (["-o", "s", "--encoding", "domain-wal"], "did you mean domain-wall?"),
    "penalty": (
        ["-o", "s", "--encoding", "domain-wall", "--penalty", "paper"],
        "does not go with --encoding domain-wall: choose local or minimal",
    ),
    "penalty of another unit": (["-o", "s", "--penalty", "0.3"], "multiple above 0 of 1/2"),
    "gap": (
        ["-o", "s", "--penalty", "paper", "--gap", "2"],
        "--gap goes with --penalty local or minimal",
    ),
}


@pytest.mark.parametrize("name", USAGE)
def test_usage_errors(folder, solved, name):
    options, words = USAGE[name]
    done = run("reduce", solved.problem, *options, cwd=folder)
    assert (done.status, done.out) == (2, b"")
    assert (
        words in done.err and done.err.startswith("qstereo reduce: ") and done.err.count("\n") == 1
    )
    assert not list(folder.iterdir())


def test_what_the_smoothness_of_the_file_does_not_allow(folder, tmp_path, solved):
    linear = tmp_path / "linear.qcf"
    succeed(
        "encode", *solved.pair.paths, "-o", linear, "--disparity", "0:3", "--smoothness", "linear"
    )
    for problem, options, words in (
        (
            solved.problem,
            ["--encoding", "st-cut"],
            f"--encoding st-cut cannot hold the smoothness of {solved.problem} (potts), but these "
            "can: one-hot, one-hot-sparse, domain-wall, multiway",
        ),
        (
            linear,
            ["--encoding", "one-hot-sparse", "--penalty", "paper"],
            "--encoding one-hot-sparse only for potts smoothness",
        ),
    ):
        done = run("reduce", problem, "-o", folder / "s.qcf", *options)
        assert (done.status, done.out) == (2, b"")
        assert done.err.startswith("qstereo reduce: --")
        assert words in done.err and done.err.count("\n") == 1
    assert not list(folder.iterdir())
    call("reduce", linear, "-o", folder / "s.qcf", "--encoding", "one-hot", "--penalty", "paper")


def test_problems_that_are_not_read(folder, tmp_path, solved):
    bare = without_chunk(solved.problem, "labl", tmp_path / "bare.qcf")
    done = run("reduce", bare, "-o", folder / "s.qcf")
    assert (done.status, "does not say which labels" in done.err) == (3, True)
    cut = tmp_path / "cut.qcf"
    succeed(
        "encode", *solved.pair.paths, "-o", cut, "--disparity", "1:4", "--encoding", "multiway-cut"
    )
    for command in (
        ["reduce", cut, "-o", folder / "s.qcf"],
        ["solve", cut, "-o", folder / "s.qsf"],
        ["compare", cut],
        ["info", cut, "--complexity"],
    ):
        done = run(*command)
        assert (done.status, done.out) == (3, b"")
        assert (
            "in one of these encodings: one-hot, one-hot-sparse, domain-wall" in done.err
            and done.err.count("\n") == 1
        )
    done = run("reduce", solved.samples, "-o", folder / "s.qcf")
    assert (done.status, "is not a .qcf file but a .qsf" in done.err) == (3, True)
    done = run("reduce", tmp_path / "none.qcf", "-o", folder / "s.qcf")
    assert (done.status, "cannot be opened" in done.err) == (4, True)
    assert not list(folder.iterdir())


def test_an_existing_file_stays_where_it_fails(folder, large):
    (folder / "s.qcf").write_text("as it was")
    done = run("reduce", large, "-o", folder / "s.qcf", "--memory-limit", "40")
    assert (done.status, "needs more than the memory limit" in done.err) == (4, True)
    assert [(path.name, path.read_text()) for path in folder.iterdir()] == [("s.qcf", "as it was")]
    done = run("reduce", large, "-o", large)
    assert (done.status, "large.qcf" in done.err) == (2, True)
    succeed("info", large)
    done = run(
        "reduce",
        large,
        "-o",
        folder / "s.qcf",
        "--time-limit",
        "0.1",
        "--penalty",
        "4503599627370496",
    )
    assert (done.status, "overflow" in done.err) == (3, True)
    assert (folder / "s.qcf").read_text() == "as it was"


@pytest.mark.parametrize(
    "encoding",
    ["one-hot", "one-hot-sparse", "domain-wall", "multiway-cut", "st-cut", "st-cut-arcs"],
)
def test_repair_of_every_encoding(folder, pair, encoding):
    """Random bits become labellings whose energies are not above those of the bits."""
    smoothness = ["--smoothness", "linear"] if encoding.startswith("st") else []
    facts = call(
        "encode",
        *pair.paths,
        "-o",
        folder / "p.qcf",
        "--disparity",
        "0:3",
        "--encoding",
        encoding,
        *smoothness,
    )
    bits = np.random.default_rng(2).integers(0, 2, (3, facts["variables"]))
    refused = run(
        "validate",
        folder / "p.qcf",
        write_qsf(folder / "x.qsf", folder / "p.qcf", bits, [0, 0, 0]),
        "--json",
    )
    assert refused.status == 3 and json.loads(refused.out)["feasible"] == 0
    lowest = []
    for sample in bits:
        seen = json.loads(
            run(
                "validate",
                folder / "p.qcf",
                write_qsf(folder / "x.qsf", folder / "p.qcf", [sample], [0]),
                "--json",
            ).out
        )
        lowest.append(seen["lowest_energy"])
    samples = write_qsf(folder / "x.qsf", folder / "p.qcf", bits, lowest)
    done = run("decode", folder / "p.qcf", samples, "-o", folder / "m.pgm")
    assert (
        done.status,
        "none of the 3 samples is feasible: add --repair to make them so" in done.err,
    ) == (1, True)
    done = run("decode", folder / "p.qcf", samples, "-o", folder / "m.pgm", "--sample", "1")
    assert (
        done.status == 1
        and "sample 1 is not feasible (" in done.err
        and "add --repair to make it so" in done.err
    )
    assert not (folder / "m.pgm").exists()
    done = run("validate", folder / "p.qcf", samples)
    means = {
        "domain-wall": "in no site a 0 stands before a 1",
        "multiway-cut": "each terminal its own",
    }
    assert done.status == 1
    assert (
        means.get(
            encoding, "each site's chain falls" if smoothness else "each site has exactly one label"
        )
        in done.out.decode()
    )
    for sample in range(3):
        repaired = call(
            "decode",
            folder / "p.qcf",
            samples,
            "-o",
            folder / "m.pgm",
            "--scale",
            "2",
            "--sample",
            sample,
            "--repair",
        )
        disparities = read_pnm((folder / "m.pgm").read_bytes())[0][:, 3:] // 2
        smooth = np.abs if smoothness else lambda t: (t != 0) * 1
        assert (
            repaired["energy"]
            == energy(pair.left, pair.right, disparities, 20, smooth)
            < lowest[sample]
        )
        assert repaired["repaired"] > 0

def test_a_core_is_no_larger_than_the_problem(tmp_path):
    """Of edges whose ends have kept different labels each would have a block of its own."""
    costs = np.random.default_rng(3).integers(0, 60, (60, 60, 16), dtype=np.int32)
    np.save(tmp_path / "costs.npy", costs)
    problem, core = tmp_path / "p.qcf", tmp_path / "core.qcf"
    options = ["--lambda", "4", "--smoothness", "linear", "--truncation", "3"]
    succeed("encode", "--problem", "label", tmp_path / "costs.npy", "-o", problem, *options)
    line = ["reduce", problem, "-o", core, "--iterations", "4", "--encoding"]
    facts = call(*line, "one-hot")
    assert facts["labels_after"] < facts["labels_before"]
    assert facts["variables_left"] == facts["variables_after"]
    small = 2**20  # bytes, at which nobody looks
    assert core.stat().st_size > max(problem.stat().st_size, small)
    done = run(*line[:-1])
    assert done.status == 0, done.err
    said = done.out.decode()
    assert "undecided sites have all their labels" in said
    kept = call(*line[:-1])
    assert f"{kept['variables_left']} variables are left" in said
    assert kept["variables_left"] < kept["variables_after"]
    assert core.stat().st_size <= max(problem.stat().st_size, small)
    assert call("info", core)["variables"] <= facts["variables_before"]
    answer = ["-o", tmp_path / "s.qsf", "--iterations", "20"]
    assert call("solve", core, *answer)["energy"] >= facts["lower_bound"]


def test_a_core_that_could_only_be_larger_is_the_problem_itself(tmp_path):
    """Costs of single sites that are decided raise those of their neighbours above one byte."""
    costs = np.zeros((390, 390, 8), dtype=np.int32)
    costs[..., 7] = 220
    decided = costs[3::9, 3::9]
    decided[:] = 255
    labels = np.random.default_rng(3).integers(0, 7, decided.shape[:2])
    np.put_along_axis(decided, labels[..., None], 0, axis=2)
    np.save(tmp_path / "costs.npy", costs)
    problem, core, other = (tmp_path / name for name in ("p.qcf", "core.qcf", "other.qcf"))
    samples, answer = tmp_path / "s.qsf", tmp_path / "a.qsf"
    succeed("encode", "--problem", "label", tmp_path / "costs.npy", "-o", problem, "--lambda", "60")
    line = ["reduce", problem, "--iterations", "1", "-o"]
    facts = call(*line, other, "--encoding", "one-hot-sparse")
    assert facts["sites_after"] < facts["sites_before"]
    assert other.stat().st_size > problem.stat().st_size > 2**20
    done = run(*line, core, "--samples", samples, "--answer", answer)
    assert done.status == 0, done.err
    assert "the file is P.qcf as it came" in done.out.decode()
    assert core.read_bytes() == problem.read_bytes()
    facts = call("reduce", problem, "--iterations", "1", "-o", other)
    assert facts["sites_after"] == facts["sites_before"]
    for found in (samples, answer):
        assert call("validate", core, found)["best_energy"] == facts["upper_bound"]


def test_samples_are_needed_where_something_is_left(folder, solved):
    done = run("decode", solved.problem, "-o", folder / "m.pgm")
    assert (done.status, done.out) == (2, b"")
    assert (
        f"the operand S.qsf is missing: samples of the 160 variables of {solved.problem}"
        in done.err
    )
    assert "the operand S.qsf is missing" in run("validate", solved.problem).err
    assert not list(folder.iterdir())


def test_a_sample_of_none(folder, decided):
    done = run("decode", decided[0], "-o", folder / "m.pgm", "--sample", "0")
    assert (done.status, "--sample goes with S.qsf" in done.err) == (2, True)
    assert not list(folder.iterdir())
