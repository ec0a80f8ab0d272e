"""The face for Python: a problem, its models, its samples by any sampler of dimod's interface."""

from __future__ import annotations

import contextlib
import hashlib
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from . import command, models, solvers
from .container import DEFAULT_LIMIT, FormatError
from .failure import InputError, io
from .output import save
from .qcf import Problem as Coefficients
from .qcf import parse_qcf, read_qcf
from .qsf import Samples, plain, read_qsf

if TYPE_CHECKING:
    import dimod
    from dwave.optimization import Model
    from numpy.typing import ArrayLike, NDArray
    Number = int | float | str

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
    return made(coefficients, hashlib.sha256(data).digest(), memory_limit, data)


def made(coefficients, digest, memory_limit=DEFAULT_LIMIT, data=None):
    """The Problem of coefficients; `data` are its file's bytes, if it has one."""
    problem = Problem.__new__(Problem)
    problem._hold(coefficients, digest, memory_limit, data)
    return problem


def load_samples(file: File, memory_limit: int = DEFAULT_LIMIT) -> Samples:
    """The Samples in a .qsf: a path or a binary stream. Raises as load()."""
    with opened(file) as stream:
        return read_qsf(stream, memory_limit)


def decode(problem: Problem, samples: Samples | None = None, *, sample: int | None = None,
           repair: bool = False) -> NDArray[np.int32]:
    """The labels of a sample, whatever the encoding, by the command `qstereo`.

    problem     a Problem that says what labels its variables stand for, reduced or not
    samples     its Samples; None where a reduction has decided every site
    sample      which of them, counted from 0; None takes the best feasible one
    repair      make samples feasible first, with the labels that cost least

    Returns an i32 array: H x W of a grid, -1 where there is no site, or else N. Labels count from
    0; for displacements and disparities too they are numbers, not pixels. Raises InputError
    (samples of another problem, no such sample), Error of status 1 (none is feasible) or 4 (no
    command qstereo, no room).
    """
    return command.decode(problem, samples, sample, repair)


class Problem:
    """One QUBO: H(x) of n variables 0 .. n - 1, each 0 or 1, in groups.

    In a one-hot group, one with a penalty, a labelling has exactly one variable at 1. Energies are
    exact integers; `scale` of their units are one real unit. An array `bits` is (samples, n) or
    (n,), of 0 and 1.

    coefficients    qcf.Problem: groups, blocks and couplings as the file has them
    digest          SHA-256 of the file, by which samples know their problem
    """

    def __init__(self, costs: ArrayLike, pairwise: str | ArrayLike | None = None, *,
                 lam: Number = 1, truncation: Number | None = None,
                 right: ArrayLike | None = None, down: ArrayLike | None = None,
                 weights: ArrayLike | None = None, edges: ArrayLike | None = None,
                 tables: ArrayLike | Sequence[ArrayLike] | None = None,
                 mask: ArrayLike | None = None, scale: int | None = None,
                 encoding: str | None = None,
                 penalty: Number | None = None, memory_limit: int = DEFAULT_LIMIT):
        """The QUBO of a labelling problem: what `qstereo encode --problem label` makes.

        Each site takes one of K labels. Its label costs `costs`; neighbours p and q cost
        lam * weight_pq * V(label of p, label of q), p the left or upper one, or the edge's first.

        costs       H x W x K for the cells of a grid, N x K with `edges`; inf forbids a label
        pairwise    V: "potts" (default), "linear" or "quadratic", or an array K x K
        lam         weight of all edges, an exact decimal number
        truncation  upper bound of linear or quadratic V
        right, down weights in a grid, H x (W - 1) and (H - 1) x W, whole numbers or floats >= 0
        edges       M x 2 sites, the lower one first: the graph is no grid
        weights     M, those of the edges
        tables      instead of V a table for each edge: M x K x K, or of a grid a pair of arrays
                    H x (W - 1) x K x K and (H - 1) x W x K x K
        mask        H x W: cells where it is 0 are no sites
        scale       floats are rounded to 1 / scale; whole numbers stay exact. None = 1, with a
                    UserWarning that says how much is lost, if anything is
        encoding, penalty   names as in `qstereo encode --help`

        Raises InputError with the command's sentence, and Error of status 4 (no command qstereo, no
        room).
        """
        arrays = {"right": right, "down": down, "weights": weights, "tables": tables, "mask": mask}
        data = command.encode(costs, pairwise, edges, arrays, {
            "lambda": lam, "truncation": truncation, "scale": scale, "encoding": encoding,
            "penalty": penalty, "memory-limit": max(1, memory_limit >> 20)})
        self._hold(parse_qcf(data, memory_limit), hashlib.sha256(data).digest(), memory_limit, data)

    def _hold(self, coefficients, digest, memory_limit, data):
        self.coefficients, self.digest = coefficients, digest
        self.memory_limit, self._data = memory_limit, data

    def save(self, file: str | os.PathLike | BinaryIO) -> None:
        """Write the .qcf to a path, whole or not at all, or to a binary stream. Raises FileError,
        and InputError for a window, which is part of a file."""
        if self._data is None:
            raise InputError("a window has no file of its own; save the whole problem")
        save(file, self._data)

    def __len__(self) -> int:
        """n, the number of variables."""
        return self.coefficients.linear.size

    @property
    def scale(self) -> int:
        """int: energy units in one real unit."""
        return self.coefficients.scale

    @property
    def known(self) -> NDArray[np.uint8] | None:
        """u8 array (n,): the best labelling known that the file carries, or None."""
        return self.coefficients.known

    @property
    def stated_bound(self) -> int | None:
        """int: the lower bound of H that the file states, or None. It is a claim: only a
        certificate proves one."""
        return self.coefficients.stated_bound

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
