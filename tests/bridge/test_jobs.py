"""The life of a problem at the service: whatever fails or is interrupted, one problem is created and its answer is found."""

import contextlib
import json
import math
import os
import random
import signal
import socket
import sys
import threading
import time

import pytest
from problems import all_states, grid
from service import TOKEN, Service
from qstereo_bridge import jobs, models, qcf, qsf, runner, services, text
from qstereo_bridge.output import Output

# Seconds after which a test fails that waits for what does not come: far more than any busy machine takes.
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


@pytest.mark.parametrize("solver", SERVICES)
def test_send_now_and_collect_later(solver, solve, collect, service, tmp_path):
    service.delay = 2
    status, out, err = solve(solver, "--no-wait")
    (problem_id, _), = service.problems.items()
    assert (status, err) == (0, "") and problem_id in out and f"collect {tmp_path}/s.qsf.job" in out
    assert names(tmp_path) == ["s.qsf.job", "tiny.qcf"]
    facts = json.loads((tmp_path / "s.qsf.job").read_text())
    assert facts.items() >= {"schema": 1, "state": "sent", "solver": solver, "problem_id": problem_id, "problem": "tiny.qcf"}.items()
    status, out, err = collect("--no-wait")
    assert (status, out) == (1, "") and "no answer yet" in err
    status, out, err = collect()
    assert status == 0 and best(tmp_path) == LEAST and names(tmp_path) == ["s.qsf", "tiny.qcf"] and len(service.problems) == 1
    assert collect()[0] == 3


def test_no_wait_json(solve, service, tmp_path):
    found = json.loads(solve("hybrid-nl", "--no-wait", "--json")[1])
    assert found == {"schema": 1, "solver": "hybrid-nl", "job": f"{tmp_path}/s.qsf.job", "problem_id": next(iter(service.problems))}


def test_collected_and_waited_for_are_the_same(solve, collect, service, tmp_path):
    for solver in SERVICES:
        options = ["--seed", 1] if solver == "qpu" else []
        solve(solver, *options)
        waited = qsf.parse_qsf((tmp_path / "s.qsf").read_bytes())
        solve(solver, "--no-wait", *options)
        collect()
        collected = qsf.parse_qsf((tmp_path / "s.qsf").read_bytes())
        assert (waited.records == collected.records).all() and (waited.bits == collected.bits).all()
        assert {**waited.info, "problem_id": 0} == {**collected.info, "problem_id": 0}


# Trouble with the network and the service.


@pytest.mark.parametrize("solver", SERVICES)
@pytest.mark.parametrize("method, path, how", [
    ("GET", "solvers", "drop"), ("POST", "^problems", "drop after"), ("POST", "^problems", "500 after"), ("GET", r"^problems/$", "drop"),
    ("GET", r"^problems/$", 500), ("GET", r"^problems/.+", "drop"), ("GET", r"^problems/.+", 500), ("GET", r"^problems/.+", 429)])
def test_passing_trouble(solver, method, path, how, solve, service, tmp_path):
    service.fail(method, path, how)
    status, out, err = solve(solver)
    assert status == 0 and best(tmp_path) == LEAST and len(service.problems) == 1 and names(tmp_path) == ["s.qsf", "tiny.qcf"]
    assert all(how == 0 for *_, how in service.faults)


@pytest.mark.parametrize("method, path, how", [("PUT", "part/1", "drop"), ("PUT", "part/1", 500), ("corrupt", "part/1", True),
                                               ("POST", "combine", 500), ("GET", "^answers", "drop")])
def test_passing_trouble_with_transfers(method, path, how, solve, service, tmp_path):
    service.fail(method, path, how)
    assert solve("hybrid-nl")[0] == 0 and best(tmp_path) == LEAST and len(service.problems) == 1


@pytest.mark.parametrize("method, path, how, said", [("POST", "bqm/multipart$", 403, "refuses it to this account"),
                                                     ("corrupt", "part/1", True, "Checksum mismatch")])
def test_upload_that_fails_for_good_sends_nothing(method, path, how, said, solve, service, tmp_path, monkeypatch):
    monkeypatch.setattr("dwave.cloud.utils.decorators.time.sleep", lambda seconds: None)
    service.fail(method, path, how, times=99)
    status, out, err = solve("hybrid-bqm")
    assert (status, out) == (5, "") and said in err and err.count("\n") == 1
    assert not service.problems and names(tmp_path) == ["tiny.qcf"]


@pytest.mark.parametrize("how", ["drop", 500, 503])
def test_not_known_whether_it_arrived(how, solve, collect, service, tmp_path):
    """The request is lost: the next run asks before it sends."""
    service.fail("POST", "^problems", how)
    status, out, err = solve()
    assert (status, out) == (5, "") and "Whether the problem arrived is not known" in err and "collect" in err
    assert names(tmp_path) == ["s.qsf.job", "tiny.qcf"] and json.loads((tmp_path / "s.qsf.job").read_text())["state"] == "sending"
    status, out, err = collect()
    assert status == 1 and "nothing was sent and nothing is charged" in err
    assert solve()[0] == 0 and best(tmp_path) == LEAST and len(service.problems) == 1


@pytest.mark.parametrize("how", [408, 409, 418, 451, 499])
def test_replies_that_are_no_refusal(how, solve, service, tmp_path):
    """Some gateway's word: the problem may have arrived all the same."""
    service.fail("POST", "^problems", how)
    status, _, err = solve()
    assert status == 5 and "Whether the problem arrived is not known" in err and names(tmp_path) == ["s.qsf.job", "tiny.qcf"]


