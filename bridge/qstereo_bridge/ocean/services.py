"""The way to D-Wave's services: the user's account and its solvers, and errors in one sentence."""

import contextlib
import hashlib
import ipaddress
import os
from urllib.parse import urlsplit

from ..core import text
from ..core.failure import Error, SolverError

CONFIGURE = ("set up your account with `dwave config create`, or put your token into the "
             "environment variable DWAVE_API_TOKEN")
NO_ACCOUNT = f"no D-Wave account is configured; {CONFIGURE}"
# Set to 1, this lets a token travel in plain text to another machine than this one.
PLAIN_HTTP = "QSTEREO_PLAIN_HTTP"
# Bytes that one reply may unpack to: far more than any answer that a .qsf could hold.
LARGEST_REPLY = 1 << 30
# Which solver of the account is taken, unless the user names one: as Ocean's own samplers choose.
WANTED = {"qpu": {"qpu": True, "order_by": "-num_active_qubits"}, **{
    f"hybrid-{model}": {"hybrid": True, "supported_problem_types__contains": model,
                        "order_by": "-properties.version"} for model in ("bqm", "cqm", "nl")}}
# D-Wave's users know the nonlinear solver by this name.
NAMES = {"hybrid-nl": "hybrid-nl (Stride)"}


class NoAccount(SolverError):
    """Nothing says which account to use."""


class Session:
    """A client of D-Wave's, and the `solver` that it found for `name`. With `reading` only answers
    are read: the solver is not asked for, it may be offline, or gone."""

    def __init__(self, name, solver_name=None, reading=False):
        # Connections that are not kept: Ocean's samplers found long uploads to be cut otherwise.
        self.client = client("qpu" if name == "qpu" else "hybrid", WANTED[name], solver_name,
                             connection_close=name != "qpu")
        kind = "ising" if name == "qpu" else name.removeprefix("hybrid-")
        try:
            self.solver = (_reader(self.client, kind, solver_name or name) if reading
                           else self.client.get_solver())
            if kind not in self.solver.supported_problem_types:
                raise SolverError(f"{text.line(self.solver.name)} is not a solver for {name}; name "
                                  "another with --solver-name, `qstereo-bridge solvers` lists "
                                  "those that you reach")
        except BaseException:
            self.close()
            raise
        self.properties = self.solver.properties
        # With an answer a thread of the client looks for the solver that the answer names. It may
        # be offline, gone, or calibrated since then, which gives it another name.
        self.client.get_solver = lambda **named: self.solver

    def requests(self, timeout=None, retry=3):
        """The service's list of problems. Of its requests only those are repeated that never found
        a connection."""
        from dwave.cloud.api.resources import Problems

        config = self.client.config
        problems = Problems.from_config(
            config, timeout=timeout or config.request_timeout,
            retry={"total": retry, "connect": retry, "read": 0, "status": 0, "other": 0,
                   "redirect": 0, "backoff_factor": 0.5, "respect_retry_after_header": False})
        # The token is for this endpoint alone.
        problems.session.max_redirects = 0
        bounded(problems.session)
        return problems

    def account(self, salt):
        """What tells one account from another and says nothing of either."""
        told = f"{salt}\n{self.client.config.endpoint}\n{self.client.config.token}"
        return hashlib.sha256(told.encode()).hexdigest()[:16]

    def close(self):
        self.client.close(wait=False)


def client(kind="base", wanted=None, solver_name=None, **options):
    """A client of D-Wave's, of its kind "base", "qpu" or "hybrid", with the user's configuration.
    Raises SolverError for a configuration that cannot be meant."""
    # An account that there is not is told of before anything large is imported.
    configured = configuration()
    from dwave.cloud.client import base, hybrid, qpu

    parent = {"base": base, "qpu": qpu, "hybrid": hybrid}[kind].Client
    made = type("Client", (parent,), {
        "create_session": lambda self: bounded(parent.create_session(self))})
    named = {"solver": solver_name} if solver_name else {}
    return made.from_config(client="base", defaults={"solver": wanted} if wanted else {},
                            **configured, **named, **options)


def configuration():
    """Token and, where it has one, endpoint of the user's configuration. Raises NoAccount, and
    SolverError for a configuration that cannot be meant."""
    from dwave.cloud.config import load_config

    hide_tokens()
    config = load_config()
    found = {key: config[key].strip() for key in ("token", "endpoint") if config.get(key)}
    if "token" not in config:
        raise NoAccount(NO_ACCOUNT)
    if not found.get("token"):
        raise SolverError(f"the token of your D-Wave account is empty; {CONFIGURE}")
    scheme, place = found.get("endpoint", "https://").partition("://")[::2]
    said = f"D-Wave's endpoint {text.line(found.get('endpoint', ''))}"
    if scheme not in ("http", "https"):
        raise SolverError(f"{said} does not begin with https://; set it so in D-Wave's "
                          "configuration")
    if scheme == "http" and not _loopback(place) and os.environ.get(PLAIN_HTTP) != "1":
        raise SolverError(f"{said} is plain http: anyone on the way could read your token. Use "
                          f"https://, or allow it with the environment variable {PLAIN_HTTP}=1")
    return found


