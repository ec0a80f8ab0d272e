"""D-Wave's quantum annealer: embedding, chain strength, annealing parameters, and samples from
broken and whole chains."""

import os
import sys

import numpy as np

from . import embedding, models
from .embedding import Chip
from .failure import InputError, SolverError, failing, io
from .hybrid import SMALLER, Request
from .qsf import plain, read_qsf
from .services import given
from .solvers import Answer, check_occurrences
from .text import line

# Published in 2026, the solver's properties; for --dry-run without an account.
_EVERY = {"num_reads_range": [1, 10_000],
          "parameters": dict.fromkeys(("fast_anneal", "initial_state", "anneal_schedule"))}
PUBLISHED_CHIPS = {"Advantage (Pegasus P16)": {"qubits": range(5627), **_EVERY},
                   "Advantage2 (Zephyr Z12)": {"qubits": range(4577), **_EVERY}}
# Reverse annealing goes back to this share of the anneal, where a chip's qubits begin to flip but
# keep most of their state.
REVERSE_TO = 0.45
MEND = "majority vote of the chain's qubits, +1 where they are even"

# Ocean's warnings by their class, in plain words.
WARNINGS = {
    "ChainLengthWarning": "some chains have more than 7 qubits and are likely to break; a sparser "
                          "encoding or a smaller window shortens them",
    "ChainStrengthWarning": "couplings of the problem are as strong as the chains; try a larger "
                            "--chain-strength, or smaller penalties",
    "EnergyScaleWarning": "some coefficients are a thousand times smaller than the largest and "
                          "drown in the chip's noise; smaller penalties help",
    "ChainBreakWarning": "the best samples have broken chains; try a larger --chain-strength",
    "TooFewSamplesWarning": "the lowest energy was seen in few samples. Descent from the samples "
                            "and merging them are free; more reads or a longer --annealing-time "
                            "may help"}


