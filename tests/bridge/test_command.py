"""The command qstereo-bridge: results, exit statuses, messages, and what is left on the disk."""

import hashlib
import json
import os
import pty
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import TOKEN
from problems import grid, make, random_problem
from test_solvers import BruteForceCQM
from qstereo_bridge import __version__, cli, models, output, qcf, qsf, services, solvers

FAST = ["--num-reads", 5, "--num-sweeps", 50, "--seed", 1]


def text(found):
    """(exit status, stdout, stderr) of a finished process; there is never a traceback."""
    out, err = found.stdout.decode(), found.stderr.decode()
    assert "Traceback" not in out + err
    return found.returncode, out, err


def test_solve_writes_samples(problem_file, tmp_path, main):
    samples = tmp_path / "s.qsf"
    status, out, err = main("solve", problem_file, *FAST, "-o", samples)
    assert (status, err) == (0, "") and "5 samples, best energy" in out and f"{samples}: written" in out
    read, problem = qsf.parse_qsf(samples.read_bytes()), qcf.parse_qcf(problem_file.read_bytes())
    assert read.digest == hashlib.sha256(problem_file.read_bytes()).digest() and read.solver == "anneal"
    assert (read.records["energy"] == models.energies(problem, read.bits)).all()
    assert (read.records["broken"] == qsf.NO_CHAINS).all() and read.info["parameters"]["seed"] == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["s.qsf", "tiny.qcf"]


def test_json(problem_file, tmp_path, main):
    status, out, err = main("solve", "--json", problem_file, "-o", tmp_path / "s.qsf", "--solver", "exact")
    found = json.loads(out)
    assert (status, err) == (0, "") and found["seconds"] >= 0
    assert found.items() >= {"schema": 1, "solver": "exact", "gap": 0, "proven_optimal": True, "iterations": None}.items()
    assert found["energy"] == found["lower_bound"] == found["best_energy"] and found["samples"] == found["feasible"] >= 1
    status, out, _ = main("solve", "-o", tmp_path / "s.qsf", *FAST, "--json", problem_file)
    found = json.loads(out)
    assert found.items() >= {"lower_bound": None, "gap": None, "proven_optimal": False, "iterations": 250}.items()


def test_real_units_and_no_feasible_sample(tmp_path, main):
    labl = bytes(16) + (2).to_bytes(4, "little") + bytes(44)
    problem = make([2], [], [], [-5, -5], [(1, 0)], 2, [("labl", labl)])
    (tmp_path / "p.qcf").write_bytes(qcf.pack_qcf(problem))
    status, out, _ = main("solve", tmp_path / "p.qcf", "-o", tmp_path / "s.qsf", "--solver", "exact", "--json")
    found = json.loads(out)
    assert status == 0 and found["energy"] == -4.5 and found["feasible"] == 0 and found["best_energy"] is None
    assert "none feasible" in main("solve", tmp_path / "p.qcf", "-o", tmp_path / "s.qsf", "--solver", "exact")[1]


def test_quiet_and_progress(problem_file, tmp_path, main, monkeypatch):
    assert main("solve", problem_file, "-o", tmp_path / "s.qsf", *FAST, "--quiet") == (0, "", "")
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert main("solve", problem_file, "-o", tmp_path / "s.qsf", *FAST, "--quiet") == (0, "", "")
    assert main("solve", problem_file, "-o", tmp_path / "s.qsf", *FAST)[2].endswith("\r\033[K")


def test_stdin_and_stdout(problem_file, command):
    found = command("solve", "-", "-o", "-", *FAST, input=problem_file.read_bytes())
    assert found.returncode == 0 and qsf.parse_qsf(found.stdout).digest == hashlib.sha256(problem_file.read_bytes()).digest()
    assert b"best energy" in found.stderr
    found = command("solve", "-", "-o", "/dev/stdout", *FAST, "--quiet", input=problem_file.read_bytes())
    assert qsf.parse_qsf(found.stdout).bits.shape == (5, 12)


def test_device_as_output(problem_file, command):
    assert text(command("solve", problem_file, "-o", "/dev/null", *FAST))[0] == 0
    assert os.path.exists("/dev/null") and not os.path.isfile("/dev/null")


def test_help_and_version(command):
    status, out, err = text(command("solve", "--help"))
    assert (status, err) == (0, "") and "examples:" in out and "exit status:" in out
    assert all(name in out for name in cli.SOLVERS) and "--num-reads (20)" in out
    assert text(command("--version")) == (0, f"qstereo-bridge {__version__}\n", "")


