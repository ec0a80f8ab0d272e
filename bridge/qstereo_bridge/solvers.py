"""The solvers that run on this machine: anneal, tabu, exact, and any dimod sampler.

A solver is a function (problem, options, progress) -> Answer.
"""

import concurrent.futures
import importlib
import inspect
import secrets
import threading
import time
from dataclasses import dataclass, field

import numpy as np

from . import models
from .container import check_memory
from .failure import USAGE, Failure, SolverError
from .qsf import BROKEN_UNITS, NO_CHAINS, RECORD, Samples

EXACT_VARIABLES = 24
EXACT_SAMPLES = 100


@dataclass
class Answer:
    """What a solver found.

    bits            u8 array (samples, n)
    energies        the solver's own energies, None where it gives none
    objective       whether these energies leave out the one-hot penalties
    occurrences     how often each sample was seen, None = once
    broken          share of broken chains of each sample (0 to 1), None = no chains
    iterations      reads times sweeps, None where that says nothing
    lower_bound     a proven lower bound of H (of ilp: of H's feasible states), or None
    info            what the .qsf's INFO will say
    """

    bits: np.ndarray
    energies: np.ndarray = None
    objective: bool = False
    occurrences: np.ndarray = None
    broken: np.ndarray = None
    iterations: int = None
    lower_bound: int = None
    info: dict = field(default_factory=dict)


def from_sampleset(sampleset, n, **more):
    """The Answer in a dimod SampleSet over the variables 0 .. n - 1, in any order, BINARY or SPIN.
    Raises SolverError where it has other variables or other values."""
    record, labels = sampleset.record, list(sampleset.variables)
    if len(labels) != n or set(labels) != set(range(n)):
        raise SolverError(f"the answer has {len(labels)} variables that are not the {n} of the "
                          "problem")
    low = -1 if sampleset.vartype.name == "SPIN" else 0
    found = record.sample[:, np.argsort(np.array(labels, int))]
    samples = np.rint(found)
    # Hybrid solvers answer in floating point. Written so that what is no number is refused, too.
    if not ((np.abs(found - samples) < 1e-6) & np.isin(samples, (low, 1))).all():
        raise SolverError(f"the answer has values other than {low} and 1")
    return Answer((samples == 1).astype(np.uint8), record.energy,
                  occurrences=record.num_occurrences,
                  broken=getattr(record, "chain_break_fraction", None), **more)


def check_occurrences(counts):
    """Raises SolverError unless each is a number of reads that a .qsf can hold."""
    if ((np.asarray(counts) < 1) | (np.asarray(counts) >= 2**32)).any():
        raise SolverError("the answer has samples that were never seen, or too often")


def samples_of(problem, solver, answer):
    """The Samples in an Answer, with exact energies. Raises SolverError for what no .qsf holds."""
    counts = 1 if answer.occurrences is None else answer.occurrences
    check_occurrences(counts)
    records = np.empty(answer.bits.shape[0], RECORD)
    records["energy"], records["occurrences"] = models.energies(problem, answer.bits), counts
    records["broken"] = (NO_CHAINS if answer.broken is None else
                         np.rint(answer.broken * BROKEN_UNITS))
    return Samples(problem.digest, solver, records, answer.bits, answer.info)


def interruptible(call, tick, stop=float("inf")):
    """call() in a thread of its own, tick() five times a second in this one, until the time `stop`.
    Ocean's samplers leave the interpreter for minutes; this way Ctrl-C is heard at once."""
    future = concurrent.futures.Future()

    def work():
        try:
            future.set_result(call())
        except BaseException as error:
            future.set_exception(error)

    threading.Thread(target=work, daemon=True).start()
    while not concurrent.futures.wait([future], min(0.2, max(0, stop - time.monotonic()))).done:
        if time.monotonic() >= stop:
            return None
        tick()
    return future.result()


def nothing_to_decide(problem):
    """The Answer to a problem without variables: its one state."""
    return Answer(np.zeros((1, 0), np.uint8), np.array([problem.offset]),
                  lower_bound=problem.offset)


def _sampled(problem, sampler, tick, **parameters):
    """The SampleSet of a dimod sampler, which need not be one that waits."""
    bqm = models.to_bqm(problem)

    def work():
        found = sampler.sample(bqm, **parameters)
        found.resolve()
        return found
    return interruptible(work, tick)


def _reads(problem, options):
    """The parameters of a sampler here, after a look at the room that its samples will take; the
    seed is one that can be told afterwards."""
    check_memory(16 * problem.linear.size * options.num_reads, problem.memory_limit,
                 f"{options.num_reads:,} samples of {problem.linear.size:,} variables")
    return {"num_reads": options.num_reads,
            "seed": secrets.randbelow(2**31) if options.seed is None else options.seed}


def _beta_range(problem):
    """Inverse temperatures from where the couplings between groups begin to matter to where they
    are frozen; without any, the same of linear terms. The sampler's own range goes by all
    coefficients, penalties included: on a labelling problem most of its sweeps are then spent in
    vain."""
    g, h, block, weight = problem.couplings
    largest = np.array([np.abs(block.astype(np.int64)).max() for block in problem.blocks],
                       np.int64)
    strengths = (np.abs(weight) * largest[block])[g != h]
    if not strengths.any():
        strengths = np.append(np.abs(problem.linear), 1)
    typical = float(np.median(strengths[strengths > 0]))
    return [1 / typical, 20 / typical]


