"""The command qstereo-bridge: results, exit statuses, messages, and what is left on the disk."""

import hashlib
import json
import os
import pty
import resource
import signal
import subprocess
import sys

import numpy as np
import pytest
from bridge_tools import COMMAND
from job_tools import WHILE
from problems import altered, domain_walls, grid, make, nothing, pack_qcf, random_problem
from service import TOKEN
from qstereo_bridge import __version__
from qstereo_bridge.desk import cli
from qstereo_bridge.core import models, qcf, qsf
from qstereo_bridge.runs import bill, remote
from qstereo_bridge.samplers import solvers

SERVICES = ["qpu", "hybrid-nl", "hybrid-bqm", "hybrid-cqm"]
FAST = ["--num-reads", 5, "--num-sweeps", 50, "--seed", 1]


def text(found):
    """(exit status, stdout, stderr) of a finished process; there is never a traceback."""
    out, err = found.stdout.decode(), found.stderr.decode()
    assert "Traceback" not in out + err
    return found.returncode, out, err


def files(folder):
    return sorted(path.name for path in folder.iterdir() if path.is_file())


def test_no_summary_of_a_command_is_cut_short(main):
    status, out, _ = main("--help")
    assert status == 0 and "..." not in out.split("Commands:")[1]


def test_solve_writes_samples(problem_file, tmp_path, main):
    samples = tmp_path / "s.qsf"
    status, out, err = main("solve", problem_file, *FAST, "--no-postprocess", "-o", samples)
    assert (
        (status, err) == (0, "")
        and "5 samples, best energy" in out
        and f"{samples}: written" in out
    )
    read, problem = qsf.parse_qsf(samples.read_bytes()), qcf.parse_qcf(problem_file.read_bytes())
    assert (
        read.digest == hashlib.sha256(problem_file.read_bytes()).digest()
        and read.solver == "anneal"
    )
    assert (read.records["energy"] == models.energies(problem, read.bits)).all()
    assert (read.records["broken"] == qsf.NO_CHAINS).all() and read.info["parameters"]["seed"] == 1
    assert files(tmp_path) == ["s.qsf", "tiny.qcf"]


def test_json(problem_file, tmp_path, main):
    status, out, err = main(
        "solve", "--json", problem_file, "-o", tmp_path / "s.qsf", "--solver", "exact"
    )
    found = json.loads(out)
    assert (status, err) == (0, "") and found["seconds"] >= 0
    assert (
        found.items()
        >= {
            "schema": 1,
            "solver": "exact",
            "gap": 0,
            "proven_optimal": True,
            "iterations": None,
        }.items()
    )
    assert (
        found["energy"] == found["lower_bound"] == found["best_energy"]
        and found["samples"] == found["feasible"] >= 1
    )
    status, out, _ = main("solve", "-o", tmp_path / "s.qsf", *FAST, "--json", problem_file)
    found = json.loads(out)
    assert (
        found.items()
        >= {"lower_bound": None, "gap": None, "proven_optimal": False, "iterations": 250}.items()
    )


def test_real_units_and_no_feasible_sample(tmp_path, main):
    labl = (1).to_bytes(4, "little") + bytes(12) + (2).to_bytes(4, "little") + bytes(44)
    problem = make([2], [], [], [-5, -5], [(1, 0)], 2, [("labl", labl)])
    (tmp_path / "p.qcf").write_bytes(pack_qcf(problem))
    status, out, _ = main(
        "solve", tmp_path / "p.qcf", "-o", tmp_path / "s.qsf", "--solver", "exact", "--json"
    )
    found = json.loads(out)
    assert (
        status == 0
        and found["energy"] == -4.5
        and found["feasible"] == 0
        and found["best_energy"] is None
    )
    assert found["lower_bound"] == -4.5 and not found["proven_optimal"]
    out = main("solve", tmp_path / "p.qcf", "-o", tmp_path / "s.qsf", "--solver", "exact")[1]
    assert (
        "the minimum of the QUBO is infeasible: the penalty is too small" in out
        and "none feasible" in out
    )
    assert "optimal" not in out


