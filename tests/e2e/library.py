"""libqstereo, called from Python: the first implementation of the file formats, beside the
bridge's.
"""

import ctypes
import os
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
QSTEREO = os.environ.get("QSTEREO", ROOT / "build" / "qstereo")
QSTEREO_PNM = os.environ.get("QSTEREO_PNM", ROOT / "build" / "opencv0" / "qstereo")
BRIDGE = os.environ.get("QSTEREO_BRIDGE", ROOT / ".venv" / "bin" / "qstereo-bridge")
HEADERS = sorted((ROOT / "libqstereo" / "include").rglob("*.h"))


class Qubo:
    """A .qcf opened by the C library. Raises ValueError(status) where it refuses."""

    def __init__(self, data):
        self.lib = ctypes.CDLL(str(ROOT / "build" / "libqstereo.so"))
        self.lib.qs_index_workspace.restype = ctypes.c_size_t
        self.lib.qs_repair_workspace.restype = ctypes.c_size_t
        self.lib.qs_qubo_energy.restype = ctypes.c_int64
        self.data = data
        # The structs' sizes are C's affair: these are larger than any of them.
        self.view, self.index = (ctypes.create_string_buffer(4096) for _ in range(2))
        self._demand(
            self.lib.qs_qubo_open(
                data, ctypes.c_size_t(len(data)), ctypes.c_uint64(2**40), self.view, None
            )
        )
        size = self.lib.qs_index_workspace(self.view)
        self.workspace = ctypes.create_string_buffer(size)
        self._demand(
            self.lib.qs_index_build(self.view, self.workspace, ctypes.c_size_t(size), self.index)
        )

    def _demand(self, status):
        if status:
            raise ValueError(status)

    def energy(self, bits):
        """H of one sample, a sequence of 0 and 1."""
        packed = np.packbits(np.asarray(bits, np.uint8), bitorder="little").tobytes()
        return self.lib.qs_qubo_energy(self.index, packed)

    def repair(self, bits):
        packed = ctypes.create_string_buffer(
            np.packbits(np.asarray(bits, np.uint8), bitorder="little").tobytes()
        )
        size = self.lib.qs_repair_workspace(self.index)
        self._demand(
            self.lib.qs_sample_repair(
                self.index,
                packed,
                ctypes.create_string_buffer(size + 1),
                ctypes.c_size_t(size),
                None,
            )
        )
        return np.unpackbits(
            np.frombuffer(packed, np.uint8, -(-len(bits) // 8)), bitorder="little", count=len(bits)
        )

    def terms(self, n):
        """(linear, {(i, j): value}, offset) of the folded QUBO, out of energies of at most two
        variables at 1.
        """
        unit = np.eye(n, dtype=np.uint8)
        offset = self.energy(np.zeros(n))
        linear = [self.energy(unit[i]) - offset for i in range(n)]
        pairs = {
            (i, j): self.energy(unit[i] | unit[j]) - offset - linear[i] - linear[j]
            for i in range(n)
            for j in range(i + 1, n)
        }
        return linear, {pair: value for pair, value in pairs.items() if value}, offset
