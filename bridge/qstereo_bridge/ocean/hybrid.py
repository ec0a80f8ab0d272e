"""D-Wave's hybrid solvers: what each takes of a Problem, its limits and least time, its answer.

A kind of solver is a class: `problem_type` is the service's word for it; refusal(properties) says
why a solver of these properties does not take the problem (None: it does); prepare(session,
progress) makes the Request; decode(future, job) reads the answer; plan(properties, solver) says
what would be sent, without an account by published properties and no `solver`.
"""

import functools
from dataclasses import dataclass, field

import numpy as np

from ..core import models
from ..core.answers import Answer, from_sampleset
from ..core.failure import SolverError
from ..core.qsf import plain
from .services import explain, given
from .upload import bqm_file

SMALLER = "take a smaller window (encode --roi), fewer labels, or what `qstereo reduce` leaves"
LARGER = "hybrid-nl takes larger ones; or " + SMALLER
# Solver properties as D-Wave published them in 2026, for --dry-run without an account.
PUBLISHED = {
    "qpu": {"chip_id": "Advantage2 (Zephyr Z12)", "qubits": range(4577),
            "num_reads_range": [1, 10_000]},
    "hybrid-bqm": {"maximum_number_of_variables": 1_000_000, "quota_conversion_rate": 20,
                   "maximum_number_of_biases": 200_000_000, "minimum_time_limit": [
                       [1, 3], [1024, 3], [4096, 10], [10_000, 40], [30_000, 200], [100_000, 600],
                       [1_000_000, 600]]},
    "hybrid-cqm": {"maximum_number_of_variables": 5_000_000, "quota_conversion_rate": 20,
                   "maximum_number_of_constraints": 100_000, "minimum_time_limit_s": 5,
                   "maximum_number_of_biases": 750_000_000, "num_variables_multiplier": 1.574e-4,
                   "num_biases_multiplier": 4.657e-6, "num_constraints_multiplier": 6.444e-9},
    "hybrid-nl": {"maximum_number_of_nodes": 2_000_000, "maximum_state_size": 750 << 20,
                  "maximum_decision_state_size": 50 << 20, "quota_conversion_rate": 20}}


@dataclass
class Request:
    """What is sent: the parameters as the service takes them (`sent`) and for the user to read; a
    file to `upload`, or the problem itself as `data`; `facts` that reading the answer needs."""

    sent: dict
    parameters: dict
    upload: object = None
    data: dict = None
    facts: dict = field(default_factory=dict)


class Hybrid:
    """What the hybrid solvers share. Each has

    limits          {what is counted: the property of the solver that limits it}
    sizes           {what is counted: how many}
    least_time(properties)      the least time limit in seconds
    upload_bytes(), file()      the size of the file that is uploaded, and that file
    """

    advice, penalties, objective = LARGER, True, False

    def __init__(self, problem, options):
        self.problem, self.options, self.n = problem, options, problem.linear.size

    @functools.cached_property
    def terms(self):
        """How many quadratic terms the model has that is sent."""
        return models.Terms(self.problem, self.penalties).count

    def refusal(self, properties):
        for what, limit in self.limits.items():
            if self.sizes[what] > properties.get(limit, np.inf):
                return (f"{self.sizes[what]:,} {what}, the service takes {properties[limit]:,}; "
                        f"{self.advice}")
        least, wanted = self.least_time(properties), self.options.time_limit
        most = 3600 * properties.get("maximum_time_limit_hrs", 1e6)
        if wanted is not None and not least <= wanted <= most:
            return (f"a time limit of {wanted:g} s, the service takes {least:,.1f} to {most:,.0f} "
                    "s for this problem")
        return None

    def prepare(self, session, progress):
        progress("building the model")
        parameters = {"time_limit": self.time_limit(session.properties)}
        return Request(parameters, parameters, upload=self.file())

    def time_limit(self, properties):
        return self.options.time_limit or float(self.least_time(properties))

    def plan(self, properties, solver=None):
        seconds, reason = self.time_limit(properties), self.refusal(properties)
        rate = properties.get("quota_conversion_rate")
        return {"variables": self.n, "quadratic_terms": self.terms, **self.sizes,
                "upload_bytes": self.upload_bytes(),
                "minimum_time_limit": float(self.least_time(properties)), "time_limit": seconds,
                "charge_seconds": seconds, "charge_qpu_seconds": seconds / rate if rate else None,
                "limits": {what: properties[limit] for what, limit in self.limits.items()
                           if limit in properties}, "fits": reason is None, "reason": reason}

    def decode(self, future, job):
        # Timing stands beside all else that they say; what problem and job say is left out.
        ours = ("problem_id", "problem_label", "problem_data_id", "constraint_labels")
        # A thread of the client may still be at the result: it adds to `info`, and only then is
        # future.sampleset there.
        sampleset = future.result()["sampleset"]
        said = {key: value for key, value in sampleset.info.copy().items() if key not in ours}
        timing = {key: said.pop(key) for key in list(said) if key.endswith("_time")}
        return from_sampleset(sampleset, self.n, objective=self.objective,
                              info=plain({"timing": timing, **said}))