def test_one_feasible_minimiser_among_many_proves(tmp_path, main):
    """A penalty of 0 for two variables: 512 of the 1,536 minimisers are feasible, the first hundred
    by number are not.
    """
    problem = make([2] + [1] * 9, [], [], [-1, -1] + [0] * 9, [(0, 1)] + [(0, 0)] * 9)
    (tmp_path / "p.qcf").write_bytes(pack_qcf(problem))
    solve = "solve", tmp_path / "p.qcf", "-o", tmp_path / "s.qsf", "--solver", "exact"
    found = json.loads(main(*solve, "--json")[1])
    assert found["proven_optimal"] and found["samples"] == found["feasible"] == 100
    assert "(proven optimal)" in main(*solve)[1]


def test_quiet_and_progress(problem_file, tmp_path, main, monkeypatch):
    assert main("solve", problem_file, "-o", tmp_path / "s.qsf", *FAST, "--quiet") == (0, "", "")
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert main("solve", problem_file, "-o", tmp_path / "s.qsf", *FAST, "--quiet") == (0, "", "")
    assert main("solve", problem_file, "-o", tmp_path / "s.qsf", *FAST)[2].endswith("\r\033[K")


def test_stdin_and_stdout(problem_file, command):
    found = command("solve", "-", "-o", "-", *FAST, input=problem_file.read_bytes())
    assert (
        found.returncode == 0
        and qsf.parse_qsf(found.stdout).digest == hashlib.sha256(problem_file.read_bytes()).digest()
    )
    assert b"best energy" in found.stderr
    found = command(
        "solve", "-", "-o", "/dev/stdout", *FAST, "--no-postprocess", "--quiet",
        input=problem_file.read_bytes())
    assert qsf.parse_qsf(found.stdout).bits.shape == (5, 12)


def test_device_as_output(problem_file, command):
    assert text(command("solve", problem_file, "-o", "/dev/null", *FAST))[0] == 0
    assert os.path.exists("/dev/null") and not os.path.isfile("/dev/null")


def test_help_and_version(command):
    status, out, err = text(command("solve", "--help"))
    assert (status, err) == (0, "") and "Examples:" in out and "Exit status:" in out
    assert all(name in out for name in cli.SOLVERS) and "--num-reads (20)" in out
    assert (
        text(command("-V"))
        == text(command("--version"))
        == (0, f"qstereo-bridge {__version__}\n", "")
    )


@pytest.mark.parametrize(
    "arguments, said",
    [
        ([], "Missing command"),
        (["slove"], "'solve'"),
        (["rhubarb"], "No such command"),
        (["solve"], "P.qcf"),
        (["solve", "P"], "-o S.qsf"),
        (["solve", "P", "--bogus"], "--bogus"),
        (["solve", "P", "--num-read", "1"], "--num-reads"),
        (["solve", "P", "-o", "S", "--num-reads", "0"], "not between"),
        (["solve", "P", "-o", "S", "--num-reads", "x"], "whole number"),
        (["solve", "P", "-o", "S", "--seed", "-1"], "not between"),
        (["solve", "P", "-o", "S", "--time-limit", "nan"], "not between"),
        (["solve", "P", "-o", "S", "--time-limit", "0"], "not between"),
        (["solve", "P", "-o", "S", "--memory-limit", "0"], "not between"),
        (
            ["solve", "P", "-o", "S", "--solver", "exact", "--seed", "1"],
            "only these do: anneal, tabu, qpu, MODULE:CLASS",
        ),
        (
            ["solve", "P", "-o", "S", "--label", "x"],
            "only these do: qpu, hybrid-nl, hybrid-bqm, hybrid-cqm",
        ),
        (
            ["solve", "P", "-o", "S", "--solver", "qpu", "--embedding", "E", "--seed", "0"],
            "leave --seed and --copies out",
        ),
        (["solve", "P", "-o", "S", "--copies", "2"], "only these do: qpu"),
        (["solve", "P", "-o", "S", "--no-wait"], "for D-Wave's services"),
        (["solve", "P", "-o", "S", "--resubmit"], "for D-Wave's services"),
        (["solve", "P", "Q", "-o", "S"], "--out-dir"),
        (["solve", "P", "--out-dir", "D", "-o", "S"], "does not go with"),
        (["solve", "-", "--out-dir", "D"], "stdin has no name"),
        (["collect"], "S.qsf.job"),
        (["collect", "S.qsf"], "does not end in .job"),
        (["collect", "S.job", "-o", "S.job"], "does not end in .job"),
        (["solve", "P", "-o", "-", "--json"], "stdout"),
        (["solve", "/dev/null", "-o", "/dev/../dev/null"], "problem itself"),
    ],
)
def test_usage(arguments, said, main):
    status, out, err = main(*arguments)
    assert (
        (status, out) == (2, "")
        and said in err
        and err.startswith("qstereo-bridge")
        and err.count("\n") == 1
    )


