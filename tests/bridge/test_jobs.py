"""The life of a problem at the service: whatever fails, one problem is created and its answer is
found."""

import json
import math
import socket
import sys
import threading

import pytest
from job_tools import (  # noqa: F401
    LEAST, SERVICES, WHILE, begin, best, collect, few_retries, hurry, names, sent,
    service, solve, until)
from problems import grid, pack_qcf
from service import Service
from qstereo_bridge.runs import jobs, runner
from qstereo_bridge.core import qsf, text
from qstereo_bridge.ocean import hybrid, services
from qstereo_bridge.core.output import Output


@pytest.mark.parametrize("solver", SERVICES)
def test_send_now_and_collect_later(solver, solve, collect, service, tmp_path):
    service.delay = 2
    status, out, err = solve(solver, "--no-wait")
    (problem_id, _), = service.problems.items()
    assert (status, err) == (0, "") and problem_id in out and f"collect {tmp_path}/s.qsf.job" in out
    assert names(tmp_path) == ["s.qsf.job", "tiny.qcf"]
    facts = json.loads((tmp_path / "s.qsf.job").read_text())
    assert (facts.items() >= {"schema": 1, "state": "sent", "solver": solver,
                              "problem_id": problem_id, "problem": "tiny.qcf"}.items())
    status, out, err = collect("--no-wait")
    assert (status, out) == (1, "") and "no answer yet" in err
    status, out, err = collect()
    assert (status == 0 and best(tmp_path) == LEAST and names(tmp_path) == ["s.qsf", "tiny.qcf"]
            and len(service.problems) == 1)
    assert collect()[0] == 3


def test_no_wait_json(solve, service, tmp_path):
    found = json.loads(solve("hybrid-nl", "--no-wait", "--json")[1])
    assert (found == {"schema": 1, "solver": "hybrid-nl", "job": f"{tmp_path}/s.qsf.job",
                      "problem_id": next(iter(service.problems))})


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
@pytest.mark.parametrize("method, path, how", [("GET", "solvers", "drop"),
                                               ("POST", "^problems", "drop after"),
                                               ("POST", "^problems", "500 after"),
                                               ("GET", r"^problems/$", "drop"),
                                               ("GET", r"^problems/$", 500),
                                               ("GET", r"^problems/.+", "drop"),
                                               ("GET", r"^problems/.+", 500),
                                               ("GET", r"^problems/.+", 429)])
def test_passing_trouble(solver, method, path, how, solve, service, tmp_path):
    service.fail(method, path, how)
    status, out, err = solve(solver)
    assert (status == 0 and best(tmp_path) == LEAST and len(service.problems) == 1
            and names(tmp_path) == ["s.qsf", "tiny.qcf"])
    assert all(how == 0 for *_, how in service.faults)


@pytest.mark.parametrize("method, path, how", [("PUT", "part/1", "drop"), ("PUT", "part/1", 500),
                                               ("corrupt", "part/1", True),
                                               ("POST", "combine", 500),
                                               ("GET", "^answers", "drop")])
def test_passing_trouble_with_transfers(method, path, how, solve, service, tmp_path):
    service.fail(method, path, how)
    assert solve("hybrid-nl")[0] == 0 and best(tmp_path) == LEAST and len(service.problems) == 1


@pytest.mark.parametrize("method, path, how, said", [("POST", "bqm/multipart$", 403,
                                                      "refuses it to this account"),
                                                     ("corrupt", "part/1", True,
                                                      "Checksum mismatch")])
def test_upload_that_fails_for_good_sends_nothing(method, path, how, said, solve, service, tmp_path,
                                                  monkeypatch):
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
    assert ((status, out) == (5, "") and "Whether the problem arrived is not known" in err
            and "collect" in err)
    assert (names(tmp_path) == ["s.qsf.job", "tiny.qcf"]
            and json.loads((tmp_path / "s.qsf.job").read_text())["state"] == "sending")
    status, out, err = collect()
    assert status == 1 and "nothing was sent and nothing is charged" in err
    assert solve()[0] == 0 and best(tmp_path) == LEAST and len(service.problems) == 1


@pytest.mark.parametrize("how", [408, 409, 418, 451, 499])
def test_replies_that_are_no_refusal(how, solve, service, tmp_path):
    """Some gateway's word: the problem may have arrived all the same."""
    service.fail("POST", "^problems", how)
    status, _, err = solve()
    assert (status == 5 and "Whether the problem arrived is not known" in err
            and names(tmp_path) == ["s.qsf.job", "tiny.qcf"])