class Qpu:
    """A Problem for the quantum annealer; the interface of hybrid.Hybrid.

    With --fast-anneal, whose protocol knows no linear terms, these become couplings to one more
    variable: the energy is then the same for a state and its opposite, and that with the additional
    variable at +1 is the answer.
    """

    problem_type = "ising"

    def __init__(self, problem, options):
        self.problem, self.options = problem, options

    @property
    def least_copies(self):
        return 1 if self.options.copies == "auto" else self.options.copies

    def refusal(self, properties):
        options, n, qubits = self.options, self.problem.linear.size, len(properties["qubits"])
        known, fast = set(properties.get("parameters", {})), options.fast_anneal
        unknown = sorted(set(options.param or {}) - known) if known else []
        for wrong, said in (
                (n > qubits, f"{n:,} variables do not fit on a chip of {qubits:,} qubits; "
                             f"{SMALLER}, or use hybrid-nl"),
                (n * self.least_copies > qubits,
                 f"{options.copies} copies of {n:,} variables do not fit on a chip of {qubits:,} "
                 "qubits; take fewer --copies"),
                (fast and "fast_anneal" not in known,
                 "this solver has no fast anneal; `qstereo-bridge solvers` shows which has"),
                (options.reverse_from and not {"initial_state", "anneal_schedule"} <= known,
                 "this solver has no reverse annealing"),
                (unknown, f"this solver has no parameter {', '.join(unknown)}; it has "
                          + ", ".join(map(line, sorted(known))))):
            if wrong:
                return said
        return _outside(options.num_reads, "reads", properties.get("num_reads_range")) or _outside(
            options.annealing_time, "microseconds of annealing",
            properties.get("fast_anneal_time_range" if fast else "annealing_time_range"))

    def prepare(self, session, progress):
        from dwave.cloud.coders import encode_problem_as_qp
        from dwave.embedding import embed_bqm
        from dwave.embedding.chain_strength import uniform_torque_compensation
        from dwave.embedding.utils import edgelist_to_adjacency
        from dwave.system.warnings import WarningHandler

        progress("building the model")
        ising, solver = self.ising(), session.solver
        chains = self.embedding(ising, Chip.of_solver(solver), progress)
        chains = [sorted(map(int, chains[v])) for v in range(len(chains))]
        strength = self.options.chain_strength
        strength = float(uniform_torque_compensation(ising) if strength is None else strength)
        warnings = WarningHandler("save")
        warnings.energy_scale(ising)
        adjacency, linear, quadratic = edgelist_to_adjacency(solver.undirected_edges), {}, {}
        for at in range(0, len(chains), len(ising)):
            copy = dict(enumerate(chains[at:at + len(ising)]))
            warnings.chain_length(copy)
            warnings.chain_strength(ising, strength, copy)
            target = embed_bqm(ising, copy, adjacency, chain_strength=strength)
            linear.update(target.linear)
            quadratic.update(target.quadratic)
        lengths = np.array(list(map(len, chains)))
        parameters, sent = self.parameters(chains, session.properties)
        if too_long := self.too_long(solver, int(lengths.sum())):
            raise SolverError(too_long)
        return Request(
            sent, {**parameters, "chain_strength": strength},
            data=encode_problem_as_qp(solver, linear, quadratic, 0, undirected_biases=True),
            facts={"chains": chains, "chip": session.properties.get("chip_id"),
                   "warnings": sorted({one["type"].__name__ for one in warnings.saved}),
                   "embedding": {"copies": len(chains) // len(ising), "qubits": int(lengths.sum()),
                                 "longest_chain": int(lengths.max()),
                                 "mean_chain": float(lengths.mean())}})

    def ising(self):
        """The spins' model, variables 0 .. n - 1, and n for the linear terms of a fast anneal."""
        bqm = models.to_bqm(self.problem, self.options.memory_limit)
        bqm.change_vartype("SPIN", inplace=True)
        if self.options.fast_anneal:
            fields = [(v, len(bqm), bias) for v, bias in bqm.linear.items() if bias]
            bqm.add_variable(len(bqm), 0)
            bqm.add_quadratic_from(fields)
            bqm.add_linear_from([(v, -bias) for v, _, bias in fields])
        return bqm

    def embedding(self, ising, chip, progress):
        """The user's embedding, the one of this graph that is remembered, or a new one:
        {variable: qubits}, one copy after the other."""
        options, source = self.options, self.source(ising)
        try:
            if options.embedding:
                found = self.users(source, chip)
                if options.copies != 1:
                    found = embedding.find_copies(source, chip, options.copies, found,
                                                  options.seed, progress=progress)
            else:
                progress("looking for an embedding")
                found = embedding.obtain(source, chip, options.seed, progress=progress,
                                         copies=options.copies)
        except embedding.NoEmbedding as error:
            raise SolverError(f"the problem does not fit on this chip: {error}; {SMALLER}, or use "
                              "a hybrid solver") from None
        if options.copies == "auto" and not options.quiet:
            progress(None)
            count = len(found.chains) // source.variables
            print(f"qstereo-bridge {options.command}: {count:,} copies found on "
                  f"{line(chip.name)}: {options.num_reads * count:,} samples from "
                  f"{options.num_reads:,} reads (searched {found.seconds:.1f} of "
                  f"{embedding.TIMEOUT:g} s)", file=sys.stderr, flush=True)
        return found.chains

    def source(self, ising):
        """The graph of ising()."""
        pairs = np.sort(np.array(list(ising.quadratic), np.int32).reshape(-1, 2), axis=1)
        pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
        starts = self.problem.starts
        return embedding.Source(pairs[:, 0], pairs[:, 1], np.append(starts, len(ising))
                                if len(ising) > starts[-1] else starts)

    def users(self, source, chip):
        """The Embedding in the user's file. Raises Failure where it is none of this graph into this
        chip."""
        path = self.options.embedding
        with failing(path), io(path, "read"):
            found = embedding.read(path)
            if source.variables > len(found.chains) == self.problem.linear.size:
                raise InputError("--fast-anneal needs an embedding of its own, with one more "
                                 "variable: leave --embedding out")
            embedding.check(found, source, chip)
        return found

    def anneal(self, properties):
        """The annealing parameters, but for the state that reverse annealing begins from."""
        options = self.options
        told = given(num_reads=options.num_reads, annealing_time=options.annealing_time,
                     fast_anneal=options.fast_anneal or None)
        if options.reverse_from:
            time = told.pop("annealing_time", properties.get("default_annealing_time", 20.0))
            told["anneal_schedule"] = [[0.0, 1.0], [time / 4, REVERSE_TO],
                                       [3 * time / 4, REVERSE_TO], [time, 1.0]]
            told["reinitialize_state"] = True
        return {**told, **(options.param or {})}

    def parameters(self, chains, properties):
        """The annealing parameters: (for the user, for the service)."""
        from dwave.cloud.solver import StructuredSolver

        told, path = self.anneal(properties), self.options.reverse_from
        if not path:
            return told, told
        spins = np.resize(2 * self.start().astype(int) - 1, len(chains)).tolist()
        state = {qubit: spin for chain, spin in zip(chains, spins) for qubit in chain}
        return {**told, "reverse_from": os.path.basename(path)}, (
            StructuredSolver.reformat_parameters("ising", {**told, "initial_state": state},
                                                 properties))

    def start(self):
        """The bits of the best sample in --reverse-from: feasible ones first."""
        path = self.options.reverse_from
        with failing(path), io(path, "read"), open(path, "rb") as stream:
            samples = read_qsf(stream, self.options.memory_limit)
            if samples.digest != self.options.digest or not samples.records.size:
                raise InputError("these samples are not of this problem, or there are none")
        feasible = models.feasible(self.problem, samples.bits)
        return samples.bits[np.lexsort((samples.records["energy"], ~feasible))[0]]

    def decode(self, future, job):
        problem, sampleset = self.problem, future.sampleset
        reads = sampleset.record.num_occurrences
        check_occurrences(reads)
        if not np.isfinite(sampleset.record.energy).all():
            raise SolverError("the answer has energies that are not numbers")
        column = {qubit: at for at, qubit in enumerate(sampleset.variables)}
        samples = sampleset.record.sample
        lengths = np.array(list(map(len, job.chains)))
        columns = [column[qubit] for chain in job.chains for qubit in chain]
        sums = np.add.reduceat(samples[:, columns], np.cumsum(lengths) - lengths, axis=1,
                               dtype=np.int64)
        # A row for each copy, those of one read together.
        copies, n = job.embedding.get("copies", 1), problem.linear.size
        spins = np.where(sums >= 0, 1, -1).reshape(copies * len(samples), -1)
        spins[:, :n] *= spins[:, n:] if spins.shape[1] > n else 1
        broken = (np.abs(sums) != lengths).reshape(spins.shape).mean(axis=1)
        bits = (spins[:, :n] > 0).astype(np.uint8)
        energies, occurrences = models.energies(problem, bits), np.repeat(reads, copies)
        warnings = job.warnings + ["ChainBreakWarning"] * bool(
            broken[energies == energies.min()].min() > 0)
        warnings += ["TooFewSamplesWarning"] * more_reads_help(bits, energies, occurrences)
        return Answer(bits, occurrences=occurrences, broken=broken, info=plain({
            "timing": dict(future.timing), "chip": job.chip,
            "chain_strength": job.parameters["chain_strength"], "embedding": job.embedding,
            "broken_chains": MEND, **({"chains": job.chains} if copies == 1 else {}),
            "mean_broken_share": float(np.average(broken, weights=occurrences)),
            **({"warnings": [WARNINGS[name] for name in warnings]} if warnings else {})}))

    def plan(self, properties, solver=None):
        """`properties` None: of no account, by what D-Wave published; it fits where one of the
        chips takes it.

        Of an embedding that is known the upload and the charge are exact. Else the upload is what
        it is at least (each coupling on one coupler), the charge what it is at most (all qubits
        read out).
        """
        options, terms = self.options, models.Terms(self.problem)
        chips = (PUBLISHED_CHIPS if properties is None else
                 {properties.get("chip_id", "the chip"): properties})
        refusals = {name: self.refusal(chip) for name, chip in chips.items()}
        sizes = {name: len(chip["qubits"]) for name, chip in chips.items()}
        takers = [name for name, why in refusals.items() if why is None]
        count = terms.count
        if takers and terms.repeated:
            # What cancels is not sent.
            count = models.expand(self.problem, limit=options.memory_limit)[1][0].size
        found = {"variables": self.problem.linear.size, "quadratic_terms": count,
                 "copies": options.copies, "qubits": sizes, "limits": {},
                 "minimum_time_limit": None, "embedded_qubits": None,
                 "upload_bytes": _qp_bytes(min(sizes[name] for name in takers or sizes),
                                           self.least_copies * count),
                 "fits": None if takers else False,
                 "reason": None if takers else refusals[max(sizes, key=sizes.get)]}
        if takers and options.reverse_from:
            self.start()
        if not takers or solver is None:
            return found
        chip, source, known = Chip.of_solver(solver), self.source(self.ising()), None
        if options.embedding:
            known = self.users(source, chip)
            # The other copies are looked for anew each time.
            known = known if options.copies == 1 else None
        elif options.seed is None:
            known = embedding.kept(source, chip, options.copies)
        if known:
            used = np.isin(chip.couplers, known.used()).all(axis=1)
            found.update(fits=True, embedded_qubits=len(known.used()),
                         upload_bytes=_qp_bytes(chip.qubits.size, int(used.sum())))
        qubits = found["embedded_qubits"]
        found["charge_seconds"] = estimated_seconds(solver, qubits or chip.qubits.size,
                                                    self.anneal(solver.properties))
        if too_long := self.too_long(solver, qubits or source.variables * self.least_copies):
            found.update(fits=False, reason=too_long)
        return found

    def chains(self, solver):
        """What the embedding needs, found and kept for the call: qubits and lengths of chains. With
        `solver` None, on a Zephyr chip of twelve tiles each way. Raises NoEmbedding."""
        chip = Chip.named("zephyr:12") if solver is None else Chip.of_solver(solver)
        found = embedding.obtain(self.source(self.ising()), chip).figures()
        return {"embedded_qubits": found.pop("qubits"), **found, "fits": True}

    def too_long(self, solver, qubits):
        """The refusal of a solver whose chip all reads together would take longer than it allows,
        or None."""
        seconds = estimated_seconds(solver, qubits, self.anneal(solver.properties))
        longest = solver.properties.get("problem_run_duration_range")
        return (f"these reads would take the chip {seconds:.2f} s at once, it allows "
                f"{longest[1] / 1e6:g} s; take fewer --num-reads or a shorter --annealing-time"
                if seconds and longest and seconds * 1e6 > longest[1] else None)