def test_unknown_solver_lists_the_known(main):
    status, _, err = main("solve", "P", "-o", "S", "--solver", "magic")
    assert status == 2 and all(name in err for name in cli.SOLVERS)


@pytest.mark.parametrize(
    "change, status, said",
    [
        (lambda data: b"", 3, "byte 0"),
        (lambda data: data[:40], 3, "byte 40"),
        (lambda data: b"P5" + data, 3, "not a .qcf file"),
        (lambda data: data[:-1], 3, "ends here"),
        (lambda data: data + b"\0", 3, "after the end"),
        (lambda data: data[:90] + bytes([data[90] ^ 1]) + data[91:], 3, "CRC-32C of chunk 0"),
    ],
)
def test_bad_problem(change, status, said, problem_file, tmp_path, main):
    problem_file.write_bytes(change(problem_file.read_bytes()))
    found, out, err = main("solve", problem_file, "-o", tmp_path / "s.qsf", *FAST)
    assert (
        (found, out) == (status, "")
        and err.startswith(f"qstereo-bridge solve: {problem_file}: ")
        and said in err
    )
    assert not (tmp_path / "s.qsf").exists()


def test_samples_file_is_no_problem(problem_file, tmp_path, main):
    assert main("solve", problem_file, "-o", tmp_path / "s.qsf", *FAST)[0] == 0
    assert main("solve", tmp_path / "s.qsf", "-o", tmp_path / "t.qsf", *FAST)[0] == 3
    assert not (tmp_path / "t.qsf").exists()


def test_memory_limit(tmp_path, main):
    (tmp_path / "p.qcf").write_bytes(pack_qcf(grid(20, 20, 16, dense=True)))
    status, _, err = main(
        "solve", tmp_path / "p.qcf", "-o", tmp_path / "s.qsf", "--memory-limit", 5
    )
    assert status == 4 and "p.qcf: a model of" in err and "--memory-limit" in err
    assert (
        main(
            "solve", tmp_path / "p.qcf", "-o", tmp_path / "s.qsf", "--memory-limit", 1 << 20, *FAST
        )[0]
        == 0
    )


def test_unreadable_and_unwritable(problem_file, tmp_path, main):
    status, _, err = main("solve", tmp_path / "none.qcf", "-o", tmp_path / "s.qsf")
    assert status == 4 and "none.qcf: cannot read: No such file" in err
    assert main("solve", tmp_path, "-o", tmp_path / "s.qsf")[0] == 4
    status, _, err = main("solve", problem_file, "-o", tmp_path / "none" / "s.qsf", *FAST)
    assert status == 4 and "there is no folder" in err
    assert main("solve", problem_file, "-o", tmp_path, *FAST)[0] == 4
    status, _, err = main("solve", problem_file, "-o", "/dev/full", *FAST)
    assert status == 4 and "/dev/full: cannot write: No space left" in err


def test_no_permission(problem_file, main, monkeypatch):
    """Root may write everywhere, so the system's answer is given here."""
    problem_file.with_suffix(".qsf").touch()
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    status, _, err = main("solve", problem_file, "-o", problem_file.with_suffix(".qsf"), *FAST)
    assert status == 4 and "cannot write: no permission" in err


