"""D-Wave's services: qpu, hybrid-bqm, hybrid-cqm; and what would be sent to them (--dry-run).

Nothing of Ocean is imported until a service is used.
"""

import contextlib
import os
import re

import numpy as np

from . import models
from .qcf import DEFAULT_LIMIT
from .solvers import SolverError, from_sampleset

CONFIGURE = ("set up your account with `dwave config create`, or put your token into the environment variable "
             "DWAVE_API_TOKEN")

# Solver properties as D-Wave published them in 2026; only --dry-run relies on them.
PUBLISHED_LIMITS = {
    "hybrid-bqm": {"variables": 1_000_000, "biases": 200_000_000},
    "hybrid-cqm": {"variables": 5_000_000, "constraints": 100_000, "biases": 750_000_000},
    "qpu": {"Advantage (Pegasus P16)": 5627, "Advantage2 (Zephyr Z12)": 4577},
}
BQM_TIMES = ((1, 1024, 4096, 10_000, 30_000, 100_000), (3, 3, 10, 40, 200, 600))


def connect(name):
    """Ocean's sampler for the service `name`, through the user's own configuration."""
    import dwave.system

    if name == "qpu":
        return dwave.system.EmbeddingComposite(dwave.system.DWaveSampler())
    return dwave.system.LeapHybridSampler() if name == "hybrid-bqm" else dwave.system.LeapHybridCQMSampler()


def scrub(text):
    """`text` without the user's token and without anything that looks like one."""
    tokens = {os.environ.get("DWAVE_API_TOKEN")}
    with contextlib.suppress(Exception):
        from dwave.cloud.config import load_config
        tokens.add(load_config().get("token"))
    for token in filter(None, tokens):
        text = text.replace(token, "(token)")
    return re.sub(r"\b[A-Za-z]{2,8}-[0-9a-f]{32,}\b", "(token)", text)


def _explain(error):
    """One sentence for whatever a service or its client raised."""
    names = {cls.__name__ for cls in type(error).__mro__}
    said = " ".join(str(error).split()) or type(error).__name__
    if "API token not defined" in said:
        return f"no D-Wave account is configured; {CONFIGURE}"
    if "ConfigFileError" in names:
        return f"D-Wave's configuration file cannot be used ({said}); {CONFIGURE}"
    if names & {"SolverAuthenticationError", "ResourceAuthenticationError", "ResourceAccessForbiddenError"}:
        return f"D-Wave does not accept the token ({said}); {CONFIGURE}"
    if "SolverNotFoundError" in names:
        return f"your D-Wave account reaches no such solver ({said}); `dwave solvers` lists those it reaches"
    if names & {"RequestTimeout", "PollingTimeout", "Timeout", "ConnectionError", "ProblemUploadError"}:
        return f"D-Wave's service cannot be reached or does not answer ({said}); check the network and try again"
    if "no embedding found" in said:
        return "the problem does not fit on this chip: no embedding was found; make it smaller, or use a hybrid solver"
    if isinstance(error, ImportError):
        return f"a part of D-Wave's Ocean tools is missing ({said}); pip install dwave-system"
    return f"{type(error).__name__}: {said}"


@contextlib.contextmanager
def _service(name):
    """Ocean's sampler for `name`; whatever goes wrong in its use becomes one SolverError without a token in it."""
    try:
        with connect(name) as sampler:
            yield sampler
    except SolverError:
        raise
    except Exception as error:
        # Ocean, its HTTP client and the service raise dozens of types; the user needs one sentence.
        raise SolverError(scrub(_explain(error))) from None


def _given(**parameters):
    return {key: value for key, value in parameters.items() if value is not None}


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


def qpu(problem, options, progress):
    """The quantum annealer: minor embedding, then num_reads anneals. Broken chains are mended by majority vote."""
    bqm = models.to_bqm(problem, options.memory_limit)
    parameters = _given(num_reads=options.num_reads, annealing_time=options.annealing_time, label=options.label)
    with _service("qpu") as sampler:
        qubits = len(sampler.child.nodelist)
        if len(bqm) > qubits:
            raise SolverError(f"{len(bqm):,} variables do not fit on a chip of {qubits:,} qubits; "
                              "make the problem smaller, or use a hybrid solver")
        progress("embedding and sampling")
        sampleset = sampler.sample(bqm, chain_strength=options.chain_strength, return_embedding=True, **parameters)
        sampleset.resolve()
        chip = sampler.child.properties.get("chip_id")
    info = dict(sampleset.info)
    context = info.pop("embedding_context")
    chains = [len(chain) for chain in context["embedding"].values()]
    info.update(chip=chip, parameters=parameters, chain_strength=context["chain_strength"],
                embedding={"qubits": sum(chains), "longest_chain": max(chains), "mean_chain": sum(chains) / len(chains),
                           "seconds": context["timing"]["embedding"]})
    return from_sampleset(sampleset, len(bqm), info=plain(info))


