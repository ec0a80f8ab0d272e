"""Any labelling problem: from arrays, by samples, to an array of labels.

    python examples/labels_from_python.py

The command qstereo is found on the PATH, or by the variable QSTEREO.
"""

import numpy as np
import qstereo_bridge as qb
from dwave.samplers import SimulatedAnnealingSampler

# A noisy picture of two halves. Label 0 is dark, label 1 bright.
random = np.random.default_rng(1)
picture = np.repeat([[60, 190]], 8, 1) + random.normal(0, 50, (12, 16))
costs = np.stack([abs(picture - 60), abs(picture - 190)], axis=-1)

# Neighbours of different labels cost 60, or less where their greys differ.
weights = [np.exp(-abs(np.diff(picture, axis=axis)) / 100) for axis in (1, 0)]
p = qb.Problem(costs, "potts", lam=60, right=weights[0], down=weights[1],
               scale=100)
p.save("p.qcf")
print(f"{len(p)} variables, energies in units of 1/{p.scale}")

samples = p.sample(SimulatedAnnealingSampler(), num_reads=20, seed=1)
labels = qb.decode(p, samples)
for row in labels:
    print("".join(".#"[label] for label in row))
