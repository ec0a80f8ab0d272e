"""The life of a problem at D-Wave's service: sent once, found again after any interruption, never
charged twice.

A job file (JSON, without a token) lies beside the samples file until the samples are written. Its
`state` says how far the problem is:

    uploading   nothing is charged yet: it may be sent again
    sending     the one request that creates the problem may have left: the service is asked for the
                job's label, which no other job has
    sent        the service has the problem, under `problem_id`

By the state alone, whatever ends the work, an error or a signal, leaves the file or removes it, and
says how to go on.
"""

import _thread
import concurrent.futures
import contextlib
import json
import os
import re
import secrets
import time
from datetime import datetime, timezone

from ..core.failure import BAD_INPUT, IO, NO, SERVICE, Error, Failure, SolverError, io
from ..core.output import sync_folder, temporary
from ..core.qsf import plain
from ..core.text import line, parse, shown
from ..ocean.services import connect, explain

try:
    import fcntl
except ImportError:
    fcntl = None

SCHEMA = 1
UPLOADING, SENDING, SENT = "uploading", "sending", "sent"
# Seconds after which a request that left is in the service's list of problems, if it ever arrived.
ARRIVED = 10
# Pauses between attempts at what may be repeated: asking costs nothing.
PAUSES = (0.3, 1, 3)
# The most seconds between two questions whether there is an answer.
LAZIEST = 5
# Replies that say that the service did not take the problem. Others, as 408 and 499, may be of a
# gateway that knows nothing.
REFUSALS = (400, 401, 402, 403, 404, 413, 422, 429)
# Seconds that Ctrl-C takes at most for the cancellations.
DEADLINE = 6
RUNNING = ("PENDING", "IN_PROGRESS")
AT_WORK = "{}: another qstereo-bridge is at work on this job; wait for it, or stop it"
NO_LOCKS = ("locks on files keep a problem from being charged twice; this system has none. Use "
            "Linux, macOS or another Unix; on Windows run qstereo-bridge in WSL. Nothing was sent")
# What an error says of a job, by its state.
HINTS = {SENDING: "whether the problem arrived is not known; {} asks again, and nothing is sent "
                  "twice",
         SENT: "the problem is at the service; {} fetches the answer"}
UNKNOWN = ("it has expired, or belongs to another project or region than the one configured. Where "
           "it is known {} fetches the answer; `qstereo-bridge solve --resubmit` sends and charges "
           "it once more")


class Held:
    """A file that is locked while this process holds it, and replaced as a whole: on the disk
    before the next step is taken. Its methods raise Failure."""

    def __init__(self, path):
        self.path, self.stream = path, None

    def take(self):
        """Lock the file, if there is one: its bytes, or None."""
        with io(self.path, "read"), contextlib.suppress(FileNotFoundError):
            while True:
                self.stream = open(self.path, "rb+")
                lock(self.stream, self.path)
                # It may have been replaced or removed, and let go, since it was opened.
                if os.path.samestat(os.fstat(self.stream.fileno()), os.stat(self.path)):
                    return self.stream.read()
                self.stream.close()
        self.leave()
        return None

    def put(self, data):
        """Replace the file, or make it: where it is not held there must be none."""
        with io(self.path, "write"), temporary(self.path) as (name, stream):
            lock(stream, name)
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
            _put(name, self.path, self.stream is None)
            sync_folder(self.path)
        before, self.stream = self.stream, stream
        if before:
            before.close()

    def leave(self):
        """Let go of the file; it stays."""
        if self.stream:
            self.stream.close()
            self.stream = None

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.leave()


