"""The way to D-Wave's services: the user's account and its solvers, errors in one sentence, and no token in anything that is written.

Nothing of Ocean is imported until a service is used.
"""

import contextlib
import hashlib
import os
import re

import numpy as np

from .container import FormatError
from .failure import Failure
from .solvers import SolverError

CONFIGURE = ("set up your account with `dwave config create`, or put your token into the environment variable "
             "DWAVE_API_TOKEN")


def _hybrid(model):
    return {"hybrid": True, "supported_problem_types__contains": model, "order_by": "-properties.version"}


# Which solver of the account is taken, unless the user names one: the choices of Ocean's own samplers.
WANTED = {"qpu": {"qpu": True, "order_by": "-num_active_qubits"}, "hybrid-bqm": _hybrid("bqm"), "hybrid-cqm": _hybrid("cqm"),
          "hybrid-nl": _hybrid("nl")}
PROBLEM_TYPES = {"qpu": "ising", "hybrid-bqm": "bqm", "hybrid-cqm": "cqm", "hybrid-nl": "nl"}


class Session:
    """One client of D-Wave's, and the solver that it found for `name`; several problems may share it, each in a thread of its own.

    reading         only answers are read: the solver is not asked for, it may be offline, or gone
    properties      the solver's own, as the service gives them: its limits among them
    """

    def __init__(self, name, solver_name=None, reading=False):
        from dwave.cloud import Client

        self.name = name
        # Connections that are not kept: Ocean's samplers found long uploads to be cut otherwise.
        given = {"solver": solver_name} if solver_name else {}
        self.client = Client.from_config(client="qpu" if name == "qpu" else "hybrid", connection_close=name != "qpu",
                                         defaults={"solver": WANTED[name]}, **given)
        try:
            self.solver = _reader(self.client, name, solver_name) if reading else self.client.get_solver()
            if PROBLEM_TYPES[name] not in self.solver.supported_problem_types:
                raise SolverError(f"{self.solver.name} is no solver for {name}; name another with --solver-name, "
                                  "`qstereo-bridge solvers` lists those that you reach")
        except BaseException:
            self.close()
            raise
        self.properties = self.solver.properties

    def requests(self, timeout=None, retry=3):
        """The service's list of problems. Of its requests only those are repeated that never found a connection."""
        from dwave.cloud.api.resources import Problems

        retry = {"total": retry, "connect": retry, "read": 0, "status": 0, "other": 0, "redirect": 0, "backoff_factor": 0.5,
                 "respect_retry_after_header": False}
        problems = Problems.from_config(self.client.config, retry=retry, timeout=timeout or self.client.config.request_timeout)
        # The token is for this endpoint alone.
        problems.session.max_redirects = 0
        return problems

    def account(self, salt):
        """What tells one account from another and says nothing of either: whose list of problems it is."""
        config = self.client.config
        return hashlib.sha256(f"{salt}\n{config.endpoint}\n{config.token}".encode()).hexdigest()[:16]

    def close(self):
        self.client.close(wait=False)


def _reader(client, name, solver_name):
    """A solver that reads answers of the kind `name`, for which the client wants none of a real one's properties."""
    from dwave.cloud import solver

    kind = {"qpu": solver.StructuredSolver, "hybrid-bqm": solver.BQMSolver, "hybrid-cqm": solver.CQMSolver, "hybrid-nl": solver.NLSolver}
    properties = {"supported_problem_types": [PROBLEM_TYPES[name]], "qubits": [], "couplers": []}
    return kind[name](client, {"identity": {"name": solver_name or name}, "properties": properties})


@contextlib.contextmanager
def connect(name, solver_name=None, reading=False):
    """A Session in the user's own configuration; whatever goes wrong in its use becomes a SolverError without a token in it."""
    with explained(), contextlib.closing(Session(name, solver_name, reading)) as session:
        yield session


@contextlib.contextmanager
def explained():
    """Ocean, its HTTP client and the service raise dozens of types; the user needs one sentence."""
    try:
        yield
    except (Failure, FormatError, MemoryError, SolverError):
        raise
    except Exception as error:
        raise SolverError(explain(error)) from None


