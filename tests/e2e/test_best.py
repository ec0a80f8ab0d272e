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