@pytest.mark.parametrize("how", [400, 401, 402, 403, 404, 413, 422, 429])
def test_replies_that_are_refusals(how, solve, service, tmp_path):
    service.fail("POST", "^problems", how)
    status, _, err = solve()
    assert (status == 5 and "as it was told" in err and "collect" not in err
            and names(tmp_path) == ["tiny.qcf"])


@pytest.mark.parametrize("said", ["2001-01-01T00:00:00+00:00", "2101-01-01T00:00:00+00:00"])
def test_clocks_of_two_machines(said, solve, collect, service, tmp_path, monkeypatch):
    """However old a request seems by this clock, its problem has a moment to appear; however young,
    not for ever."""
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
    assert ((status, out) == (5, "") and "does not know problem" in err and "--resubmit" in err
            and "is at the service" not in err)
    assert names(tmp_path) == ["s.qsf.job", "tiny.qcf"]


@pytest.mark.parametrize("times", [1, 99])
def test_service_that_asks_for_patience(times, solve, collect, service, tmp_path):
    """429 and 503 with Retry-After, which D-Wave's client counts among the connections that failed.
    """
    service.patience = 0
    service.fail("POST", "^problems", "drop after")
    service.fail("GET", r"^problems/$", 429, times=times)
    service.fail("GET", r"^problems/.+", 503, times=times)
    status, out, err = solve()
    if times > 1:
        assert (status == 5 and "too many requests" in err
                and "Whether the problem arrived is not known" in err)
        service.fail("GET", r"^problems/$", 429, times=0)
        service.faults[1][3] = 0
        status, out, err = collect()
        assert status == 5 and "error of its own" in err and "is at the service" in err
        service.faults.clear()
        assert collect()[0] == 0
    assert best(tmp_path) == LEAST and len(service.problems) == 1


def test_patience_that_the_client_loses(solve, service, tmp_path, monkeypatch):
    """Where the user's configuration allows no retries of a status, the client gives up with an
    error of its own."""
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
    monkeypatch.setattr(handler, "_create", lambda self, job: create(self,
        {**job, "label": job["label"].title().replace(" ", "  ",
                                                      1)[:20] + " " + job["label"].split()[-1]}),
                        raising=False)
    assert solve("hybrid-nl", "--label", "two words")[0] == 0 and best(tmp_path) == LEAST


def test_labels_of_safe_characters(solve, service, tmp_path):
    label = "  a/b\t\u00e4<&>\n\u202e frame_1.2-3 " + 300 * "x"
    assert solve("hybrid-nl", "--label", label)[0] == 0
    sent = next(iter(service.problems.values())).label
    words = sent.split(" ")
    assert (words[0] == "a_b" and words[3] == "frame_1.2-3" and len(sent) < 150 and sent.isascii()
            and sent == " ".join(sent.split()))
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
        assert (status == 5 and "has moved" in err and not other.requests
                and names(tmp_path) == ["s.qsf.job", "tiny.qcf"])


def test_job_that_the_service_has_forgotten_without_waiting(solve, collect, service, tmp_path):
    solve("hybrid-nl", "--no-wait")
    service.problems.clear()
    status, _, err = collect("--no-wait")
    assert status == 5 and "does not know problem" in err


def test_without_the_nonlinear_models(solve, service, problem_file, main, monkeypatch):
    monkeypatch.setitem(sys.modules, "dwave.optimization", None)
    for status, out, err in (solve("hybrid-nl"), main("solve", problem_file, "--solver",
                                                      "hybrid-nl", "--dry-run")):
        assert (status, out) == (5, "") and "pip install" in err and not service.problems


def test_token_of_a_profile_is_not_told(monkeypatch, tmp_path):
    (tmp_path / "dwave.conf").write_text(
        "[defaults]\nendpoint = x\n[first]\ntoken = of-first\n[second]\ntoken = of  second\n")
    monkeypatch.setenv("DWAVE_CONFIG_FILE", str(tmp_path / "dwave.conf"))
    monkeypatch.setenv("DWAVE_API_TOKEN", "of the  environment")
    monkeypatch.setattr(text, "_hidden", set())
    for token in ("of-first", "of  second", "of the  environment"):
        assert (services.explain(ValueError(f"sent {token} there"))
                == "ValueError: sent (token) there")


def test_arrived_although_the_client_could_not_know(solve, collect, service, tmp_path):
    """The request arrives, then the network is gone: neither a reply nor the list of problems."""
    service.fail("POST", "^problems", "drop after")
    service.fail("GET", "^problems", "drop", times=3)
    status, _, err = solve()
    assert status == 5 and names(tmp_path) == ["s.qsf.job", "tiny.qcf"]
    assert ("Whether the problem arrived is not known" in err
            and f"collect {tmp_path}/s.qsf.job" in err)
    status, _, err = solve()
    assert (status == 1 and "was sent" in err and "not sent again" in err
            and len(service.problems) == 1)
    assert collect()[0] == 0 and best(tmp_path) == LEAST and len(service.problems) == 1


