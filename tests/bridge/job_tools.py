"""What the tests of jobs share: a service whose answers come by polling, the commands `solve` and
`collect` on it, and the command in a process of its own."""

import os
import signal
import sys
import time

import pytest
from problems import all_states, grid
from qstereo_bridge.runs import jobs
from qstereo_bridge.core import models, qsf

# Seconds after which a test fails that waits for what does not come: far more than any busy machine
# takes.
WHILE = 600
SERVICES = ["qpu", "hybrid-bqm", "hybrid-cqm", "hybrid-nl"]
SMALL = grid(2, 2, 3)
LEAST = int(models.energies(SMALL, all_states(12)).min())


@pytest.fixture
def service(service):
    """Answers come by polling, as those of hard problems do."""
    service.immediate, service.delay = False, 1
    return service


@pytest.fixture(autouse=True)
def hurry(monkeypatch):
    monkeypatch.setattr(jobs, "PAUSES", (0.05, 0.1))
    monkeypatch.setattr(jobs, "ARRIVED", 1)


@pytest.fixture(autouse=True)
def few_retries(environment, monkeypatch, tmp_path_factory, service):
    """D-Wave's client asks ten times over ten seconds where a connection is dropped."""
    path = tmp_path_factory.mktemp("configuration") / "dwave.conf"
    path.write_text("[defaults]\nhttp_retry_total = 2\n")
    environment["DWAVE_CONFIG_FILE"] = str(path)
    monkeypatch.setenv("DWAVE_CONFIG_FILE", str(path))


@pytest.fixture
def solve(problem_file, tmp_path, main, service):
    def run(solver="hybrid-nl", *options):
        return main("solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", solver, *options)
    return run


@pytest.fixture
def collect(tmp_path, main, service):
    return lambda *options: main("collect", tmp_path / "s.qsf.job", *options)


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def best(tmp_path):
    read = qsf.parse_qsf((tmp_path / "s.qsf").read_bytes())
    assert (read.records["energy"] == models.energies(SMALL, read.bits)).all()
    return int(read.records["energy"].min())


def child(arguments, environment, out, deadline=WHILE):
    """The command as a process has it, in one that has the modules already."""
    os.dup2(os.open(out, os.O_CREAT | os.O_WRONLY | os.O_APPEND), 2)
    os.environ.update(environment)
    sys.argv = ["qstereo-bridge", *arguments]
    # Tests that run in the background have it ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    jobs.DEADLINE = deadline
    from qstereo_bridge.__main__ import run
    run()


@pytest.fixture
def begin(processes, problem_file, tmp_path, environment, service):
    def start(solver, *options):
        arguments = ["solve", str(problem_file), "-o", str(tmp_path / "s.qsf"), "--solver",
                     solver, *options]
        process = processes.Process(target=child, args=(arguments, environment,
                                                        str(tmp_path / "stderr")), daemon=True)
        process.start()
        return process
    return start


def until(condition):
    """Wait for what certainly comes; where it does not, the test fails after a long while."""
    stop = time.monotonic() + WHILE
    while not condition():
        assert time.monotonic() < stop
        time.sleep(0.005)


def kill(process):
    """Kill it, and wait until it is gone; for threads that do not own it."""
    os.kill(process.pid, signal.SIGKILL)

    def gone():
        try:
            os.kill(process.pid, 0)
        except ProcessLookupError:
            return True
    until(gone)


def sent(path):
    """Whether a job file says so."""
    return path.exists() and '"sent"' in path.read_text()
