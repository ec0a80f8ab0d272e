"""D-Wave's quantum annealer: embedding, chain strength, parameters, samples from broken chains."""

import numpy as np

from ..core import models
from ..core.answers import Answer, check_occurrences
from ..core.failure import USAGE, Failure, SolverError, failing, io
from ..core.qsf import plain
from ..core.text import line, say
from . import embedding
from .embedding import Chip
from .hybrid import SMALLER, Request
from .services import given

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


def wide(bqm):
    """Whether some bias is a thousand times smaller than the largest. Ocean's own check counts
    those that are 0, too, which no noise drowns."""
    biases = np.abs([*bqm.linear.values(), *bqm.quadratic.values()])
    biases = biases[biases > 0]
    return bool(biases.size) and bool(1000 * biases.min() < biases.max())


class Qpu:
    """A Problem for the quantum annealer; the interface of hybrid.Hybrid."""

    problem_type = "ising"

    def __init__(self, problem, options):
        self.problem, self.options = problem, options

    @property
    def least_copies(self):
        return 1 if self.options.copies == "auto" else self.options.copies

    @property
    def anneal(self):
        """The parameters for the service."""
        options = self.options
        return {**given(num_reads=options.num_reads, annealing_time=options.annealing_time),
                **(options.param or {})}

    def refusal(self, properties):
        options, n, qubits = self.options, self.problem.linear.size, len(properties["qubits"])
        known = properties.get("parameters") or self.anneal
        if n * self.least_copies > qubits:
            copies = "" if self.least_copies == 1 else f"{options.copies} copies of "
            return (f"{copies}{n:,} variables do not fit on a chip of {qubits:,} qubits; "
                    f"{SMALLER}, use fewer --copies, or hybrid-nl")
        if unknown := sorted(set(options.param or {}) - set(known)):
            raise Failure(USAGE, f"this solver has no parameter {', '.join(unknown)}; it has "
                          + ", ".join(map(line, sorted(known))))
        if options.copies != "auto" and (said := self.too_many_reversals(options.copies)):
            return said
        for value, what, key in ((options.num_reads, "reads", "num_reads_range"), (
                options.annealing_time, "microseconds of annealing", "annealing_time_range")):
            low, high = properties.get(key, (-np.inf, np.inf))
            if value is not None and not low <= value <= high:
                return f"{value:g} {what}, this solver takes {low:g} to {high:,.10g}"
        return None

    def too_many_reversals(self, copies):
        """The refusal of more --spin-reversals than copies, or None."""
        wanted = self.options.spin_reversals or 1
        return ("a job is one request, with one spin reversal for each copy of the problem; for "
                f"{wanted:,} of them take --copies {wanted}, or send several jobs, each of which "
                "is charged" if wanted > copies else None)

    def prepare(self, session, progress):
        from dwave.cloud.coders import encode_problem_as_qp
        from dwave.embedding import embed_bqm
        from dwave.embedding.chain_strength import uniform_torque_compensation
        from dwave.embedding.utils import edgelist_to_adjacency
        from dwave.system.warnings import WarningHandler

        progress("building the model")
        options, solver, warnings = self.options, session.solver, WarningHandler("save")
        ising = models.to_bqm(self.problem).change_vartype("SPIN")
        found, n = self.embedding(Chip.of_solver(solver), progress), len(ising)
        chains = [sorted(map(int, found[v])) for v in range(len(found))]
        lengths, copies = np.array(list(map(len, chains))), len(chains) // n
        if refusal := self.too_long(solver, int(lengths.sum())) or self.too_many_reversals(copies):
            raise SolverError(refusal)
        strength = options.chain_strength or float(uniform_torque_compensation(ising))
        flips = np.random.default_rng(options.seed).integers(0, 2, (options.spin_reversals or 0, n))
        adjacency, linear, quadratic = edgelist_to_adjacency(solver.undirected_edges), {}, {}
        for c in range(copies):
            copy, source = dict(enumerate(chains[c * n:(c + 1) * n])), ising.copy()
            for v in np.flatnonzero(flips[c % len(flips)]) if len(flips) else ():
                source.flip_variable(v)
            warnings.chain_length(copy)
            warnings.chain_strength(ising, strength, copy)
            target = embed_bqm(source, copy, adjacency, chain_strength=strength)
            linear.update(target.linear)
            quadratic.update(target.quadratic)
        told = {**self.anneal, "chain_strength": strength,
                **given(spin_reversals=options.spin_reversals)}
        return Request(
            self.anneal, told,
            data=encode_problem_as_qp(solver, linear, quadratic, 0, undirected_biases=True),
            facts={"chains": chains, "flips": flips.tolist(),
                   "chip": session.properties.get("chip_id"),
                   "warnings": sorted({*(one["type"].__name__ for one in warnings.saved),
                                       *["EnergyScaleWarning"] * wide(ising)}),
                   "embedding": {"copies": copies, "qubits": int(lengths.sum()),
                                 "longest_chain": int(lengths.max()),
                                 "mean_chain": float(lengths.mean())}})

    def embedding(self, chip, progress):
        """The user's embedding, a remembered one of this graph, or a new one: {variable: qubits},
        one copy after the other."""
        options, source = self.options, embedding.Source.of(self.problem)
        progress("looking for an embedding")
        try:
            found = self.users(source, chip) or embedding.obtain(
                source, chip, options.seed, progress=progress, copies=options.copies)
        except embedding.NoEmbedding as error:
            raise SolverError(f"the problem does not fit on this chip: {error}; {SMALLER}, or use "
                              "a hybrid solver") from None
        if options.copies == "auto" and not options.quiet:
            progress(None)
            count = len(found.chains) // len(source.graph)
            say(options, f"{count:,} copies found on {line(chip.name)}: "
                         f"{options.num_reads * count:,} samples from {options.num_reads:,} reads "
                         f"(searched {found.seconds:.1f} of {embedding.TIMEOUT:g} s)")
        return found.chains

    def users(self, source, chip):
        """The Embedding in the user's file, None without one. Raises Failure where it is none of
        this graph into this chip."""
        path = self.options.embedding
        if path is None:
            return None
        with failing(path), io(path, "read"):
            found = embedding.read(path)
            embedding.check(found, source, chip)
        return found

    def decode(self, future, job):
        problem, sampleset, n = self.problem, future.sampleset, self.problem.linear.size
        reads = sampleset.record.num_occurrences
        check_occurrences(reads)
        if not np.isfinite(sampleset.record.energy).all():
            raise SolverError("the answer has energies that are not numbers")
        column = {qubit: at for at, qubit in enumerate(sampleset.variables)}
        lengths = np.array(list(map(len, job.chains)))
        columns = [column[qubit] for chain in job.chains for qubit in chain]
        sums = np.add.reduceat(sampleset.record.sample[:, columns], np.cumsum(lengths) - lengths,
                               axis=1, dtype=np.int64)
        # A row for each copy, those of one read together.
        copies = job.embedding.get("copies", 1)
        bits = (sums >= 0).astype(np.uint8).reshape(-1, n)
        if flips := getattr(job, "flips", None):
            bits ^= np.resize(np.array(flips, np.uint8), (copies, n))[
                np.arange(len(bits)) % copies]
        broken = (np.abs(sums) != lengths).reshape(bits.shape).mean(axis=1)
        energies, occurrences = models.energies(problem, bits), np.repeat(reads, copies)
        warnings = job.warnings + ["ChainBreakWarning"] * bool(
            broken[energies == energies.min()].min() > 0)
        # Descent and merging, which follow else, make more of the reads than their best.
        warnings += ["TooFewSamplesWarning"] * (
            getattr(self.options, "no_postprocess", False)
            and more_reads_help(bits, energies, occurrences))
        return Answer(bits, occurrences=occurrences, broken=broken, info=plain({
            "timing": dict(future.timing), "chip": job.chip,
            "chain_strength": job.parameters["chain_strength"], "embedding": job.embedding,
            "broken_chains": MEND, **({"chains": job.chains} if copies == 1 else {}),
            "mean_broken_share": float(np.average(broken, weights=occurrences)),
            **({"warnings": [WARNINGS[name] for name in warnings]} if warnings else {})}))

    def plan(self, properties, solver=None):
        """Where an embedding is known, upload and charge are exact. Else the upload is what it is
        at least (each coupling on one coupler), the charge what it is at most (all qubits used)."""
        options, terms, reason = self.options, models.Terms(self.problem), self.refusal(properties)
        count, qubits = terms.count, len(properties["qubits"])
        if not reason and terms.repeated:
            # What cancels is not sent.
            count = models.expand(self.problem)[1][0].size
        found = {"variables": self.problem.linear.size, "quadratic_terms": count,
                 "copies": options.copies, "limits": {}, "minimum_time_limit": None,
                 "qubits": {properties.get("chip_id", "the chip"): qubits}, "embedded_qubits": None,
                 "upload_bytes": _qp_bytes(qubits, self.least_copies * count),
                 "fits": False if reason else None, "reason": reason}
        if reason or solver is None:
            return found
        source, chip = embedding.Source.of(self.problem), Chip.of_solver(solver)
        known = self.users(source, chip) or (
            embedding.kept(source, chip, options.copies) if options.seed is None else None)
        if known:
            couplers = chip.graph.subgraph(known.used()).number_of_edges()
            found.update(fits=True, embedded_qubits=len(known.used()),
                         upload_bytes=_qp_bytes(qubits, couplers))
        used = found["embedded_qubits"]
        found["charge_seconds"] = self.seconds(solver, used or qubits)
        if too_long := self.too_long(solver, used or len(source.graph) * self.least_copies):
            found.update(fits=False, reason=too_long)
        return found

    def seconds(self, solver, qubits):
        """QPU access time by the solver's own estimate; None where it does not say."""
        try:
            return solver.estimate_qpu_access_time(num_qubits=qubits, **self.anneal) / 1e6
        except (KeyError, ValueError, TypeError):
            return None

    def too_long(self, solver, qubits):
        """Why the solver does not take all reads at once, or None."""
        seconds = self.seconds(solver, qubits)
        longest = solver.properties.get("problem_run_duration_range", (0, np.inf))[1] / 1e6
        return (f"these reads would take the chip {seconds:.2f} s at once, it allows {longest:g} "
                "s; take fewer --num-reads or a shorter --annealing-time"
                if seconds and seconds > longest else None)


def more_reads_help(bits, energies, occurrences):
    """Whether states repeat themselves and the best does not. Where most reads show a state that
    was seen once (by Good and Turing: so would another read), more of them change nothing."""
    _, state = np.unique(np.packbits(bits, axis=1), axis=0, return_inverse=True)
    seen = np.bincount(state.ravel(), weights=occurrences)
    best = occurrences[energies == energies.min()].sum()
    return bool(2 * (seen == 1).sum() <= seen.sum() and best <= np.sqrt(seen.sum()))


def _qp_bytes(qubits, couplers):
    """Of the service's format qp: base64 of a double for each of the chip's qubits, and for each
    coupler between used ones."""
    return sum(4 * -(-8 * count // 3) for count in (qubits, couplers))