@pytest.mark.parametrize("how", [400, 401, 402, 403, 404, 413, 422, 429])
def test_replies_that_are_refusals(how, solve, service, tmp_path):
    service.fail("POST", "^problems", how)
    status, _, err = solve()
    assert status == 5 and "as it was told" in err and "collect" not in err and names(tmp_path) == ["tiny.qcf"]


@pytest.mark.parametrize("said", ["2001-01-01T00:00:00+00:00", "2101-01-01T00:00:00+00:00"])
def test_clocks_of_two_machines(said, solve, collect, service, tmp_path, monkeypatch):
    """However old a request seems by this clock, its problem has a moment to appear; however young, not for ever."""
    service.fail("POST", "^problems", "drop after")
    service.fail("GET", "^problems", "drop", times=3)
    assert solve()[0] == 5
    path = tmp_path / "s.qsf.job"
    path.write_text(json.dumps({**json.loads(path.read_text()), "time": said}))
    there = dict(service.problems)
    service.problems.clear()
    monkeypatch.setattr(jobs, "PAUSES", (0,))
    monkeypatch.setattr(jobs, "ARRIVED", 0)
    status, _, err = collect()
    assert status == 1 and "nothing was sent" in err
    monkeypatch.setattr(jobs, "PAUSES", (WHILE,))
    service.fail("GET", "^problems", lambda: None)
    service.fail("GET", "^problems", lambda: service.problems.update(there))
    assert collect()[0] == 0 and best(tmp_path) == LEAST


def test_problem_that_the_service_has_forgotten(solve, collect, service, tmp_path):
    solve("hybrid-nl", "--no-wait")
    service.problems.clear()
    status, out, err = collect()
    assert (status, out) == (5, "") and "does not know problem" in err and "--resubmit" in err and "is at the service" not in err
    assert names(tmp_path) == ["s.qsf.job", "tiny.qcf"]


@pytest.mark.parametrize("times", [1, 99])
def test_service_that_asks_for_patience(times, solve, collect, service, tmp_path):
    """429 and 503 with Retry-After, which D-Wave's client counts among the connections that failed."""
    service.patience = 0
    service.fail("POST", "^problems", "drop after")
    service.fail("GET", r"^problems/$", 429, times=times)
    service.fail("GET", r"^problems/.+", 503, times=times)
    status, out, err = solve()
    if times > 1:
        assert status == 5 and "too many requests" in err and "Whether the problem arrived is not known" in err
        service.fail("GET", r"^problems/$", 429, times=0)
        service.faults[1][3] = 0
        status, out, err = collect()
        assert status == 5 and "error of its own" in err and "is at the service" in err
        service.faults.clear()
        assert collect()[0] == 0
    assert best(tmp_path) == LEAST and len(service.problems) == 1


def test_patience_that_the_client_loses(solve, service, tmp_path, monkeypatch):
    """Where the user's configuration allows no retries of a status, the client gives up with an error of its own."""
    (tmp_path / "dwave.conf").write_text("[defaults]\nhttp_retry_status = 0\n")
    monkeypatch.setenv("DWAVE_CONFIG_FILE", str(tmp_path / "dwave.conf"))
    service.patience = 0
    service.fail("GET", r"^problems/.+", 503)
    assert solve()[0] == 0 and len(service.problems) == 1
    service.fail("GET", r"^problems/.+", 503, times=99)
    status, _, err = solve()
    assert status == 5 and "is overloaded" in err and "is at the service" in err


def test_label_that_the_service_tidies_up(solve, service, tmp_path, monkeypatch):
    handler = service.server.RequestHandlerClass
    create = handler._create
    monkeypatch.setattr(handler, "_create", lambda self, job: create(self, {**job, "label": job["label"].title().replace(" ", "  ", 1)[:20] + " "
                                                                            + job["label"].split()[-1]}), raising=False)
    assert solve("hybrid-nl", "--label", "two words")[0] == 0 and best(tmp_path) == LEAST


def test_labels_of_safe_characters(solve, service, tmp_path):
    label = "  a/b\t\u00e4<&>\n\u202e frame_1.2-3 " + 300 * "x"
    assert solve("hybrid-nl", "--label", label)[0] == 0
    sent = next(iter(service.problems.values())).label
    words = sent.split(" ")
    assert words[0] == "a_b" and words[3] == "frame_1.2-3" and len(sent) < 150 and sent.isascii() and sent == " ".join(sent.split())
    assert set(sent) <= set("abcdefghijklmnopqrstuvwxyz0123456789._- ")
    assert qsf.parse_qsf((tmp_path / "s.qsf").read_bytes()).info["parameters"]["label"] == label


@pytest.mark.parametrize("state", ["sent", "sending"])
def test_redirected_questions_are_not_followed(state, solve, collect, service, tmp_path):
    """They would take the token elsewhere."""
    solve("hybrid-nl", "--no-wait")
    path = tmp_path / "s.qsf.job"
    path.write_text(json.dumps({**json.loads(path.read_text()), "state": state}))
    with Service() as other:
        service.elsewhere = other.url
        service.fail("GET", "^problems", 307, times=9)
        status, _, err = collect("--no-wait")
        assert status == 5 and "has moved" in err and not other.requests and names(tmp_path) == ["s.qsf.job", "tiny.qcf"]


