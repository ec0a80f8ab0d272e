"""Coupling blocks: the matrix t of a coupling, as a table or as a Toeplitz matrix."""

import struct
from dataclasses import dataclass

import numpy as np


def places(lengths):
    """0, 1, .. length - 1 for each of `lengths`, one after another."""
    return np.arange(lengths.sum()) - np.repeat(np.cumsum(lengths) - lengths, lengths)


@dataclass
class Table:
    """A coupling block, entry by entry: `table` is an i32 array of rows x columns."""

    table: np.ndarray

    @property
    def shape(self):
        return self.table.shape

    def entries(self, upper):
        """(number in each row, columns, values) of the entries that are not 0; with `upper` of
        those above the diagonal only."""
        table = np.triu(self.table, 1) if upper else self.table
        row, column = np.nonzero(table)
        number = np.bincount(row, minlength=table.shape[0])
        return number, column.astype(np.int32), table[row, column]

    def count_nonzero(self, upper):
        """How many entries() there are."""
        return int(np.count_nonzero(np.triu(self.table, 1) if upper else self.table))

    def dense(self):
        """The block as an array, rows x columns."""
        return self.table

    def transposed(self):
        return Table(self.table.T)

    def abs_sum(self, dtype):
        """Sum of the entries' absolute values, computed in `dtype`."""
        return np.abs(self.table.astype(dtype)).sum()

    def abs_max(self):
        """The largest of the entries' absolute values."""
        return int(np.abs(self.table.astype(np.int64)).max())

    def pack(self):
        return struct.pack("<III", *self.shape, 0) + self.table.astype("<i4").tobytes()


@dataclass
class Toeplitz:
    """A coupling block that is constant along each diagonal: values[j - i - first], and `fill`
    outside the values. Its methods are Table's."""

    shape: tuple
    fill: int
    first: int
    values: np.ndarray

    def _lengths(self, first, last):
        """Entries on each of the diagonals j - i = first .. last - 1."""
        rows, columns = self.shape
        d = np.arange(first, last, dtype=np.int64)
        return np.maximum(np.minimum(rows, columns - d) - np.maximum(0, -d), 0)

    def _diagonals(self):
        """i32 array: the value of each diagonal, from the bottom left corner on."""
        diagonals = np.full(sum(self.shape) - 1, self.fill, np.int32)
        at = self.first + self.shape[0] - 1
        diagonals[at:at + self.values.size] = self.values
        return diagonals

    def entries(self, upper):
        (rows, columns), diagonals = self.shape, self._diagonals()
        if upper:
            diagonals[:rows] = 0
        used, row = np.flatnonzero(diagonals), np.arange(rows)
        low, high = (np.searchsorted(used, start - row) for start in (rows - 1, rows - 1 + columns))
        diagonal = used[np.repeat(low, high - low) + places(high - low)]
        column = diagonal - np.repeat(rows - 1 - row, high - low)
        return high - low, column.astype(np.int32), diagonals[diagonal]

    def dense(self):
        rows, columns = self.shape
        return self._diagonals()[np.arange(columns) - np.arange(rows)[:, None] + rows - 1]

    def transposed(self):
        first = 1 - self.first - self.values.size if self.values.size else 0
        return Toeplitz(self.shape[::-1], self.fill, first, self.values[::-1])

    def count_nonzero(self, upper):
        rows, columns = self.shape
        first = max(self.first, 1) if upper else self.first
        values = self.values[first - self.first:]
        lengths = self._lengths(first, first + values.size)
        whole = rows * (rows - 1) // 2 if upper else rows * columns
        return int(lengths[values != 0].sum()) + (self.fill != 0) * (whole - int(lengths.sum()))

    def abs_sum(self, dtype):
        lengths = self._lengths(self.first, self.first + self.values.size)
        others = dtype(self.shape[0] * self.shape[1] - int(lengths.sum()))
        of_values = (lengths.astype(dtype) * np.abs(self.values.astype(dtype))).sum()
        return of_values + dtype(abs(self.fill)) * others

    def abs_max(self):
        return max(abs(self.fill), int(np.abs(self.values.astype(np.int64)).max(initial=0)))

    def pack(self):
        head = struct.pack("<IIIiiI", *self.shape, 1, self.fill, self.first, self.values.size)
        return head + self.values.astype("<i4").tobytes()