def configured():
    """Whether there is an account to ask: a token in the environment, or one of the places of D-Wave's configuration file."""
    if os.environ.get("DWAVE_API_TOKEN"):
        return True
    named = os.environ.get("DWAVE_CONFIG_FILE")
    home = os.environ.get("XDG_CONFIG_HOME") or os.path.expanduser("~/.config")
    places = [named] if named else ["dwave.conf", f"{home}/dwave/dwave.conf", "/etc/xdg/dwave/dwave.conf"]
    return any(map(os.path.isfile, places))


def scrub(text):
    """`text` without the user's token and without anything that looks like one."""
    tokens = {os.environ.get("DWAVE_API_TOKEN")}
    with contextlib.suppress(Exception):
        # Of all profiles: which of them was used is not known here.
        from dwave.cloud.config.loaders import load_config_from_files
        named = os.environ.get("DWAVE_CONFIG_FILE")
        config = load_config_from_files([named] if named else None)
        tokens |= {config[section].get("token") for section in config}
    for token in sorted(filter(None, tokens), key=len, reverse=True):
        text = text.replace(token, "(token)")
    return re.sub(r"\b[A-Za-z]{2,8}-[0-9a-f]{32,}\b", "(token)", text)


# By names of classes, so that nothing has to be imported to say them; the first that fits is said.
SENTENCES = [
    ({"ConfigFileError"}, "D-Wave's configuration file cannot be used ({}); " + CONFIGURE),
    ({"SolverAuthenticationError", "ResourceAuthenticationError"}, "D-Wave does not accept the token ({}); " + CONFIGURE),
    ({"ResourceAccessForbiddenError"}, "D-Wave refuses it to this account ({}); see your project's rights and quota"),
    ({"ResourceLimitsExceededError"}, "D-Wave has too many requests of this account, or its quota is used up ({}); try again later"),
    ({"SolverNotFoundError"}, "your D-Wave account reaches no such solver ({}); `qstereo-bridge solvers` lists those it reaches"),
    ({"SolverOfflineError"}, "the solver is offline ({}); try again later, or name another with --solver-name"),
    ({"CanceledFutureError"}, "the problem was cancelled at the service"),
    ({"InternalServerError"}, "D-Wave's service has an error of its own ({}); try again later"),
    ({"RetryError"}, "D-Wave's service is overloaded, or has too many requests of this account ({}); try again later"),
    ({"TooManyRedirects"}, "D-Wave's endpoint has moved ({}); set the endpoint in D-Wave's configuration"),
    ({"RequestTimeout", "PollingTimeout", "Timeout", "ConnectionError", "ProblemUploadError"},
     "D-Wave's service cannot be reached or does not answer ({}); check the network and try again"),
    ({"ImportError"}, "a part of D-Wave's Ocean tools is missing ({}); pip install dwave-system"),
]
OF_STATUS = {401: "ResourceAuthenticationError", 403: "ResourceAccessForbiddenError", 429: "ResourceLimitsExceededError"}


def explain(error):
    """One sentence for whatever a service or its client raised; without a token."""
    names = {cls.__name__ for cls in type(error).__mro__}
    if "ProblemUploadError" in names and error.__cause__:
        return explain(error.__cause__)
    status = getattr(error, "error_code", None)
    if isinstance(status, int):
        names.add("InternalServerError" if status >= 500 else OF_STATUS.get(status, ""))
    said = " ".join(scrub(str(error)).split()) or type(error).__name__
    if "API token not defined" in said:
        return f"no D-Wave account is configured; {CONFIGURE}"
    for classes, sentence in SENTENCES:
        if names & classes:
            return sentence.format(said)
    if names & {"SolverFailureError", "SolverError", "RequestError"}:
        return f"D-Wave's service says: {said}"
    return f"{type(error).__name__}: {said}"


def plain(value):
    """`value` as JSON can hold it: numpy's numbers and arrays as Python's, what is unknown as text."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, set, np.ndarray)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value if value is None or isinstance(value, (bool, int, float, str)) else str(value)


def given(**parameters):
    """Those of the parameters that are not None."""
    return {key: value for key, value in parameters.items() if value is not None}
