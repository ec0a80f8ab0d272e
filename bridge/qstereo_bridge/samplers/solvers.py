"""The solvers that run on this machine: anneal, tabu, exact, and any dimod sampler.

A solver is a function (problem, options, progress) -> Answer.
"""

import concurrent.futures
import importlib
import inspect
import secrets
import threading
import time

import numpy as np

from ..core import models
from ..core.answers import Answer, from_sampleset
from ..core.container import check_memory
from ..core.failure import USAGE, Failure, SolverError

EXACT_VARIABLES = 24
EXACT_SAMPLES = 100


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