def test_job_that_the_service_has_forgotten_without_waiting(solve, collect, service, tmp_path):
    solve("hybrid-nl", "--no-wait")
    service.problems.clear()
    status, _, err = collect("--no-wait")
    assert status == 5 and "does not know problem" in err


def test_without_the_nonlinear_models(solve, service, problem_file, main, monkeypatch):
    monkeypatch.setitem(sys.modules, "dwave.optimization", None)
    for status, out, err in (solve("hybrid-nl"), main("solve", problem_file, "--solver", "hybrid-nl", "--dry-run")):
        assert (status, out) == (5, "") and "pip install" in err and not service.problems


def test_token_of_a_profile_is_not_told(monkeypatch, tmp_path):
    (tmp_path / "dwave.conf").write_text("[defaults]\nendpoint = x\n[first]\ntoken = of-first\n[second]\ntoken = of  second\n")
    monkeypatch.setenv("DWAVE_CONFIG_FILE", str(tmp_path / "dwave.conf"))
    monkeypatch.setenv("DWAVE_API_TOKEN", "of the  environment")
    monkeypatch.setattr(text, "_hidden", set())
    for token in ("of-first", "of  second", "of the  environment"):
        assert services.explain(ValueError(f"sent {token} there")) == "ValueError: sent (token) there"


def test_arrived_although_the_client_could_not_know(solve, collect, service, tmp_path):
    """The request arrives, then the network is gone: neither a reply nor the list of problems."""
    service.fail("POST", "^problems", "drop after")
    service.fail("GET", "^problems", "drop", times=3)
    status, _, err = solve()
    assert status == 5 and names(tmp_path) == ["s.qsf.job", "tiny.qcf"]
    assert "Whether the problem arrived is not known" in err and f"collect {tmp_path}/s.qsf.job" in err
    status, _, err = solve()
    assert status == 1 and "was sent" in err and "not sent again" in err and len(service.problems) == 1
    assert collect()[0] == 0 and best(tmp_path) == LEAST and len(service.problems) == 1


def test_nobody_there(problem_file, tmp_path, main, service, monkeypatch):
    """The service vanishes between the upload and the request: it never arrived, nothing is left."""
    def vanish():
        service.server.socket.shutdown(socket.SHUT_RDWR)  # closing alone lets a poll that is under way take one more connection
        service.server.socket.close()
        threading.Thread(target=service.server.shutdown).start()
        return None
    service.fail("POST", "combine", vanish)
    status, _, err = main("solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", "hybrid-bqm")
    assert status == 5 and "cannot be reached" in err and names(tmp_path) == ["tiny.qcf"]


@pytest.mark.parametrize("solver", SERVICES)
@pytest.mark.parametrize("how, said", [("drop", "cannot be reached"), (500, "error of its own"), (401, "does not accept the token"),
                                       (404, "as it was told")])
def test_answer_that_cannot_be_had_now_is_there_later(solver, how, said, solve, collect, service, tmp_path):
    service.fail("GET", r"^problems/.+", how, times=40)
    status, out, err = solve(solver)
    assert (status, out) == (5, "") and said in err and ("is at the service" in err or how == 404) and f"collect {tmp_path}/s.qsf.job" in err
    assert names(tmp_path) == ["s.qsf.job", "tiny.qcf"]
    service.faults.clear()
    assert collect()[0] == 0 and best(tmp_path) == LEAST and len(service.problems) == 1


@pytest.mark.parametrize("outcome, said", [("FAILED", "too hot"), ("CANCELLED", "was cancelled")])
@pytest.mark.parametrize("solver", SERVICES)
def test_problems_that_end_without_an_answer(solver, outcome, said, solve, service, tmp_path):
    service.outcome, service.reason = outcome, "too hot"
    status, out, err = solve(solver)
    assert (status, out) == (5, "") and said in err and "collect" not in err and names(tmp_path) == ["tiny.qcf"]


def shorten(answer):
    """An answer of wrong length, in each format."""
    if answer["format"] == "qp":
        return {**answer, "solutions": answer["solutions"][:8]}
    if answer["format"] == "bq":
        import dimod
        whole = dimod.SampleSet.from_serializable(answer["data"])
        return {**answer, "data": dimod.SampleSet.from_samples((whole.record.sample[:, :-1], list(whole.variables)[:-1]), "BINARY",
                                                               whole.record.energy).to_serializable()}
    return answer


@pytest.mark.parametrize("solver", SERVICES)
def test_answer_of_wrong_length(solver, solve, collect, service, tmp_path):
    service.spoil = shorten
    if solver == "hybrid-nl":
        def shorten_data(answer):
            service.answers.update({name: data[:-20] for name, data in service.answers.items()})
            return answer
        service.spoil = shorten_data
    status, out, err = solve(solver)
    assert (status, out) == (5, "") and f"collect {tmp_path}/s.qsf.job" in err and err.count("\n") == 1
    assert names(tmp_path) == ["s.qsf.job", "tiny.qcf"]
    service.spoil = None
    for problem in service.problems.values():
        problem.answer = None
    assert collect()[0] == 0 and best(tmp_path) == LEAST


def test_slow_answer(solve, service, monkeypatch):
    """The problem goes on when the user has been told how far it is."""
    service.pending = math.inf
    real = runner.progress

    def progress(options):
        show = real(options)

        def tell(text):
            show(text)
            if text == "pending":
                service.pending, service.delay = 0, math.inf
            if text == "in progress":
                service.delay = 0
        return tell
    monkeypatch.setattr(runner, "progress", progress)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    status, out, err = solve()
    assert status == 0 and "hybrid-nl: pending" in err and "hybrid-nl: in progress" in err