class Bqm(Hybrid):
    """Penalties folded in."""

    problem_type = "bqm"
    limits = {"variables": "maximum_number_of_variables", "biases": "maximum_number_of_biases"}

    @property
    def sizes(self):
        return {"variables": self.n, "biases": self.n + self.terms}

    def least_time(self, properties):
        return np.interp(self.n, *zip(*properties["minimum_time_limit"]))

    def upload_bytes(self):
        # dimod's binary layout: linear terms of 12 bytes, each quadratic term twice at 12 bytes.
        return 200 + 12 * self.n + 24 * self.terms

    def file(self):
        return bqm_file(self.problem)


class Cqm(Hybrid):
    """One-hot groups as constraints, penalties dropped."""

    problem_type, penalties, objective = "cqm", False, True
    limits = {"variables": "maximum_number_of_variables",
              "constraints": "maximum_number_of_constraints", "biases": "maximum_number_of_biases"}

    @property
    def sizes(self):
        one_hot = self.problem.one_hot
        return {"variables": self.n, "constraints": int(one_hot.sum()),
                "biases": self.n + self.terms + int(self.problem.sizes[one_hot].sum())}

    def least_time(self, properties):
        (variables, constraints, biases), get = self.sizes.values(), properties.get
        return max(properties["minimum_time_limit_s"],
                   get("num_variables_multiplier", 1.57e-4) * variables
                   + get("num_biases_multiplier", 4.65e-6) * biases
                   + get("num_constraints_multiplier", 6.44e-9) * variables * constraints)

    def upload_bytes(self):
        # Measured on dimod's files, to within a tenth: a small archive member for each constraint.
        return 41 * self.n + 16 * self.terms + 860 * self.sizes["constraints"]

    def file(self):
        return models.to_cqm(self.problem).to_file()


class Nl(Hybrid):
    """One integer a site, no groups and no penalties; other problems a bit for each variable."""

    problem_type, advice = "nl", SMALLER
    limits = {"nodes": "maximum_number_of_nodes", "bytes of state": "maximum_state_size",
              "bytes of decisions": "maximum_decision_state_size"}

    def __init__(self, problem, options):
        super().__init__(problem, options)
        try:
            self.model = models.to_nl(problem)
        except ImportError as error:
            raise SolverError(explain(error)) from None

    @property
    def sizes(self):
        return {"nodes": self.model.num_nodes(), "bytes of state": self.model.state_size(),
                "bytes of decisions": self.model.decision_state_size()}

    def least_time(self, properties):
        # The formula, and its numbers where the service names none, are those of Ocean's sampler.
        nodes, size, get = self.model.num_nodes(), self.model.state_size(), properties.get
        return max(get("min_time_limit", 5), get("num_nodes_multiplier", 8.306792043756981e-05)
                   * nodes + get("state_size_multiplier", 2.8379674360396316e-10) * size
                   + get("num_nodes_state_size_multiplier", 2.1097317822863966e-12) * nodes * size
                   + get("offset", 0.012671678446550175))

    def upload_bytes(self):
        with self.file() as file:
            return file.seek(0, 2)

    def file(self):
        file = self.model.to_file()
        file.seek(0)
        return file

    def decode(self, future, job):
        model = self.model
        with model.lock():
            # As Ocean's own sampler does. Decisions outside their bounds are refused here.
            model.states.from_file(future.answer_data, check_header=False)
            decision = next(model.iter_decisions())
            found = [i for i in range(model.states.size()) if decision.has_state(i)]
            energies = np.array([float(model.objective.state(i)) for i in found])
            bits = np.array([decision.state(i) for i in found], np.int64).reshape(len(found), -1)
        if self.problem.one_hot.all():
            places, bits = self.problem.starts[:-1] + bits, np.zeros((len(found), self.n), np.uint8)
            np.put_along_axis(bits, places, 1, axis=1)
        timing = dict(future.timing)
        warnings = timing.pop("warnings", None) or None
        return Answer(bits.astype(np.uint8), energies,
                      info=plain({**given(warnings=warnings), "timing": timing}))