class Job(Held):
    """One job file. Each of its `facts` is an attribute, too; `session` is what serves it, for
    signals to use.

    A `with` lets go of it. Where an error ends that, a job of which nothing was sent is removed,
    and for others the error says how to go on.
    """

    active = set()

    def __init__(self, path, facts):
        super().__init__(path)
        self.facts, self.session = facts, None

    @classmethod
    def load(cls, path, whatever=False):
        """The job in the file `path`; where there is none a new one, without a file. Raises
        Failure: another process has it, or it is no job file, which `whatever` allows as it is to
        be replaced."""
        job = cls(path, {"state": UPLOADING})
        data = job.take()
        if data is None:
            return job
        with contextlib.suppress(ValueError, KeyError, TypeError):
            facts = parse(data)
            if _sound(facts):
                job.facts = facts
                return job
        if whatever:
            return job
        job.leave()
        raise Failure(BAD_INPUT, f"{path}: this is not a job file of this version; give "
                                 "another, or remove it")

    def save(self, **changes):
        """Change facts, and have them on the disk."""
        facts = {**self.facts, **changes}
        self.put(json.dumps(facts, indent=1).encode() + b"\n")
        self.facts = facts
        Job.active.add(self)

    def leave(self):
        super().leave()
        Job.active.discard(self)

    def remove(self):
        with contextlib.suppress(OSError):
            os.remove(self.path)
        self.leave()

    def __getattr__(self, name):
        if name in self.facts:
            return self.facts[name]
        raise AttributeError(name)

    @property
    def command(self):
        """What fetches the answer."""
        return ("the same `qstereo-bridge solve --windows`" if self.facts.get("window") else
                f"`qstereo-bridge collect {self.path}`")

    def __exit__(self, kind, error, trace):
        if error is None or not self.stream:
            return self.leave()
        if self.state == UPLOADING:
            return self.remove()
        self.leave()
        if not isinstance(error, Error) or error.status not in (IO, SERVICE):
            return None
        if self.state == SENT and getattr(error, "code", None) == 404:
            raise SolverError(f"D-Wave's service does not know problem {self.problem_id} "
                              f"({error}): {UNKNOWN.format(self.command)}") from None
        hint = HINTS[self.state].format(self.command)
        raise Failure(error.status, f"{error}. {hint[0].upper()}{hint[1:]}") from None


def _sound(facts):
    """Whether a job file's content is what `save` writes; may raise what a wrong type raises."""
    text = ["solver", "label", "problem_digest"] + ["problem_id"] * (facts["state"] == SENT)
    perhaps = ("service_solver", "user_label", "problem")
    return (facts["schema"] == SCHEMA and facts["state"] in (UPLOADING, SENDING, SENT)
            and isinstance(facts["parameters"], dict)
            and all(isinstance(facts[key], str) for key in text)
            and all(isinstance(facts[key], (str, type(None))) for key in perhaps)
            and datetime.fromisoformat(facts["time"]).tzinfo is not None)


def _put(name, path, new):
    """Give the file `name` the name `path`. Raises Failure where it is to be new and is there."""
    if new:
        try:
            os.link(name, path)
            os.remove(name)
            return
        except FileExistsError:
            raise Failure(IO, AT_WORK.format(path)) from None
        except OSError:
            # A file system without links: two processes at one instant are not told apart there.
            pass
    os.replace(name, path)


def lock(stream, path):
    try:
        if fcntl is None:
            raise Failure(IO, NO_LOCKS)
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (Failure, OSError) as error:
        stream.close()
        raise error if fcntl is None else Failure(IO, AT_WORK.format(path)) from None


def path_of(output, digest):
    """The name of the job file for the samples file `output`; for no regular file, one here."""
    if output == "-" or os.path.exists(output) and not os.path.isfile(output):
        return f"qstereo-{digest.hex()[:12]}.qsf.job"
    return f"{os.path.realpath(output)}.job"


def _now():
    return datetime.now(timezone.utc).isoformat(timespec="seconds")


def was_sent(job):
    """Whether the service has the problem of a job; it is asked where the job does not know."""
    if job.state == SENDING:
        with connect(job.solver, job.service_solver, reading=True) as session:
            _find(session, job)
    return job.state == SENT


