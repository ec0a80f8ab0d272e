"""From a QUBO coefficient file (.qcf) through any sampler to a samples file (.qsf).

    import qstereo_bridge as qb
    p = qb.load("p.qcf")
    p.sample(dimod.ExactSolver()).save("s.qsf")

The rooms, each of which sees those before it alone: `core` (files, models, energies, merging),
`verify` (proofs), `samplers` (what solves here), `ocean` (D-Wave's services and chips), `runs` (one
run of a solver, paid for once), `desk` (the command). README.md has a map of them.
"""

import importlib
from typing import TYPE_CHECKING

__version__ = "0.2.0"

if TYPE_CHECKING:
    from .core.container import (Corrupt, FormatError, NotOurFormat, OverLimit, Truncated,
                                 Unsupported)
    from .core.failure import Error, FileError, InputError, SolverError
    from .core.merging import merge
    from .core.problem import Problem, Samples, decode, load, load_samples
    from .samplers.windows import plan, window

_PLACES = {name: place for place, names in {
    "core.container": "Corrupt FormatError NotOurFormat OverLimit Truncated Unsupported",
    "core.failure": "Error FileError InputError SolverError",
    "core.merging": "merge", "core.problem": "Problem Samples decode load load_samples",
    "samplers.windows": "plan window"}.items() for name in names.split()}
__all__ = ["__version__", *_PLACES]


def __getattr__(name):
    """What is used is imported then: the command's start does not wait for numpy."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module("." + _PLACES[name], __name__), name)


def __dir__():
    return [*globals(), *_PLACES]
