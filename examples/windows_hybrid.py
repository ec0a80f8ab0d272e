"""Windows of a reduced problem as a loop of dwave-hybrid.

    qstereo reduce p.qcf -o core.qcf --encoding domain-wall --samples start.qsf
    python windows_hybrid.py core.qcf start.qsf s.qsf 500

Ten windows of at most 500 variables, each merged into the best state known.
"""

import sys

import dimod
import hybrid
import qstereo_bridge as qb


class Window(hybrid.Runnable):
    """The next window as the subproblem, all other variables as in `bits`."""

    def next(self, state, **options):
        variables = qb.plan(p, size, state.call)
        part = qb.window(p, state.bits, variables)
        return state.updated(variables=variables, part=part,
                             subproblem=part.to_bqm())


class Merge(hybrid.Runnable):
    """Descent and merging of the samples, into `bits` where that is better."""

    def next(self, state, **options):
        part, bits = state.part, state.bits.copy()
        samples = qb.merge(part, part.samples(state.subsamples))
        best = samples.bits[samples.info["result"]["sample"]]
        if part.energies(best)[0] < p.energies(bits)[0]:
            bits[state.variables] = best
        print(f"call {state.call + 1}: energy {p.energies(bits)[0]}")
        return state.updated(bits=bits, call=state.call + 1)


core, start, output, size = *sys.argv[1:4], int(sys.argv[4])
p = qb.load(core)
# On the annealer: hybrid.QPUSubproblemAutoEmbeddingSampler(num_reads=200)
sampler = hybrid.SimulatedAnnealingSubproblemSampler(num_reads=20)
calls = hybrid.Loop(Window() | sampler | Merge(), max_iter=10)
begin = hybrid.State(bits=qb.load_samples(start).bits[0], call=0)
bits = calls.run(begin).result().bits
found = dimod.SampleSet.from_samples(bits, "BINARY", 0)
p.samples(found, "dwave-hybrid").save(output)