def send(job, kind, options, session, progress):
    """Create the problem of `kind` at the service, with a new label in the file of the job.

    One request does it, which is never repeated once it may have arrived. Raises SolverError.
    """
    digest = kind.problem.digest.hex()
    problem = None if options.problem == "-" else os.path.relpath(
        options.problem, os.path.dirname(job.path) or ".")
    # What a service might change in it is left out; the last word is no other job's.
    words = re.sub(r"[^A-Za-z0-9._ -]", "_", " ".join((options.label or "").split())).split()
    label = " ".join(words)[:100].strip() or "qstereo"
    job.facts, job.session = {
        "schema": SCHEMA, "state": UPLOADING, "solver": options.solver, "problem_id": None,
        "service_solver": session.solver.name, "user_label": options.label, "problem": problem,
        "label": f"{label} {digest[:8]}-{secrets.token_hex(6)}", "problem_digest": digest,
        "variables": kind.problem.linear.size, "time": _now(), "parameters": {},
        "window": bool(getattr(options, "windows", None))}, session
    job.save()
    if refusal := kind.refusal(session.properties):
        raise SolverError(refusal)
    request = kind.prepare(session, progress)
    job.save(parameters=request.parameters, **request.facts)
    with request.upload or contextlib.nullcontext() as file:
        data = request.data or {"format": "ref", "data": _upload(session, file, progress)}
    progress("sending")
    _create(job, session, {"data": data, "params": plain(request.sent), "label": job.label,
                           "type": kind.problem_type, "solver": session.solver.identity})


def _upload(session, data, progress):
    """Upload a binary file; the service's name for it. It is free, so a failure is tried again."""
    from dwave.cloud.exceptions import ProblemUploadError

    for last in (False, True):
        future = session.client.upload_problem_encoded(data)
        while not concurrent.futures.wait([future], 0.2).done:
            progress("uploading")
        if last or not isinstance(future.exception(), ProblemUploadError):
            return future.result()


def _create(job, session, problem):
    from dwave.cloud.api.models import ProblemJob
    from requests import TooManyRedirects

    with session.requests() as requests:
        problem = ProblemJob(**problem)
        job.save(state=SENDING, time=_now(), account=session.account(job.label))
        try:
            reply, = requests.submit_problems([problem])
            refusal = getattr(reply, "error_msg", None)
            if refusal is None and not _is_label_of(job, reply.label):
                raise ValueError("the service's reply is about another problem")
        except TooManyRedirects as error:
            job.remove()
            raise SolverError(f"D-Wave's endpoint has moved to "
                              f"{line(error.response.headers['Location'])}; nothing was sent. Set "
                              "the endpoint in D-Wave's configuration") from None
        except Exception as error:
            if _never_arrived(error):
                job.remove()
                raise
            if _find(session, job):
                return
            raise
    if refusal is not None:
        job.remove()
        raise SolverError(f"D-Wave's service refuses the problem: {line(refusal)}")
    # Known, whatever the disk makes of it.
    job.facts.update(state=SENT, problem_id=reply.id)
    job.save()


def _never_arrived(error):
    """Whether the service refused a request that failed so, or was not there."""
    from dwave.cloud.utils.exception import is_caused_by
    from urllib3.exceptions import ConnectTimeoutError, NewConnectionError

    return getattr(error, "error_code", None) in REFUSALS or is_caused_by(
        error, (NewConnectionError, ConnectTimeoutError))


def _find(session, job):
    """Ask the service for the problem of the job's label: whether it is there. If so the job knows
    its id afterwards. A request that has only just left may still arrive: it is asked again until
    the request is old enough."""
    age = (datetime.now(timezone.utc) - datetime.fromisoformat(job.time)).total_seconds()
    # Clocks may differ: by this one it may have left in the future, or long ago.
    stop = time.monotonic() + max(sum(PAUSES), min(ARRIVED, ARRIVED - age))
    while True:
        with session.requests() as requests:
            listed = _patiently(lambda: requests.list_problems(label=job.label))
        if found := [problem for problem in listed if _is_label_of(job, problem.label)]:
            job.save(state=SENT, problem_id=found[0].id)
            return True
        if time.monotonic() > stop:
            break
        time.sleep(0.5)
    if job.facts.get("account") not in (None, session.account(job.label)):
        raise SolverError("the problem may have been sent with another token or to another "
                          "endpoint than are configured now, and these know nothing of it; with "
                          f"those that sent it, {job.command} finds it")
    return False