def _loopback(place):
    try:
        host = urlsplit(f"//{place}").hostname
        return host == "localhost" or ipaddress.ip_address(host or "").is_loopback
    except ValueError:
        return False


def hide_tokens():
    """No message holds a token of any profile: which of them was used is not known later."""
    with contextlib.suppress(Exception):
        from dwave.cloud.config.loaders import load_config_from_files

        named = os.environ.get("DWAVE_CONFIG_FILE")
        config = load_config_from_files([named] if named else None)
        text.hide(config[section].get("token") for section in config)


def bounded(session):
    """A session of requests none of whose replies grows beyond LARGEST_REPLY: a few compressed
    bytes may unpack to more than any machine holds."""
    def bound(response, **options):
        stream = response.raw.stream

        def limited(*arguments, **options):
            size = 0
            for part in stream(*arguments, **options):
                size += len(part)
                if size > LARGEST_REPLY:
                    raise SolverError("the service's reply is too large: it unpacks to more than "
                                      f"{LARGEST_REPLY >> 20:,} MiB")
                yield part
        response.raw.stream = limited
    session.hooks["response"].insert(0, bound)
    return session


def _reader(client, kind, name):
    """A solver that reads answers, for which the client wants none of a real one's properties."""
    from dwave.cloud import solver

    made = {"ising": solver.StructuredSolver, "bqm": solver.BQMSolver, "cqm": solver.CQMSolver,
            "nl": solver.NLSolver}[kind]
    return made(client, {"identity": {"name": name}, "properties": {
        "supported_problem_types": [kind], "qubits": [], "couplers": []}})


@contextlib.contextmanager
def connect(name, solver_name=None, reading=False):
    """A Session in the user's own configuration; what goes wrong in its use is a SolverError."""
    with explained(), contextlib.closing(Session(name, solver_name, reading)) as session:
        yield session


@contextlib.contextmanager
def explained():
    """Ocean, its HTTP client and the service raise dozens of types; the user needs a sentence."""
    try:
        yield
    except (Error, MemoryError):
        raise
    except Exception as error:
        raise SolverError(explain(error), getattr(error, "error_code", None)) from None


LATER = "({}); try again later"
# By names of classes, so that nothing has to be imported to say them; the first that fits is said.
SENTENCES = {
    "ConfigFileError UnicodeDecodeError":
        "D-Wave's configuration file cannot be used ({}); " + CONFIGURE,
    "SolverAuthenticationError ResourceAuthenticationError":
        "D-Wave does not accept the token ({}); " + CONFIGURE,
    "ResourceAccessForbiddenError":
        "D-Wave refuses it to this account ({}); see your project's rights and quota",
    "ResourceLimitsExceededError": "D-Wave has too many requests of this account, or its quota is "
                                   "used up " + LATER,
    "SolverNotFoundError": "your D-Wave account reaches no such solver ({}); `qstereo-bridge "
                           "solvers` lists those it reaches",
    "SolverOfflineError": "the solver is offline " + LATER + ", or name another with --solver-name",
    "CanceledFutureError": "the problem was cancelled at the service",
    "InternalServerError": "D-Wave's service has an error of its own " + LATER,
    "RetryError":
        "D-Wave's service is overloaded, or has too many requests of this account " + LATER,
    "TooManyRedirects":
        "D-Wave's endpoint has moved ({}); set the endpoint in D-Wave's configuration",
    "RequestTimeout PollingTimeout Timeout ConnectionError ProblemUploadError":
        "D-Wave's service cannot be reached or does not answer ({}); check the network and try "
        "again",
    "InvalidAPIResponseError ResourceBadResponseError ContentDecodingError ChunkedEncodingError "
    "JSONDecodeError": "D-Wave's service gave a reply that cannot be read " + LATER,
    "ImportError": "a part of D-Wave's Ocean tools is missing ({}); "
                   "in the project's folder: pip install './bridge[dwave]'",
    "SolverFailureError SolverError RequestError": "D-Wave's service says: {}"}
OF_STATUS = {401: "ResourceAuthenticationError", 403: "ResourceAccessForbiddenError",
             429: "ResourceLimitsExceededError"}


def explain(error):
    """One sentence for whatever a service or its client raised; without a token."""
    names = {cls.__name__ for cls in type(error).__mro__}
    if "ProblemUploadError" in names and error.__cause__:
        return explain(error.__cause__)
    status = getattr(error, "error_code", None)
    if isinstance(status, int):
        names.add("InternalServerError" if status >= 500 else OF_STATUS.get(status, ""))
    hide_tokens()
    said = text.line(str(error)) or type(error).__name__
    if "API token not defined" in said:
        return NO_ACCOUNT
    if "Config profile" in said:
        return f"{said}; `dwave config ls` and `dwave config inspect` show those that there are"
    return next((sentence.format(said) for classes, sentence in SENTENCES.items()
                 if names & set(classes.split())), f"{type(error).__name__}: {said}")


def given(**parameters):
    """Those of the parameters that are not None."""
    return {key: value for key, value in parameters.items() if value is not None}
