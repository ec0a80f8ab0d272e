"""The paper's example through each of D-Wave's services, by its real clients, on a stand-in."""

import json
import subprocess
import sys

import numpy as np
import pytest
from library import BRIDGE, ROOT

sys.path.append(str(ROOT / "tests" / "bridge"))

from service import Service  # noqa: E402
from test_paper import DISPARITIES, PAPER  # noqa: E402


@pytest.fixture
def service(monkeypatch):
    with Service() as service:
        service.immediate, service.delay = False, 1
        for name, value in service.environment.items():
            monkeypatch.setenv(name, value)
        yield service


def mock_annealer():
    """Ocean's own stand-in for the chip. Its own annealer descends only, so it gets another."""
    from dwave.samplers import SimulatedAnnealingSampler
    from dwave.system.testing import MockDWaveSampler
    return MockDWaveSampler(topology_type="zephyr", topology_shape=[3, 4], parameter_warnings=False,
                            substitute_sampler=SimulatedAnnealingSampler())


# The paper's solver is given the paper's encoding, too.
ONE_HOT = ["--encoding", "one-hot"]
CASES = [("qpu", []), ("qpu, Ocean's mock", []), ("hybrid-bqm", []), ("hybrid-cqm", []),
         ("hybrid-cqm", ONE_HOT), ("hybrid-nl", [])]


@pytest.mark.parametrize("solver, encoding", CASES)
def test_paper(solver, encoding, service, run, tmp_path):
    if "mock" in solver:
        service.sampler = mock_annealer()
    solver = solver.split(",")[0]
    run("qstereo", "encode", PAPER / "left.pgm", PAPER / "right.pgm", "-o", "p.qcf", "--disparity",
        "0:1", "--lambda", "10", *encoding)
    solved = run("qstereo-bridge", "solve", "p.qcf", "-o", "s.qsf", "--solver", solver, "--json")
    assert solved["best_energy"] == 50 and len(service.problems) == 1
    valid = run("qstereo", "validate", "p.qcf", "s.qsf", "--json")
    assert valid["best_energy"] == 50 and valid["energies_agree"]
    assert run("qstereo", "decode", "p.qcf", "s.qsf", "-o", "d.pgm", "--json")["energy"] == 50
    held = np.frombuffer((tmp_path / "d.pgm").read_bytes()[-12:], np.uint8).reshape(3, 4)
    assert held.tolist() == [[0, *(8 * d or 1 for d in row)] for row in DISPARITIES]
    info = run("qstereo", "info", "s.qsf", "--json")["info"]
    assert info["timing"]["qpu_access_time"] > 0 and info["problem_id"] in service.problems


def test_nothing_of_a_solve_is_left_but_samples(service, run, tmp_path):
    run("qstereo", "encode", PAPER / "left.pgm", PAPER / "right.pgm", "-o", "p.qcf", "--disparity",
        "0:1", "--lambda", "10")
    done = subprocess.run(
        [BRIDGE, "solve", "p.qcf", "-o", "s.qsf", "--solver", "hybrid-nl", "--no-wait", "--json"],
        cwd=tmp_path,
        capture_output=True,
        check=True)
    run("qstereo-bridge", "collect", json.loads(done.stdout)["job"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["p.qcf", "s.qsf"]
