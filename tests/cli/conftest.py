import json
from types import SimpleNamespace

import cli_tools
import numpy as np
import pytest
from cli_tools import energy, has_opencv, one_hot, random_pair, succeed, write_qsf


@pytest.fixture
def pair(tmp_path):
    """A pair of 12 x 5 pixels."""
    left, right, left_path, right_path = random_pair(tmp_path, 12, 5)
    return SimpleNamespace(left=left, right=right, paths=(left_path, right_path))


@pytest.fixture
def solved(tmp_path, pair):
    """A problem (8 x 5 sites, disparities 1 to 4) and three samples: infeasible, feasible,
    feasible and better.
    """
    problem = tmp_path / "p.qcf"
    done = succeed(
        "encode", *pair.paths, "-o", problem, "--disparity", "1:4", "--lambda", "2.5", "--json"
    )
    facts = json.loads(done.out)
    flat = np.full((5, 8), 3)
    steps = flat.copy()
    steps[:, 4:] = 1
    maps = sorted([flat, steps], key=lambda m: -energy(pair.left, pair.right, m, 2.5))
    energies = [energy(pair.left, pair.right, m, 2.5) for m in maps]
    bits = [one_hot(m - 1, 4) for m in maps]
    broken = bits[1].copy()
    broken[np.flatnonzero(broken)[0]] = 0
    # The empty site pays a = gap = 1 unit instead of its cost and its two edges, one-hot-sparse.
    site = abs(pair.left[0, 4] - pair.right[0, 4 - maps[1][0, 0]])
    edges = 2.5 * ((maps[1][0, 0] == maps[1][0, 1]) * 1 + (maps[1][0, 0] == maps[1][1, 0]) * 1)
    least = min(abs(pair.left[0, 4] - pair.right[0, 4 - d]) for d in range(1, 5))
    broken_energy = energies[1] - site + edges + least + 0.5
    samples = write_qsf(
        tmp_path / "s.qsf",
        problem,
        [broken, *bits],
        [broken_energy * 2, energies[0] * 2, energies[1] * 2],
        occurrences=[1, 5, 2],
    )
    return SimpleNamespace(
        problem=problem,
        samples=samples,
        facts=facts,
        maps=maps,
        energies=energies,
        bits=bits,
        broken=broken,
        broken_energy=broken_energy,
        pair=pair,
    )


@pytest.fixture(scope="session")
def built_with_opencv():
    return has_opencv()


@pytest.fixture
def opencv(built_with_opencv, monkeypatch):
    """Runs the command that was built with OpenCV; skips if there is none."""
    if not built_with_opencv:
        pytest.skip("built without OpenCV")
    monkeypatch.setattr(cli_tools, "PROGRAM", cli_tools.QSTEREO)


@pytest.fixture(scope="session")
def large(tmp_path_factory):
    """A problem of 385 x 300 sites and 16 labels that no solver finishes in a second."""
    folder = tmp_path_factory.mktemp("large")
    *_, left, right = random_pair(folder, 400, 300)
    succeed("encode", left, right, "-o", folder / "large.qcf")
    return folder / "large.qcf"


@pytest.fixture
def pnm_only():
    """The command built without OpenCV."""
    if cli_tools.QSTEREO_PNM is None:
        pytest.skip("QSTEREO_PNM names no command")
    return cli_tools.QSTEREO_PNM


@pytest.fixture
def folder(tmp_path):
    """An empty folder for outputs, so that nothing but the output may be in it."""
    made = tmp_path / "out"
    made.mkdir()
    return made


def pytest_report_header():
    return f"qstereo: {cli_tools.QSTEREO}"
