"""From a QUBO coefficient file (.qcf) through D-Wave's samplers to a samples file (.qsf).

The modules, in the way of the data: `container` (header, chunks, CRC), `blocks` and `qcf` (the problem), `models` (its
terms, energies, dimod models), `solvers` (the local ones), `ilp` (HiGHS's), `qsf` (the samples), `output` (whole files or none), `failure` (how the
command ends), `cli` (the command), `__main__` (its start, and its end by a signal).

For D-Wave's services: `services` (account and messages), `hybrid`, `qpu` and `embedding` (what each solver takes, and its answers),
`tiles` and `picture` (chips: grids laid out in them, and drawn), `embed` (that command),
`upload` (files of models), `jobs` (the life of a problem there), `remote` (the commands that use them).
"""

__version__ = "0.1.0"
