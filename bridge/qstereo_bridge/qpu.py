"""D-Wave's quantum annealer: embedding, chain strength, annealing parameters, and samples from broken and whole chains."""

import os

import numpy as np

from . import models
from .failure import BAD_INPUT, Failure, io
from .hybrid import SMALLER, Request
from .services import given, plain
from .solvers import Answer, SolverError

# Published in 2026; for --dry-run without an account.
PUBLISHED_QUBITS = {"Advantage (Pegasus P16)": 5627, "Advantage2 (Zephyr Z12)": 4577}
# Reverse annealing goes back to this share of the anneal, where a chip's qubits begin to flip but keep most of their state.
REVERSE_TO = 0.45
MEND = "majority vote of the chain's qubits, +1 where they are even"

# Ocean's warnings by their class, in plain words.
WARNINGS = {
    "ChainLengthWarning": "some chains have more than 7 qubits and are likely to break; a sparser encoding or a smaller "
                          "window shortens them",
    "ChainStrengthWarning": "couplings of the problem are as strong as the chains; try a larger --chain-strength, or "
                            "smaller penalties",
    "EnergyScaleWarning": "some coefficients are a thousand times smaller than the largest and drown in the chip's noise; "
                          "smaller penalties help",
    "ChainBreakWarning": "the best samples have broken chains; try a larger --chain-strength",
    "TooFewSamplesWarning": "the lowest energy was seen in few samples; take more reads, or a longer --annealing-time",
}