@pytest.mark.parametrize("stdout", ["full", "pipe"])
@pytest.mark.parametrize("options", [[], ["--json"]])
def test_failing_stdout_leaves_the_old_file(stdout, options, problem_file, tmp_path, command):
    (tmp_path / "s.qsf").write_bytes(b"old")
    reading, writing = os.pipe()
    os.close(reading)
    with open("/dev/full", "w") if stdout == "full" else open(writing, "w") as stream:
        found = command(
            "solve",
            problem_file,
            "-o",
            tmp_path / "s.qsf",
            *FAST,
            *options,
            capture_output=False,
            stdout=stream,
            stderr=subprocess.PIPE,
        )
    assert (
        found.returncode == 4
        and b"Traceback" not in found.stderr
        and b"stdout: cannot write" in found.stderr
    )
    assert (tmp_path / "s.qsf").read_bytes() == b"old" and files(tmp_path) == ["s.qsf", "tiny.qcf"]


def test_closed_stdin_and_stdout(problem_file, tmp_path, command):
    close = {
        "preexec_fn": lambda: os.closerange(0, 2),
        "capture_output": False,
        "stderr": subprocess.PIPE,
    }
    for arguments, said in (["-", "-o", tmp_path / "s.qsf"], b"-: cannot read"), (
        [problem_file, "-o", "-"],
        b"-: cannot write",
    ):
        found = command("solve", *arguments, *FAST, **close)
        assert found.returncode == 4 and said in found.stderr and b"Traceback" not in found.stderr


def test_long_names(problem_file, tmp_path, main, monkeypatch):
    """What is too long is refused before the solver's work, what just fits is written."""
    samples = tmp_path / ("s" * 255)
    assert main("solve", problem_file, "-o", samples, *FAST)[0] == 0 and qsf.parse_qsf(
        samples.read_bytes()
    )
    monkeypatch.setattr(solvers, "anneal", None)
    status, _, err = main("solve", problem_file, "-o", tmp_path / ("s" * 256), *FAST)
    assert status == 4 and "cannot write: File name too long" in err
    assert main("solve", problem_file, "-o", "", *FAST)[0] == 4
    assert files(tmp_path) == [samples.name, "tiny.qcf"]


def test_temporary_is_there_while_the_solver_works(problem_file, tmp_path, main, monkeypatch):
    real, seen = solvers.anneal, []

    def watching(*arguments):
        seen.extend(files(tmp_path))
        return real(*arguments)

    monkeypatch.setattr(solvers, "anneal", watching)
    assert main("solve", problem_file, "-o", tmp_path / "s.qsf", *FAST)[0] == 0
    temporary, problem = seen
    assert (
        temporary.startswith(".qstereo-")
        and problem == "tiny.qcf"
        and files(tmp_path) == ["s.qsf", "tiny.qcf"]
    )


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
        monkeypatch.setattr(
            "builtins.open", lambda *a, **b: fail() if a[1:] == ("xb",) else real(*a, **b)
        )
    assert main("solve", problem_file, "-o", samples, *FAST)[0] == 4
    assert samples.read_bytes() == b"old" and files(tmp_path) == ["s.qsf", "tiny.qcf"]


def test_failures_leave_the_old_file(problem_file, tmp_path, command):
    samples = tmp_path / "s.qsf"
    samples.write_bytes(b"old")
    problem_file.write_bytes(pack_qcf(grid(3, 3, 3)))
    status, _, err = text(command("solve", problem_file, "-o", samples, "--solver", "exact"))
    assert status == 5 and "at most 24 variables" in err
    for solver in SERVICES:
        status, out, err = text(command("solve", problem_file, "-o", samples, "--solver", solver))
        assert (
            (status, out) == (5, "")
            and "dwave config create" in err
            and "DWAVE_API_TOKEN" in err
            and err.count("\n") == 1
        )
    assert samples.read_bytes() == b"old"
    assert files(tmp_path) == ["s.qsf", "tiny.qcf"]