@pytest.mark.parametrize("lasting", [False, True])
def test_poll_that_is_told_nothing(lasting, solve, service, tmp_path, monkeypatch):
    """An empty list in place of the problem's status: D-Wave's client asks no more."""
    monkeypatch.setattr(jobs, "SILENCE", 0)
    handler, told = service.server.RequestHandlerClass, []
    answer = handler._list

    def nothing(self, query, body):
        told.append(query)
        return (200, []) if "id" in query and (lasting or len(told) == 1) else answer(self, query, body)
    monkeypatch.setattr(handler, "ROUTES", [(pattern, nothing if action is answer else action) for pattern, action in handler.ROUTES])
    assert solve()[0] == 0 and best(tmp_path) == LEAST and told


# The job file.


def test_nothing_is_sent_twice_unasked(solve, service, tmp_path):
    solve("hybrid-nl", "--no-wait")
    status, out, err = solve()
    assert (status, out) == (1, "") and f"qstereo-bridge collect {tmp_path}/s.qsf.job" in err and "--resubmit" in err
    assert len(service.problems) == 1
    assert solve("hybrid-nl", "--resubmit")[0] == 0 and len(service.problems) == 2 and names(tmp_path) == ["s.qsf", "tiny.qcf"]


def test_job_of_another_problem_is_not_forgotten(solve, service, problem_file):
    solve("hybrid-nl", "--no-wait")
    problem_file.write_bytes(qcf.pack_qcf(grid(2, 2, 3, seed=1)))
    status, _, err = solve()
    assert status == 1 and "another problem" in err and len(service.problems) == 1


def test_collect_wants_the_problem_that_was_sent(solve, collect, service, problem_file, tmp_path):
    solve("hybrid-nl", "--no-wait")
    good = problem_file.read_bytes()
    problem_file.write_bytes(qcf.pack_qcf(grid(2, 2, 3, seed=1)))
    status, _, err = collect()
    assert status == 3 and "not the problem that was sent" in err
    problem_file.unlink()
    status, _, err = collect()
    assert status == 2 and "no longer at" in err and "--problem" in err
    (tmp_path / "elsewhere.qcf").write_bytes(good)
    assert collect("--problem", tmp_path / "elsewhere.qcf", "-o", tmp_path / "t.qsf")[0] == 0
    assert names(tmp_path) == ["elsewhere.qcf", "t.qsf"]


def test_job_file_may_move_with_its_problem(solve, service, problem_file, tmp_path, main):
    """As on another machine."""
    solve("hybrid-nl", "--no-wait")
    other = tmp_path / "other"
    other.mkdir()
    problem_file.rename(other / "tiny.qcf")
    (tmp_path / "s.qsf.job").rename(other / "s.qsf.job")
    assert main("collect", other / "s.qsf.job")[0] == 0 and names(other) == ["s.qsf", "tiny.qcf"]


def test_collect_refuses_the_answer_of_another_problem(solve, collect, service, tmp_path):
    solve("hybrid-nl", "--no-wait")
    first = next(iter(service.problems))
    solve("hybrid-nl", "--no-wait", "--resubmit")
    path = tmp_path / "s.qsf.job"
    path.write_text(json.dumps({**json.loads(path.read_text()), "problem_id": first}))
    status, _, err = collect()
    assert status == 5 and "the answer to another problem" in err and not (tmp_path / "s.qsf").exists()


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"schema": 2}', '{"schema": 1, "state": "odd"}', "\xff"])
def test_bad_job_files(content, solve, collect, service, tmp_path):
    (tmp_path / "s.qsf.job").write_bytes(content.encode("latin-1"))
    for status, _, err in (collect(), solve()):
        assert status == 3 and "no job file" in err and not service.problems
    assert solve("hybrid-nl", "--resubmit")[0] == 0


def test_one_process_at_a_time(solve, collect, service, tmp_path):
    solve("hybrid-nl", "--no-wait")
    with jobs.Job.load(str(tmp_path / "s.qsf.job")):
        for status, _, err in (collect(), solve()):
            assert status == 4 and "another qstereo-bridge" in err
    assert collect()[0] == 0


def test_two_processes_at_once_send_one_problem(begin, service, tmp_path):
    service.delay = math.inf
    processes = [begin("hybrid-bqm") for _ in range(2)]
    until(lambda: not all(process.is_alive() for process in processes))
    service.delay = 0
    for process in processes:
        process.join(WHILE)
    assert sorted(process.exitcode for process in processes) == [0, 4] and len(service.problems) == 1
    assert best(tmp_path) == LEAST and not (tmp_path / "s.qsf.job").exists()


def test_resubmit_leaves_a_job_alone_that_is_being_worked_on(solve, service, tmp_path):
    solve("hybrid-nl", "--no-wait")
    with jobs.Job.load(str(tmp_path / "s.qsf.job")):
        assert solve("hybrid-nl", "--resubmit")[0] == 4
    assert len(service.problems) == 1