class Qpu:
    """A Problem for the quantum annealer; the interface of hybrid.Hybrid.

    With --fast-anneal, whose protocol knows no linear terms, these become couplings to one more variable: the energy is then the same
    for a state and its opposite, and that with the additional variable at +1 is the answer.
    """

    problem_type = "ising"

    def __init__(self, problem, options):
        self.problem, self.options = problem, options

    def check(self, properties):
        options, n, qubits = self.options, self.problem.linear.size, len(properties["qubits"])
        if n > qubits:
            raise SolverError(f"{n:,} variables do not fit on a chip of {qubits:,} qubits; {SMALLER}, or use hybrid-nl")
        if n * self.least_copies() > qubits:
            raise SolverError(f"{options.copies:,} copies of {n:,} variables do not fit on a chip of {qubits:,} qubits; take fewer --copies")
        _within(options.num_reads, "reads", properties.get("num_reads_range"))
        known = properties.get("parameters", {})
        if options.fast_anneal:
            if "fast_anneal" not in known:
                raise SolverError("this solver has no fast anneal; `qstereo-bridge solvers` shows which has")
            if options.reverse_from:
                raise SolverError("a fast anneal cannot begin from a state; leave out --fast-anneal or --reverse-from")
            if options.annealing_time is None:
                raise SolverError("--fast-anneal wants an --annealing-time")
        if options.reverse_from and not {"initial_state", "anneal_schedule"} <= set(known):
            raise SolverError("this solver has no reverse annealing")
        _within(options.annealing_time, "microseconds of annealing",
                properties.get("fast_anneal_time_range" if options.fast_anneal else "annealing_time_range"))

    def least_copies(self):
        return 1 if self.options.copies == "auto" else self.options.copies

    def prepare(self, session, progress):
        from dwave.cloud.coders import encode_problem_as_qp
        from dwave.embedding import embed_bqm
        from dwave.embedding.chain_strength import uniform_torque_compensation
        from dwave.embedding.utils import edgelist_to_adjacency
        from dwave.system.warnings import WarningHandler

        progress("building the model")
        ising, solver = self.ising(), session.solver
        chains = self.embedding(ising, _chip(solver), progress)
        chains = [sorted(map(int, chains[v])) for v in range(len(chains))]
        strength = self.options.chain_strength
        strength = float(uniform_torque_compensation(ising) if strength is None else strength)
        warnings = WarningHandler("save")
        warnings.energy_scale(ising)
        adjacency, linear, quadratic, offset = edgelist_to_adjacency(solver.undirected_edges), {}, {}, 0
        for at in range(0, len(chains), len(ising)):
            copy = dict(enumerate(chains[at:at + len(ising)]))
            warnings.chain_length(copy)
            warnings.chain_strength(ising, strength, copy)
            target = embed_bqm(ising, copy, adjacency, chain_strength=strength)
            linear.update(target.linear)
            quadratic.update(target.quadratic)
            offset += target.offset
        lengths = np.array(list(map(len, chains)))
        parameters, sent = self.parameters(chains, session.properties)
        _check_duration(solver, session.properties, int(lengths.sum()), sent)
        return Request(sent, {**parameters, "chain_strength": strength}, data=encode_problem_as_qp(
            solver, linear, quadratic, offset, undirected_biases=True), facts={
                "chains": chains, "chip": session.properties.get("chip_id"),
                "warnings": sorted({one["type"].__name__ for one in warnings.saved}),
                "embedding": {"copies": len(chains) // len(ising), "qubits": int(lengths.sum()), "longest_chain": int(lengths.max()),
                              "mean_chain": float(lengths.mean())}})

    def ising(self):
        """The spins' model, variables 0 .. n - 1, and n for the linear terms of a fast anneal."""
        bqm = models.to_bqm(self.problem, self.options.memory_limit).change_vartype("SPIN", inplace=True)
        if self.options.fast_anneal:
            fields = [(v, len(bqm), bias) for v, bias in bqm.linear.items() if bias]
            bqm.add_variable(len(bqm), 0)
            bqm.add_quadratic_from(fields)
            bqm.add_linear_from([(v, -bias) for v, _, bias in fields])
        return bqm

    def embedding(self, ising, chip, progress):
        """The user's embedding, the one of this graph that is remembered, or a new one: {variable: qubits}, one copy after the other."""
        from . import embedding

        options, pairs = self.options, np.sort(np.array(list(ising.quadratic), np.int32).reshape(-1, 2), axis=1)
        pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
        starts = self.problem.starts()
        source = embedding.Source(pairs[:, 0], pairs[:, 1], np.append(starts, len(ising)) if len(ising) > starts[-1] else starts)
        try:
            if options.embedding:
                with io(options.embedding, "read"):
                    found = embedding.read(options.embedding)
                embedding.check(found, source, chip)
                if options.copies != 1:
                    found = embedding.find_copies(source, chip, options.copies, found, options.seed, progress=progress)
            else:
                progress("looking for an embedding")
                found = embedding.obtain(source, chip, options.seed, progress=progress, copies=options.copies)
        except embedding.NotThisOne as error:
            prefix = "" if str(error).startswith(options.embedding) else f"{options.embedding}: "
            raise Failure(BAD_INPUT, f"{prefix}{error}") from None
        except embedding.NoEmbedding as error:
            raise SolverError(f"the problem does not fit on this chip: {error}; {SMALLER}, or use a hybrid solver") from None
        return found.chains

    def parameters(self, chains, properties):
        """The annealing parameters: (for the user, for the service)."""
        from dwave.cloud.solver import StructuredSolver

        options = self.options
        told = given(num_reads=options.num_reads, annealing_time=options.annealing_time, fast_anneal=options.fast_anneal or None)
        if not options.reverse_from:
            return told, told
        time = told.pop("annealing_time", None) or properties.get("default_annealing_time", 20.0)
        told["anneal_schedule"] = [[0.0, 1.0], [time / 4, REVERSE_TO], [3 * time / 4, REVERSE_TO], [time, 1.0]]
        told["reinitialize_state"] = True
        spins = 2 * self.start().astype(int) - 1
        spins = np.tile(spins, len(chains) // spins.size)
        state = {qubit: int(spin) for chain, spin in zip(chains, spins) for qubit in chain}
        sent = StructuredSolver.reformat_parameters("ising", {**told, "initial_state": state}, properties)
        return {**told, "reverse_from": os.path.basename(options.reverse_from)}, sent

    def start(self):
        """The bits of the best sample in --reverse-from: feasible ones first."""
        from .qsf import read_qsf

        path = self.options.reverse_from
        with io(path, "read"), open(path, "rb") as stream:
            samples = read_qsf(stream, self.options.memory_limit)
        if samples.digest != self.options.digest or not samples.records.size:
            raise Failure(BAD_INPUT, f"{path}: these samples are not of this problem, or there are none")
        order = np.lexsort((samples.records["energy"], ~models.feasible(self.problem, samples.bits)))
        return samples.bits[order[0]]

    @staticmethod
    def decode(problem, future, job):
        sampleset = future.sampleset
        column = {qubit: at for at, qubit in enumerate(sampleset.variables)}
        samples = sampleset.record.sample
        lengths = np.array(list(map(len, job.chains)))
        sums = np.add.reduceat(samples[:, [column[qubit] for chain in job.chains for qubit in chain]],
                               np.cumsum(lengths) - lengths, axis=1, dtype=np.int64)
        # A row for each copy, those of one read together.
        copies, n = job.embedding.get("copies", 1), problem.linear.size
        spins = np.where(sums >= 0, 1, -1).reshape(copies * len(samples), -1)
        spins[:, :n] *= spins[:, n:] if spins.shape[1] > n else 1
        broken = (np.abs(sums) != lengths).reshape(spins.shape).mean(axis=1)
        bits = (spins[:, :n] > 0).astype(np.uint8)
        energies = models.energies(problem, bits)
        occurrences = np.repeat(sampleset.record.num_occurrences, copies)
        best = energies == energies.min()
        warnings = list(job.warnings)
        warnings += ["ChainBreakWarning"] * bool(broken[best].min() > 0)
        warnings += ["TooFewSamplesWarning"] * bool(occurrences[best].sum() <= np.sqrt(occurrences.sum()))
        return Answer(bits, occurrences=occurrences, broken=broken, info=plain({
            "timing": dict(future.timing), "chip": job.chip, "chain_strength": job.parameters["chain_strength"],
            "embedding": job.embedding,
            "broken_chains": MEND, "mean_broken_share": float(np.average(broken, weights=occurrences)),
            **({"warnings": [WARNINGS[name] for name in warnings]} if warnings else {})}))

    def plan(self, properties):
        """`properties` None: of no account, by what D-Wave published."""
        n, terms = self.problem.linear.size, models.Terms(self.problem)
        chips = PUBLISHED_QUBITS if properties is None else {properties.get("chip_id", "the chip"): len(properties["qubits"])}
        found = {"variables": n, "quadratic_terms": terms.count, "copies": self.options.copies, "qubits": chips, "minimum_time_limit": None,
                 "fits": None if n * self.least_copies() <= max(chips.values()) else False}
        if found["fits"] is None:
            found.update(_ranges(*models.expand(self.problem, limit=self.options.memory_limit)))
        # The solver's format qp: base64 of one double for each qubit and each coupler, before embedding.
        return {**found, "upload_bytes": sum(4 * -(-8 * count // 3) for count in (n, found["quadratic_terms"]))}


def _chip(solver):
    """The working graph of one of D-Wave's chips."""
    from .embedding import Chip
    topology = solver.properties.get("topology", {})
    family, shape = topology.get("type"), topology.get("shape", [None])
    usual = family == "pegasus" or shape[1:] == [4]
    couplers = np.sort(np.array(sorted(solver.undirected_edges), np.int32).reshape(-1, 2), axis=1)
    return Chip(solver.name, family if usual else None, shape[0], np.array(sorted(solver.nodes), np.int32),
                couplers[np.lexsort((couplers[:, 1], couplers[:, 0]))])


def _within(value, what, bounds):
    if value is not None and bounds and not bounds[0] <= value <= bounds[1]:
        raise SolverError(f"{value:g} {what}, this solver takes {bounds[0]:g} to {bounds[1]:,.10g}")


def estimated_seconds(solver, qubits, sent):
    """Seconds of QPU access time that the solver itself estimates for parameters `sent`; None where it does not say."""
    try:
        return solver.estimate_qpu_access_time(
            num_qubits=qubits, num_reads=sent.get("num_reads", 1), annealing_time=sent.get("annealing_time"),
            anneal_schedule=sent.get("anneal_schedule"), reverse_anneal="initial_state" in sent,
            reinitialize_state=sent.get("reinitialize_state", False)) / 1e6
    except (KeyError, ValueError):
        return None


def _check_duration(solver, properties, qubits, sent):
    seconds, longest = estimated_seconds(solver, qubits, sent), properties.get("problem_run_duration_range")
    if seconds and longest and seconds * 1e6 > longest[1]:
        raise SolverError(f"these reads would take the chip {seconds:.2f} s at once, it allows {longest[1] / 1e6:g} s; "
                          "take fewer --num-reads or a shorter --annealing-time")


def _ranges(linear, quadratic, offset):
    """The number of quadratic terms, the largest degree and the ranges of the coefficients of an expanded problem."""
    rows, columns, values = quadratic
    degree = np.bincount(rows, minlength=linear.size) + np.bincount(columns, minlength=linear.size)
    return {"quadratic_terms": rows.size, "largest_degree": int(degree.max()),
            "linear_min": int(linear.min()), "linear_max": int(linear.max()),
            "quadratic_min": int(values.min()) if rows.size else None, "quadratic_max": int(values.max()) if rows.size else None}
