"""Signals, kills, and several problems at once: whatever is interrupted, one problem is created and
its answer is found."""

import contextlib
import json
import math
import os
import random
import signal
import threading
import time

import pytest
from job_tools import (  # noqa: F401
    LEAST, SERVICES, WHILE, begin, best, collect, few_retries, hurry, kill,
    names, sent, service, solve, until)
from problems import all_states, grid, pack_qcf
from service import TOKEN
from qstereo_bridge.core import models, qsf


@pytest.mark.parametrize("solver", SERVICES)
def test_ctrl_c_cancels_what_has_not_begun(solver, begin, service, tmp_path):
    service.pending = math.inf
    process = begin(solver)
    until(lambda: sent(tmp_path / "s.qsf.job"))
    os.kill(process.pid, signal.SIGINT)
    process.join(WHILE)
    said = (tmp_path / "stderr").read_text()
    assert (process.exitcode == 130 and "had not begun and is cancelled; nothing is charged" in said
            and TOKEN not in said)
    assert ([problem.status for problem in service.problems.values()] == ["CANCELLED"]
            and names(tmp_path) == ["stderr", "tiny.qcf"])


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_interrupted_says_how_to_collect(number, begin, collect, service, tmp_path):
    """Begun: not cancelled. Other signals than Ctrl-C cancel nothing."""
    service.pending, service.delay = (0 if number == signal.SIGINT else math.inf), math.inf
    process = begin("hybrid-nl")
    until(lambda: sent(tmp_path / "s.qsf.job"))
    os.kill(process.pid, number)
    process.join(WHILE)
    assert (process.exitcode == 128 + number and f"collect {tmp_path}/s.qsf.job"
            in (tmp_path / "stderr").read_text())
    assert not any(problem.cancelled for problem in service.problems.values())
    service.pending = service.delay = 0
    assert collect()[0] == 0 and best(tmp_path) == LEAST and len(service.problems) == 1


def test_interrupted_in_the_upload(begin, service, tmp_path):
    reached = threading.Event()
    service.fail("PUT", "part", lambda: (reached.set(), service.closed.wait()))
    process = begin("hybrid-nl")
    assert reached.wait(WHILE)
    os.kill(process.pid, signal.SIGINT)
    process.join(WHILE)
    assert (process.exitcode == 130 and "interrupted; nothing was sent"
            in (tmp_path / "stderr").read_text())
    assert names(tmp_path) == ["stderr", "tiny.qcf"] and not service.problems


def recover(solve, collect, tmp_path):
    """What a person does after the machine went down: collect, and solve again where that says that
    nothing was sent."""
    if (tmp_path / "s.qsf.job").exists():
        status, _, err = collect()
        if status == 0:
            return
        assert status == 1 and "nothing was sent" in err
    if not (tmp_path / "s.qsf").exists():
        assert solve()[0] == 0


@pytest.mark.parametrize("when", ["before", "after"])
@pytest.mark.parametrize("method, path", [("POST", "combine"), ("POST", "^problems"),
                                          ("GET", r"^problems/.+")])
def test_killed_at_the_worst_moments(method, path, when, begin, solve, collect, service, tmp_path):
    """kill -9 when the service has a request, and has not carried it out or has."""
    process, begun = None, threading.Event()

    def strike():
        assert begun.wait(WHILE)
        kill(process)
        return "drop" if when == "before" else "drop after"
    service.fail(method, path, strike)
    process = begin("hybrid-nl")
    begun.set()
    process.join(WHILE)
    assert process.exitcode == -signal.SIGKILL
    recover(solve, collect, tmp_path)
    assert (len(service.problems) == 1 and best(tmp_path) == LEAST
            and "s.qsf.job" not in names(tmp_path))