def more_reads_help(bits, energies, occurrences):
    """Whether more reads are likely to help: states repeat themselves, and the best does not.

    By Good and Turing, the share of reads whose state was seen once is the chance that another
    read shows a new state. Where that is most of them, reads are few beside what there is to see,
    and a thousand more will not change it.
    """
    _, state = np.unique(np.packbits(bits, axis=1), axis=0, return_inverse=True)
    seen = np.bincount(state.ravel(), weights=occurrences)
    best = occurrences[energies == energies.min()].sum()
    return bool(2 * (seen == 1).sum() <= seen.sum() and best <= np.sqrt(seen.sum()))


def _qp_bytes(qubits, couplers):
    """Of the service's format qp: base64 of a double for each of the chip's qubits, used or not,
    and for each coupler between used ones."""
    return sum(4 * -(-8 * count // 3) for count in (qubits, couplers))


def _outside(value, what, bounds):
    """The refusal of a value that is outside the bounds, or None."""
    return (f"{value:g} {what}, this solver takes {bounds[0]:g} to {bounds[1]:,.10g}"
            if value is not None and bounds and not bounds[0] <= value <= bounds[1] else None)


def estimated_seconds(solver, qubits, anneal):
    """Seconds of QPU access time that the solver itself estimates for what Qpu.anneal() gives; None
    where it does not say."""
    # Every schedule of ours begins from a state; which one is nothing to the estimate.
    state = [1] if "anneal_schedule" in anneal else None
    try:
        return solver.estimate_qpu_access_time(num_qubits=qubits, initial_state=state,
                                               **anneal) / 1e6
    except (KeyError, ValueError):
        return None
