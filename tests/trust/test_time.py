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


@pytest.mark.parametrize("spent", [0, 2, 9])
@pytest.mark.parametrize("name", LINES)
def test_what_was_spent_before_counts(tmp_path, name, spent):
    """3 seconds: of 2 that are spent there is time left, of 9 there is none."""
    *_, left, right = random_pair(tmp_path, 20, 6)
    succeed("encode", left, right, "-o", tmp_path / "p.qcf", "--disparity", "0:3", "--lambda", 90)
    done = succeed(*LINES[name], "--iterations", 3, "--time-limit", 3, "--json", program=PNM,
                   cwd=tmp_path,
                   env={**os.environ, "LD_PRELOAD": CLOCK, "CLOCK_SPENT": str(spent)})
    iterations = json.loads(done.out)["iterations"]
    assert iterations < 3 if spent == 9 else iterations == 3