def anneal(problem, options, progress):
    """Simulated annealing. A time limit stops it between two reads."""
    from dwave.samplers import SimulatedAnnealingSampler

    reads, stop = [0], time.monotonic() + (options.time_limit or float("inf"))

    def after_read():
        reads[0] += 1
        return time.monotonic() > stop
    told = {**_reads(problem, options), "num_sweeps": options.num_sweeps}
    found = _sampled(problem, SimulatedAnnealingSampler(), lambda: progress(
        f"{reads[0]} of {options.num_reads} reads"), **told, beta_range=_beta_range(problem),
        interrupt_function=after_read)
    info = {"parameters": {**told, "time_limit": options.time_limit, **{
        key: found.info[key] for key in ("beta_range", "beta_schedule_type")}},
            "timing": {"anneal": found.info["timing"]}}
    return from_sampleset(found, problem.linear.size, info=info,
                          iterations=len(found) * options.num_sweeps)


def tabu(problem, options, progress):
    """Tabu search; the time limit is shared by the reads. Its matrix is dense: 32 bytes for each
    pair of variables."""
    from dwave.samplers import TabuSampler

    n, reads, limit = problem.linear.size, options.num_reads, options.time_limit
    check_memory(32 * n * n, problem.memory_limit, f"tabu search, dense in {n:,} variables,")
    told = {**_reads(problem, options),
            "timeout": min(max(1, round(1000 * limit / reads)), 2**31 - 1)}
    found = _sampled(problem, TabuSampler(), lambda: progress(f"{reads} reads in {limit:g} s"),
                     **told)
    return from_sampleset(found, n, info={"parameters": told})


def exact(problem, options, progress):
    """All states, by doubling: those with variable k at 1 are those without it, plus its linear
    term and couplings."""
    n = problem.linear.size
    if n > EXACT_VARIABLES:
        raise SolverError(f"exact takes at most {EXACT_VARIABLES} variables, this problem has "
                          f"{n:,}; use anneal")
    linear, (rows, columns, values), offset = models.expand(problem)
    couplings = np.zeros((n, n), np.int64)
    couplings[rows, columns] = values
    energies, flip = np.empty(1 << n, np.int64), np.empty(1 << n - 1, np.int64)
    energies[0] = offset
    for k in range(n):
        flip[0] = linear[k]
        for j in range(k):
            np.add(flip[:1 << j], couplings[j, k], out=flip[1 << j:2 << j])
        np.add(energies[:1 << k], flip[:1 << k], out=energies[1 << k:2 << k])
    best = np.flatnonzero(energies == energies.min())
    # Feasible minimisers first: where there is one, the minimum is that of the labellings.
    sound, starts = np.ones(best.size, bool), problem.starts.tolist()
    for group in np.flatnonzero(problem.one_hot).tolist():
        inside = best & (1 << starts[group + 1]) - (1 << starts[group])
        sound &= (inside != 0) & (inside & inside - 1 == 0)
    best = np.append(best[sound], best[~sound])
    bits = (best[:EXACT_SAMPLES, None] >> np.arange(n) & 1).astype(np.uint8)
    info = {"states": 1 << n, "minimisers": best.size}
    return Answer(bits, energies[best[:EXACT_SAMPLES]], lower_bound=int(energies.min()), info=info)


def load_sampler(name):
    """A sampler of the class MODULE:CLASS, made without arguments. Raises Failure, SolverError."""
    import dimod

    place, _, kind = name.partition(":")
    try:
        sampler = getattr(importlib.import_module(place), kind)()
    except (ImportError, AttributeError, TypeError, ValueError) as error:
        raise Failure(USAGE, f"{name}: there is no such sampler ({error}); name an installed "
                      "package and its class, as dwave.samplers:TabuSampler") from None
    except Exception as error:
        raise SolverError(f"{name} cannot be made: {error}") from None
    if not isinstance(sampler, dimod.Sampler):
        raise Failure(USAGE, f"{name} is not a dimod sampler")
    return sampler


def sample(problem, options, progress):
    """The Answer of the dimod sampler that `options.solver` names."""
    sampler = load_sampler(options.solver)
    told = {key: getattr(options, key) for key in ("num_reads", "seed")
            if getattr(options, key) is not None} | (options.param or {})
    # Some samplers, as openjij's, name in `parameters` only some of what their method takes.
    method = inspect.signature(sampler.sample).parameters.values()
    known = {*sampler.parameters, *(one.name for one in method if one.kind is one.KEYWORD_ONLY
                                    or one.default is not one.empty)}
    for key in told:
        if key not in known:
            raise Failure(USAGE, f"{options.solver} does not take the parameter {key}, only "
                          f"{', '.join(sorted(known))}")
    wanted, info = dict(told), {"parameters": told}
    if options.spin_reversals:
        from dwave.preprocessing.composites import SpinReversalTransformComposite

        sampler = SpinReversalTransformComposite(sampler, seed=options.seed)
        wanted["num_spin_reversal_transforms"] = told["spin_reversals"] = options.spin_reversals
    try:
        found = _sampled(problem, sampler, lambda: progress("sampling"), **wanted)
    except (ValueError, TypeError, RuntimeError, KeyError) as error:
        raise SolverError(f"{options.solver} fails: {error}") from None
    return from_sampleset(found, problem.linear.size, info=info)
