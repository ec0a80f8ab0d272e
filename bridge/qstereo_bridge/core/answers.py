"""What a solver found, checked and made into samples."""

from dataclasses import dataclass, field

import numpy as np

from . import models
from .failure import SolverError
from .qsf import BROKEN_UNITS, NO_CHAINS, RECORD, Samples


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


def nothing_to_decide(problem):
    """The Answer to a problem without variables: its one state."""
    return Answer(np.zeros((1, 0), np.uint8), np.array([problem.offset]),
                  lower_bound=problem.offset)