def test_link_stays_a_link(problem_file, tmp_path, main):
    (tmp_path / "real.qsf").write_bytes(b"old")
    (tmp_path / "s.qsf").symlink_to(tmp_path / "real.qsf")
    assert main("solve", problem_file, "-o", tmp_path / "s.qsf", *FAST)[0] == 0
    assert (tmp_path / "s.qsf").is_symlink() and qsf.parse_qsf((tmp_path / "real.qsf").read_bytes())


@pytest.mark.parametrize("endpoint", ["http://127.0.0.1:9/sapi/v2/", "nonsense"])
def test_token_is_never_told(endpoint, problem_file, tmp_path, command, environment):
    environment.update(DWAVE_API_TOKEN=TOKEN, DWAVE_API_ENDPOINT=endpoint, NO_PROXY="127.0.0.1")
    (tmp_path / "dwave.conf").write_text(
        f"[defaults]\ntoken = {TOKEN}\nhttp_retry_total = 0\nhttp_retry_connect = 0\n"
    )
    environment["DWAVE_CONFIG_FILE"] = str(tmp_path / "dwave.conf")
    status, out, err = text(
        command("solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", "hybrid-cqm")
    )
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


def test_without_one_hot_groups_nothing_is_said_of_labellings(tmp_path, main):
    """Domain walls, and terminals, which are one-hot but bound to labels of their own."""
    problem, samples = tmp_path / "p.qcf", tmp_path / "s.qsf"
    labl = (4).to_bytes(4, "little") + bytes(12) + (1).to_bytes(4, "little") + bytes(44)
    terminals = altered(grid(2, 1, 3), sides=[("labl", labl)])
    for unknown in (domain_walls(2, 2, 3)[0], terminals):
        problem.write_bytes(pack_qcf(unknown))
        solve = "solve", problem, "-o", samples, "--solver", "exact"
        said = main(*solve)[1]
        assert (
            "`qstereo validate` says which samples are labellings" in said
            and "(proven least of the QUBO)" in said
        )
        told = json.loads(main(*solve, "--json")[1])
        assert (
            told["feasible"] is told["proven_optimal"] is None
            and told["best_energy"] == told["energy"] == told["lower_bound"]
        )


@pytest.mark.parametrize("solver", cli.SOLVERS)
def test_nothing_left_to_decide(solver, tmp_path, main, monkeypatch):
    """One empty sample, whatever the solver, and nothing is sent."""
    monkeypatch.setattr(remote, "connect", None)
    monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    problem, samples = tmp_path / "p.qcf", tmp_path / "s.qsf"
    problem.write_bytes(
        pack_qcf(nothing(-7, [("labl", bytes(16) + (2).to_bytes(4, "little") + bytes(44))]))
    )
    solve = "solve", problem, "--solver", solver
    status, out, err = main(*solve, "-o", samples, "--json")
    found = json.loads(out)
    assert (
        (status, err) == (0, "")
        and found["proven_optimal"]
        and found["samples"] == found["feasible"] == 1
    )
    assert (
        found["energy"] == found["lower_bound"] == found["best_energy"] == -3.5
        and found["gap"] == 0
    )
    assert "1 sample, best energy -3.5 (proven optimal)" in main(*solve, "-o", samples)[1]
    read = qsf.parse_qsf(samples.read_bytes())
    assert (
        read.bits.shape == (1, 0)
        and read.records["energy"].tolist() == [-7]
        and read.solver == solver
    )
    assert "nothing is left to decide" in main(*solve, "--dry-run")[1]
    assert (
        json.loads(main(*solve, "--dry-run", "--json")[1]).items()
        >= {"variables": 0, "upload_bytes": 0, "fits": True}.items()
    )


@pytest.mark.parametrize("solver", cli.SOLVERS)
def test_dry_run(solver, problem_file, main):
    status, out, err = main("solve", problem_file, "--solver", solver, "--dry-run")
    assert (status, err) == (0, "") and "12 variables" in out and "sent" in out
    assert ("upload" in out) == ("as published" in out) == (solver in SERVICES)
    found = json.loads(main("solve", problem_file, "--solver", solver, "--dry-run", "--json")[1])
    assert (
        found.items() >= {"schema": 1, "solver": solver, "dry_run": True, "variables": 12}.items()
    )