def test_a_lock_on_a_replaced_file_is_none(tmp_path, monkeypatch):
    facts = {"schema": 1, "state": jobs.UPLOADING, "solver": "qpu", "label": "", "problem_digest": "", "parameters": {}, "time": jobs._now(),
             "service_solver": None, "user_label": None, "problem": None}
    path, lock = str(tmp_path / "s.qsf.job"), jobs._lock
    job = jobs.Job(path, facts)
    job.save(new=True)
    with pytest.raises(jobs.Failure, match="another qstereo-bridge"):
        jobs.Job(path, dict(facts)).save(new=True)

    def late(stream, name):
        monkeypatch.setattr(jobs, "_lock", lock)
        job.save(state=jobs.SENDING)
        lock(stream, name)
    monkeypatch.setattr(jobs, "_lock", late)
    with pytest.raises(jobs.Failure, match="another qstereo-bridge"):
        jobs.Job.load(path)
    job.leave()
    assert names(tmp_path) == ["s.qsf.job"]


@pytest.mark.parametrize("field, value", [("time", "x"), ("time", "2026-01-01T00:00:00"), ("problem", 5), ("problem_id", None), ("parameters", 5),
                                          ("service_solver", 5)])
def test_job_files_with_a_wrong_field(field, value, solve, collect, service, tmp_path):
    solve("hybrid-nl", "--no-wait")
    path = tmp_path / "s.qsf.job"
    facts = json.loads(path.read_text())
    for changed in ({**facts, field: value}, {key: facts[key] for key in facts if key != field}):
        path.write_text(json.dumps(changed))
        status, _, err = collect()
        assert status == 3 and "no job file" in err


def test_redirected_post_is_not_followed(solve, service, tmp_path, monkeypatch):
    solve("hybrid-nl", "--no-wait")
    other = next(iter(service.problems.values()))
    other.label = None
    (tmp_path / "s.qsf.job").unlink()
    handler = service.server.RequestHandlerClass

    def moved(self):
        if self.path.endswith("problems/"):
            self._body()
            self.send_response(301)
            self.send_header("Location", f"{service.url}problems/?")
            self.send_header("Content-Length", "0")
            self.end_headers()
        else:
            super(handler, self).do_POST()
    monkeypatch.setattr(handler, "do_POST", moved, raising=False)
    status, out, err = solve()
    assert (status, out) == (5, "") and "has moved to" in err and len(service.problems) == 1 and names(tmp_path) == ["tiny.qcf"]


@pytest.mark.parametrize("reply", [[None], [{}], [{"id": None, "label": "x"}], [{"id": "other", "label": None}], {}, []])
def test_reply_that_says_nothing_of_this_problem(reply, solve, service, tmp_path, monkeypatch):
    handler = service.server.RequestHandlerClass
    submit = handler._submit
    monkeypatch.setattr(handler, "ROUTES", [(pattern, (lambda self, query, body: (submit(self, query, body), (200, reply))[1])
                                             if pattern == "POST problems/" else action) for pattern, action in handler.ROUTES])
    assert solve()[0] == 0 and len(service.problems) == 1 and names(tmp_path) == ["s.qsf", "tiny.qcf"]


def test_another_account_does_not_say_that_nothing_was_sent(solve, collect, service, tmp_path, monkeypatch):
    service.fail("POST", "^problems", "500 after")
    service.fail("GET", "^problems", 500, times=99)
    assert solve()[0] == 5 and json.loads((tmp_path / "s.qsf.job").read_text())["state"] == "sending"
    service.faults.clear()
    there = dict(service.problems)
    service.problems.clear()
    monkeypatch.setattr("service.TOKEN", "DEV-" + "9" * 40)
    monkeypatch.setenv("DWAVE_API_TOKEN", "DEV-" + "9" * 40)
    for status, _, err in (collect(), solve()):
        assert status == 5 and "another token" in err and "nothing was sent" not in err and not service.problems
    monkeypatch.undo()
    service.problems.update(there)


def test_chip_that_was_calibrated_since(solve, collect, service, tmp_path):
    solve("qpu", "--no-wait")
    solver = next(data for data in service.solvers.values() if "graph_id" in data["identity"].get("version", {}))
    solver["identity"] = {**solver["identity"], "version": {"graph_id": "another"}}
    assert collect()[0] == 0 and best(tmp_path) == LEAST


@pytest.mark.parametrize("solver", SERVICES)
@pytest.mark.parametrize("how", ["offline", "retired"])
def test_answer_of_a_solver_that_is_gone(how, solver, solve, collect, service, tmp_path):
    solve(solver, "--no-wait")
    for problem in service.problems.values():
        problem.solve()
    if how == "retired":
        service.solvers.clear()
    for data in service.solvers.values():
        data["status"] = "OFFLINE"
    assert collect()[0] == 0 and best(tmp_path) == LEAST


@pytest.mark.parametrize("counts", [0, -1, 2**33])
def test_impossible_occurrences_keep_the_job(counts, solve, collect, service, tmp_path):
    import dimod

    def spoil(answer):
        found = dimod.SampleSet.from_serializable(answer["data"])
        found.record.num_occurrences[:] = counts
        return {**answer, "data": found.to_serializable() | {"info": answer["data"]["info"]}}
    service.spoil = spoil
    status, _, err = solve("hybrid-bqm")
    assert status == 5 and "never seen" in err and names(tmp_path) == ["s.qsf.job", "tiny.qcf"]


def test_answer_without_samples_keeps_the_job(solve, collect, service, tmp_path):
    import dimod
    service.spoil = lambda answer: {**answer, "data": dimod.SampleSet.from_serializable(answer["data"]).truncate(0).to_serializable()}
    status, out, err = solve("hybrid-bqm")
    assert (status, out) == (5, "") and "has no samples" in err and f"collect {tmp_path}/s.qsf.job" in err
    assert names(tmp_path) == ["s.qsf.job", "tiny.qcf"] and collect()[0] == 5 and names(tmp_path) == ["s.qsf.job", "tiny.qcf"]