def _is_label_of(job, label):
    """By its last word, which no other job has; a service may tidy up the words before it."""
    return (label or "").split()[-1:] == job.label.split()[-1:]


def _patiently(ask):
    """ask(), again after a pause where the service is in trouble. For what changes nothing."""
    for pause in (*PAUSES, None):
        try:
            return ask()
        except Exception as error:
            status, names = (getattr(error, "error_code", None),
                             {cls.__name__ for cls in type(error).__mro__})
            passing = status == 429 or status >= 500 if isinstance(status, int) else names & {
                "RequestTimeout", "ConnectionError", "ChunkedEncodingError", "RetryError"}
            if pause is None or not passing:
                raise
            time.sleep(pause)


def _status(job, requests):
    # D-Wave's client asks no more where the list of problems has nothing of it.
    found = _patiently(lambda: requests.get_problem_statuses([job.problem_id])) or [
        _patiently(lambda: requests.get_problem(job.problem_id))]
    return found[0].status.value


def fetch(session, job, kind, progress, once=False):
    """The Answer to a problem that was sent. With `once`, Failure(NO) where there is none yet."""
    job.session, pause = session, 0.05
    with session.requests() as requests:
        while (status := _status(job, requests)) in RUNNING:
            if once:
                raise Failure(NO, f"{job.path}: there is no answer yet")
            progress(status.lower().replace("_", " "))
            time.sleep(pause)
            pause = min(1.3 * pause, LAZIEST)
    future = _patiently(lambda: _answer(session, job))
    if future.label is not None and not _is_label_of(job, future.label):
        raise SolverError(f"the service's problem {job.problem_id} has the label "
                          f"{line(str(future.label))!r}, the job {job.label!r}: it is the answer "
                          "to another problem")
    try:
        answer = kind.decode(future, job)
    except Exception as error:
        raise error if isinstance(error, SolverError) else SolverError(
            f"the service's answer cannot be read ({explain(error)})") from None
    label = {"label": job.user_label} if job.user_label else {}
    answer.info = {"service_solver": job.service_solver, "problem_id": job.problem_id,
                   "parameters": {**job.parameters, **label}, **answer.info}
    return answer


def _answer(session, job):
    """A resolved Future of D-Wave's client."""
    future = session.client.retrieve_answer(job.problem_id)
    future.wait()
    if future.remote_status in ("FAILED", "CANCELLED"):
        job.remove()
    future.result()
    return future


def interrupted(cancel):
    """What the user is to know of each job when a signal ends the command; with `cancel`, what has
    not begun is cancelled first."""
    said, jobs = [], list(Job.active)
    cancelled = _cancelled([job for job in jobs if job.state == SENT]) if cancel else []
    for job in jobs:
        if job.state == UPLOADING or job in cancelled:
            job.remove()
        said.append(shown(
            "nothing was sent" if job.state == UPLOADING else
            f"{job.problem_id} had not begun and is cancelled; nothing is charged"
            if job in cancelled else HINTS[job.state].format(job.command)))
    return said


def _cancelled(jobs):
    """Ask the service to cancel those of the jobs that have not begun: those that certainly are
    cancelled by the deadline."""
    stop, cancelled, asked = time.monotonic() + DEADLINE, [], []

    def ask():
        for job in jobs:
            # What fails is not repeated: the problem may go on, and can be collected.
            with (contextlib.suppress(Exception),
                  job.session.requests(timeout=DEADLINE, retry=0) as requests):
                if requests.get_problem_status(job.problem_id).status.value == "PENDING":
                    requests.cancel_problem(job.problem_id)
                    if requests.get_problem_status(job.problem_id).status.value == "CANCELLED":
                        cancelled.append(job)
        asked.append(True)
    # Threads of Python's own want locks that the interrupted code may hold.
    _thread.start_new_thread(ask, ())
    while not asked and time.monotonic() < stop:
        time.sleep(0.02)
    return list(cancelled)
