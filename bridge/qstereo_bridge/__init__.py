"""From a QUBO coefficient file (.qcf) through any sampler to a samples file (.qsf).

    import qstereo_bridge as qb
    p = qb.load("p.qcf")
    p.sample(dimod.ExactSolver()).save("s.qsf")

The core needs numpy and dimod: `container` (header, chunks, CRC), `qcf` (the problem), `qsf` (the
samples), `models` (terms, energies, dimod's models), `command` (what the command qstereo does for
Python), `problem` (the face for Python), `failure` (all errors), `text` (strings from outside),
`output` (whole files or none). On it stand `solvers` and `ilp` (what runs here), `registry` (their
names), `runner` (one run of the command), `merging` (the best of all samples), `windows` (plans,
folded problems), `calls` (runs of many calls), `export`, `verify` (certificates),
`cli` (the command) and `__main__` (its end by a signal).

For D-Wave's services: `services` (account and messages), `hybrid`, `qpu` and `embedding` (what each
solver takes, and its answers), `tiles` (grids laid out in chips), `packing` (parts side by side),
`embed` (that command), `upload` (files of models), `jobs` (the life of a problem there), `remote`
(the commands that use them).
"""

import importlib
from typing import TYPE_CHECKING

__version__ = "0.2.0"

if TYPE_CHECKING:
    from .container import Corrupt, FormatError, NotOurFormat, OverLimit, Truncated, Unsupported
    from .failure import Error, FileError, InputError, SolverError
    from .merging import merge
    from .problem import Problem, Samples, decode, load, load_samples
    from .windows import plan, window

_PLACES = {name: place for place, names in {
    "container": "Corrupt FormatError NotOurFormat OverLimit Truncated Unsupported",
    "failure": "Error FileError InputError SolverError",
    "merging": "merge", "problem": "Problem Samples decode load load_samples",
    "windows": "plan window"}.items() for name in names.split()}
__all__ = ["__version__", *_PLACES]


def __getattr__(name):
    """What is used is imported then: the command's start does not wait for numpy."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module("." + _PLACES[name], __name__), name)


def __dir__():
    return [*globals(), *_PLACES]
