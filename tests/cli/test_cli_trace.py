"""--trace of solve, match, compare and reduce: how energy and bound went on."""

import csv
import json

import pytest
from cli_tools import SOLVERS, run, succeed, write_pgm

HEADING = ["solver", "seconds", "iteration", "energy", "bound", "variables"]


def rows_of(path):
    with open(path, newline="", encoding="ascii") as file:
        reader = csv.DictReader(file)
        rows = list(reader)
    assert reader.fieldnames == HEADING and rows
    return rows


def numbers(rows, key):
    return [float(row[key]) for row in rows if row[key]]


@pytest.mark.parametrize("solver", SOLVERS)
def test_solve(folder, solved, solver):
    """The last row is the answer; a bound never falls, and time never runs back."""
    trace = folder / "t.csv"
    said = json.loads(succeed("solve", solved.problem, "-o", folder / "s.qsf", "--solver", solver,
                              "--trace", trace, "--json").out)
    rows = rows_of(trace)
    assert {row["solver"] for row in rows} == {solver} and numbers(rows, "variables") == []
    assert numbers(rows, "energy")[-1] == said["energy"]
    assert numbers(rows[-1:], "bound") == ([] if said["lower_bound"] is None
                                           else [said["lower_bound"]])
    assert int(rows[-1]["iteration"]) == said["iterations"]
    assert float(rows[-1]["seconds"]) == said["seconds"]
    for key in ("seconds", "bound"):
        assert numbers(rows, key) == sorted(numbers(rows, key))
    if solver != "anneal":  # which tells the energy of the moment
        assert numbers(rows, "energy") == sorted(numbers(rows, "energy"), reverse=True)
    told = [[row[key] for key in ("energy", "bound", "variables")] for row in rows[:-1]]
    assert all(one != other for one, other in zip(told, told[1:]))


def test_compare_has_all_solvers_in_one_file(folder, solved):
    trace = folder / "t.csv"
    said = json.loads(succeed("compare", solved.problem, "--trace", trace, "--json").out)
    rows = rows_of(trace)
    assert said["trace"] == str(trace)
    assert list(dict.fromkeys(row["solver"] for row in rows)) == SOLVERS
    last = {row["solver"]: float(row["energy"]) for row in rows}
    assert last == {one["solver"]: one["energy"] for one in said["results"]}


def test_reduce_says_what_is_left(folder, solved):
    trace = folder / "t.csv"
    said = json.loads(succeed("reduce", solved.problem, "-o", folder / "c.qcf", "--trace", trace,
                              "--json").out)
    rows = rows_of(trace)
    assert {row["solver"] for row in rows} == {"reduce"}
    assert (numbers(rows, "energy")[-1], numbers(rows, "bound")[-1]) == (
        said["upper_bound"], said["lower_bound"])
    left = numbers(rows, "variables")
    assert left == sorted(left, reverse=True) and left[-1] == said["variables_after"]


def test_match_traces_the_left_picture_alone(folder, pair):
    said = []
    for check in ([], ["--after", "check"]):
        said.append(json.loads(succeed(
            "match", *pair.paths, "-o", folder / "m.pgm", "--disparity", "1:4", "--solver", "trws",
            "--trace", folder / f"t{len(said)}.csv", "--json", "--cost", "ad:40", "--border",
            "keep", *check).out))
    for number, of in enumerate(said):
        rows = rows_of(folder / f"t{number}.csv")
        assert float(rows[-1]["energy"]) == of["energy"]
        assert float(rows[-1]["seconds"]) == of["seconds"]


def test_what_is_refused(folder, solved, pair, tmp_path):
    line = ["solve", solved.problem, "-o", folder / "s.qsf"]
    done = run(*line, "--trace", "-")
    assert done.status == 2 and "--trace cannot go to standard output" in done.err
    done = run(*line, "--trace", folder / "none" / "t.csv")
    assert done.status == 4 and "t.csv" in done.err
    write_pgm(tmp_path / "l_0001.pgm", pair.left)
    write_pgm(tmp_path / "r_0001.pgm", pair.right)
    done = run("match", tmp_path / "l_%04d.pgm", tmp_path / "r_%04d.pgm", "-o",
               folder / "m_%04d.pgm", "--trace", folder / "t.csv")
    assert done.status == 2 and "--trace goes with one pair" in done.err
    assert list(folder.iterdir()) == []


def test_no_trace_where_the_command_fails(folder, solved):
    """A solver that cannot be used leaves neither answer nor trace."""
    done = run("solve", solved.problem, "-o", folder / "s.qsf", "--solver", "cut",
               "--trace", folder / "t.csv")
    assert done.status == 2 and list(folder.iterdir()) == []
