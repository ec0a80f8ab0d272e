"""Arrays of any labelling problem, with tables of edges and forbidden labels: encoded, reduced,
read and annealed by the bridge without knowing of labels, repaired and decoded to an array.
"""

import numpy as np
import pytest
from qstereo_bridge.core import qcf


def instance(tmp_path):
    random = np.random.default_rng(3)
    costs = random.integers(0, 40, (4, 5, 3)).astype(np.float32)
    costs[random.random(costs.shape) < 0.2] = np.inf
    costs[..., 1] = np.where(np.isinf(costs).all(-1), 7, costs[..., 1])
    right = random.integers(0, 20, (4, 4, 3, 3))
    down = random.integers(0, 20, (3, 5, 3, 3))
    for name, array in {"costs": costs, "right": right, "down": down}.items():
        np.save(tmp_path / f"{name}.npy", array)
    return costs, right, down


def energy(costs, right, down, x):
    y, column = np.indices(x.shape)
    total = costs[y, column, x].sum()
    y, column = np.indices(right.shape[:2])
    total += right[y, column, x[:, :-1], x[:, 1:]].sum()
    y, column = np.indices(down.shape[:2])
    return total + down[y, column, x[:-1], x[1:]].sum()


@pytest.mark.parametrize("reduced", [False, True])
def test_arrays_to_array(run, tmp_path, reduced):
    arrays = instance(tmp_path)
    run("qstereo", "encode", "--problem", "label", "costs.npy", "--tables", "right.npy,down.npy",
        "-o", "p.qcf")
    best = run("qstereo", "label", "costs.npy", "--tables", "right.npy,down.npy", "-o", "best.npy",
               "--json")
    assert best["proven_optimal"]
    assert best["energy"] == energy(*arrays, np.load(tmp_path / "best.npy"))
    problem = "p.qcf"
    with open(tmp_path / "p.qcf", "rb") as file:
        whole = qcf.read_qcf(file)
    assert whole.linear.size == np.isfinite(arrays[0]).sum() - (
        np.isfinite(arrays[0]).sum(-1) == 1
    ).sum()
    if reduced:
        problem = "small.qcf"
        facts = run("qstereo", "reduce", "p.qcf", "-o", problem, "--target", "20", "--json")
        assert facts["variables_after"] < whole.linear.size
    run("qstereo-bridge", "solve", problem, "-o", "s.qsf", "--num-reads", "40",
        "--seed", "1")
    facts = run("qstereo", "decode", problem, "s.qsf", "-o", "labels.npy", "--repair", "--json")
    labels = np.load(tmp_path / "labels.npy")
    assert np.isfinite(np.take_along_axis(arrays[0], labels[..., None], -1)).all()
    assert facts["energy"] == energy(*arrays, labels)
    assert best["energy"] <= facts["energy"] <= best["energy"] + 40
