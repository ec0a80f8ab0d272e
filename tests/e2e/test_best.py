"""`best` beside the solvers that it is made of, on problems too noisy for TRW-S alone."""

import numpy as np


def test_best_is_below_its_parts(run, tmp_path):
    better = 0
    for seed in range(3):
        random = np.random.default_rng(seed)
        for name in ("left.pgm", "right.pgm"):
            picture = random.integers(0, 256, (30, 36), dtype=np.uint8)
            (tmp_path / name).write_bytes(b"P5 36 30 255\n" + picture.tobytes())
        run("qstereo", "encode", "left.pgm", "right.pgm", "-o", "p.qcf", "--disparity", "0:7",
            "--lambda", "30")
        found = {
            name: run("qstereo", "solve", "p.qcf", "-o", "s.qsf", "--solver", name, "--iterations",
                      "100", "--json")
            for name in ("best", "trws", "expansion")
        }
        assert found["best"]["energy"] <= min(found["trws"]["energy"], found["expansion"]["energy"])
        assert found["best"]["lower_bound"] >= found["trws"]["lower_bound"]
        better += found["best"]["energy"] < found["trws"]["energy"]
    assert better > 0


def test_moves_come_where_messages_are_above_the_cheapest_labels(run, tmp_path):
    """Strokes that must be kept, and nothing between them: messages take long from one to another,
    and moves do not wait for them."""
    random = np.random.default_rng(1)
    costs = np.zeros((60, 60, 3), np.int64)
    for label, row in enumerate((5, 25, 50)):
        costs[row:row + 4, 20:30] = 1_000_000
        costs[row:row + 4, 20:30, label] = 0
    np.save(tmp_path / "costs.npy", costs)
    for name, shape in (("right", (60, 59)), ("down", (59, 60))):
        tables = random.integers(1, 20, (*shape, 1, 1)) * (1 - np.eye(3, dtype=np.int64))
        np.save(tmp_path / f"{name}.npy", tables)
    found = {
        name: run("qstereo", "label", "costs.npy", "-o", "x.npy", "--tables", "right.npy,down.npy",
                  "--solver", name, "--iterations", "8", "--json")["energy"]
        for name in ("best", "trws", "expansion")
    }
    assert found["best"] <= found["expansion"] < found["trws"]
