"""From a QUBO coefficient file (.qcf) through D-Wave's samplers to a samples file (.qsf).

The modules, in the way of the data: `container` (header, chunks, CRC), `blocks` and `qcf` (the problem), `models` (its
terms, energies, dimod models), `solvers` (the local ones), `ilp` (HiGHS's) and `services` (D-Wave's), `qsf` (the samples),
`output` (whole files or none), `cli` (the command), `__main__` (its start, and its end by a signal).
"""

__version__ = "0.1.0"