@pytest.mark.parametrize("arguments, said", [
    ([], "COMMAND"), (["slove"], "slove"), (["solve"], "P.qcf"), (["solve", "P"], "-o S.qsf"), (["solve", "P", "--bogus"], "--bogus"),
    (["solve", "P", "-o", "S", "--num-reads", "0"], "not between"), (["solve", "P", "-o", "S", "--num-reads", "x"], "whole number"),
    (["solve", "P", "-o", "S", "--seed", "-1"], "not between"), (["solve", "P", "-o", "S", "--time-limit", "nan"], "not between"),
    (["solve", "P", "-o", "S", "--time-limit", "0"], "not between"), (["solve", "P", "-o", "S", "--memory-limit", "0"], "not between"),
    (["solve", "P", "-o", "S", "--solver", "exact", "--seed", "1"], "only anneal, tabu do"),
    (["solve", "P", "-o", "S", "--label", "x"], "only qpu, hybrid-bqm, hybrid-cqm do"),
    (["solve", "P", "-o", "-", "--json"], "stdout"), (["solve", "/dev/null", "-o", "/dev/../dev/null"], "problem itself")])
def test_usage(arguments, said, main):
    status, out, err = main(*arguments)
    assert (status, out) == (2, "") and said in err and err.startswith("qstereo-bridge") and err.count("\n") == 1


def test_unknown_solver_lists_the_known(main):
    status, _, err = main("solve", "P", "-o", "S", "--solver", "magic")
    assert status == 2 and all(name in err for name in cli.SOLVERS)


@pytest.mark.parametrize("change, status, said", [
    (lambda data: b"", 3, "byte 0"), (lambda data: data[:40], 3, "byte 40"), (lambda data: b"P5" + data, 3, "no .qcf file"),
    (lambda data: data[:-1], 3, "ends here"), (lambda data: data + b"\0", 3, "after the end"),
    (lambda data: data[:90] + bytes([data[90] ^ 1]) + data[91:], 3, "CRC-32C of chunk 0")])
def test_bad_problem(change, status, said, problem_file, tmp_path, main):
    problem_file.write_bytes(change(problem_file.read_bytes()))
    found, out, err = main("solve", problem_file, "-o", tmp_path / "s.qsf", *FAST)
    assert (found, out) == (status, "") and err.startswith(f"qstereo-bridge solve: {problem_file}: ") and said in err
    assert not (tmp_path / "s.qsf").exists()


def test_samples_file_is_no_problem(problem_file, tmp_path, main):
    assert main("solve", problem_file, "-o", tmp_path / "s.qsf", *FAST)[0] == 0
    assert main("solve", tmp_path / "s.qsf", "-o", tmp_path / "t.qsf", *FAST)[0] == 3
    assert not (tmp_path / "t.qsf").exists()


def test_memory_limit(tmp_path, main):
    (tmp_path / "p.qcf").write_bytes(qcf.pack_qcf(grid(20, 20, 16, dense=True)))
    status, _, err = main("solve", tmp_path / "p.qcf", "-o", tmp_path / "s.qsf", "--memory-limit", 5)
    assert status == 4 and "p.qcf: a model of" in err and "--memory-limit" in err
    assert main("solve", tmp_path / "p.qcf", "-o", tmp_path / "s.qsf", "--memory-limit", 1 << 20, *FAST)[0] == 0


def test_unreadable_and_unwritable(problem_file, tmp_path, main):
    status, _, err = main("solve", tmp_path / "none.qcf", "-o", tmp_path / "s.qsf")
    assert status == 4 and "none.qcf: cannot read: No such file" in err
    assert main("solve", tmp_path, "-o", tmp_path / "s.qsf")[0] == 4
    status, _, err = main("solve", problem_file, "-o", tmp_path / "none" / "s.qsf", *FAST)
    assert status == 4 and "there is no folder" in err
    assert main("solve", problem_file, "-o", tmp_path, *FAST)[0] == 4
    status, _, err = main("solve", problem_file, "-o", "/dev/full", *FAST)
    assert status == 4 and "/dev/full: cannot write: No space left" in err


def test_no_permission(tmp_path, monkeypatch):
    """Root may write everywhere, so the system's answer is given here."""
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    with pytest.raises(PermissionError, match=str(tmp_path)):
        output.check_writable(tmp_path / "s.qsf")
    output.check_writable("/dev/null")
    output.check_writable("-")