def test_nobody_there(problem_file, tmp_path, main, service, monkeypatch):
    """The service vanishes between the upload and the request: it never arrived, nothing is left.
    """
    def vanish():
        # Closing alone lets a poll that is under way take one more connection.
        service.server.socket.shutdown(socket.SHUT_RDWR)
        service.server.socket.close()
        threading.Thread(target=service.server.shutdown).start()
        return None
    service.fail("POST", "combine", vanish)
    status, _, err = main("solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", "hybrid-bqm")
    assert status == 5 and "cannot be reached" in err and names(tmp_path) == ["tiny.qcf"]


@pytest.mark.parametrize("solver", SERVICES)
@pytest.mark.parametrize("how, said", [("drop", "cannot be reached"), (500, "error of its own"),
                                       (401, "does not accept the token"), (404, "as it was told")])
def test_answer_that_cannot_be_had_now_is_there_later(solver, how, said, solve, collect, service,
                                                      tmp_path):
    service.fail("GET", r"^problems/.+", how, times=40)
    status, out, err = solve(solver)
    assert ((status, out) == (5, "") and said in err and ("is at the service" in err or how == 404)
            and f"collect {tmp_path}/s.qsf.job" in err)
    assert names(tmp_path) == ["s.qsf.job", "tiny.qcf"]
    service.faults.clear()
    assert collect()[0] == 0 and best(tmp_path) == LEAST and len(service.problems) == 1


@pytest.mark.parametrize("outcome, said", [("FAILED", "too hot"), ("CANCELLED", "was cancelled")])
@pytest.mark.parametrize("solver", SERVICES)
def test_problems_that_end_without_an_answer(solver, outcome, said, solve, service, tmp_path):
    service.outcome, service.reason = outcome, "too hot"
    status, out, err = solve(solver)
    assert ((status, out) == (5, "") and said in err and "collect" not in err
            and names(tmp_path) == ["tiny.qcf"])


def shorten(answer):
    """An answer of wrong length, in each format."""
    if answer["format"] == "qp":
        return {**answer, "solutions": answer["solutions"][:8]}
    if answer["format"] == "bq":
        import dimod
        whole = dimod.SampleSet.from_serializable(answer["data"])
        return {**answer, "data": dimod.SampleSet.from_samples((whole.record.sample[:, :-1],
            list(whole.variables)[:-1]), "BINARY", whole.record.energy).to_serializable()}
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
    assert ((status, out) == (5, "") and f"collect {tmp_path}/s.qsf.job" in err
            and err.count("\n") == 1)
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
    handler, told = service.server.RequestHandlerClass, []
    answer = handler._list

    def nothing(self, query, body):
        told.append(query)
        return ((200, []) if "id" in query and (lasting or len(told) == 1) else answer(self, query,
            body))
    monkeypatch.setattr(handler, "ROUTES", [(pattern, nothing if action is answer else action)
                                            for pattern, action in handler.ROUTES])
    assert solve()[0] == 0 and best(tmp_path) == LEAST and told


# The job file.


def test_nothing_is_sent_twice_unasked(solve, service, tmp_path):
    solve("hybrid-nl", "--no-wait")
    status, out, err = solve()
    assert ((status, out) == (1, "") and f"qstereo-bridge collect {tmp_path}/s.qsf.job" in err
            and "--resubmit" in err)
    assert len(service.problems) == 1
    assert (solve("hybrid-nl", "--resubmit")[0] == 0 and len(service.problems) == 2
            and names(tmp_path) == ["s.qsf", "tiny.qcf"])


def test_job_of_another_problem_is_not_forgotten(solve, service, problem_file):
    solve("hybrid-nl", "--no-wait")
    problem_file.write_bytes(pack_qcf(grid(2, 2, 3, seed=1)))
    status, _, err = solve()
    assert status == 1 and "another problem" in err and len(service.problems) == 1


def test_collect_wants_the_problem_that_was_sent(solve, collect, service, problem_file, tmp_path):
    solve("hybrid-nl", "--no-wait")
    good = problem_file.read_bytes()
    problem_file.write_bytes(pack_qcf(grid(2, 2, 3, seed=1)))
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
    assert (status == 5 and "the answer to another problem" in err
            and not (tmp_path / "s.qsf").exists())


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"schema": 2}',
                                     '{"schema": 1, "state": "odd"}', "\xff"])