def hybrid_bqm(problem, options, progress):
    """The hybrid solver for binary quadratic models."""
    bqm = models.to_bqm(problem, options.memory_limit)
    with _service("hybrid-bqm") as sampler:
        most = sampler.properties.get("maximum_number_of_variables", len(bqm))
        if len(bqm) > most:
            # Ocean sends it all the same, and the service refuses it after the upload.
            raise SolverError(f"{len(bqm):,} variables, the service takes {most:,}; make the problem smaller")
        progress("sent to the hybrid solver")
        time_limit = options.time_limit or float(sampler.min_time_limit(bqm))
        sampleset = sampler.sample(bqm, time_limit=time_limit, **_given(label=options.label))
        sampleset.resolve()
    info = {**sampleset.info, "parameters": _given(time_limit=time_limit, label=options.label)}
    return from_sampleset(sampleset, len(bqm), info=plain(info))


def hybrid_cqm(problem, options, progress):
    """The hybrid solver for constrained quadratic models: one-hot groups as constraints, penalties dropped."""
    cqm = models.to_cqm(problem, options.memory_limit)
    with _service("hybrid-cqm") as sampler:
        progress("sent to the hybrid solver")
        time_limit = options.time_limit or float(sampler.min_time_limit(cqm))
        sampleset = sampler.sample_cqm(cqm, time_limit=time_limit, **_given(label=options.label))
        sampleset.resolve()
    info = {**sampleset.info, "parameters": _given(time_limit=time_limit, label=options.label)}
    return from_sampleset(sampleset, problem.linear.size, objective=True, info=plain(info))


def plan(name, problem, limit=DEFAULT_LIMIT):
    """What `name` would be sent: a dict for --dry-run. `fits` is None where only the service can tell. Raises OverLimit."""
    terms, n = models.Terms(problem, penalties=name != "hybrid-cqm"), problem.linear.size
    found = {"variables": n, "quadratic_terms": terms.count}
    if name == "qpu":
        chips = PUBLISHED_LIMITS[name]
        found.update(qubits=chips, minimum_time_limit=None, fits=None if n <= max(chips.values()) else False)
        if found["fits"] is None:
            found.update(_ranges(*models.expand(problem, limit=limit)))
        # The solver's format qp: base64 of one double for each qubit and each coupler, before embedding.
        found.update(upload_bytes=sum(4 * -(-8 * count // 3) for count in (n, found["quadratic_terms"])))
    elif name == "hybrid-bqm":
        # dimod's binary layout: linear terms of 12 bytes, each quadratic term twice at 12 bytes.
        found.update(upload_bytes=200 + 12 * n + 24 * terms.count, biases=n + terms.count,
                     minimum_time_limit=float(np.interp(n, *BQM_TIMES)))
    elif name == "hybrid-cqm":
        constraints, members = int(problem.one_hot().sum()), int(problem.sizes()[problem.one_hot()].sum())
        biases = n + terms.count + members
        # Measured on dimod's files, to within a tenth: one small archive member for each constraint.
        found.update(upload_bytes=41 * n + 16 * terms.count + 860 * constraints, biases=biases, constraints=constraints,
                     minimum_time_limit=max(5.0, 1.574e-4 * n + 4.657e-6 * biases + 6.444e-9 * n * constraints))
    if name.startswith("hybrid"):
        limits = PUBLISHED_LIMITS[name]
        found.update(limits=limits, fits=all(found[key] <= limit for key, limit in limits.items()))
    return found


def _ranges(linear, quadratic, offset):
    """The number of quadratic terms, the largest degree and the ranges of the coefficients of an expanded problem."""
    rows, columns, values = quadratic
    degree = np.bincount(rows, minlength=linear.size) + np.bincount(columns, minlength=linear.size)
    return {"quadratic_terms": rows.size, "largest_degree": int(degree.max()),
            "linear_min": int(linear.min()), "linear_max": int(linear.max()),
            "quadratic_min": int(values.min()) if rows.size else None, "quadratic_max": int(values.max()) if rows.size else None}