def test_full_stdout(problem_file, tmp_path, command):
    with open("/dev/full", "w") as full:
        found = command("solve", problem_file, "-o", tmp_path / "s.qsf", *FAST, capture_output=False, stdout=full,
                        stderr=subprocess.PIPE)
    assert found.returncode == 4 and b"Traceback" not in found.stderr and b"No space" in found.stderr


@pytest.mark.parametrize("fault", ["open", "replace"])
def test_failed_write_leaves_the_old_file(fault, problem_file, tmp_path, main, monkeypatch):
    samples = tmp_path / "s.qsf"
    samples.write_bytes(b"old")

    def fail(*arguments):
        raise OSError(28, "No space left on device")
    if fault == "replace":
        monkeypatch.setattr(os, "replace", fail)
    else:
        real = open
        monkeypatch.setattr("builtins.open", lambda *a, **b: fail() if a[1:] == ("xb",) else real(*a, **b))
    assert main("solve", problem_file, "-o", samples, *FAST)[0] == 4
    assert samples.read_bytes() == b"old" and sorted(path.name for path in tmp_path.iterdir()) == ["s.qsf", "tiny.qcf"]


def test_failures_leave_the_old_file(problem_file, tmp_path, command):
    samples = tmp_path / "s.qsf"
    samples.write_bytes(b"old")
    problem_file.write_bytes(qcf.pack_qcf(grid(3, 3, 3)))
    status, _, err = text(command("solve", problem_file, "-o", samples, "--solver", "exact"))
    assert status == 5 and "at most 24 variables" in err
    for solver in ("qpu", "hybrid-bqm", "hybrid-cqm"):
        status, out, err = text(command("solve", problem_file, "-o", samples, "--solver", solver))
        assert (status, out) == (5, "") and "dwave config create" in err and "DWAVE_API_TOKEN" in err and err.count("\n") == 1
    assert samples.read_bytes() == b"old"
    assert sorted(path.name for path in tmp_path.iterdir() if path.is_file()) == ["s.qsf", "tiny.qcf"]


def test_link_stays_a_link(problem_file, tmp_path, main):
    (tmp_path / "real.qsf").write_bytes(b"old")
    (tmp_path / "s.qsf").symlink_to(tmp_path / "real.qsf")
    assert main("solve", problem_file, "-o", tmp_path / "s.qsf", *FAST)[0] == 0
    assert (tmp_path / "s.qsf").is_symlink() and qsf.parse_qsf((tmp_path / "real.qsf").read_bytes())


@pytest.mark.parametrize("endpoint", ["http://127.0.0.1:9/sapi/v2/", "nonsense"])
def test_token_is_never_told(endpoint, problem_file, tmp_path, command, environment):
    environment.update(DWAVE_API_TOKEN=TOKEN, DWAVE_API_ENDPOINT=endpoint, NO_PROXY="127.0.0.1")
    (tmp_path / "dwave.conf").write_text(f"[defaults]\ntoken = {TOKEN}\nhttp_retry_total = 0\nhttp_retry_connect = 0\n")
    environment["DWAVE_CONFIG_FILE"] = str(tmp_path / "dwave.conf")
    status, out, err = text(command("solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", "hybrid-cqm"))
    assert status == 5 and TOKEN not in out + err and not (tmp_path / "s.qsf").exists()


def test_wrong_energy_is_an_error(problem_file, tmp_path, main, monkeypatch):
    real = solvers.exact

    def lying(*arguments):
        answer = real(*arguments)
        answer.energies = answer.energies + 1.0
        return answer
    monkeypatch.setattr(solvers, "exact", lying)
    status, _, err = main("solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", "exact")
    assert status == 5 and "internal error" in err and not (tmp_path / "s.qsf").exists()


def test_energies_of_a_cqm_answer_are_h(problem_file, tmp_path, main, monkeypatch):
    monkeypatch.setattr(services, "connect", lambda name: BruteForceCQM())
    status, out, err = main("solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", "hybrid-cqm", "--json")
    read, problem = qsf.parse_qsf((tmp_path / "s.qsf").read_bytes()), qcf.parse_qcf(problem_file.read_bytes())
    assert (status, err) == (0, "") and (read.records["energy"] == models.energies(problem, read.bits)).all()
    assert 0 < json.loads(out)["feasible"] < json.loads(out)["samples"]
    assert read.info["parameters"]["label"] == "tiny" and read.info["run_time"] == 5000000


@pytest.mark.parametrize("solver", cli.SOLVERS)
def test_dry_run(solver, problem_file, main):
    status, out, err = main("solve", problem_file, "--solver", solver, "--dry-run")
    assert (status, err) == (0, "") and "12 variables" in out and "sent" in out
    assert ("as published" in out) == (solver in ("qpu", "hybrid-bqm", "hybrid-cqm"))
    found = json.loads(main("solve", problem_file, "--solver", solver, "--dry-run", "--json")[1])
    assert found.items() >= {"schema": 1, "solver": solver, "dry_run": True, "variables": 12}.items()