def test_bad_job_files(content, solve, collect, service, tmp_path):
    (tmp_path / "s.qsf.job").write_bytes(content.encode("latin-1"))
    for status, _, err in (collect(), solve()):
        assert status == 3 and "not a job file" in err and not service.problems
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
    assert (sorted(process.exitcode for process in processes) == [0, 4]
            and len(service.problems) == 1)
    assert best(tmp_path) == LEAST and not (tmp_path / "s.qsf.job").exists()


def test_resubmit_leaves_a_job_alone_that_is_being_worked_on(solve, service, tmp_path):
    solve("hybrid-nl", "--no-wait")
    with jobs.Job.load(str(tmp_path / "s.qsf.job")):
        assert solve("hybrid-nl", "--resubmit")[0] == 4
    assert len(service.problems) == 1


def test_a_lock_on_a_replaced_file_is_none(tmp_path, monkeypatch):
    facts = {"schema": 1, "state": jobs.UPLOADING, "solver": "qpu", "label": "",
             "problem_digest": "", "parameters": {}, "time": jobs._now(), "service_solver": None,
             "user_label": None, "problem": None}
    path, lock = str(tmp_path / "s.qsf.job"), jobs.lock
    job = jobs.Job(path, facts)
    job.save()
    with pytest.raises(jobs.Failure, match="another qstereo-bridge"):
        jobs.Job(path, dict(facts)).save()

    def late(stream, name):
        monkeypatch.setattr(jobs, "lock", lock)
        job.save(state=jobs.SENDING)
        lock(stream, name)
    monkeypatch.setattr(jobs, "lock", late)
    with pytest.raises(jobs.Failure, match="another qstereo-bridge"):
        jobs.Job.load(path)
    job.leave()
    assert names(tmp_path) == ["s.qsf.job"]


@pytest.mark.parametrize("field, value", [("time", "x"), ("time", "2026-01-01T00:00:00"),
                                          ("problem", 5), ("problem_id", None), ("parameters", 5),
                                          ("service_solver", 5)])
def test_job_files_with_a_wrong_field(field, value, solve, collect, service, tmp_path):
    solve("hybrid-nl", "--no-wait")
    path = tmp_path / "s.qsf.job"
    facts = json.loads(path.read_text())
    for changed in ({**facts, field: value}, {key: facts[key] for key in facts if key != field}):
        path.write_text(json.dumps(changed))
        status, _, err = collect()
        assert status == 3 and "not a job file" in err


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
    assert ((status, out) == (5, "") and "has moved to" in err and len(service.problems) == 1
            and names(tmp_path) == ["tiny.qcf"])


@pytest.mark.parametrize("reply", [[None], [{}], [{"id": None, "label": "x"}],
                                   [{"id": "other", "label": None}], {}, []])
def test_reply_that_says_nothing_of_this_problem(reply, solve, service, tmp_path, monkeypatch):
    handler = service.server.RequestHandlerClass
    submit = handler._submit
    monkeypatch.setattr(handler, "ROUTES", [(pattern, (lambda self, query,
                                                       body: (submit(self, query, body),
                                                              (200, reply))[1])
                                             if pattern == "POST problems/" else action)
                                            for pattern, action in handler.ROUTES])
    assert (solve()[0] == 0 and len(service.problems) == 1 and names(tmp_path) == ["s.qsf",
        "tiny.qcf"])


def test_another_account_does_not_say_that_nothing_was_sent(solve, collect, service, tmp_path,
                                                            monkeypatch):
    service.fail("POST", "^problems", "500 after")
    service.fail("GET", "^problems", 500, times=99)
    assert (solve()[0] == 5 and json.loads((tmp_path / "s.qsf.job").read_text())["state"]
            == "sending")
    service.faults.clear()
    there = dict(service.problems)
    service.problems.clear()
    monkeypatch.setattr("service.TOKEN", "DEV-" + "9" * 40)
    monkeypatch.setenv("DWAVE_API_TOKEN", "DEV-" + "9" * 40)
    for status, _, err in (collect(), solve()):
        assert (status == 5 and "another token" in err and "nothing was sent" not in err
                and not service.problems)
    monkeypatch.undo()
    service.problems.update(there)


@pytest.fixture
def loaded_first(monkeypatch):
    """A client whose threads have an answer, or know why not, before retrieve_answer() returns."""
    from dwave.cloud import Client
    retrieve = Client.retrieve_answer

    def retrieved(client, problem_id):
        future = retrieve(client, problem_id)
        future.wait()
        return future
    monkeypatch.setattr(Client, "retrieve_answer", retrieved)


