"""solve: the library's solvers on a .qcf, held against numpy and brute force."""

import json
import re
import signal

import numpy as np
import pytest
from cli_tools import (
    LONG,
    ROOT,
    SOLVERS,
    best_of_all,
    chunks_of,
    energy,
    on_terminal,
    random_pair,
    read_pnm,
    run,
    signal_at_output,
    started,
    succeed,
    without_chunk,
)

GOLDEN = ROOT / "tests" / "golden"
KEYS = {
    "schema",
    "solver",
    "energy",
    "lower_bound",
    "gap",
    "proven_optimal",
    "iterations",
    "seconds",
    "converged",
}
SMOOTH = {
    "potts": lambda t: (t != 0) * 1,
    "linear": lambda t: np.minimum(np.abs(t), 2),
    "quadratic": lambda t: np.minimum(t * t, 3),
}


def solve(problem, output, *options):
    return json.loads(succeed("solve", problem, "-o", output, "--json", *options).out)


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_answer_and_what_is_said_of_it(folder, solved, solver):
    """F by numpy, H by validate, and the same facts on standard output and in the file."""
    facts = solve(solved.problem, folder / "s.qsf", "--solver", solver)
    assert set(facts) == KEYS
    assert (facts["schema"], facts["solver"]) == (1, solver)
    succeed("decode", solved.problem, folder / "s.qsf", "-o", folder / "m.pgm", "--scale", "2")
    disparities = read_pnm((folder / "m.pgm").read_bytes())[0][:, 4:] // 2
    assert facts["energy"] == energy(solved.pair.left, solved.pair.right, disparities, 2.5)
    checked = json.loads(run("validate", solved.problem, folder / "s.qsf", "--json").out)
    assert (checked["samples"], checked["feasible"], checked["energies_agree"]) == (1, 1, True)
    said = json.loads(run("info", folder / "s.qsf", "--json").out)
    assert (said["solver"], said["best_energy"]) == (solver, 2 * facts["energy"])
    assert said["info"] == {
        "parameters": {"iterations": None, "time_limit": None, "seed": 0},
        "lower_bound": None if facts["lower_bound"] is None else 2 * facts["lower_bound"],
        "proven_optimal": facts["proven_optimal"],
        "iterations": facts["iterations"],
        "seconds": facts["seconds"],
    }
    assert sorted(path.name for path in folder.iterdir()) == ["m.pgm", "s.qsf"]


@pytest.mark.parametrize("smoothness", SMOOTH)
@pytest.mark.parametrize("seed", range(4))
def test_bounds_and_energies_hold_the_optimum_between_them(tmp_path, seed, smoothness):
    left, right, left_path, right_path = random_pair(tmp_path, 5, 3, seed)
    lam = [0, 7.5, 20, 60][seed]
    options = [
        "--smoothness",
        smoothness,
        *(
            ["--truncation", {"linear": 2, "quadratic": 3}[smoothness]]
            if smoothness != "potts"
            else []
        ),
    ]
    succeed(
        "encode", left_path, right_path, "-o", tmp_path / "p.qcf", "--disparity", "0:2", "--lambda",
        lam, *options
    )
    optimum = best_of_all(left, right, 3, lam, SMOOTH[smoothness])
    for solver in SOLVERS:
        done = run(
            "solve", tmp_path / "p.qcf", "-o", tmp_path / "s.qsf", "--json", "--solver", solver
        )
        facts = json.loads(done.out)
        assert facts["energy"] >= optimum
        if facts["lower_bound"] is None:
            assert (facts["gap"], facts["proven_optimal"]) == (None, False)
        else:
            assert facts["lower_bound"] <= optimum
            assert facts["gap"] == facts["energy"] - facts["lower_bound"]
            assert facts["proven_optimal"] == (facts["gap"] == 0)
        assert (facts["lower_bound"] is not None) == (solver in ("trws", "best"))


