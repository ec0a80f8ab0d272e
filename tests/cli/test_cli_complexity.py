"""info --complexity: each row is what the QUBO itself has, encoded by encode."""

import json

import pytest
from cli_tools import ROOT, bits_of, random_pair, run, succeed, without_chunk

FORMS = [
    ("one-hot", "local"),
    ("one-hot", "paper"),
    ("one-hot-sparse", "local"),
    ("one-hot-sparse", "minimal"),
    ("domain-wall", "local"),
    ("multiway-cut", "local"),
    ("st-cut", "local"),
    ("st-cut-arcs", "local"),
]
RANGES = ["linear_min", "linear_max", "quadratic_min", "quadratic_max"]
HELD = {
    "potts": {"one-hot", "one-hot-sparse", "domain-wall", "multiway-cut"},
    "linear": {"one-hot", "one-hot-sparse", "domain-wall", "st-cut", "st-cut-arcs"},
    "quadratic": {"one-hot", "domain-wall"},
}


def call(*arguments):
    return json.loads(succeed(*arguments, "--json").out)


@pytest.mark.parametrize("smoothness", HELD)
def test_rows_are_those_of_the_files(folder, pair, smoothness):
    options = ["--disparity", "0:3", "--lambda", "2.5", "--smoothness", smoothness]
    succeed("encode", *pair.paths, "-o", folder / "p.qcf", *options)
    rows = call("info", folder / "p.qcf", "--complexity")["encodings"]
    assert [(row["encoding"], row["penalty"], row["truncated"]) for row in rows] == [
        (*form, cut) for form in FORMS for cut in (False, True)
    ]
    for row in rows:
        if row["encoding"] not in HELD[smoothness]:
            assert (
                row["why_not"]
                and row["unit"] is None
                and [row[key] for key in RANGES] == [None] * 4
            )
            continue
        facts = call(
            "encode",
            *pair.paths,
            "-o",
            folder / "q.qcf",
            *options,
            "--encoding",
            row["encoding"],
            "--penalty",
            row["penalty"],
            *(["--truncate"] if row["truncated"] else []),
        )
        assert row["why_not"] is None and row["unit"] > 0
        assert {key: row[key] for key in ["variables", "quadratic_terms", *RANGES]} == {
            key: facts[key] for key in ["variables", "quadratic_terms", *RANGES]
        }


def test_counts_of_the_cuts_are_given_for_potts_too(folder, pair):
    """By the formulas; with linear smoothness the same numbers are measured."""
    counts = {}
    for smoothness in ("potts", "linear"):
        succeed(
            "encode", *pair.paths, "-o", folder / "p.qcf", "--disparity", "0:3", "--smoothness",
            smoothness
        )
        rows = call("info", folder / "p.qcf", "--complexity")["encodings"][-4:]
        counts[smoothness] = [
            (row["encoding"], row["variables"], row["quadratic_terms"]) for row in rows
        ]
        assert {row["why_not"] for row in rows} == {
            None if smoothness == "linear" else "linear smoothness without truncation only"
        }
    assert counts["potts"] == counts["linear"]
    assert call("info", folder / "p.qcf", "--complexity")["encodings"][-4]["variables"] == len(
        bits_of([0] * 45, 4, "st-cut")
    )


def test_a_unit_by_hand():
    """Two sites of two labels, one edge of 3: one-hot-sparse, a = 1, b = 1 + 3 + 1."""
    problem = ROOT / "tests" / "golden" / "good-smallest.qcf"
    row = call("info", problem, "--complexity")["encodings"][4]
    assert (row["encoding"], row["penalty"]) == ("one-hot-sparse", "local")
    # Q: linear 0 - 1 and 2 - 1 of site 1, -1 and -1 of site 2; pairs 5 in a site, -3 for equal
    # labels. 4h = 2 Q_ii + sum_j Q_ij, 4J = Q_ij.
    h = [(2 * linear + 5 - 3) / 4 for linear in (-1, 1, -1, -1)]
    assert row["unit"] == pytest.approx(
        min(4 / max(map(abs, h)), 2 / (3 / 4), 1 / (5 / 4)), rel=1e-12
    )


