"""Windows of a reduced problem on the workers of Ray.

    qstereo reduce p.qcf -o core.qcf --encoding domain-wall --samples start.qsf
    python windows_ray.py core.qcf start.qsf s.qsf 500

In each of three rounds four windows of at most 500 variables are sampled at
once, all from the best state known. Merging takes from each what makes this
state better.
"""

import sys

import dimod
import numpy as np
import qstereo_bridge as qb
import ray
from dwave.samplers import SimulatedAnnealingSampler


# For paid calls: @ray.remote(resources={"qpu": 1}, max_retries=0)
@ray.remote
def answer(core, bits, variables, seed):
    """States of the whole problem with the variables of a window sampled."""
    part = qb.window(qb.load(core), bits, variables)
    samples = part.sample(SimulatedAnnealingSampler(), num_reads=20, seed=seed)
    states = np.tile(bits, (len(samples.bits), 1))
    states[:, variables] = samples.bits
    return states


core, start, output, size = *sys.argv[1:4], int(sys.argv[4])
ray.init()
p = qb.load(core)


def samples_of(states):
    return p.samples(dimod.SampleSet.from_samples(states, "BINARY", 0), "ray")


bits = qb.load_samples(start).bits[0]
for turn in range(3):
    calls = range(4 * turn, 4 * turn + 4)
    tasks = [answer.remote(core, bits, qb.plan(p, size, call), call)
             for call in calls]
    states = np.concatenate([bits[None], *ray.get(tasks)])
    merged = qb.merge(p, samples_of(states))
    bits = merged.bits[merged.info["result"]["sample"]]
    print(f"{calls[-1] + 1} calls: energy {p.energies(bits)[0]}")
samples_of(bits).save(output)
