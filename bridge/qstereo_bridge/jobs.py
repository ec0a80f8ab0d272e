"""The life of a problem at D-Wave's service: sent once, found again after any interruption, never
charged twice.

A job file (JSON, without a token) lies beside the samples file until the samples are written. Its
`state` says how far the problem is:

    uploading   nothing is charged yet: it may be sent again
    sending     the one request that creates the problem may have left: the service is asked for the
                job's label, which no other job has
    sent        the service has the problem, under `problem_id`

The file is replaced as a whole, on the disk before the next step is taken, and locked while its
process lives.
"""

import _thread
import concurrent.futures
import contextlib
import json
import os
import re
import secrets
import time
import zlib
from datetime import datetime, timezone

from .failure import BAD_INPUT, IO, NO, Failure, SolverError, io
from .output import sync_folder, temporary
from .qsf import plain
from .services import connect, explain
from .text import line, shown

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
# Seconds until the service is asked what became of a problem: D-Wave's client may ask no more.
SILENCE = 60
# Replies that say that the service did not take the problem. Others, as 408 and 499, may be of a
# gateway that knows nothing.
REFUSALS = (400, 401, 402, 403, 404, 413, 422, 429)
# Seconds that Ctrl-C takes at most for the cancellations.
DEADLINE = 6
RUNNING = ("PENDING", "IN_PROGRESS")
AT_WORK = "{}: another qstereo-bridge is at work on this job; wait for it, or stop it"
NO_LOCKS = ("locks on files keep a problem from being charged twice; this system has none. Use "
            "Linux, macOS or another Unix; on Windows run qstereo-bridge in WSL. Nothing was sent")


class Job:
    """One job file, held open and locked. Each of its `facts` is an attribute, too; `session` is
    what serves it, for signals to use."""

    active = []

    def __init__(self, path, facts, stream=None):
        self.path, self.facts, self.stream, self.session = path, facts, stream, None

    @classmethod
    def load(cls, path, whatever=False):
        """The job in the file `path`, or None where there is none. Raises Failure: another process
        has it, or it is no job file, which `whatever` allows as it is to be replaced."""
        with io(path, "read"):
            while True:
                try:
                    stream = open(path, "rb+")
                    lock(stream, path)
                    # It may have been replaced or removed, and let go, since it was opened.
                    if os.path.samestat(os.fstat(stream.fileno()), os.stat(path)):
                        break
                    stream.close()
                except FileNotFoundError:
                    return None
            job = cls(path, {"state": UPLOADING}, stream)
            with contextlib.suppress(ValueError, KeyError, TypeError, RecursionError):
                facts = json.load(stream)
                if _sound(facts):
                    job.facts = facts
                    return job
        if whatever:
            return job
        job.leave()
        raise Failure(BAD_INPUT, f"{path}: this is not a job file of this version; give "
                                 "another, or remove it")

    def save(self, new=False, **changes):
        """Change facts, and have them on the disk. `new`: there must be no such file yet."""
        self.facts.update(changes)
        with io(self.path, "write"), temporary(self.path) as (name, stream):
            lock(stream, name)
            stream.write(json.dumps(self.facts, indent=1).encode() + b"\n")
            stream.flush()
            os.fsync(stream.fileno())
            _put(name, self.path, new)
            sync_folder(self.path)
        if self.stream:
            self.stream.close()
        self.stream = stream
        if self not in Job.active:
            Job.active.append(self)

    def leave(self):
        """Let go of the file; it stays."""
        if self in Job.active:
            Job.active.remove(self)
        if self.stream:
            self.stream.close()
            self.stream = None

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

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.leave()


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


def check_earlier(options):
    """An earlier Job of the samples file that may be forgotten, held until another takes its place;
    None where there is none. Raises Failure(NO) where it may be at the service."""
    earlier = Job.load(path_of(options.output, options.digest), whatever=options.resubmit)
    if earlier is None or earlier.state == UPLOADING or options.resubmit:
        return earlier
    with contextlib.ExitStack() as held:
        held.enter_context(earlier)
        if earlier.problem_digest != options.digest.hex():
            raise Failure(NO, f"{earlier.path}: the answer to another problem ({earlier.problem}) "
                              f"is still to be collected under this name; {earlier.command}, or "
                              "give another -o, or --resubmit to forget it")
        if was_sent(earlier):
            raise Failure(NO, f"{earlier.path}: this problem was sent {earlier.time} and is not "
                              f"sent again; {earlier.command} fetches the answer (--resubmit sends "
                              "and charges it once more)")
        held.pop_all()
    return earlier


def was_sent(job):
    """Whether the service has the problem of a job; it is asked where the job does not know."""
    if job.state == SENDING:
        with connect(job.solver, job.service_solver, reading=True) as session:
            find(session, job)
    return job.state == SENT


