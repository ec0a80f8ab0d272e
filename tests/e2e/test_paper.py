"""The paper's supplementary example, from pictures to disparities, against what it prints."""

import re

import numpy as np
import pytest
from library import ROOT
from qstereo_bridge.core import models, qcf

PAPER = ROOT / "samples" / "paper"

# The whole model as printed in the supplement, less the typography: x_{column,row,disparity}.
PRINTED = """
-150x100 -200x101 -200x200 -150x201 -200x300 -200x301 -200x110 -200x111 -150x210 -200x211 -200x310
-150x311 -150x120 -200x121 -200x220 -150x221 -200x320 -200x321 +400x100x101 +400x200x201
+400x300x301 +400x110x111 +400x210x211 +400x310x311 +400x120x121 +400x220x221 +400x320x321 +1800
+10x100x201 +10x101x200 +10x100x111 +10x101x110 +10x200x301 +10x201x300 +10x200x211 +10x201x210
+10x300x311 +10x301x310 +10x110x211 +10x111x210 +10x110x121 +10x111x120 +10x210x311 +10x211x310
+10x210x221 +10x211x220 +10x310x321 +10x311x320 +10x120x221 +10x121x220 +10x220x321 +10x221x320
"""
# The printed solution: disparities of columns 1 to 3 of each row.
DISPARITIES = [[1, 0, 0], [1, 1, 0], [1, 0, 0]]

def printed_model():
    """(linear, {(i, j): value}, offset) in the paper's order of variables: row by row, the
    disparities of a pixel together.
    """
    def variable(name):
        column, row, disparity = map(int, name)
        return 6 * row + 2 * (column - 1) + disparity
    linear, pairs, offset = [0] * 18, {}, 0
    for term in PRINTED.split():
        coefficient, *names = term.split("x")
        if not names:
            offset = int(coefficient)
        elif len(names) == 1:
            linear[variable(names[0])] = int(coefficient)
        else:
            pairs[tuple(sorted(map(variable, names)))] = int(coefficient)
    return linear, pairs, offset


@pytest.fixture
def problem(run, tmp_path):
    run("qstereo", "encode", PAPER / "left.pgm", PAPER / "right.pgm", "-o", "p.qcf", "--disparity",
        "0:1", "--lambda", "10", "--encoding", "one-hot", "--penalty", "200")
    return tmp_path / "p.qcf"


def test_the_qubo_is_the_printed_one(problem, run):
    linear, (rows, columns, values), offset = models.expand(qcf.parse_qcf(problem.read_bytes()))
    pairs = dict(zip(zip(rows.tolist(), columns.tolist()), values.tolist()))
    assert (linear.tolist(), pairs, offset) == printed_model()
    info = run("qstereo", "info", "p.qcf", "--json")
    assert (info["variables"], info["quadratic_terms"], info["offset"]) == (18, 33, 1800)
    assert (info["linear_min"], info["linear_max"]) == (-200, -150)
    assert (info["quadratic_min"], info["quadratic_max"]) == (10, 400)
    assert (info["penalty_min"], info["penalty_max"]) == (200, 200)
    assert (info["lambda"], info["sites"]) == (10, 9)


@pytest.mark.parametrize(
    "options", [["--encoding", "one-hot", "--penalty", "200"], ["--encoding", "one-hot"],
                ["--encoding", "one-hot", "--penalty", "paper"], [], ["--penalty", "paper"]],
    ids=lambda options: " ".join(options) or "default")
def test_minimum_and_disparities(options, run, tmp_path):
    run("qstereo", "encode", PAPER / "left.pgm", PAPER / "right.pgm", "-o", "p.qcf", "--disparity",
        "0:1", "--lambda", "10", *options)
    solved = run("qstereo-bridge", "solve", "p.qcf", "-o", "s.qsf", "--solver", "exact", "--json")
    assert (solved["energy"], solved["proven_optimal"], solved["samples"]) == (50, True, 1)
    valid = run("qstereo", "validate", "p.qcf", "s.qsf", "--json")
    assert (valid["feasible"], valid["best_energy"], valid["energies_agree"]) == (1, 50, True)
    assert run("qstereo", "decode", "p.qcf", "s.qsf", "-o", "d.pgm", "--json")["energy"] == 50
    with open(tmp_path / "d.pgm", "rb") as file:
        held = np.frombuffer(file.read()[-12:], np.uint8).reshape(3, 4)
    # Scale 8; 0 = no value, as the first column has no match for disparity 1; 1 = disparity 0.
    assert held.tolist() == [[0, *(8 * d or 1 for d in row)] for row in DISPARITIES]
    score = run("qstereo", "score", "d.pgm", PAPER / "truth.pgm", "--json")
    assert (score["pixels"], score["rms"], score["bad_0_5"]) == (9, 0, 0)


def test_the_papers_alpha_bound(run):
    """sum of max theta + lambda |N| = 6 x 50 + 10 x 12 = 420: the least integer above it is 421
    (and the printed 200 is below).
    """
    run("qstereo", "encode", PAPER / "left.pgm", PAPER / "right.pgm", "-o", "p.qcf", "--disparity",
        "0:1", "--lambda", "10", "--encoding", "one-hot", "--penalty", "paper")
    info = run("qstereo", "info", "p.qcf", "--json")
    assert (info["penalty_min"], info["pair_penalty_max"]) == (421, 842)


def test_printed_terms_are_all_there():
    assert len(re.findall(r"x\d{3}x", PRINTED)) == 33