def test_samples_that_cannot_be_read_again_keep_the_job(solve, collect, service, tmp_path, monkeypatch):
    pack = qsf.pack_qsf
    with monkeypatch.context() as patch:
        patch.setattr(qsf, "pack_qsf", lambda samples: pack(samples)[:-1])
        status, out, err = solve()
    assert (status, out) == (5, "") and "no sound .qsf" in err and f"collect {tmp_path}/s.qsf.job" in err
    assert names(tmp_path) == ["s.qsf.job", "tiny.qcf"] and collect()[0] == 0 and best(tmp_path) == LEAST


def test_disk_full_when_the_problem_was_sent(solve, collect, service, tmp_path, monkeypatch):
    put = jobs._put

    def full(name, path, new):
        if json.loads(open(name, "rb").read())["state"] == jobs.SENT:
            raise OSError(28, "No space left on device")
        put(name, path, new)
    with monkeypatch.context() as patch:
        patch.setattr(jobs, "_put", full)
        status, _, err = solve()
    assert status == 4 and "is at the service" in err and "collect" in err and names(tmp_path) == ["s.qsf.job", "tiny.qcf"]
    assert collect()[0] == 0 and len(service.problems) == 1


def test_problem_from_stdin(service, problem_file, tmp_path, main, command):
    found = command("solve", "-", "-o", tmp_path / "s.qsf", "--solver", "hybrid-nl", "--no-wait", input=problem_file.read_bytes())
    assert found.returncode == 0
    status, _, err = main("collect", tmp_path / "s.qsf.job")
    assert status == 2 and "stdin" in err
    assert main("collect", tmp_path / "s.qsf.job", "--problem", problem_file)[0] == 0


def test_samples_to_stdout(service, problem_file, tmp_path, command, monkeypatch):
    service.fail("GET", r"^problems/.+", 404, times=9)
    monkeypatch.chdir(tmp_path)
    found = command("solve", problem_file, "-o", "-", "--solver", "hybrid-nl", cwd=tmp_path)
    job, = tmp_path.glob("qstereo-*.qsf.job")
    assert found.returncode == 5 and found.stdout == b"" and job.name.encode() in found.stderr
    service.faults.clear()
    found = command("collect", job, "-o", "-", cwd=tmp_path)
    assert found.returncode == 0 and qsf.parse_qsf(found.stdout).bits.shape[1] == 12 and names(tmp_path) == ["tiny.qcf"]


def test_folder_that_cannot_hold_the_job(service, problem_file, tmp_path, main):
    status, _, err = main("solve", problem_file, "-o", tmp_path / "none" / "s.qsf", "--solver", "hybrid-nl", "--no-wait")
    assert status == 4 and "cannot write" in err and not service.problems


def test_failed_write_of_the_samples_keeps_the_job(solve, collect, service, tmp_path, monkeypatch):
    def full(*arguments):
        raise OSError(28, "No space left on device")
    with monkeypatch.context() as patch:
        patch.setattr(Output, "write", full)
        status, _, err = solve()
    assert status == 4 and "No space left" in err and "collect" in err and names(tmp_path) == ["s.qsf.job", "tiny.qcf"]
    assert collect()[0] == 0 and len(service.problems) == 1


# Signals.


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
        arguments = ["solve", str(problem_file), "-o", str(tmp_path / "s.qsf"), "--solver", solver, *options]
        process = processes.Process(target=child, args=(arguments, environment, str(tmp_path / "stderr")), daemon=True)
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


