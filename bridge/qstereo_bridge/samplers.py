"""Any dimod sampler that is installed: found by MODULE:CLASS, its parameters checked, run."""

import importlib

import dimod

from . import models
from .failure import USAGE, Failure, SolverError
from .solvers import from_sampleset, interruptible


def load(name):
    """A sampler of the class MODULE:CLASS, made without arguments. Raises Failure, SolverError."""
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
    """The Answer of the sampler that `options.solver` names."""
    sampler, told = load(options.solver), dict(options.param or {})
    for key in ("num_reads", "seed"):
        if getattr(options, key) is not None:
            told.setdefault(key, getattr(options, key))
    for key in told:
        if key not in sampler.parameters:
            raise Failure(USAGE, f"{options.solver} does not take the parameter {key}, only "
                          f"{', '.join(sorted(sampler.parameters))}")
    wanted, info = dict(told), {"parameters": told}
    if options.spin_reversals:
        from dwave.preprocessing.composites import SpinReversalTransformComposite

        sampler = SpinReversalTransformComposite(sampler, seed=options.seed)
        wanted["num_spin_reversal_transforms"] = told["spin_reversals"] = options.spin_reversals
    bqm = models.to_bqm(problem, options.memory_limit)

    def work():
        # The sample set of many samplers is a promise.
        found = sampler.sample(bqm, **wanted)
        found.resolve()
        return found
    try:
        found = interruptible(work, lambda: progress("sampling"))
    except (ValueError, TypeError, RuntimeError, KeyError) as error:
        raise SolverError(f"{options.solver} fails: {error}") from None
    return from_sampleset(found, problem.linear.size, info=info)
