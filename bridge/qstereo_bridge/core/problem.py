"""The face for Python: a problem, its models, its samples by any sampler of dimod's interface."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from . import answers, command, models
from .container import DEFAULT_LIMIT, FormatError
from .failure import InputError, io
from .output import save
from .qcf import Coefficients, parse_qcf, read_qcf
from .qsf import Samples, plain, read_qsf

if TYPE_CHECKING:
    import dimod
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
        return made(read_qcf(stream, memory_limit))


def made(coefficients):
    """The Problem of these Coefficients."""
    problem = Problem.__new__(Problem)
    vars(problem).update(vars(coefficients))
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


class Problem(Coefficients):
    """One QUBO: H(x) of n variables 0 .. n - 1, each 0 or 1, in groups.

    In a one-hot group, one with a penalty, a labelling has exactly one variable at 1. Energies are
    exact integers; `scale` of their units are one real unit. An array `bits` is (samples, n) or
    (n,), of 0 and 1. Of the attributes see qcf.Coefficients.
    """

    to_bqm, to_cqm, to_nl = models.to_bqm, models.to_cqm, models.to_nl
    energies, feasible, parts = models.energies, models.feasible, models.parts

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
        vars(self).update(vars(parse_qcf(data, memory_limit)))

    def save(self, file: str | os.PathLike | BinaryIO) -> None:
        """Write the .qcf to a path, whole or not at all, or to a binary stream. Raises FileError,
        and InputError for a window, which is part of a file."""
        if self.data is None:
            raise InputError("a window has no file of its own; save the whole problem")
        save(file, self.data)

    def __len__(self) -> int:
        """n, the number of variables."""
        return self.linear.size

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
        answer = answers.from_sampleset(sampleset, len(self), info=plain(dict(sampleset.info)))
        return answers.samples_of(self, solver, answer)
