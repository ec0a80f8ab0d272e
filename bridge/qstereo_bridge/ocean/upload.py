"""Files for the hybrid solvers, written as their terms are expanded: no model of dimod's is built,
and memory stays at the problem's own.

The layout of dimod's binary quadratic models, version 2.0: header, offset, for each variable where
its terms begin and its linear term, then each variable's terms, those with earlier variables too,
in the order of the other variable.
"""

import tempfile

import numpy as np

from ..core import models

LINEAR = np.dtype([("start", "<i4"), ("bias", "<f8")])
TERM = np.dtype([("other", "<i4"), ("bias", "<f8")])


def bqm_file(problem):
    """A binary file, to be closed by the caller: `to_bqm(problem).to_file(ignore_labels=True)`."""
    terms = models.Terms(problem, both=True)
    if terms.repeated or terms.count > np.iinfo(np.int32).max:
        # What stands in several terms has to be added up first; dimod widens the starts where they
        # need it.
        return models.to_bqm(problem).to_file(ignore_labels=True)
    from dimod.serialization.fileview import make_header

    n, degree = problem.linear.size, np.zeros(problem.linear.size, np.int64)
    file = tempfile.TemporaryFile()
    file.write(make_header(b"DIMODBQM", {
        "shape": (n, terms.count // 2), "dtype": "float64", "itype": "int32", "ntype": "int32",
        "vartype": "BINARY", "type": "BinaryQuadraticModel", "variables": False}, (2, 0)))
    file.write(np.array([models.constant(problem)], "<f8").tobytes())
    at = file.tell()
    file.seek(at + LINEAR.itemsize * n)
    for row, column, value in terms.chunks():
        part = np.empty(row.size, TERM)
        part["other"], part["bias"] = column, value
        file.write(part.data)
        first = row[:1].sum()
        counts = np.bincount(row - first)
        degree[first:first + counts.size] += counts
    linear = np.empty(n, LINEAR)
    linear["start"], linear["bias"] = np.cumsum(degree) - degree, models.linear_terms(problem)
    file.seek(at)
    file.write(linear.data)
    file.seek(0)
    return file
