"""Real scenes, if they are there (a folder `shared/data/middlebury` beside the project)."""

import numpy as np
import pytest
from PIL import Image
from library import ROOT

SCENES = ROOT.parent / "shared" / "data" / "middlebury"

pytestmark = pytest.mark.skipif(not SCENES.is_dir(), reason=f"no scenes in {SCENES}")


def grey(path):
    rgb = np.asarray(Image.open(path).convert("RGB")).astype(int)
    return (299 * rgb[..., 0] + 587 * rgb[..., 1] + 114 * rgb[..., 2] + 500) // 1000


def test_venus_window_solved_decoded_and_scored(run, tmp_path):
    scene = SCENES / "venus"
    run("qstereo", "encode", scene / "left.png", scene / "right.png", "-o", "p.qcf", "--disparity",
        "0:19", "--roi", "200,150,40,40")
    solved = run("qstereo-bridge", "solve", "p.qcf", "-o", "s.qsf", "--num-reads", "2", "--seed",
                 "1", "--json")
    valid = run("qstereo", "validate", "p.qcf", "s.qsf", "--json")
    assert valid["energies_agree"] and valid["feasible"] > 0 and valid["best_energy"] == solved[
        "best_energy"]
    decoded = run("qstereo", "decode", "p.qcf", "s.qsf", "-o", "d.png", "--color", "--json")
    held = np.asarray(Image.open(tmp_path / "d.png")).astype(int)
    assert held.shape == (383, 434) and np.count_nonzero(held) == 1600
    assert Image.open(tmp_path / "d.color.png").size == (434, 383)
    # F of the map, from the pictures.
    window = (slice(150, 190), slice(200, 240))
    d = np.where(held[window] == 1, 0, held[window]) // 8
    left, right = grey(scene / "left.png"), grey(scene / "right.png")
    rows, columns = np.mgrid[window]
    unary = np.abs(left[window] - right[rows, columns - d]).sum()
    cuts = np.count_nonzero(d[:, 1:] != d[:, :-1]) + np.count_nonzero(d[1:] != d[:-1])
    assert decoded["energy"] == unary + 20 * cuts == valid["best_energy"]
    # And its score, from the definition.
    truth = np.asarray(Image.open(scene / "truth.png")).astype(int)[window] / 8
    error = np.abs(d - truth)
    score = run("qstereo", "score", "d.png", scene / "truth.png", "--json")
    assert score["pixels"] == 1600
    assert score["rms"] == pytest.approx(np.sqrt((error**2).mean()), rel=1e-12)
    assert score["bad_0_5"] == pytest.approx(100 * (error > 0.5).mean(), rel=1e-12)
    assert score["bad_1_0"] == pytest.approx(100 * (error > 1).mean(), rel=1e-12)


def test_whole_scene_grid_and_penalties(run):
    scene = SCENES / "tsukuba"
    run("qstereo", "encode", scene / "left.png", scene / "right.png", "-o", "p.qcf")
    info = run("qstereo", "info", "p.qcf", "--json")
    assert (info["width"], info["height"], info["sites"]) == (369, 288, 369 * 288)
    assert info["variables"] == 369 * 288 * 16
    run("qstereo", "encode", scene / "left.png", scene / "right.png", "-o", "q.qcf", "--roi",
        "142,94,100,100", "--penalty", "paper", "--encoding", "one-hot")
    columns, rows = slice(142, 242), slice(94, 194)
    left, right = grey(scene / "left.png"), grey(scene / "right.png")
    theta = np.stack(
        [np.abs(left[rows, columns] - right[rows, 142 - d:242 - d]) for d in range(16)])
    alpha = theta.max(0).sum() + 20 * 19800 + 1
    assert alpha > 900000
    assert run("qstereo", "info", "q.qcf", "--json")["penalty_max"] == alpha