def test_killed_at_any_moment(begin, solve, collect, service, tmp_path):
    """At moments spread over a whole run: before, in and after each of its requests in turn.
    QSTEREO_KILLS=50 kills at fifty."""
    process = begin("hybrid-bqm")
    process.join(WHILE)
    assert process.exitcode == 0
    whole, rng, stages = len(service.requests), random.Random(1), set()
    kills = int(os.environ.get("QSTEREO_KILLS", 12))
    for turn in range(kills):
        service.problems.clear()
        with contextlib.suppress(FileNotFoundError):
            (tmp_path / "s.qsf").unlink()
        begun, reached = threading.Event(), threading.Event()
        service.requests.clear()

        def moment(last=turn * whole // kills, how=(None, "drop", "drop after")[turn % 3]):
            if len(service.requests) > last and not reached.is_set():
                begun.wait(WHILE)
                if how:
                    kill(process)
                reached.set()
                return how
        service.fail("GET|POST|PUT", "", moment, times=10**6)
        process = begin("hybrid-bqm")
        begun.set()
        until(lambda: reached.is_set() or (tmp_path / "s.qsf").exists())
        time.sleep(rng.uniform(0, 0.02))
        process.kill()
        process.join(WHILE)
        service.faults.clear()
        path = tmp_path / "s.qsf.job"
        stages.add(json.loads(path.read_text())["state"] if path.exists() else "none")
        recover(solve, collect, tmp_path)
        assert len(service.problems) == 1 and best(tmp_path) == LEAST and not path.exists()
    assert len(stages) > 1


# Several problems.


@pytest.fixture
def frames(tmp_path):
    problems = {f"frame{i}": grid(2, 2, 3, seed=i) for i in range(5)}
    for name, problem in problems.items():
        (tmp_path / f"{name}.qcf").write_bytes(pack_qcf(problem))
    return problems


def test_many(frames, service, tmp_path, main):
    arguments = ("solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir", tmp_path / "out",
                 "--solver", "hybrid-bqm")
    status, out, err = main(*arguments)
    assert ((status, err) == (0, "") and out.count("\n") == 5 and "[5/5]" in out
            and len(service.problems) == 5)
    for name, problem in frames.items():
        read = qsf.parse_qsf((tmp_path / "out" / f"{name}.qsf").read_bytes())
        assert read.records["energy"].min() == models.energies(problem, all_states(12)).min()
        assert read.info["parameters"]["label"] == name
    assert (sum(path.split("?")[0].endswith("solvers/remote/") for _, path,
                _ in service.requests) == 2)
    status, out, err = main(*arguments)
    assert (status, err) == (0, "") and out.count("skipped") == 5 and len(service.problems) == 5
    (tmp_path / "frame3.qcf").write_bytes(pack_qcf(grid(2, 2, 3, seed=9)))
    status, out, _ = main(*arguments, "--json")
    found = json.loads(out)
    assert status == 0 and len(service.problems) == 6 and found["failed"] == []
    assert ([bool(one.get("skipped")) for one in sorted(found["problems"],
                                                        key=lambda one: one["problem"])] == [True,
        True, True, False, True])


def test_one_of_many_fails(frames, service, tmp_path, main):
    (tmp_path / "frame2.qcf").write_bytes(b"no problem")
    service.fail("POST", "^problems", 400)
    arguments = ("solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir", tmp_path / "out",
                 "--solver", "hybrid-nl")
    status, out, err = main(*arguments)
    assert (status == 1 and out.count("\n") == 3 and "2 of 5 failed" in err
            and "frame2.qcf: byte 0" in err and "frame0.qcf" in err)
    (tmp_path / "frame2.qcf").write_bytes(pack_qcf(frames["frame2"]))
    status, out, err = main(*arguments)
    assert ((status, err) == (0, "") and out.count("skipped") == 3
            and len(names(tmp_path / "out")) == 5 and len(service.problems) == 5)


def test_output_of_many_that_is_a_folder(frames, service, tmp_path, main):
    (tmp_path / "out" / "frame1.qsf").mkdir(parents=True)
    status, out, err = main("solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir",
                            tmp_path / "out", "--solver", "hybrid-bqm")
    assert (status == 1 and out.count("written") == 0 and out.count("\n") == 4
            and "1 of 5 failed" in err and "frame1" in err)


def test_many_sent_as_json(frames, service, tmp_path, main):
    status, out, _ = main("solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir",
                          tmp_path / "out", "--solver", "hybrid-nl", "--no-wait", "--json")
    found = json.loads(out)
    assert (status == 0 and len(found["problems"]) == 5 and all(one["job"].endswith(".qsf.job")
        for one in found["problems"]))


def test_many_here(frames, tmp_path, main):
    status, out, err = main("solve", *tmp_path.glob("frame*.qcf"), "--out-dir", tmp_path / "out",
                            "--solver", "exact")
    assert (status, err) == (0, "") and out.count("proven optimal") == 5


def test_many_are_collected_on_a_second_run(frames, service, tmp_path, main):
    arguments = ("solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir", tmp_path / "out",
                 "--solver", "hybrid-nl")
    status, out, _ = main(*arguments, "--no-wait")
    assert (status == 0 and len(service.problems) == 5 and names(tmp_path / "out")
            == [f"frame{i}.qsf.job" for i in range(5)])
    status, out, err = main(*arguments)
    assert ((status, err) == (0, "") and len(service.problems) == 5
            and names(tmp_path / "out") == [f"frame{i}.qsf" for i in range(5)])


def test_many_send_what_never_arrived(frames, service, tmp_path, main):
    service.fail("POST", "^problems", "drop")
    arguments = ("solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir", tmp_path / "out",
                 "--solver", "hybrid-nl")
    status, _, err = main(*arguments)
    assert status == 1 and "1 of 5 failed" in err and len(service.problems) == 4
    status, out, err = main(*arguments)
    assert (status, err) == (0, "") and out.count("skipped") == 4 and len(service.problems) == 5


def test_many_that_are_sent_are_not_sent_again(frames, service, tmp_path, main):
    arguments = ("solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir", tmp_path / "out",
                 "--no-wait", "--solver")
    service.fail("POST", "^problems", "drop")
    assert main(*arguments, "hybrid-nl")[0] == 1 and len(service.problems) == 4
    status, out, err = main(*arguments, "hybrid-bqm")
    assert ((status, err) == (0, "") and out.count("skipped, it was sent to hybrid-nl") == 4
            and len(service.problems) == 5)
    found = json.loads(main(*arguments, "hybrid-bqm", "--json")[1])
    assert sorted(one["solver"] for one in found["problems"]) == ["hybrid-bqm"] + 4 * ["hybrid-nl"]
    assert (all(one["skipped"] and one["problem_id"] in service.problems
                for one in found["problems"]) and len(service.problems) == 5)
    (tmp_path / "frame3.qcf").write_bytes(pack_qcf(grid(2, 2, 3, seed=9)))
    status, out, err = main(*arguments, "hybrid-nl")
    assert (status == 1 and out.count("skipped") == 4 and "another problem" in err
            and len(service.problems) == 5)


def test_many_are_collected_from_the_solver_that_has_them(frames, service, tmp_path, main):
    arguments = ("solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir", tmp_path / "out",
                 "--solver")
    main(*arguments, "hybrid-nl", "--no-wait")
    found = json.loads(main(*arguments, "hybrid-bqm", "--json")[1])
    assert ({one["solver"] for one in found["problems"]} == {"hybrid-nl"}
            and len(service.problems) == 5)
    assert all(qsf.parse_qsf(path.read_bytes()).solver == "hybrid-nl"
               for path in (tmp_path / "out").iterdir())


def test_many_of_one_name(frames, tmp_path, main):
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "frame0.qcf").write_bytes(b"")
    status, _, err = main("solve", tmp_path / "frame0.qcf", tmp_path / "other" / "frame0.qcf",
                          "--out-dir", tmp_path / "out")
    assert status == 2 and "would both go to" in err


# Tokens.


def test_no_token_in_logs(service, problem_file, tmp_path, command, environment):
    """D-Wave's client logs what it does where the user asks it to."""
    environment.update(DWAVE_LOG_LEVEL="trace")
    found = command("solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", "qpu",
                    env=environment)
    assert found.returncode == 0 and len(found.stderr) > 1000
    service.fail("POST", "^problems", 500, times=9)
    assert (command("solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", "hybrid-bqm",
                    env=environment).returncode == 5)


def test_no_token_at_the_service_but_in_its_header(solve, service):
    for solver in SERVICES:
        solve(solver)
    assert all(TOKEN.encode() not in body and TOKEN not in path for _, path,
               body in service.requests)
    assert all(TOKEN not in json.dumps(problem.job) for problem in service.problems.values())
