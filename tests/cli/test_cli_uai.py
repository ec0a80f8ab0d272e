"""encode --problem uai: Markov networks of the UAI format, beside every state of them."""

import itertools
import json

import numpy as np
import pytest
from cli_tools import run

SCALE = 1000


def write(path, values, factors):
    """factors: (variables, table); the last variable's values run fastest."""
    text = ["MARKOV", str(len(values)), " ".join(map(str, values)), str(len(factors))]
    text += [" ".join(map(str, [len(scope), *scope])) for scope, _ in factors]
    for _, table in factors:
        text += ["", str(table.size), " ".join(repr(float(p)) for p in table.flat)]
    path.write_text("\n".join(text) + "\n")
    return path


def least_cost(values, factors):
    """The least sum of rounded costs, over the states of probability above 0."""
    best = None
    for state in itertools.product(*map(range, values)):
        entries = [table[tuple(state[v] for v in scope)] for scope, table in factors]
        if all(entries):
            cost = sum(int(np.rint(-np.log(p) * SCALE)) for p in entries)
            best = cost if best is None else min(best, cost)
    return best / SCALE


@pytest.mark.parametrize("seed", range(6))
def test_least_costs(tmp_path, seed):
    random = np.random.default_rng(seed)
    values = random.integers(1, 4, 5).tolist()
    pairs = [p for p in itertools.permutations(range(5), 2) if random.random() < 0.35]
    scopes = [(v,) for v in range(5)] + pairs + [()] * (seed % 2)
    factors = [(s, random.random([values[v] for v in s]) * 3 + 0.01) for s in scopes]
    values_of_3 = factors[3][1]
    values_of_3[1:] *= random.integers(0, 2, len(values_of_3) - 1)
    problem = tmp_path / "p.qcf"
    net = write(tmp_path / "net.uai", values, factors)
    done = run("encode", "--problem", "uai", net, "-o", problem, "--scale", SCALE, "--json")
    assert done.status == 0, done.err
    assert json.loads(done.out)["variables"] <= sum(values)
    done = run("solve", problem, "-o", tmp_path / "s.qsf", "--json")
    assert json.loads(done.out)["energy"] == pytest.approx(least_cost(values, factors), abs=1e-9)


def test_comments_blank_lines_and_other_ends_of_lines(tmp_path):
    """They change nothing, and lines are counted on."""
    net, outs = tmp_path / "net.uai", []
    for i, text in enumerate([
        GOOD,
        GOOD.replace("\n", "\r\n"),
        GOOD.replace("\n", "\n\n \n"),
        GOOD.replace("\n", " "),
        "c of a comment\n# and one\n" + GOOD.replace("2 0 1\n", "2 0 1\n  c\n#x 3\n") + "c end",
    ]):
        net.write_bytes(text.encode())
        outs.append(tmp_path / f"{i}.qcf")
        done = run("encode", "--problem", "uai", net, "-o", outs[-1])
        assert done.status == 0, done.err
    assert len({out.read_bytes() for out in outs}) == 1
    net.write_text("#\nc c\n" + GOOD.replace(".3", "# .3"))
    done = run("encode", "--problem", "uai", net, "-o", tmp_path / "p.qcf")
    assert done.status == 3 and "ends before the last entry" in done.err
    net.write_text("#\nc c\n" + GOOD.replace(".3", "x"))
    assert "line 13: the entry x" in run("encode", "--problem", "uai", net, "-o", "p.qcf").err


GOOD = "MARKOV\n2\n2 2\n2\n1 0\n2 0 1\n2\n .5 .5\n4\n .1 .2\n .3 .4\n"


@pytest.mark.parametrize(
    ("was", "now", "words"),
    [
        ("MARKOV", "BAYES", ["MARKOV"]),
        ("2 0 1", "3 0 1 0", ["line 6", "3 variables", "pairwise"]),
        ("2 0 1", "2 0 0", ["line 6", "twice"]),
        ("2 0 1", "2 0 2", ["line 6", "0 to 1"]),
        ("\n4\n", "\n3\n", ["line 9", "3 entries", "4 values"]),
        (".3", "0", ["line 11", "0", "small probability"]),
        (".3", "-1", ["line 11", "-1"]),
        (".3", "x", ["line 11", "x"]),
        (".4\n", "", ["ends before"]),
        (".4\n", ".4 5\n", ["line 11", "behind the last"]),
        (" .5 .5", "0 0", ["variable 0"]),
        ("2\n2 2", "x\n2 2", ["line 2", "x"]),
    ],
)
def test_errors_name_the_line(tmp_path, was, now, words):
    assert GOOD.count(was) >= 1
    net = tmp_path / "net.uai"
    net.write_text(GOOD)
    out = tmp_path / "p.qcf"
    assert run("encode", "--problem", "uai", net, "-o", out).status == 0
    out.unlink()
    net.write_text(GOOD.replace(was, now, 1))
    done = run("encode", "--problem", "uai", net, "-o", out)
    assert done.status == 3
    assert not out.exists()
    for word in ["net.uai", *words]:
        assert word in done.err
