"""--time-limit is that of the whole command, from before main on. Here time stands still, so that
no test waits for a clock."""

import json
import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "cli"))
from cli_tools import random_pair, succeed  # noqa: E402

PNM, CLOCK = (os.environ[name] for name in ("QSTEREO_PNM", "QSTEREO_CLOCK"))
LINES = {
    "match": ["match", "left.pgm", "right.pgm", "-o", "m.pgm", "--disparity", "0:3",
              "--solver", "anneal"],
    "solve": ["solve", "p.qcf", "-o", "s.qsf", "--solver", "anneal"],
    "reduce": ["reduce", "p.qcf", "-o", "c.qcf"],
}


def iterations(folder, name, limit, spent):
    *_, left, right = random_pair(folder, 20, 6)
    succeed("encode", left, right, "-o", folder / "p.qcf", "--disparity", "0:3", "--lambda", 90)
    done = succeed(*LINES[name], "--iterations", 3, "--time-limit", limit, "--json", program=PNM,
                   cwd=folder,
                   env={**os.environ, "LD_PRELOAD": CLOCK, "CLOCK_SPENT": str(spent)})
    return json.loads(done.out)["iterations"]


CASES = [(name, spent) for name in LINES for spent in (0, 2, 9)]
CASES += [(name, spent) for name in ("match", "solve") for spent in (2.97, 2.99)]


@pytest.mark.parametrize("name, spent", CASES)
def test_what_was_spent_before_counts(tmp_path, name, spent):
    """3 seconds: of 2 that are spent there is time left, of 9 there is none. 0.02 seconds are kept
    for the end of a command."""
    found = iterations(tmp_path, name, 3, spent)
    assert found < 3 if spent > 2.98 else found == 3


@pytest.mark.parametrize("name", ["match", "solve"])
def test_a_limit_below_what_the_end_takes_is_one(tmp_path, name):
    assert iterations(tmp_path, name, 0.01, 0.001) < 3
