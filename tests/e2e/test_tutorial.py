"""docs/TUTORIAL.md: its commands run as they stand, and its pictures are of such a run."""

import json
import subprocess
import sys

import numpy as np
import pytest
from library import BRIDGE, QSTEREO, ROOT

pytest.importorskip("matplotlib")
Image = pytest.importorskip("PIL.Image")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("tutorial")
    done = subprocess.run(
        [sys.executable, ROOT / "scripts" / "tutorial", "--qstereo", QSTEREO, "--bridge", BRIDGE,
         "--work", made, "-o", made], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("\n$ qstereo") + 1 == 11
    return made


def test_the_answer_is_near_the_best(folder):
    said = json.loads((folder / "out" / "core.json").read_text())
    found = {one["solver"]: one for one in said["results"]}
    assert list(found) == ["icm", "expansion", "best", "known", "anneal"]
    assert found["best"]["proven_optimal"]
    assert found["known"]["energy"] >= found["best"]["energy"]
    assert 0 <= found["anneal"]["gap"] < 0.01 * found["best"]["energy"]
    assert found["anneal"]["bad_1_0"] < 8
    assert "My first report" in (folder / "report.html").read_text()


@pytest.mark.parametrize("name", ["tutorial-map.png", "tutorial-proof.png"])
def test_the_pictures_are_those_of_this_run(folder, name):
    """But for pixels of equal energy, which another version of a sampler may answer otherwise."""
    here, there = (np.array(Image.open(path / name).convert("RGB")).astype(int)
                   for path in (folder, ROOT / "docs"))
    assert here.shape == there.shape
    assert (np.abs(here - there).max(-1) > 32).mean() < 0.01


def test_the_picture_of_the_proof_shows_what_is_open(folder):
    """White on the left: as many pixels as the file has undecided sites."""
    done = subprocess.run([str(QSTEREO), "info", folder / "core.qcf", "--json"],
                          capture_output=True, text=True, check=True)
    undecided = json.loads(done.stdout)["sites_open"]
    shown = np.array(Image.open(folder / "tutorial-proof.png").convert("RGB"))[::2, ::2]
    assert (shown[:, :200] == 255).all(-1).sum() == undecided > 0