CLOUD = ["dwave.system", "dwave.cloud", "dwave.samplers"]


@pytest.mark.parametrize("arguments, absent", [
    (["--version"], [*CLOUD, "dimod", "numpy"]), (["solve", "--help"], [*CLOUD, "dimod", "numpy"]),
    (["solve", "P", "--dry-run", "--solver", "qpu"], [*CLOUD, "dimod"]),
    (["solve", "P", "--dry-run", "--solver", "hybrid-cqm"], [*CLOUD, "dimod"]),
    (["solve", "P", "-o", "/dev/null", "--solver", "exact"], CLOUD), (["solve", "P", "-o", "/dev/null", *FAST], CLOUD[:2])])
def test_lazy_imports(arguments, absent, problem_file, environment):
    arguments = [str(problem_file) if word == "P" else str(word) for word in arguments]
    code = ("import sys\nfrom qstereo_bridge.cli import main\ntry:\n    status = main(sys.argv[1:])\nexcept SystemExit as e:\n"
            f"    status = e.code\nassert status == 0\nprint([name for name in {absent} if name in sys.modules], file=sys.stderr)")
    found = subprocess.run([sys.executable, "-c", code, *arguments], env=environment, capture_output=True, text=True, timeout=60)
    assert found.stderr == "[]\n"


@pytest.mark.parametrize("arguments", [["--num-reads", "1", "--num-sweeps", "100000000"], ["--num-reads", "100000"],
                                       ["--solver", "tabu", "--time-limit", "1000", "--num-reads", "1"]])
def test_ctrl_c(arguments, tmp_path, environment):
    """One long read, many short ones, a long search; each has begun when the signal comes (the progress line says so)."""
    (tmp_path / "p.qcf").write_bytes(qcf.pack_qcf(grid(10, 10, 4)))
    (tmp_path / "s.qsf").write_bytes(b"old")
    terminal, other = pty.openpty()
    process = subprocess.Popen([sys.executable, "-c", "from qstereo_bridge.cli import run; run()", "solve", tmp_path / "p.qcf",
                                "-o", tmp_path / "s.qsf", *arguments], env=environment, stdout=subprocess.PIPE, stderr=other)
    os.close(other)
    said = b""
    while b"reads" not in said:
        said += os.read(terminal, 1000)
    process.send_signal(signal.SIGINT)
    began = time.monotonic()
    assert process.wait(timeout=20) == 130 and time.monotonic() - began < 5
    said += os.read(terminal, 1000)
    assert b"interrupted" in said and b"Traceback" not in said
    os.close(terminal)
    process.stdout.close()
    assert (tmp_path / "s.qsf").read_bytes() == b"old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["p.qcf", "s.qsf"]


def test_ctrl_c_does_not_wait_for_a_service(problem_file, tmp_path, main, monkeypatch):
    class Waiting(BruteForceCQM):
        def sample_cqm(self, *arguments, **options):
            raise KeyboardInterrupt

        def close(self):
            pytest.fail("the client's close() waits for the answer")
    monkeypatch.setattr(services, "connect", lambda name: Waiting())
    status, out, err = main("solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", "hybrid-cqm")
    assert (status, out) == (130, "") and "interrupted" in err and not (tmp_path / "s.qsf").exists()


def test_no_binary_to_a_terminal(problem_file, environment):
    terminal, other = pty.openpty()
    found = subprocess.run([sys.executable, "-c", "from qstereo_bridge.cli import run; run()", "solve", problem_file, "-o", "-"],
                           env=environment, stdout=other, stderr=subprocess.PIPE, timeout=60)
    os.close(terminal)
    os.close(other)
    assert found.returncode == 2 and b"terminal" in found.stderr


def test_random_samples_agree_with_their_records(tmp_path, main):
    """Wider than a byte, more than one group size, weights of every width."""
    for seed in range(5):
        problem = random_problem(seed, variables=20)
        (tmp_path / "p.qcf").write_bytes(qcf.pack_qcf(problem))
        assert main("solve", tmp_path / "p.qcf", "-o", tmp_path / "s.qsf", *FAST)[0] == 0
        read = qsf.parse_qsf((tmp_path / "s.qsf").read_bytes())
        assert np.array_equal(read.records["energy"], models.energies(problem, read.bits))
