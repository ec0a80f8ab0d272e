"""The solvers, an entry each. What a place of the package names is imported when it is used."""

import importlib
import os
from typing import NamedTuple


def at(place):
    """What is at a place of the package, "module:name"."""
    module, _, name = place.partition(":")
    return getattr(importlib.import_module(f"qstereo_bridge.{module}"), name)


class Solver(NamedTuple):
    """place       of a function (problem, options, progress) -> Answer; where the solver is `paid`,
                one of D-Wave's services, of a class (problem, options) as in ocean/hybrid.py
    options     those that it takes, with their defaults
    """

    place: str
    summary: str
    options: dict
    paid: bool = False

    def run(self, *arguments):
        return at(self.place)(*arguments)


_SERVICE = {"solver_name": None, "label": None, "max_charge": None}
_HYBRID = {"time_limit": None, **_SERVICE}
# D-Wave's own name of the nonlinear solver.
ALIASES = {"stride": "hybrid-nl"}
ANY = "MODULE:CLASS"
EVERY = {
    "anneal": Solver("samplers.solvers:anneal", "simulated annealing (the default)",
                     {"num_reads": 20, "num_sweeps": 1000, "seed": None, "time_limit": None}),
    "tabu": Solver("samplers.solvers:tabu", "tabu search; --time-limit is for all reads together",
                   {"num_reads": 10, "seed": None, "time_limit": 10.0}),
    "exact": Solver("samplers.solvers:exact", "tries every state of at most 24 variables; writes "
                    "up to 100 of the best, feasible ones first", {}),
    "ilp": Solver("samplers.ilp:ilp", "the proven best labelling, by HiGHS: an integer program for "
                  "each connected part", {"time_limit": None}),
    "qpu": Solver("ocean.qpu:Qpu", "D-Wave's quantum annealer, by minor embedding",
                  {"num_reads": 1000, "annealing_time": None, "chain_strength": None,
                   "embedding": None, "copies": 1, "seed": None, "param": None,
                   "spin_reversals": None, **_SERVICE}, True),
    "hybrid-nl": Solver("ocean.hybrid:Nl", "D-Wave's nonlinear hybrid solver (Stride), with one "
                        "integer for each site: for whole pictures", _HYBRID, True),
    "hybrid-bqm": Solver("ocean.hybrid:Bqm", "D-Wave's hybrid solver for QUBOs, with the penalties",
                         _HYBRID, True),
    "hybrid-cqm": Solver("ocean.hybrid:Cqm", "D-Wave's hybrid solver with constraints: one for "
                         "each one-hot group, and no penalties", _HYBRID, True),
    ANY: Solver("samplers.solvers:sample", "any dimod sampler; --param sets its parameters",
                {"num_reads": None, "seed": None, "param": None, "spin_reversals": None})}
SOLVERS = {name: solver for name, solver in EVERY.items() if name != ANY}


def find(name):
    """The Solver of this name: one of the table, or any dimod sampler as MODULE:CLASS."""
    return EVERY[ANY if ":" in name else name]


def name_label(options):
    """Sets the label of a problem for the service: its file's name, unless the user gave one."""
    if "label" in find(options.solver).options and options.label is None and options.problem != "-":
        options.label = os.path.splitext(os.path.basename(options.problem))[0]
    if options.label is not None:
        # Bytes that are not UTF-8: neither service nor .qsf could hold them.
        options.label = options.label.encode("utf-8", "replace").decode()