def start(options, variables, earlier=None):
    """A new Job for the problem, in place of an `earlier` one that is held."""
    path, digest = path_of(options.output, options.digest), options.digest.hex()
    problem = None if options.problem == "-" else os.path.relpath(options.problem,
                                                                  os.path.dirname(path) or ".")
    # What a service might change in it is left out; the last word is no other job's.
    words = re.sub(r"[^A-Za-z0-9._ -]", "_", " ".join((options.label or "").split())).split()
    label = " ".join(words)[:100].strip() or "qstereo"
    job = earlier or Job(path, {})
    job.facts = {"schema": SCHEMA, "state": UPLOADING, "solver": options.solver,
                 "service_solver": None, "user_label": options.label, "problem_id": None,
                 "label": f"{label} {digest[:8]}-{secrets.token_hex(6)}", "problem": problem,
                 "problem_digest": digest, "variables": variables, "time": _now(),
                 "parameters": {}, "window": bool(getattr(options, "windows", None))}
    job.save(new=earlier is None)
    return job


def _now():
    return datetime.now(timezone.utc).isoformat(timespec="seconds")


@contextlib.contextmanager
def keeping(job):
    """Remove the job when the answer is on the disk; where that fails, say how to fetch it."""
    with job:
        try:
            yield
        except SolverError as error:
            raise SolverError(f"{error}; {job.command} asks again") from None
        except Failure as failure:
            raise Failure(failure.status, f"{failure}; {job.command} fetches the answer again, -o "
                                          "writes it elsewhere") from None
        job.remove()


def solve(kind, options, progress, session, earlier=None):
    """Send the problem of `kind` and wait for its answer: (Answer, None with --no-wait; Job).

    The caller removes the job when the answer is on the disk. Where this fails, the job file is
    gone if nothing was sent.
    """
    job = start(options, kind.problem.linear.size, earlier)
    job.session = session
    try:
        if refusal := kind.refusal(session.properties):
            raise SolverError(refusal)
        request = kind.prepare(session, progress)
        job.save(service_solver=session.solver.name, parameters=request.parameters, **request.facts)
        with request.upload or contextlib.nullcontext() as file:
            data = request.data if file is None else {
                "format": "ref", "data": upload(session, file, progress)}
        progress("sending")
        send(session, job, kind.problem_type, data, request.sent)
        return None if options.no_wait else decoded(kind, wait(session, job, progress), job), job
    except BaseException:
        if job.state == UPLOADING:
            job.remove()
        job.leave()
        raise


def decoded(kind, future, job):
    """The Answer in a resolved Future. Raises SolverError for one that cannot be."""
    try:
        answer = kind.decode(future, job)
    except Exception as error:
        why = (error if isinstance(error, SolverError) else
               f"the service's answer cannot be read ({explain(error)})")
        raise SolverError(f"{why}; {job.command} asks for it again") from None
    label = {"label": job.user_label} if job.user_label else {}
    answer.info = {"service_solver": job.service_solver, "problem_id": job.problem_id,
                   "parameters": {**job.parameters, **label}, **answer.info}
    return answer


def upload(session, data, progress):
    """Upload a binary file; the service's name for it. It is free, so a failure is tried again."""
    from dwave.cloud.exceptions import ProblemUploadError

    for last in (False, True):
        future = session.client.upload_problem_encoded(data)
        while not concurrent.futures.wait([future], 0.2).done:
            progress("uploading")
        if last or not isinstance(future.exception(), ProblemUploadError):
            return future.result()


def send(session, job, problem_type, data, parameters):
    """Create the problem: one request, never repeated once it may have arrived. Raises SolverError.
    """
    from requests import TooManyRedirects

    body = {"solver": session.solver.identity.dict(), "data": data, "type": problem_type,
            "params": parameters, "label": job.label}
    content = zlib.compress(json.dumps([plain(body)]).encode())
    with session.requests() as requests:
        post = requests.session
        post.set_accept(media_type="application/vnd.dwave.sapi.problems+json", ask_version="3.0.0",
                        accept_version="~=3.0")
        job.save(state=SENDING, time=_now(), account=session.account(job.label))
        try:
            # A redirected POST would become a GET of the account's problems, or take the token
            # elsewhere.
            reply = json.loads(post.post("", data=content, allow_redirects=False, headers={
                "Content-Type": "application/json", "Content-Encoding": "deflate"}).content)[0]
            if "error_msg" not in reply and not (isinstance(reply["id"], str)
                                                 and _is_label_of(job, reply["label"])):
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
            return _find_after(error, session, job)
    if "error_msg" in reply:
        job.remove()
        raise SolverError(f"D-Wave's service refuses the problem: {line(str(reply['error_msg']))}")
    try:
        job.save(state=SENT, problem_id=reply["id"])
    except Failure as failure:
        raise Failure(failure.status, f"{failure}. The problem is at the service as "
                      f"{line(reply['id'])}; {job.command} finds it by its label") from None


