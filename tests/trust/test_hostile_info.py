"""JSON from outside. In what a solver says of itself, the INFO of a .qsf, both readers refuse
numbers that no double holds; what is of another kind than expected breaks no command."""

import json
import sys
from pathlib import Path

import pytest
from qstereo_bridge.desk.cli import main
from qstereo_bridge.core.container import FormatError
from qstereo_bridge.core.qsf import parse_qsf

sys.path.insert(0, str(Path(__file__).parents[1] / "cli"))
from cli_tools import random_pair, run, succeed, with_chunk  # noqa: E402

REFUSED = {
    "beyond all doubles": "1e999",
    "below all doubles": "-1e999",
    "a whole number beyond all doubles": "1" + "0" * 400,
    "a number of 1,001 characters": "0." + "1" * 999,
}
TAKEN = {
    "the largest double": "1.7976931348623157e308",
    "the least double": "-1.7976931348623157e308",
    "a number below all doubles but 0": "1e-999",
    "a number of 1,000 characters": "0." + "1" * 998,
    **{kind: text for kind, text in (
        ("truth", "true"), ("nothing", "null"), ("a text", '"x"'), ("a list", "[[1], {}]"),
        ("an object", '{"known": 1, "reads": "x"}'), ("half a character", '"\\ud800"'))},
}
KEYS = ["lower_bound", "result", "calls", "warnings", "chains", "timing", "parameters", "merged"]


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    """A reduced problem, and a sample of it."""
    folder = tmp_path_factory.mktemp("solved")
    *_, left, right = random_pair(folder, 40, 20)
    problem, samples = folder / "p.qcf", folder / "s.qsf"
    succeed("encode", left, right, "-o", problem, "--disparity", "0:5", "--reduce",
            "--encoding", "domain-wall")
    succeed("solve", problem, "-o", samples, "--solver", "icm")
    return problem, samples


def hostile(samples, text, path):
    said = ", ".join(f"{json.dumps(key)}: {text}" for key in KEYS)
    return with_chunk(samples, "INFO", f"{{{said}}}".encode(), path)


@pytest.mark.parametrize("name", REFUSED)
def test_refused_by_both_readers(solved, name, tmp_path):
    path = hostile(solved[1], REFUSED[name], tmp_path / "s.qsf")
    for line in (["info", path], ["validate", solved[0], path]):
        done = run(*line)
        assert done.status == 3 and "INFO" in done.err
    with pytest.raises(FormatError, match="INFO"):
        parse_qsf(path.read_bytes())


@pytest.mark.parametrize("name", TAKEN)
def test_breaks_no_command(solved, name, tmp_path, capsys):
    problem, path = solved[0], hostile(solved[1], TAKEN[name], tmp_path / "s.qsf")
    succeed("info", path, "--json")
    succeed("validate", problem, path)
    out = tmp_path / "out.qsf"
    for line in (
        ["merge", problem, path, "-o", out],
        ["solve", problem, "-o", out, "--solver", "exact", "--windows", "2", "--start", path],
        ["inspect", problem, path],
    ):
        assert main([str(word) for word in line]) in (0, 1, 2, 3, 4), line
    assert parse_qsf(path.read_bytes()).info.keys() == set(KEYS)


DEEP = "[" * 50000
JOURNAL = '{"format": "qstereo-journal"}\n'
# name of a file, what it holds: results that are none
RESULTS = [
    ("r.json", DEEP),
    ("r.json", "[5]"),
    ("r.json", '{"problems": [5]}'),
    ("r.json", '{"results": [5]}'),
    ("r.json", '{"results": [{"energy": "x"}]}'),
    ("r.json", '{"results": [{"solver": "a"}], "trace": "\\u0000"}'),
    ("r.json", '{"results": [{"solver": "a", "map": "\\u0000"}]}'),
    ("r.json", '{"results": [{"solver": "a"}], "width": "x"}'),
    ("w.qsf.journal", DEEP),
    ("w.qsf.journal", JOURNAL + "5\n"),
    ("w.qsf.journal", JOURNAL + '{"charge_seconds": "x"}\n'),
    ("t.csv", "\x00\n"),
]


@pytest.mark.parametrize("name, text", RESULTS)
def test_results_that_are_none(name, text, tmp_path, capsys):
    path = tmp_path / name
    path.write_text(text)
    assert main(["report", str(path), "-o", str(tmp_path / "page.html")]) == 3
    assert capsys.readouterr().err.count("\n") == 1
    assert [found.name for found in tmp_path.iterdir()] == [name]


LINES = [DEEP, "5", '{"bits": 5}', '{"bits": "AA==", "charge_seconds": {}}']


@pytest.mark.parametrize("line", LINES)
def test_journals_that_are_none(solved, line, tmp_path, capsys):
    """They are of no run, and stay as they are."""
    out = tmp_path / "out.qsf"
    words = ["solve", str(solved[0]), "-o", str(out), "--solver", "exact", "--windows", "2"]
    assert main([*words, "--calls", "1", "--alone"]) == 0
    journal = Path(f"{out}.journal")
    held = journal.read_text().splitlines()[0] + "\n" + line + "\n"
    journal.write_text(held)
    assert main([*words, "--alone"]) == 1
    assert "the journal of another run" in capsys.readouterr().err
    assert journal.read_text() == held


def test_parameters_that_are_no_json(solved, tmp_path, capsys):
    words = ["solve", str(solved[0]), "-o", str(tmp_path / "out.qsf"), "--solver", "anneal"]
    assert main([*words, "--param", f"a={DEEP}"]) == 2
    assert "is not KEY=JSON" in capsys.readouterr().err
