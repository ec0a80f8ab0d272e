"""Files written straight from the problem are those that dimod writes of its models."""

import io

import dimod
import pytest
from problems import grid, random_problem
from qstereo_bridge.core import models
from qstereo_bridge.ocean import upload


def both(problem):
    with upload.bqm_file(problem) as ours, models.to_bqm(problem).to_file(
            ignore_labels=True) as theirs:
        return ours.read(), theirs.read()


def test_random_problems_to_the_byte():
    for seed in range(300):
        ours, theirs = both(random_problem(seed, 16))
        assert ours == theirs


@pytest.mark.parametrize("size", [(1, 1, 1), (1, 1, 5), (5, 4, 3), (40, 30, 8)])
@pytest.mark.parametrize("dense", [False, True])
def test_grids_to_the_byte(size, dense, monkeypatch):
    monkeypatch.setattr(models, "CHUNK", 1000)
    problem = grid(*size, dense)
    ours, theirs = both(problem)
    assert (ours == theirs and dimod.BinaryQuadraticModel.from_file(io.BytesIO(ours))
            == models.to_bqm(problem))


def test_no_model_is_built_but_for_repeated_pairs(monkeypatch):
    monkeypatch.setattr(models, "to_bqm", None)
    upload.bqm_file(grid(5, 4, 3)).close()
    repeated = 0
    for seed in range(60):
        try:
            upload.bqm_file(random_problem(seed)).close()
        except TypeError:
            repeated += 1
    assert 0 < repeated < 50