@pytest.mark.parametrize("solver", SERVICES)
def test_ctrl_c_cancels_what_has_not_begun(solver, begin, service, tmp_path):
    service.pending = math.inf
    process = begin(solver)
    until(lambda: sent(tmp_path / "s.qsf.job"))
    os.kill(process.pid, signal.SIGINT)
    process.join(WHILE)
    said = (tmp_path / "stderr").read_text()
    assert process.exitcode == 130 and "had not begun and is cancelled; nothing is charged" in said and TOKEN not in said
    assert [problem.status for problem in service.problems.values()] == ["CANCELLED"] and names(tmp_path) == ["stderr", "tiny.qcf"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_interrupted_says_how_to_collect(number, begin, collect, service, tmp_path):
    """Begun: not cancelled. Other signals than Ctrl-C cancel nothing."""
    service.pending, service.delay = (0 if number == signal.SIGINT else math.inf), math.inf
    process = begin("hybrid-nl")
    until(lambda: sent(tmp_path / "s.qsf.job"))
    os.kill(process.pid, number)
    process.join(WHILE)
    assert process.exitcode == 128 + number and f"collect {tmp_path}/s.qsf.job" in (tmp_path / "stderr").read_text()
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
    assert process.exitcode == 130 and "interrupted; nothing was sent" in (tmp_path / "stderr").read_text()
    assert names(tmp_path) == ["stderr", "tiny.qcf"] and not service.problems


def recover(solve, collect, tmp_path):
    """What a person does after the machine went down: collect, and solve again where that says that nothing was sent."""
    if (tmp_path / "s.qsf.job").exists():
        status, _, err = collect()
        if status == 0:
            return
        assert status == 1 and "nothing was sent" in err
    if not (tmp_path / "s.qsf").exists():
        assert solve()[0] == 0


@pytest.mark.parametrize("when", ["before", "after"])
@pytest.mark.parametrize("method, path", [("POST", "combine"), ("POST", "^problems"), ("GET", r"^problems/.+")])
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
    assert len(service.problems) == 1 and best(tmp_path) == LEAST and "s.qsf.job" not in names(tmp_path)


def test_killed_at_any_moment(begin, solve, collect, service, tmp_path):
    """At moments spread over a whole run: before, in and after each of its requests in turn. QSTEREO_KILLS=50 kills at fifty."""
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
        (tmp_path / f"{name}.qcf").write_bytes(qcf.pack_qcf(problem))
    return problems


@pytest.mark.parametrize("jobs_at_once", [1, 3])
def test_many(jobs_at_once, frames, service, tmp_path, main):
    arguments = "solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir", tmp_path / "out", "--solver", "hybrid-bqm", "--jobs", jobs_at_once
    status, out, err = main(*arguments)
    assert (status, err) == (0, "") and out.count("\n") == 5 and "[5/5]" in out and len(service.problems) == 5
    for name, problem in frames.items():
        read = qsf.parse_qsf((tmp_path / "out" / f"{name}.qsf").read_bytes())
        assert read.records["energy"].min() == models.energies(problem, all_states(12)).min()
        assert read.info["parameters"]["label"] == name
    assert sum(path.split("?")[0].endswith("solvers/remote/") for _, path, _ in service.requests) == 2
    status, out, err = main(*arguments)
    assert (status, err) == (0, "") and out.count("skipped") == 5 and len(service.problems) == 5
    (tmp_path / "frame3.qcf").write_bytes(qcf.pack_qcf(grid(2, 2, 3, seed=9)))
    status, out, _ = main(*arguments, "--json")
    found = json.loads(out)
    assert status == 0 and len(service.problems) == 6 and found["failed"] == []
    assert [bool(one.get("skipped")) for one in sorted(found["problems"], key=lambda one: one["problem"])] == [True, True, True, False, True]


def test_one_of_many_fails(frames, service, tmp_path, main):
    (tmp_path / "frame2.qcf").write_bytes(b"no problem")
    service.fail("POST", "^problems", 400)
    arguments = "solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir", tmp_path / "out", "--solver", "hybrid-nl"
    status, out, err = main(*arguments)
    assert status == 1 and out.count("\n") == 3 and "2 of 5 failed" in err and "frame2.qcf: byte 0" in err and "frame0.qcf" in err
    (tmp_path / "frame2.qcf").write_bytes(qcf.pack_qcf(frames["frame2"]))
    status, out, err = main(*arguments)
    assert (status, err) == (0, "") and out.count("skipped") == 3 and len(names(tmp_path / "out")) == 5 and len(service.problems) == 5


@pytest.fixture
def begin_all(processes, frames, service, environment, tmp_path):
    """Starts the command on five problems; gives its process when so many of them are sent."""
    def start(at_once, count, **more):
        service.pending = math.inf
        arguments = ["solve", *map(str, sorted(tmp_path.glob("frame*.qcf"))), "--out-dir", str(tmp_path / "out"), "--solver", "hybrid-bqm",
                     "--jobs", str(at_once)]
        process = processes.Process(target=child, args=(arguments, environment, str(tmp_path / "stderr")), kwargs=more, daemon=True)
        process.start()
        until(lambda: sum(map(sent, tmp_path.glob("out/*.job"))) == count)
        return process
    return start


def test_nothing_is_sent_after_ctrl_c(begin_all, service):
    """Threads whose problem is cancelled would go on to the next one, if they went on."""
    process = begin_all(2, 2)
    service.fail("DELETE", "^problems", lambda: print(service.closed.wait(0.3)), times=99)
    os.kill(process.pid, signal.SIGINT)
    process.join(WHILE)
    assert process.exitcode == 130 and len(service.problems) == 2 and all(problem.cancelled for problem in service.problems.values())


def test_ctrl_c_has_one_deadline_for_all(begin_all, service, tmp_path):
    """A service that hangs holds up the end once, not once for each problem and question; the jobs stay."""
    process, asked = begin_all(5, 5, deadline=2), []
    service.fail("GET", r"^problems/$", lambda: (asked.append(1), service.closed.wait()), times=999)
    os.kill(process.pid, signal.SIGINT)
    process.join(WHILE)
    assert process.exitcode == 130
    # One question for each, at the same time: none of them is answered. The client's own may be one more.
    assert len(asked) <= 5 + 5
    assert (tmp_path / "stderr").read_text().count("the problem is at the service; `qstereo-bridge collect") == 5
    assert names(tmp_path / "out") == [f"frame{i}.qsf.job" for i in range(5)]


def test_ctrl_c_cancels_many_at_once(begin_all, service, tmp_path):
    """No cancellation is answered before all have come."""
    process, all_here = begin_all(5, 5), threading.Barrier(5, timeout=WHILE)
    service.fail("DELETE", "^problems", lambda: print(all_here.wait()), times=99)
    os.kill(process.pid, signal.SIGINT)
    process.join(WHILE)
    assert process.exitcode == 130 and all(problem.cancelled for problem in service.problems.values()) and names(tmp_path / "out") == []


def test_no_temporary_after_a_signal(tmp_path, monkeypatch):
    """A thread that still runs makes none; whatever it was about to do, it stays there."""
    monkeypatch.setattr(Output, "pending", set())
    monkeypatch.setattr(Output, "stopping", False)
    at_work = Output(str(tmp_path / "at-work.qsf"))
    late = Output(str(tmp_path / "late.qsf"))
    Output.abandon()

    def quietly(step):
        with contextlib.suppress(OSError):
            step()
    for step in (lambda: Output(str(tmp_path / "new.qsf")), lambda: at_work.write(b"x"), late.keep):
        thread = threading.Thread(target=quietly, args=(step,), daemon=True)
        thread.start()
        thread.join(0.3)
        assert thread.is_alive() and names(tmp_path) == []
    monkeypatch.undo()


def test_output_of_many_that_is_a_folder(frames, service, tmp_path, main):
    (tmp_path / "out" / "frame1.qsf").mkdir(parents=True)
    status, out, err = main("solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir", tmp_path / "out", "--solver", "hybrid-bqm")
    assert status == 1 and out.count("written") == 0 and out.count("\n") == 4 and "1 of 5 failed" in err and "frame1" in err


def test_many_sent_as_json(frames, service, tmp_path, main):
    status, out, _ = main("solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir", tmp_path / "out", "--solver", "hybrid-nl", "--no-wait",
                          "--json")
    found = json.loads(out)
    assert status == 0 and len(found["problems"]) == 5 and all(one["job"].endswith(".qsf.job") for one in found["problems"])


def test_many_here(frames, tmp_path, main):
    status, out, err = main("solve", *tmp_path.glob("frame*.qcf"), "--out-dir", tmp_path / "out", "--solver", "exact", "--jobs", 2)
    assert (status, err) == (0, "") and out.count("proven optimal") == 5


def test_many_are_collected_on_a_second_run(frames, service, tmp_path, main):
    arguments = "solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir", tmp_path / "out", "--solver", "hybrid-nl"
    status, out, _ = main(*arguments, "--no-wait")
    assert status == 0 and len(service.problems) == 5 and names(tmp_path / "out") == [f"frame{i}.qsf.job" for i in range(5)]
    status, out, err = main(*arguments)
    assert (status, err) == (0, "") and len(service.problems) == 5 and names(tmp_path / "out") == [f"frame{i}.qsf" for i in range(5)]


def test_many_send_what_never_arrived(frames, service, tmp_path, main):
    service.fail("POST", "^problems", "drop")
    arguments = "solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir", tmp_path / "out", "--solver", "hybrid-nl"
    status, _, err = main(*arguments)
    assert status == 1 and "1 of 5 failed" in err and len(service.problems) == 4
    status, out, err = main(*arguments)
    assert (status, err) == (0, "") and out.count("skipped") == 4 and len(service.problems) == 5


def test_many_that_are_sent_are_not_sent_again(frames, service, tmp_path, main):
    arguments = "solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir", tmp_path / "out", "--no-wait", "--solver"
    service.fail("POST", "^problems", "drop")
    assert main(*arguments, "hybrid-nl")[0] == 1 and len(service.problems) == 4
    status, out, err = main(*arguments, "hybrid-bqm")
    assert (status, err) == (0, "") and out.count("skipped, it was sent to hybrid-nl") == 4 and len(service.problems) == 5
    found = json.loads(main(*arguments, "hybrid-bqm", "--json")[1])
    assert sorted(one["solver"] for one in found["problems"]) == ["hybrid-bqm"] + 4 * ["hybrid-nl"]
    assert all(one["skipped"] and one["problem_id"] in service.problems for one in found["problems"]) and len(service.problems) == 5
    (tmp_path / "frame3.qcf").write_bytes(qcf.pack_qcf(grid(2, 2, 3, seed=9)))
    status, out, err = main(*arguments, "hybrid-nl")
    assert status == 1 and out.count("skipped") == 4 and "another problem" in err and len(service.problems) == 5


def test_many_are_collected_from_the_solver_that_has_them(frames, service, tmp_path, main):
    arguments = "solve", *sorted(tmp_path.glob("frame*.qcf")), "--out-dir", tmp_path / "out", "--solver"
    main(*arguments, "hybrid-nl", "--no-wait")
    found = json.loads(main(*arguments, "hybrid-bqm", "--json")[1])
    assert {one["solver"] for one in found["problems"]} == {"hybrid-nl"} and len(service.problems) == 5
    assert all(qsf.parse_qsf(path.read_bytes()).solver == "hybrid-nl" for path in (tmp_path / "out").iterdir())


def test_many_of_one_name(frames, tmp_path, main):
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "frame0.qcf").write_bytes(b"")
    status, _, err = main("solve", tmp_path / "frame0.qcf", tmp_path / "other" / "frame0.qcf", "--out-dir", tmp_path / "out")
    assert status == 2 and "would both go to" in err


# Tokens.


def test_no_token_in_logs(service, problem_file, tmp_path, command, environment):
    """D-Wave's client logs what it does where the user asks it to."""
    environment.update(DWAVE_LOG_LEVEL="trace")
    found = command("solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", "qpu", env=environment)
    assert found.returncode == 0 and len(found.stderr) > 1000
    service.fail("POST", "^problems", 500, times=9)
    assert command("solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", "hybrid-bqm", env=environment).returncode == 5


def test_no_token_at_the_service_but_in_its_header(solve, service):
    for solver in SERVICES:
        solve(solver)
    assert all(TOKEN.encode() not in body and TOKEN not in path for _, path, body in service.requests)
    assert all(TOKEN not in json.dumps(problem.job) for problem in service.problems.values())
