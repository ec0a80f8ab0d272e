"""A stereo problem from Python: read it, sample it twice, save, decode, draw.

    qstereo encode left.png right.png -o p.qcf --roi 90,60,40,40
    python examples/from_python.py p.qcf --qstereo build/qstereo
"""

import argparse
import subprocess

import qstereo_bridge as qb
from dwave.samplers import SimulatedAnnealingSampler, TabuSampler
from matplotlib.image import imread, imsave

parser = argparse.ArgumentParser()
parser.add_argument("problem")
parser.add_argument("--qstereo", default="qstereo")
arguments = parser.parse_args()

p = qb.load(arguments.problem)
print(f"{len(p)} variables in {len(p.parts())} connected parts")

found = [
    p.sample(SimulatedAnnealingSampler(), num_reads=20, seed=1),
    p.sample(TabuSampler(), num_reads=5, timeout=200, seed=1),
]
for samples in found:
    labellings = p.feasible(samples.bits).sum()
    least = samples.records["energy"].min() / p.scale
    print(f"{samples.solver}: least energy {least:g}, {labellings} labellings")

best = min(found, key=lambda samples: samples.records["energy"].min())
best.save("s.qsf")

subprocess.run([arguments.qstereo, "decode", arguments.problem, "s.qsf",
                "-o", "map.pgm"], check=True)
imsave("map.png", imread("map.pgm"), cmap="viridis")
print("s.qsf, map.pgm, map.png: written")
