"""Coupling blocks: the matrix t of a coupling, as a table or as a Toeplitz matrix."""

import struct
from dataclasses import dataclass

import numpy as np


@dataclass
class Table:
    """A coupling block, entry by entry: `entries` is an i32 array of rows x columns."""

    entries: np.ndarray

    @property
    def shape(self):
        return self.entries.shape

    def dense(self):
        """The block as a rows x columns array."""
        return self.entries

    def count_nonzero(self, upper):
        """Number of entries that are not 0; with `upper` of those above the diagonal only."""
        return int(np.count_nonzero(np.triu(self.entries, 1) if upper else self.entries))

    def abs_sum(self, dtype):
        """Sum of the entries' absolute values, computed in `dtype`."""
        return np.abs(self.entries.astype(dtype)).sum()

    def pack(self):
        return struct.pack("<III", *self.shape, 0) + self.entries.astype("<i4").tobytes()


@dataclass
class Toeplitz:
    """A coupling block that is constant along each diagonal: values[j - i - first], and `fill` outside the values."""

    shape: tuple
    fill: int
    first: int
    values: np.ndarray

    def _lengths(self, first, last):
        """Entries on each of the diagonals j - i = first .. last - 1."""
        rows, columns = self.shape
        d = np.arange(first, last, dtype=np.int64)
        return np.maximum(np.minimum(rows, columns - d) - np.maximum(0, -d), 0)

    def dense(self):
        """The block as a rows x columns array."""
        rows, columns = self.shape
        diagonals = np.full(rows + columns - 1, self.fill, np.int32)
        at = self.first + rows - 1
        diagonals[at:at + self.values.size] = self.values
        windows = np.lib.stride_tricks.sliding_window_view(diagonals, columns)
        return windows[::-1]

    def count_nonzero(self, upper):
        """Number of entries that are not 0; with `upper` of those above the diagonal only."""
        rows, columns = self.shape
        first = max(self.first, 1) if upper else self.first
        values = self.values[first - self.first:]
        lengths = self._lengths(first, first + values.size)
        whole = rows * (rows - 1) // 2 if upper else rows * columns
        return int(lengths[values != 0].sum()) + (self.fill != 0) * (whole - int(lengths.sum()))

    def abs_sum(self, dtype):
        """Sum of the entries' absolute values, computed in `dtype`."""
        lengths = self._lengths(self.first, self.first + self.values.size)
        others = self.shape[0] * self.shape[1] - int(lengths.sum())
        return (lengths.astype(dtype) * np.abs(self.values.astype(dtype))).sum() + dtype(abs(self.fill)) * dtype(others)

    def pack(self):
        return struct.pack("<IIIiiI", *self.shape, 1, self.fill, self.first, self.values.size) \
            + self.values.astype("<i4").tobytes()