def _never_arrived(error):
    """Whether the service refused a request that failed so, or was not there."""
    from dwave.cloud.utils.exception import is_caused_by
    from urllib3.exceptions import ConnectTimeoutError, NewConnectionError

    return getattr(error, "error_code", None) in REFUSALS or is_caused_by(
        error, (NewConnectionError, ConnectTimeoutError))


def _find_after(error, session, job):
    """find() the problem of a request whose reply is no good. Raises SolverError."""
    try:
        if find(session, job, patience=sum(PAUSES)):
            return
    except Failure:
        raise
    except Exception as trouble:
        error = trouble
    raise SolverError(f"{explain(error)}. Whether the problem arrived is not known; {job.command} "
                      "asks again, and nothing is sent twice") from None


def find(session, job, patience=None):
    """Ask the service for the problem of the job's label: whether it is there. If so the job knows
    its id afterwards. A request that has only just left may still arrive: it is asked again until
    the request is old enough, or for `patience` seconds."""
    age = (datetime.now(timezone.utc) - datetime.fromisoformat(job.time)).total_seconds()
    # Clocks may differ: by this one it may have left in the future, or long ago.
    enough = max(sum(PAUSES), min(ARRIVED, ARRIVED - age))
    stop = time.monotonic() + (enough if patience is None else patience)
    while True:
        with session.requests() as requests:
            listed = _patiently(lambda: requests.list_problems(label=job.label))
            found = [problem for problem in listed if _is_label_of(job, problem.label)]
        if found:
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


def wait(session, job, progress, once=False):
    """The answer to a problem that was sent, as a resolved Future of D-Wave's client. With `once`,
    None where there is none yet."""
    try:
        future = _patiently(lambda: _answer(session, job, progress, once))
    except Exception as error:
        raise SolverError(_told(job, error)) from None
    if future and future.label is not None and not _is_label_of(job, future.label):
        raise SolverError(f"the service's problem {job.problem_id} has the label "
                          f"{line(str(future.label))!r}, the job {job.label!r}: it is the answer "
                          "to another problem")
    return future


def _answer(session, job, progress, once):
    def fetched():
        future = session.client.retrieve_answer(job.problem_id)
        # The client would look for a solver of the same working graph, which a calibration since
        # then has changed.
        future.solver = session.solver
        return future

    def running():
        with session.requests() as requests:
            return any(problem.status.value in RUNNING
                       for problem in requests.get_problem_statuses([job.problem_id]))
    if once and running():
        return None
    future, stop = fetched(), time.monotonic() + SILENCE
    while not future.wait(0.2):
        progress((future.remote_status or "sent").lower().replace("_", " "))
        if time.monotonic() > stop:
            # Where the list has nothing, the client had nothing either, and asks no more.
            if future.remote_status in (None, *RUNNING) and not _patiently(running):
                future = fetched()
            stop = time.monotonic() + SILENCE
    if future.remote_status in ("FAILED", "CANCELLED"):
        job.remove()
    future.result()
    return future


def _told(job, error):
    if job.stream is None:
        return explain(error)
    if getattr(error, "error_code", None) == 404:
        return (f"D-Wave's service does not know problem {job.problem_id} ({line(str(error))}): it "
                "has expired, or belongs to another project or region than the one configured. "
                f"Where it is known {job.command} fetches the answer; `qstereo-bridge solve "
                "--resubmit` sends and charges it once more")
    said = str(error) if isinstance(error, SolverError) else explain(error)
    return f"{said}. The problem is at the service; {job.command} fetches the answer later"


def interrupted(cancel):
    """What the user is to know of each job when a signal ends the command; with `cancel`, what has
    not begun is cancelled first."""
    lines, found = [], list(Job.active)
    cancelled = _cancelled([job for job in found if job.state == SENT]) if cancel else []
    for job in found:
        if job.state == UPLOADING or job in cancelled:
            job.remove()
            lines.append("nothing was sent" if job.state == UPLOADING else
                         f"{job.problem_id} had not begun and is cancelled; nothing is charged")
        else:
            what = ("the problem is at the service" if job.state == SENT else
                    "whether the problem arrived is not known")
            lines.append(f"{what}; {job.command} fetches the answer")
    return list(map(shown, lines))


def _cancelled(found):
    """Ask the service to cancel those of the jobs that have not begun: those that certainly are
    cancelled by the deadline."""
    stop, cancelled, left = time.monotonic() + DEADLINE, [], list(found)

    def cancel(job):
        # What fails is not repeated: the problem may go on, and can be collected.
        with (contextlib.suppress(Exception),
              job.session.requests(timeout=DEADLINE, retry=0) as requests):
            if requests.get_problem_status(job.problem_id).status.value == "PENDING":
                requests.cancel_problem(job.problem_id)
                if requests.get_problem_status(job.problem_id).status.value == "CANCELLED":
                    cancelled.append(job)
        left.remove(job)
    for job in found:
        # Threads of Python's own want locks that the interrupted code may hold.
        _thread.start_new_thread(cancel, (job,))
    while left and time.monotonic() < stop:
        time.sleep(0.02)
    return list(cancelled)