@pytest.mark.parametrize(
    "name",
    [
        "good-smallest",
        "good-grid-sparse",
        "good-grid-paper",
        "good-masked-weighted",
        "good-linear",
        "good-edges-table",
    ],
)
@pytest.mark.parametrize("solver", ["icm", "anneal", "bp", "trws", "best"])
def test_masks_weights_edge_lists_and_tables(folder, name, solver):
    problem = GOLDEN / f"{name}.qcf"
    solve(problem, folder / "s.qsf", "--solver", solver)
    checked = json.loads(run("validate", problem, folder / "s.qsf", "--json").out)
    assert (checked["feasible"], checked["energies_agree"]) == (1, True)
    known = json.loads(run("validate", problem, GOLDEN / f"{name}.qsf", "--json").out)
    assert solver in ("bp", "trws") or checked["best_energy"] <= known["best_energy"]


def test_the_default_is_best(folder, solved):
    assert solve(solved.problem, folder / "s.qsf")["solver"] == "best"
    assert chunks_of(folder / "s.qsf")["SOLV"] == b"best"


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_same_seed_gives_the_same_answer(folder, solved, solver):
    facts = [
        solve(solved.problem, folder / f"{i}.qsf", "--solver", solver, "--seed", "7")
        for i in range(2)
    ]
    for of in facts:
        del of["seconds"]
    assert facts[0] == facts[1]
    assert chunks_of(folder / "0.qsf")["BITS"] == chunks_of(folder / "1.qsf")["BITS"]
    assert json.loads(chunks_of(folder / "0.qsf")["INFO"])["parameters"]["seed"] == 7


def test_seeds_matter(folder, large):
    for seed in ("1", str(2**64 - 1)):
        solve(
            large, folder / f"{seed}.qsf", "--solver", "anneal", "--iterations", "3", "--seed", seed
        )
    first, second = (chunks_of(path)["BITS"] for path in folder.iterdir())
    assert first != second


def test_iterations(folder, solved):
    facts = solve(solved.problem, folder / "s.qsf", "--solver", "anneal", "--iterations", "3")
    assert facts["iterations"] == 3
    assert json.loads(chunks_of(folder / "s.qsf")["INFO"])["parameters"]["iterations"] == 3


@pytest.mark.parametrize("solver", ["anneal", "trws", "best"])
def test_the_time_limit(folder, large, solver):
    facts = solve(
        large,
        folder / "s.qsf",
        "--solver",
        solver,
        "--time-limit",
        "0.05",
        "--iterations",
        str(10**12),
    )
    assert facts["seconds"] > 0 and not facts["converged"]
    assert json.loads(chunks_of(folder / "s.qsf")["INFO"])["parameters"] == {
        "iterations": 10**12,
        "time_limit": 0.05,
        "seed": 0,
    }
    assert json.loads(run("validate", large, folder / "s.qsf", "--json").out)["energies_agree"]


