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
        raise Failure(USAGE, f"{name} is no dimod sampler")
    return sampler


def check_parameters(name, wanted, known):
    """Raises Failure where `wanted` names a parameter that is not among the `known`."""
    for key in wanted:
        if key not in known:
            raise Failure(USAGE, f"{name} takes no parameter {key}, only "
                          f"{', '.join(sorted(known))}")


def sample(problem, options, progress):
    """The Answer of the sampler that `options.solver` names."""
    sampler = load(options.solver)
    named = {"num_reads": options.num_reads, "seed": options.seed}
    wanted = {**{key: value for key, value in named.items() if value is not None},
              **(options.param or {})}
    check_parameters(options.solver, wanted, sampler.parameters)
    told = dict(wanted)
    if options.spin_reversals:
        from dwave.preprocessing.composites import SpinReversalTransformComposite

        sampler = SpinReversalTransformComposite(sampler, seed=options.seed)
        wanted["num_spin_reversal_transforms"] = options.spin_reversals
    bqm = models.to_bqm(problem, options.memory_limit)
    try:
        # The sample set of many samplers is a promise, which resolve() waits for.
        found = interruptible(lambda: _resolved(sampler.sample(bqm, **wanted)),
                              lambda: progress("sampling"))
    except (ValueError, TypeError, RuntimeError, KeyError) as error:
        raise SolverError(f"{options.solver} fails: {error}") from None
    if options.spin_reversals:
        told["spin_reversals"] = options.spin_reversals
    return from_sampleset(found, problem.linear.size, info={"parameters": told})


def _resolved(sampleset):
    sampleset.resolve()
    return sampleset
