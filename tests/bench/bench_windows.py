"""Whole scenes on an annealer, call by call, against a stand-in of D-Wave's service whose chip has
a chip's noise; what merging and penalties do: figures `windows`.

    python tests/bench/bench_windows.py [--data DIR] [--figures DIR]

The chip is a whole Zephyr Z12. Its fields and couplings, scaled to |h| <= 4 and -2 <= J <= 1, are
off by normal errors of 0.025 and 0.0175; the states are D-Wave's simulated annealing's.
"""

import json
import os
import sys
import tempfile
from pathlib import Path

import dimod
import numpy as np
import qstereo_bridge as qb
from dwave.samplers import SimulatedAnnealingSampler
from scenes import LAMBDA, ROOT, SAMPLES, Figures, arguments, call, pair, scenes_of

sys.path.insert(0, str(ROOT / "tests" / "bridge"))
from service import Service, described  # noqa: E402

VARIABLES, CALLS, READS, SWEEPS, DRAWS = 1000, 10, 200, 1000, 5
FIELD_NOISE, COUPLING_NOISE = 0.025, 0.0175
FORMS = [("one-hot", "paper"), ("one-hot", "local"), ("one-hot-sparse", "local"),
         ("one-hot-sparse", "minimal"), ("one-hot-sparse", "minimal", "--truncate"),
         ("domain-wall", "local")]
FORM_READS = 1000


class NoisyChip:
    """A sampler with a chip's noise, drawn anew for each call. `lowest` is the strongest negative
    coupling it takes."""

    def __init__(self, lowest, seed):
        self.lowest, self.rng = lowest, np.random.default_rng(seed)

    def sample(self, bqm, num_reads):
        rng = self.rng
        spins = bqm.change_vartype("SPIN", inplace=False)
        h, (rows, columns, J), offset, labels = spins.to_numpy_vectors(return_labels=True)
        unit = max(np.abs(h).max() / 4, J.max(initial=0), (-J).max(initial=0) / -self.lowest)
        h, J = h + unit * rng.normal(0, FIELD_NOISE, h.size), J + unit * rng.normal(
            0, COUPLING_NOISE, J.size)
        noisy = dimod.BinaryQuadraticModel.from_numpy_vectors(
            h, (rows, columns, J), offset, "SPIN", variable_order=labels)
        found = SimulatedAnnealingSampler().sample(
            noisy, num_reads=num_reads, num_sweeps=SWEEPS, seed=int(rng.integers(2**31)))
        return dimod.SampleSet.from_samples_bqm(
            (found.record.sample, found.variables), spins).change_vartype(bqm.vartype)


def scene(folder, options, service):
    """One whole scene: reduced, then answered call by call until its bound, in several draws of the
    noise."""
    with tempfile.TemporaryDirectory() as place:
        whole, core, samples = (Path(place, name) for name in ("p.qcf", "core.qcf", "s.qsf"))
        info = call(options.qstereo, "encode", *pair(folder), "-o", whole)
        reduced = call(options.qstereo, "reduce", whole, "-o", core, "--encoding", "domain-wall",
                       "--truncate")
        bound = call(options.qstereo, "solve", core, "-o", samples)["lower_bound"]
        os.environ.update(service.environment, XDG_CACHE_HOME=place)
        solve = [options.bridge, "solve", core, "-o", samples, "--solver", "qpu", "--windows",
                 VARIABLES, "--calls", CALLS, "--num-reads", READS, "--alone", "--bound",
                 bound]
        samples.unlink()
        # The embeddings are found here, and kept.
        plans, embedding_seconds = timed(*solve, "--dry-run")
        draws = []
        for draw in range(1, DRAWS + 1):
            service.sampler = NoisyChip(-2, draw)
            found, seconds = timed(*solve)
            decoded = call(options.qstereo, "validate", core, samples)
            draws.append({"draw": draw, "calls": found["calls"],
                          "variables_of_calls": found["variables_of_calls"],
                          "energies_of_calls": found["energies_of_calls"],
                          "energy": decoded["best_energy"],
                          "proven": decoded["best_energy"] == bound, "cpu_seconds": seconds})
            for path in (samples, Path(f"{samples}.journal")):
                path.unlink()
    return {"scene": folder.name, "variables_before": info["variables"],
            "variables": reduced["variables_after"], "reads": READS,
            "qubits": max(plan["embedded_qubits"] for plan in plans["calls"]),
            "longest_chain": max(plan["longest_chain"] for plan in plans["calls"]),
            "lower_bound": bound, "reduce_seconds": reduced["seconds"],
            "embedding_cpu_seconds": embedding_seconds, "draws": draws}