@pytest.mark.parametrize("number, status", [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_while_solving(folder, large, number, status):
    (folder / "s.qsf").write_text("as it was")
    process = started(
        "solve", large, "-o", folder / "s.qsf", "--solver", "anneal", "--iterations", 10**9
    )
    signal_at_output(process, folder, 2, number)
    out, err = process.communicate(timeout=LONG)
    assert (process.returncode, out, err) == (status, b"", b"")
    assert [path.name for path in folder.iterdir()] == ["s.qsf"] and (
        folder / "s.qsf"
    ).read_text() == "as it was"


def test_progress_on_a_terminal(folder, large):
    status, shown = on_terminal(
        "solve",
        large,
        "-o",
        folder / "s.qsf",
        "--solver",
        "trws",
        "--iterations",
        10**9,
        "--keep-on-interrupt",
        interrupt_at=b"bound",
    )
    assert status == 0
    lines = shown.split("\r\033[K")
    assert lines[0] == "" and len(lines) > 2
    for line in lines[1:-1]:
        assert (
            line.startswith("trws: ")
            and " s, iteration " in line
            and ", energy " in line
            and ", bound " in line
            and len(line) < 80
        )


@pytest.fixture(scope="module")
def fine(tmp_path_factory):
    """The problem `large` in small units."""
    folder = tmp_path_factory.mktemp("fine")
    *_, left, right = random_pair(folder, 400, 300)
    assert (
        run("encode", left, right, "-o", folder / "fine.qcf", "--lambda", "20.000001").status == 0
    )
    return folder / "fine.qcf"


@pytest.mark.parametrize("command", ["solve", "reduce"])
def test_no_number_is_cut(folder, fine, command):
    """Energies of thirteen digits: what does not fit beside the rest is left out whole."""
    _, shown = on_terminal(command, fine, "-o", folder / "s", interrupt_at=b"iteration")
    lines = shown.split("\r\033[K")[1:-1]
    end = {
        "solve": r", energy \d{7}\.\d{1,6}(, bound \d{6,7}(\.\d{1,6})?)?",
        "reduce": r", \d+ variables left(, gap \d+\.\d{4} %)?",
    }
    assert lines
    for line in lines:
        assert (
            re.fullmatch(r"(best|reduce): \d+\.\d s, iteration \d+" + end[command], line)
            and len(line) < 80
        ), line


def test_no_progress_of_what_is_done_at_once(folder, solved):
    assert on_terminal("solve", solved.problem, "-o", folder / "s.qsf", "--solver", "icm") == (
        0,
        "",
    )


def test_a_signal_clears_the_line(folder, large):
    status, shown = on_terminal(
        "solve",
        large,
        "-o",
        folder / "s.qsf",
        "--solver",
        "anneal",
        "--iterations",
        10**9,
        interrupt_at=b"anneal: ",
    )
    assert status == 130
    assert "anneal: " in shown and shown.endswith("\r\033[K")
    assert not list(folder.iterdir())


def test_human_lines(folder, solved):
    done = run("solve", solved.problem, "-o", folder / "s.qsf", "--solver", "icm")
    facts = solve(solved.problem, folder / "s.qsf", "--solver", "icm")
    first, second = done.out.decode().splitlines()
    assert first == f"{folder / 's.qsf'}: energy {facts['energy']:g} by icm; icm has no lower bound"
    assert second.startswith(f"{facts['iterations']} iterations, 0.0")
    done = run("solve", solved.problem, "-o", folder / "s.qsf", "--solver", "trws")
    facts = solve(solved.problem, folder / "s.qsf", "--solver", "trws")
    assert ("proven optimal" in done.out.decode()) == facts["proven_optimal"]
    assert (
        f"lower bound {facts['lower_bound']:g}, gap {facts['gap']:g} (" in done.out.decode()
    ) == (not facts["proven_optimal"])


def test_standard_streams(folder, solved):
    done = succeed("solve", "-", "-o", "-", "--solver", "icm", input=solved.problem.read_bytes())
    (folder / "s.qsf").write_bytes(done.out)
    succeed("validate", solved.problem, folder / "s.qsf")


def test_memory_limit(folder, large):
    for limit, status in (("10", 4), ("200", 0)):
        done = run(
            "solve", large, "-o", folder / "s.qsf", "--solver", "icm", "--memory-limit", limit
        )
        assert (done.status, "raise --memory-limit" in done.err) == (status, status == 4)
        assert len(list(folder.iterdir())) == (status == 0)


@pytest.mark.parametrize(
    "options, words",
    [
        (
            ["--solver", "expantion"],
            "--solver expantion is unknown: did you mean expansion? It can be: "
            "icm anneal swap expansion bp trws cut pack best",
        ),
        (["--solver", "qpu"], "--solver qpu is unknown: it can be: icm anneal"),
        (["--time-limit", "0"], "--time-limit 0 is not a number of seconds above 0"),
        (["--time-limit", "-1"], "above 0"),
        (["--time-limit", "inf"], "above 0"),
        (["--time-limit", "1s"], "above 0"),
        (
            ["--iterations", "0"],
            "--iterations 0 is not a whole number from 1 to 18446744073709551615",
        ),
        (["--iterations", "1.5"], "whole number"),
        (["--seed", "18446744073709551616"], "--seed 18446744073709551616 is not a whole number"),
        (["--seed", "-1"], "whole number"),
        (["-o", "-", "--json"], "cannot both go"),
        (["--memory-limit", "0"], "whole number from 1"),
    ],
)
def test_usage_errors(folder, solved, options, words):
    done = run(
        "solve", solved.problem, *([] if "-o" in options else ["-o", folder / "s.qsf"]), *options
    )
    assert (done.status, done.out) == (2, b"")
    assert words in done.err
    assert not list(folder.iterdir())


@pytest.mark.parametrize(
    "smoothness, labels", [("linear", 3), ("linear", 5), ("quadratic", 3), ("potts", 2)]
)
def test_cut_proves_what_cuts_solve(tmp_path, smoothness, labels):
    """Linear and quadratic costs without truncation, any unary costs; potts with two labels."""
    left, right, *paths = random_pair(tmp_path, labels + 1, 2, labels)
    problem = tmp_path / "p.qcf"
    options = ["--disparity", f"0:{labels - 1}", "--lambda", "12", "--smoothness", smoothness]
    done = succeed("encode", *paths, "-o", problem, *options)
    apart = {"linear": np.abs, "quadratic": np.square, "potts": lambda t: (t != 0) * 1}[smoothness]
    facts = solve(problem, tmp_path / "s.qsf", "--solver", "cut")
    assert facts["energy"] == best_of_all(left, right, labels, 12, apart)
    assert facts["lower_bound"] == facts["energy"]
    assert facts["proven_optimal"] and facts["converged"]


def test_cut_refuses_other_costs(folder, solved):
    done = run("solve", solved.problem, "-o", folder / "s.qsf", "--solver", "cut")
    assert (done.status, done.out) == (2, b"")
    assert f"--solver cut cannot solve the problem of {solved.problem} (potts, " in done.err
    assert "take any problem: icm, anneal, swap, expansion, bp, trws, best" in done.err
    assert not list(folder.iterdir())


def test_a_problem_without_meaning(tmp_path, folder, solved):
    problem = without_chunk(solved.problem, "labl", tmp_path / "bare.qcf")
    succeed("info", problem)
    done = run("solve", problem, "-o", folder / "s.qsf")
    assert (done.status, done.out) == (3, b"")
    assert "does not say which labels its variables stand for" in done.err
    assert not list(folder.iterdir())


def test_bad_files(tmp_path, folder, solved):
    (tmp_path / "cut.qcf").write_bytes(solved.problem.read_bytes()[:-1])
    for problem, status, words in (
        (tmp_path / "none.qcf", 4, "cannot be opened"),
        (solved.samples, 3, "is not a .qcf file"),
        (tmp_path / "cut.qcf", 3, "at byte"),
    ):
        done = run("solve", problem, "-o", folder / "s.qsf")
        assert (done.status, words in done.err) == (status, True)
    assert not list(folder.iterdir())


@pytest.mark.parametrize(
    "solver, options, words",
    [
        ("bp", [], "50 iterations, S s, stopped at its own limit of 50 iterations"),
        ("bp", ["--iterations", "2"], "2 iterations, S s, stopped at the limit of 2 iterations"),
        ("bp", ["--iterations", "1"], "1 iteration, S s, stopped at the limit of 1 iteration"),
        ("bp", ["--time-limit", "0.000001"], "1 iteration, S s, stopped at the time limit"),
        (
            "bp",
            ["--time-limit", "500"],
            "50 iterations, S s, stopped at its own limit of 50 iterations",
        ),
    ],
)
def test_what_stopped_a_solver_in_words(folder, pair, solver, options, words):
    succeed("encode", *pair.paths, "-o", folder / "p.qcf", "--disparity", "0:3", "--lambda", "60")
    lines = (
        run("solve", folder / "p.qcf", "-o", folder / "s.qsf", "--solver", solver, *options)
        .out.decode()
        .splitlines()
    )
    assert re.sub(r"\d+\.\d+ s", "S s", lines[1]) == words


def test_an_end_without_a_proof_in_words(folder):
    """Costs at random, of which nothing is ruled out: best ends before its limit of iterations."""
    random = np.random.default_rng(5)
    shapes = {"c": (24, 24, 6), "right": (24, 23, 6, 6), "down": (23, 24, 6, 6)}
    for name, shape in shapes.items():
        np.save(folder / f"{name}.npy", random.integers(0, 30, shape))
    line = ["label", folder / "c.npy", "-o", folder / "l.npy",
            "--tables", f"{folder / 'right.npy'},{folder / 'down.npy'}"]
    facts = json.loads(succeed(*line, "--json").out)
    assert facts["converged"] and not facts["proven_optimal"] and facts["iterations"] < 2000
    assert b", ended because nothing more was gained\n" in succeed(*line).out
    assert b"nothing more" not in succeed(*line, "--iterations", 50).out


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_keeps_the_best_so_far(folder, large, sent):
    """Without the option it would end the command without a file."""
    line = ["solve", large, "-o", folder / "s.qsf", "--solver", "anneal", "--iterations", 10**12]
    status, shown = on_terminal(
        *line, "--keep-on-interrupt", interrupt_at=b"iteration", signals=[sent]
    )
    assert status == 0 and shown.startswith("\r\033[Kanneal: ")
    assert json.loads(run("validate", large, folder / "s.qsf", "--json").out)["energies_agree"]


def test_a_second_interrupt_ends_the_command(folder, large):
    line = ["solve", large, "-o", folder / "s.qsf", "--solver", "anneal", "--iterations", 10**12]
    both = [signal.SIGINT, signal.SIGTERM]
    status, _ = on_terminal(*line, "--keep-on-interrupt", interrupt_at=b"iteration", signals=both)
    assert status in (128 + signal.SIGINT, 128 + signal.SIGTERM)
    assert not list(folder.iterdir())


def test_messages_before_expansion_have_memory(tmp_path):
    """They come where the time is limited, and of many labels they take more than the moves."""
    *_, left, right = random_pair(tmp_path, 60, 12)
    line = ["match", left, right, "-o", tmp_path / "m.pgm", "--disparity", "0:40"]
    succeed(*line, "--solver", "expansion", "--iterations", 1, "--time-limit", 600)


def test_a_gap_limit(folder, tmp_path):
    """The first solution within the gap is taken."""
    *_, left, right = random_pair(tmp_path, 100, 60)
    assert run("encode", left, right, "-o", tmp_path / "p.qcf").status == 0
    found = {
        limit: solve(tmp_path / "p.qcf", folder / "s.qsf", "--solver", "trws", *limit)
        for limit in ((), ("--gap-limit", "5%"), ("--gap-limit", "1"))
    }
    iterations = [of["iterations"] for of in found.values()]
    assert iterations[1] <= iterations[2] <= iterations[0] and iterations[1] < iterations[0]
    assert 0 < found["--gap-limit", "5%"]["gap"] <= 0.05 * found["--gap-limit", "5%"]["energy"]
    line = ["solve", tmp_path / "p.qcf", "-o", folder / "s.qsf", "--gap-limit"]
    assert b"stopped at the gap limit" in run(*line, "5%", "--solver", "trws").out
    for text in ("x", "-1", "%"):
        done = run(*line, text)
        assert (done.status, "is not a percentage" in done.err) == (2, True)