@pytest.mark.parametrize("solver", ["hybrid-bqm", "hybrid-cqm"])
def test_answer_that_a_thread_of_the_client_is_still_at(solver, solve, monkeypatch, tmp_path):
    from dwave.cloud.computation import Future
    here, decoded, read = threading.current_thread(), threading.Event(), threading.Event()
    wait, told, decode = Future.wait, Future._get_problem_info, hybrid.Hybrid.decode

    def wait_until_decoded(future, timeout=None):
        return wait(future, timeout) and (threading.current_thread() is not here
                                          or decoded.wait(WHILE))

    def told_later(future):
        decoded.set()
        assert threading.current_thread() is not here and read.wait(WHILE)
        return told(future)

    def decoded_meanwhile(*arguments):
        try:
            return decode(*arguments)
        finally:
            read.set()
    monkeypatch.setattr(Future, "wait", wait_until_decoded)
    monkeypatch.setattr(Future, "_get_problem_info", told_later)
    monkeypatch.setattr(hybrid.Hybrid, "decode", decoded_meanwhile)
    status, _, err = solve(solver)
    assert (status, err) == (0, "") and best(tmp_path) == LEAST


@pytest.mark.usefixtures("loaded_first")
def test_chip_that_was_calibrated_since(solve, collect, service, tmp_path):
    solve("qpu", "--no-wait")
    solver = next(data for data in service.solvers.values()
                  if "graph_id" in data["identity"].get("version", {}))
    solver["identity"] = {**solver["identity"], "version": {"graph_id": "another"}}
    assert collect()[0] == 0 and best(tmp_path) == LEAST


@pytest.mark.usefixtures("loaded_first")
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
    service.spoil = lambda answer: {**answer, "data": dimod.SampleSet.from_serializable(
        answer["data"]).truncate(0).to_serializable()}
    status, out, err = solve("hybrid-bqm")
    assert ((status, out) == (5, "") and "has no samples" in err
            and f"collect {tmp_path}/s.qsf.job" in err)
    assert (names(tmp_path) == ["s.qsf.job", "tiny.qcf"] and collect()[0] == 5
            and names(tmp_path) == ["s.qsf.job", "tiny.qcf"])


def test_samples_that_cannot_be_read_again_keep_the_job(solve, collect, service, tmp_path,
                                                        monkeypatch):
    pack = qsf.pack_qsf
    with monkeypatch.context() as patch:
        patch.setattr(qsf, "pack_qsf", lambda samples: pack(samples)[:-1])
        status, out, err = solve()
    assert ((status, out) == (5, "") and "no sound .qsf" in err
            and f"collect {tmp_path}/s.qsf.job" in err)
    assert (names(tmp_path) == ["s.qsf.job", "tiny.qcf"] and collect()[0] == 0
            and best(tmp_path) == LEAST)


def test_disk_full_when_the_problem_was_sent(solve, collect, service, tmp_path, monkeypatch):
    put = jobs._put

    def full(name, path, new):
        if json.loads(open(name, "rb").read())["state"] == jobs.SENT:
            raise OSError(28, "No space left on device")
        put(name, path, new)
    with monkeypatch.context() as patch:
        patch.setattr(jobs, "_put", full)
        status, _, err = solve()
    assert (status == 4 and "is at the service" in err and "collect" in err
            and names(tmp_path) == ["s.qsf.job", "tiny.qcf"])
    assert collect()[0] == 0 and len(service.problems) == 1


def test_problem_from_stdin(service, problem_file, tmp_path, main, command):
    found = command("solve", "-", "-o", tmp_path / "s.qsf", "--solver", "hybrid-nl", "--no-wait",
                    input=problem_file.read_bytes())
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
    assert (found.returncode == 0 and qsf.parse_qsf(found.stdout).bits.shape[1] == 12
            and names(tmp_path) == ["tiny.qcf"])


def test_folder_that_cannot_hold_the_job(service, problem_file, tmp_path, main):
    status, _, err = main("solve", problem_file, "-o", tmp_path / "none" / "s.qsf", "--solver",
                          "hybrid-nl", "--no-wait")
    assert status == 4 and "cannot write" in err and not service.problems


def test_failed_write_of_the_samples_keeps_the_job(solve, collect, service, tmp_path, monkeypatch):
    def full(*arguments):
        raise OSError(28, "No space left on device")
    with monkeypatch.context() as patch:
        patch.setattr(Output, "write", full)
        status, _, err = solve()
    assert (status == 4 and "No space left" in err and "collect" in err
            and names(tmp_path) == ["s.qsf.job", "tiny.qcf"])
    assert collect()[0] == 0 and len(service.problems) == 1