def test_the_table(folder, solved):
    text = run("info", solved.problem, "--complexity").out.decode()
    lines = text.splitlines()
    assert all(len(line) <= 100 for line in lines[1:])
    assert "40 undecided sites, 160 labels left to them; smoothness: potts" in lines[0]
    heading = next(line for line in lines if line.startswith("encoding "))
    assert heading.split() == [
        "encoding",
        "variables",
        "terms",
        "linear",
        "quadratic",
        "unit",
        "truncated",
    ]
    rows = call("info", solved.problem, "--complexity")["encodings"]
    for whole, cut in zip(rows[::2], rows[1::2]):
        name = whole["encoding"] + ("" if whole["penalty"] == "local" else f", {whole['penalty']}")
        shown = next(line for line in lines if line.startswith(name + "  "))[len(name) :].split()
        assert shown[:2] == [str(whole["variables"]), str(whole["quadratic_terms"])]
        if whole["why_not"]:
            assert shown[2:] == ["-"] * 4 and any(
                line.startswith(f"{name}: {whole['why_not']}") for line in lines
            )
        else:
            assert shown[2:4] == [
                f"{whole['linear_min']:g}..{whole['linear_max']:g}",
                f"{whole['quadratic_min']:g}..{whole['quadratic_max']:g}",
            ]
            assert shown[4:] == [f"{whole['unit']:.3g}", f"{cut['unit']:.3g}"]


def test_of_a_reduced_problem(folder, pair):
    """The labels that are left, in each encoding; the formulas of the whole grid no longer hold
    for the cuts.
    """
    succeed("encode", *pair.paths, "-o", folder / "p.qcf", "--disparity", "0:3", "--lambda", "60")
    facts = call(
        "reduce",
        folder / "p.qcf",
        "-o",
        folder / "s.qcf",
        "--iterations",
        "2",
        "--encoding",
        "domain-wall",
    )
    rows = {
        (row["encoding"], row["penalty"]): row
        for row in call("info", folder / "s.qcf", "--complexity")["encodings"][::2]
    }
    assert rows["domain-wall", "local"]["variables"] == facts["variables_after"]
    assert rows["one-hot", "paper"]["variables"] == facts["variables_after"] + facts["sites_after"]
    assert rows["st-cut", "local"]["variables"] is None and rows["st-cut", "local"]["why_not"]


def test_an_encoding_that_does_not_fit_is_said_so(folder, tmp_path):
    _, _, left, right = random_pair(tmp_path, 120, 80)
    succeed("encode", left, right, "-o", folder / "p.qcf", "--smoothness", "linear")
    rows = call("info", folder / "p.qcf", "--complexity", "--memory-limit", "24")["encodings"]
    fits = {row["encoding"]: row["why_not"] for row in rows}
    assert fits["domain-wall"] is None and fits["st-cut-arcs"].startswith("over the memory limit")
    whole = call("info", folder / "p.qcf", "--complexity")["encodings"]
    for row, measured in zip(rows, whole):
        assert (row["encoding"], row["penalty"], row["variables"]) == (
            measured["encoding"],
            measured["penalty"],
            measured["variables"],
        )
        formula = row["encoding"].startswith("st-cut")
        assert row["quadratic_terms"] == (
            measured["quadratic_terms"] if formula or not row["why_not"] else None
        )
    text = run("info", folder / "p.qcf", "--complexity", "--memory-limit", "24").out.decode()
    assert "st-cut-arcs: over the memory limit, so that the rest cannot be measured\n" in text


@pytest.mark.parametrize(
    "options",
    [[], ["--encoding", "domain-wall"], ["--lambda", "60", "--reduce", "--time-limit", "0.000001"]],
)
def test_variables_are_counted_without_room_for_the_qubo(folder, tmp_path, options):
    _, _, left, right = random_pair(tmp_path, 240, 160)
    succeed("encode", left, right, "-o", folder / "p.qcf", "--disparity", "0:3", *options)
    whole, rows = (
        call("info", folder / "p.qcf", "--complexity", *limit)["encodings"]
        for limit in ([], ["--memory-limit", "9"])
    )
    assert {row["encoding"] for row in rows if (row["why_not"] or "").startswith("over")} >= {
        "one-hot",
        "domain-wall",
        "multiway-cut",
    }
    assert [row["variables"] for row in rows] == [row["variables"] for row in whole]


def test_the_gap_is_that_of_the_file(folder, pair):
    for gap in ("1", "7"):
        options = ["--disparity", "0:3", "--encoding", "domain-wall", "--gap", gap]
        facts = call("encode", *pair.paths, "-o", folder / "p.qcf", *options)
        row = call("info", folder / "p.qcf", "--complexity")["encodings"][8]
        assert (row["encoding"], row["truncated"]) == ("domain-wall", False)
        assert {key: row[key] for key in RANGES} == {key: facts[key] for key in RANGES}
        assert (
            f"the gap {gap} of the file.\n"
            in run("info", folder / "p.qcf", "--complexity").out.decode()
        )


def test_what_has_no_complexity(tmp_path, solved):
    done = run("info", solved.samples, "--complexity")
    assert (done.status, done.out) == (3, b"") and "is not a .qcf file" in done.err
    done = run("info", without_chunk(solved.problem, "labl", tmp_path / "bare.qcf"), "--complexity")
    assert (done.status, done.out) == (3, b"") and "does not say which labels" in done.err
