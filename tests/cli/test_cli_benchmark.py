"""label on instances of the Middlebury MRF benchmark: the energies of known labellings."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from cli_tools import ROOT, run

sys.path.insert(0, str(ROOT / "tests" / "bench"))
import mrf_problem

DATA = Path(ROOT).parent / "shared" / "data" / "mrf"


@pytest.fixture
def instance(tmp_path):
    def make(name):
        if not (DATA / name).is_dir():
            pytest.skip(f"no {DATA / name}")
        made = mrf_problem.INSTANCES[name](DATA / name)
        return made, mrf_problem.arrays(tmp_path, **made)

    return make


def label(tmp_path, arguments, truth, *more):
    np.save(tmp_path / "truth.npy", truth)
    out = tmp_path / "out.npy"
    done = run("label", *arguments, "-o", out, "--json", "--truth", tmp_path / "truth.npy", *more)
    assert done.status == 0, done.err
    return json.loads(done.out)


def test_house(tmp_path, instance):
    """Its picture as it is has the energy that the benchmark states; the optimum is proven."""
    _, arguments = instance("house")
    facts = label(tmp_path, arguments, mrf_problem.picture(DATA / "house" / "input.png"))
    assert facts["truth_energy"] == 686_805_375
    assert facts["energy"] == facts["lower_bound"] == 37_580_521


def test_pano(tmp_path, instance):
    """A table for each of a million edges. The start takes the first picture that is not missing;
    icm gets below it, expansion would come to 151,000.
    """
    made, arguments = instance("pano")
    start = (made["costs"] != 0).argmin(axis=-1)
    facts = label(tmp_path, arguments, start, "--solver", "icm", "--iterations", "2")
    assert facts["truth_energy"] == 360_200_000
    assert facts["energy"] < 2_000_000