def test_stride_is_hybrid_nl(problem_file, main):
    assert (
        json.loads(main("solve", problem_file, "--solver", "stride", "--dry-run", "--json")[1])[
            "solver"
        ]
        == "hybrid-nl"
    )


CLOUD = ["dwave.system", "dwave.cloud", "dwave.samplers", "scipy.optimize"]


@pytest.mark.parametrize(
    "arguments, absent",
    [
        (["--version"], [*CLOUD, "dimod", "numpy"]),
        (["solve", "--help"], [*CLOUD, "dimod", "numpy"]),
        (
            ["solve", "P", "--dry-run", "--solver", "qpu"],
            ["dwave.cloud.client", "dwave.system", "dimod"],
        ),
        (
            ["solve", "P", "--dry-run", "--solver", "hybrid-cqm"],
            ["dwave.cloud.client", "dwave.system", "dimod"],
        ),
        (["solve", "P", "-o", "/dev/null", "--solver", "exact"], CLOUD),
        (["solve", "P", "-o", "/dev/null", *FAST], CLOUD[:2]),
        (["solve", "P", "-o", "/dev/null", "--solver", "ilp"], CLOUD[:3]),
    ],
)
def test_lazy_imports(arguments, absent, problem_file, environment):
    arguments = [str(problem_file) if word == "P" else str(word) for word in arguments]
    code = (
        "import sys\n"
        "from qstereo_bridge.desk.cli import main\n"
        "try:\n"
        "    status = main(sys.argv[1:])\n"
        "except SystemExit as e:\n"
        "    status = e.code\n"
        "assert status == 0\n"
        f"print([name for name in {absent} if name in sys.modules], file=sys.stderr)"
    )
    found = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        env=environment,
        capture_output=True,
        text=True,
        timeout=WHILE,
    )
    assert found.stderr == "[]\n"


@pytest.mark.parametrize(
    "arguments",
    [
        ["--num-reads", "1", "--num-sweeps", "100000000"],
        ["--num-reads", "100000"],
        ["--solver", "tabu", "--time-limit", "1000", "--num-reads", "1"],
        ["--solver", "ilp"],
    ],
)
def test_ctrl_c(arguments, tmp_path, environment):
    """One long read, many short ones, a long search, a hard program; each has begun when the signal
    comes (the progress line says so).
    """
    (tmp_path / "p.qcf").write_bytes(
        pack_qcf(grid(60, 60, 8, weight=30) if "ilp" in arguments else grid(10, 10, 4))
    )
    (tmp_path / "s.qsf").write_bytes(b"old")
    terminal, other = pty.openpty()
    process = subprocess.Popen(
        [*COMMAND, "solve", tmp_path / "p.qcf", "-o", tmp_path / "s.qsf", *arguments],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=other,
    )
    os.close(other)
    said = b""
    while b"reads" not in said and b"program 1 of 1" not in said:
        said += os.read(terminal, 1000)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=WHILE) == 130
    said += os.read(terminal, 1000)
    assert b"interrupted" in said and b"Traceback" not in said
    os.close(terminal)
    process.stdout.close()
    assert (tmp_path / "s.qsf").read_bytes() == b"old"
    assert files(tmp_path) == ["p.qcf", "s.qsf"]


@pytest.fixture
def interrupting(tmp_path, environment):
    """The environment in which a process gets signal `number` as soon as it imports `module`."""

    def make_one(module, number):
        folder = tmp_path / "path"
        folder.mkdir()
        (folder / "sitecustomize.py").write_text(f"""
import os, sys
class Finder:
    def find_spec(name, path=None, target=None):
        if name == "{module}":
            os.kill(os.getpid(), {number:d})
sys.meta_path.insert(0, Finder)
""")
        return {**environment, "PYTHONPATH": str(folder)}

    return make_one


