"""The check of a certificate with the problem and the answer that it is about."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..core import models, qcf
from ..core.container import DEFAULT_LIMIT, read_stream
from ..core.failure import InputError
from ..core.problem import File, load, load_samples, opened
from ..core.qcf import NO_BOUND
from .certificate import MAGIC, Invalid, Problem, check, parse_qpf


@dataclass
class Verdict:
    """Whether a certificate is valid, and if not, why. Energies are in integer units, `scale` of
    which are one real unit.

    energy          of the best sample, or of the certificate's labelling
    lower_bound     that the certificate states; None = none
    """

    valid: bool
    why: str | None
    energy: int
    lower_bound: int | None
    stages: int
    scale: int


def _best_energy(p, problem, samples):
    """The energy of the best sample that is a labelling, None without one. Raises InputError."""
    if samples.digest != problem.digest:
        raise InputError("the samples are of another problem: the SHA-256 of its file differs")
    best = []
    for bits, stated in zip(samples.bits, samples.records["energy"].tolist()):
        ones, sums = (np.add.reduceat(values, problem.starts[:-1], dtype=int)
                      for values in (bits, bits * qcf.places(problem.sizes)))
        # A wall's variables that are 1 are its first ones: no others have so low a sum of places.
        if (sums == ones * (ones - 1) // 2).all() if p.wall else (ones == 1).all():
            labelling = ones if p.wall else sums
            best.append(p.energy(labelling))
            found = best[-1] - int(p.trimmed[np.arange(ones.size), labelling].sum())
        else:
            found = int(models.energies(problem, bits[None])[0])
        if found != stated:
            raise InputError("a sample has another energy than the samples file states")
    return min(best, default=None)


def _check_reduced(p, problem, smaller):
    """Every label that the certificate leaves must be in the reduced problem."""
    if smaller.encoding is None:
        raise InputError("the reduced problem does not say which labels its variables stand for")
    (sets, undecided), (others, _) = qcf.label_sets(problem), qcf.label_sets(smaller)
    inside = sets[undecided]
    inside[inside] = p.left[np.arange(p.left.shape[1]) < p.count[:, None]]
    sets[undecided] = inside
    if sets.shape != others.shape or (sets & ~others).any():
        raise Invalid("a label has left the reduced problem that the certificate does not rule out")


def verify(problem: File, other: File, certificate: File,
           memory_limit: int = DEFAULT_LIMIT) -> Verdict:
    """Check a certificate of a problem (.qcf): paths or binary streams.

    other           samples (.qsf), of which the best must be as good as the certificate states; or
                    the .qcf that `qstereo reduce` has written: each label that has left it must be
                    in no optimum
    Raises FormatError (a damaged file), InputError, FileError.
    """
    whole = load(problem, memory_limit)
    with opened(certificate) as stream:
        proof = parse_qpf(read_stream(stream, MAGIC, ".qpf", memory_limit))
    with opened(other) as stream:
        head = stream.read(len(qcf.MAGIC))
        stream.seek(-len(head), 1)
        answer = (load if head == qcf.MAGIC else load_samples)(stream, memory_limit)
    p, reduced = Problem(whole), head == qcf.MAGIC
    (_, lower_bound, stated, _, stages, _), why = proof, None
    energy = stated
    try:
        if not reduced:
            energy = _best_energy(p, whole, answer)
        check(p, whole.digest, proof)
        if reduced:
            _check_reduced(p, whole, answer)
        elif energy is None:
            raise Invalid("no sample is a labelling")
        elif energy > stated:
            raise Invalid("the best sample costs more than the certificate states")
    except Invalid as reason:
        why = str(reason)
    return Verdict(why is None, why, stated if energy is None else energy,
                   None if lower_bound == NO_BOUND else lower_bound, stages, whole.scale)
