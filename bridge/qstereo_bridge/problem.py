"""The face for Python: a problem, its models, its samples by any sampler of dimod's interface."""

from __future__ import annotations

import contextlib
import hashlib
import os
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from . import models, solvers
from .container import DEFAULT_LIMIT, FormatError
from .failure import InputError, io
from .qcf import Problem as Coefficients
from .qcf import read_qcf
from .qsf import Samples, plain, read_qsf

if TYPE_CHECKING:
    import dimod
    from dwave.optimization import Model
    from numpy.typing import ArrayLike, NDArray

File = str | os.PathLike | BinaryIO


@contextlib.contextmanager
def opened(file):
    """A binary stream for a path or a stream; errors of the system and the format name the path."""
    if hasattr(file, "read"):
        yield file
        return
    try:
        with io(file, "read"), open(file, "rb") as stream:
            yield stream
    except FormatError as error:
        raise type(error)(f"{os.fspath(file)}: {error}") from None


def load(file: File, memory_limit: int = DEFAULT_LIMIT) -> Problem:
    """The Problem in a .qcf: a path or a binary stream.

    memory_limit    bytes that the problem and its models may take
    Raises FormatError (no sound .qcf), OverLimit, FileError.
    """
    with opened(file) as stream:
        coefficients, data = read_qcf(stream, memory_limit)
    return Problem(coefficients, hashlib.sha256(data).digest(), memory_limit)


def load_samples(file: File, memory_limit: int = DEFAULT_LIMIT) -> Samples:
    """The Samples in a .qsf: a path or a binary stream. Raises as load()."""
    with opened(file) as stream:
        return read_qsf(stream, memory_limit)


class Problem:
    """One QUBO: H(x) of n variables 0 .. n - 1, each 0 or 1, in groups.

    In a one-hot group, one with a penalty, a labelling has exactly one variable at 1. Energies are
    exact integers; `scale` of their units are one real unit. An array `bits` is (samples, n) or
    (n,), of 0 and 1.

    coefficients    qcf.Problem: groups, blocks and couplings as the file has them
    digest          SHA-256 of the file, by which samples know their problem
    """

    def __init__(self, coefficients: Coefficients, digest: bytes,
                 memory_limit: int = DEFAULT_LIMIT):
        self.coefficients, self.digest = coefficients, digest
        self.memory_limit = memory_limit

    def __len__(self) -> int:
        """n, the number of variables."""
        return self.coefficients.linear.size

    @property
    def scale(self) -> int:
        """int: energy units in one real unit."""
        return self.coefficients.scale

    def to_bqm(self) -> dimod.BinaryQuadraticModel:
        """dimod.BinaryQuadraticModel of H, penalties folded in. Raises OverLimit."""
        return models.to_bqm(self.coefficients, self.memory_limit)

    def to_cqm(self) -> dimod.ConstrainedQuadraticModel:
        """dimod.ConstrainedQuadraticModel: a constraint for each one-hot group, no penalties.
        Raises OverLimit."""
        return models.to_cqm(self.coefficients, self.memory_limit)

    def to_nl(self) -> Model:
        """dwave.optimization.Model: one integer for each group where all are one-hot. Raises
        OverLimit, ImportError without the extra `dwave`."""
        return models.to_nl(self.coefficients, self.memory_limit)

    def energies(self, bits: ArrayLike) -> NDArray[np.int64]:
        """i64 array (samples,): exact H. Raises InputError for bits that do not fit."""
        return models.energies(self.coefficients, self.fitting(bits))

    def feasible(self, bits: ArrayLike) -> NDArray[np.bool_]:
        """bool array (samples,): whether each one-hot group has one variable at 1. Raises
        InputError."""
        return models.feasible(self.coefficients, self.fitting(bits))

    def parts(self) -> list[NDArray[np.int64]]:
        """The variables of each connected part: list of i64 arrays, the largest first. No coupling
        joins two parts; a group is in one part."""
        return models.parts(self.coefficients)

    def sample(self, sampler: dimod.Sampler, **parameters) -> Samples:
        """The Samples of a dimod.Sampler, which gets to_bqm() and `parameters`.

        Raises InputError where it is no sampler, SolverError where its answer does not fit, and
        whatever the sampler raises.
        """
        if not callable(getattr(sampler, "sample", None)):
            raise InputError(f"{type(sampler).__name__} is no sampler: it has no method sample")
        return self.samples(sampler.sample(self.to_bqm(), **parameters), type(sampler).__name__)

    def samples(self, sampleset: dimod.SampleSet, solver: str = "dimod") -> Samples:
        """The Samples in a dimod.SampleSet over this problem's variables, in any order, BINARY or
        SPIN. Energies are computed anew. `solver` is the name that they keep.

        Raises SolverError for other variables or values.
        """
        answer = solvers.from_sampleset(sampleset, len(self), info=plain(dict(sampleset.info)))
        return solvers.samples_of(self.coefficients, self.digest, solver, answer)

    def fitting(self, bits):
        bits = np.atleast_2d(np.asarray(bits))
        if bits.ndim != 2 or bits.shape[1] != len(self) or not np.isin(bits, (0, 1)).all():
            raise InputError(f"bits are 0 and 1 in an array (samples, {len(self)}), these are "
                             f"{bits.shape} of {bits.dtype}")
        return bits.astype(np.uint8)