@pytest.mark.parametrize(
    "module", ["qstereo_bridge.desk.cli", "click", "numpy", "dimod", "dwave.samplers"]
)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signal_in_an_import(module, number, interrupting, problem_file, tmp_path, command):
    found = command(
        "solve", problem_file, "-o", tmp_path / "s.qsf", *FAST, env=interrupting(module, number)
    )
    assert (found.returncode, found.stdout, found.stderr) == (
        128 + number,
        b"",
        b"qstereo-bridge: interrupted\n",
    )
    assert files(tmp_path) == ["tiny.qcf"]


def test_ignored_signal_stays_ignored(interrupting, problem_file, tmp_path, command):
    """As in the background of a script."""
    found = command(
        "solve",
        problem_file,
        "-o",
        tmp_path / "s.qsf",
        *FAST,
        env=interrupting("numpy", signal.SIGINT),
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN),
    )
    assert found.returncode == 0 and files(tmp_path) == ["s.qsf", "tiny.qcf"]


def test_names_that_are_no_utf8(tmp_path, command, environment, main, service):
    problem, samples = os.fsencode(tmp_path) + b"/\xff.qcf", os.fsencode(tmp_path) + b"/\xfe.qsf"
    with open(problem, "wb") as stream:
        stream.write(pack_qcf(grid(2, 2, 3)))
    environment["PYTHONIOENCODING"] = "utf-8:strict"
    status, out, err = text(command("solve", problem, "-o", samples, *FAST))
    assert (status, err) == (0, "") and "\\udcfe.qsf: written" in out and os.path.exists(samples)
    assert (
        main("solve", os.fsdecode(problem), "-o", tmp_path / "s.qsf", "--solver", "hybrid-cqm")[0]
        == 0
    )
    assert qsf.parse_qsf((tmp_path / "s.qsf").read_bytes()).info["parameters"]["label"] == "?"


def limited():
    resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))


def test_dry_run_beyond_every_chip_expands_nothing(tmp_path, command):
    (tmp_path / "p.qcf").write_bytes(pack_qcf(make([40_000], [], [], np.zeros(40_000), [(1, 1)])))
    status, out, err = text(
        command("solve", tmp_path / "p.qcf", "--solver", "qpu", "--dry-run", preexec_fn=limited)
    )
    assert (
        (status, err) == (0, "")
        and "799,980,000 quadratic terms" in out
        and "it does not fit" in out
    )


def test_dry_run_without_memory(tmp_path, main, monkeypatch):
    (tmp_path / "p.qcf").write_bytes(pack_qcf(grid(16, 16, 16, dense=True)))
    dry_run = "solve", tmp_path / "p.qcf", "--solver", "qpu", "--dry-run"
    assert main(*dry_run)[0] == 0

    def full(*arguments):
        raise MemoryError

    monkeypatch.setattr(bill, "plan", full)
    status, out, err = main(*dry_run)
    assert (status, out) == (4, "") and "not enough memory" in err


def test_no_binary_to_a_terminal(problem_file, command):
    terminal, other = pty.openpty()
    found = command(
        "solve", problem_file, "-o", "-", capture_output=False, stdout=other, stderr=subprocess.PIPE
    )
    os.close(terminal)
    os.close(other)
    assert found.returncode == 2 and b"terminal" in found.stderr


def test_random_samples_agree_with_their_records(tmp_path, main):
    """Wider than a byte, more than one group size, weights of every width."""
    for seed in range(5):
        problem = random_problem(seed, variables=20)
        (tmp_path / "p.qcf").write_bytes(pack_qcf(problem))
        assert main("solve", tmp_path / "p.qcf", "-o", tmp_path / "s.qsf", *FAST)[0] == 0
        read = qsf.parse_qsf((tmp_path / "s.qsf").read_bytes())
        assert np.array_equal(read.records["energy"], models.energies(problem, read.bits))


def test_work_that_is_no_longer_waited_for_does_not_hold_up_the_end(environment):
    """As HiGHS at a time limit; what was printed is there."""
    code = """
import threading
from qstereo_bridge import __main__
from qstereo_bridge.desk import cli
threading.Thread(target=threading.Event().wait).start()
cli.main = lambda: print("done") or 3
__main__.run()"""
    found = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, timeout=WHILE
    )
    assert (found.returncode, found.stdout, found.stderr) == (3, b"done\n", b"")