def timed(*words):
    """(What a command says as JSON, its CPU seconds.)"""
    before, found, after = os.times(), call(*words), os.times()
    return found, sum(getattr(after, field) - getattr(before, field)
                      for field in ("children_user", "children_system"))


def encoded(options, folder, roi, labels, path, encoding, penalty, *more):
    """A window of a scene in one form; its proven optimum."""
    call(options.qstereo, "encode", folder / "left.png", folder / "right.png", "-o", path, "--roi",
         roi, "--disparity", f"0:{labels - 1}", "--lambda", LAMBDA, "--encoding", encoding,
         "--penalty", penalty, *more)


def local(folder, corner, labels, options):
    """A 40 x 40 window by the local annealer: its best read, and the result."""
    with tempfile.TemporaryDirectory() as place:
        problem, samples = Path(place, "p.qcf"), Path(place, "s.qsf")
        forms = []
        for penalty in ("local", "minimal"):
            encoded(options, folder, f"{corner},40,40", labels, problem, "one-hot-sparse", penalty)
            solved = call(options.bridge, "solve", problem, "-o", samples, "--seed", 1)
            read = qb.load_samples(samples)
            reads = read.records["energy"][:read.info["result"]["reads"]]
            forms.append({"penalty": penalty, "best_read": int(reads.min()),
                          "energy": solved["best_energy"]})
        encoded(options, folder, f"{corner},40,40", labels, problem, "one-hot-sparse", "local")
        optimum = call(options.qstereo, "solve", problem, "-o", samples)
    return {"scene": folder.name, "labels": labels, "forms": forms,
            "optimum": optimum["energy"] if optimum["proven_optimal"] else None}


def shares(folder, options):
    """A window of 8 x 8 pixels and 8 labels in each form: the share of reads at the optimum."""
    found = []
    with tempfile.TemporaryDirectory() as place:
        problem, samples = Path(place, "p.qcf"), Path(place, "s.qsf")
        encoded(options, folder, "160,120,8,8", 8, problem, "one-hot-sparse", "local")
        least = call(options.qstereo, "solve", problem, "-o", samples)["energy"]
        for form in FORMS:
            encoded(options, folder, "160,120,8,8", 8, problem, *form)
            p = qb.load(problem)
            reads = p.samples(NoisyChip(-1, 1).sample(p.to_bqm(), FORM_READS))
            at = reads.records["energy"] == least * p.scale
            found.append({"encoding": form[0], "penalty": form[1], "truncated": len(form) > 2,
                          "variables": len(p), "share": float(at.mean()),
                          "merged": int(qb.merge(p, reads).records["energy"].min()) // p.scale})
    return {"scene": folder.name, "reads": FORM_READS, "optimum": least, "forms": found}


def main():
    options = arguments(__doc__)
    options.bridge = options.bridge.absolute()
    windows = [(SAMPLES, "90,60", 16)]
    if options.data:
        windows = [(options.data / "tsukuba", "160,120", 16),
                   (options.data / "venus", "200,150", 20)]
    with Figures(options.figures, "windows") as figures, Service(
            json.loads(described(12))) as service:
        figures.update(variables=VARIABLES, calls=CALLS, reads=READS)
        figures["local"] = [local(*window, options) for window in windows]
        figures["shares"] = shares(windows[0][0], options)
        figures["scenes"] = [scene(folder, options, service)
                             for folder in scenes_of(options.data)]


if __name__ == "__main__":
    main()
