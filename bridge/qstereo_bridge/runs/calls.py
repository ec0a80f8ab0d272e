"""The command `solve --windows`: call by call until the proven bound, and on from where an earlier
run ended.

What a call answers is in the journal, S.qsf.journal, before its job file, S.qsf.call-K.job, goes;
the plan of the calls follows from problem, seed and number. So the same command goes on after any
end, and each call is charged once.
"""

import base64
import contextlib
import copy
import dataclasses
import functools
import hashlib
import itertools
import json
import math
import os
import time

import numpy as np

from ..core import merging, qcf
from ..core.failure import BAD_INPUT, NO, Failure, failing, io
from ..core.output import Output
from ..core.problem import load_samples, made
from ..core.qsf import NO_CHAINS, RECORD, Samples
from ..core.text import parse
from ..samplers import windows
from ..ocean import embedding
from . import bill, jobs, registry, remote, runner

UNREDUCED = ("windows of a picture that is not reduced gain nothing. Reduce it, then give the "
             "windows of what is left:\n"
             "  qstereo reduce {0} -o core.qcf --encoding domain-wall --truncate\n"
             "  qstereo-bridge solve core.qcf -o {1} --solver {2} --windows {3}")


def _reduced(problem):
    """Whether some label has left. A QUBO of no known encoding counts as reduced."""
    return problem.encoding is None or qcf.kept(problem)[2] > 0


class Journal(jobs.Held):
    """The journal in the file `path`: JSON, `head`, which says what the run is, then a line for
    each call, on the disk before the next call.

    lines       list of dicts, those of the calls
    Raises Failure, also for the journal of another run.
    """

    def __init__(self, path, head):
        super().__init__(path)
        try:
            self.head, *self.lines = map(parse, (self.take() or b"").splitlines() or [
                json.dumps(head)])
            _charge(self.lines)  # this and the next raise on lines that are not of a journal
            for line in self.lines:
                _bits(line, 0)
        except (ValueError, KeyError, TypeError):
            self.head = None
        if self.head != head:
            self.leave()
            raise Failure(NO, f"{path}: the journal of another run (its problem, --windows, "
                              "--seed, --solver or --start differ); give another -o, or remove "
                              "the journal to begin anew")
        self.append()

    def append(self, *lines):
        """Add the lines of calls, and have them on the disk."""
        self.put("".join(json.dumps(line) + "\n" for line in [
            self.head, *self.lines, *lines]).encode())
        self.lines += lines


class _Run:
    """A run: the problem, the best state known, and the bound; energies in the file's units."""

    def __init__(self, options):
        self.options, self.session, self.tell = options, None, runner.progress(options)
        self.p = made(runner.read(options))
        problem = self.p
        if len(self.p) > options.windows and not _reduced(problem):
            raise Failure(BAD_INPUT, UNREDUCED.format(options.problem, options.output or "s.qsf",
                                                      options.solver, options.windows))
        self.known = bool(options.start) or problem.known is not None
        self.bits = windows.begin(self.p) if problem.known is None else problem.known
        bounds = {"--bound": options.bound}
        if options.start:
            with failing(options.start):
                samples = load_samples(options.start, options.memory_limit)
                best = merging.best_of(problem, samples)
            if samples.digest != problem.digest or best is None:
                raise Failure(BAD_INPUT, f"{options.start}: these samples are not of this problem, "
                                         "or there are none")
            self.bits = samples.bits[best]
            bounds[options.start] = samples.info.get("lower_bound")
        bounds[options.problem] = self.real(problem.stated_bound)
        self.bound_of, bound = next(((of, bound) for of, bound in bounds.items()
                                     if type(bound) in (int, float)), (None, None))
        # Energies are whole numbers of units, and below 2^53.
        self.bound = None if bound is None else math.ceil(
            min(max(bound * self.p.scale, -2.0**53), 2.0**53) - 1e-6)
        self.check()

    @property
    def energy(self):
        return int(self.p.energies(self.bits)[0])

    @property
    def proven(self):
        """Whether the best state is at a bound on the user's word: a file may state anything."""
        return self.energy == self.bound and self.bound_of == "--bound"

    def check(self):
        if self.bound is not None and self.energy < self.bound:
            raise Failure(BAD_INPUT, f"the lower bound {self.real(self.bound)} is none of this "
                                     f"problem: a state has {self.real(self.energy)}")

    def real(self, energy):
        return runner.real(energy, self.p.scale)

    def calls(self):
        """(number, (variables, whether it is the last of its pass)), at most --calls."""
        options = self.options
        return enumerate(itertools.islice(
            windows.calls(self.p, options.windows, options.seed or 0), options.calls))

    def head(self):
        options = self.options
        return {"schema": 1, "format": "qstereo-journal", "problem": self.p.digest.hex(),
                "windows": options.windows, "seed": options.seed or 0, "solver": options.solver,
                "begins_from": hashlib.sha256(self.bits.tobytes()).hexdigest()}

    @functools.cached_property
    def chip(self):
        """That of the solver; without an account a Zephyr of twelve tiles each way."""
        return (embedding.Chip.of_solver(self.session.solver) if self.session else
                embedding.Chip.named("zephyr:12"))

    @functools.cached_property
    def whole(self):
        """An Embedding of the whole problem, of which that of each window is a part; None where the
        chip is too small for it."""
        source = embedding.Source.of(self.p)
        if 2 * len(source.graph) <= len(self.chip.graph):
            with contextlib.suppress(embedding.NoEmbedding):
                return embedding.obtain(source, self.chip, progress=self.tell)
        return None

    def embedded(self, part, variables):
        """The Embedding of a window, which is kept for its call. Raises NoEmbedding."""
        source = embedding.Source.of(part)
        if self.whole:
            chains = {at: self.whole.chains[v] for at, v in enumerate(variables.tolist())}
            embedding.keep(dataclasses.replace(self.whole, problem=source.digest, chains=chains),
                           source, self.chip)
        return embedding.obtain(source, self.chip, progress=self.tell)

    def samples(self, lines):
        """The Samples for the file: the best state known, and what each call was."""
        info = {"windows": self.options.windows, "seed": self.options.seed or 0,
                "lower_bound": self.real(self.bound), "bound_of": self.bound_of,
                "calls": [{key: value for key, value in line.items() if key != "bits"}
                          for line in lines]}
        return Samples(self.p.digest, self.options.solver, np.array(
            [(self.energy, 1, NO_CHAINS)], RECORD), self.bits[None], info)


def _options_of(options, number):
    """The options of one call."""
    call = copy.copy(options)
    call.output = f"{options.output}.call-{number + 1}"
    call.label = options.label and f"{options.label} call {number + 1}"
    # An embedding that is kept serves every run.
    call.seed = (None if registry.find(options.solver).paid or options.seed is None
                 else (options.seed + number) % 2**31)
    call.max_charge = None
    return call


def charged(info):
    """Seconds that the service has charged, by its own timing."""
    timing = info.get("timing", {})
    return timing.get("charge_time", timing.get("qpu_access_time", 0)) / 1e6


def _line(run, number, variables, answer, found):
    """The journal's line of a call that gave `found` as the best state."""
    said = answer.info
    return {"call": number + 1, "variables": int(variables.size),
            "energy": run.real(run.energy), "samples": int(answer.bits.shape[0]),
            "charge_seconds": charged(said),
            **{key: said[key] for key in ("problem_id", "service_solver", "embedding",
                                          "mean_broken_share", "timing") if key in said},
            "bits": base64.b64encode(np.packbits(found, bitorder="little").tobytes()).decode()}


def _bits(line, n):
    packed = np.frombuffer(base64.b64decode(line["bits"]), np.uint8)
    return np.unpackbits(packed, count=n, bitorder="little")


def solve(options):
    """Solve by windows, write the samples, print."""
    began = time.monotonic()
    with io(options.output, "write"), Output(options.output, last=False):
        run = _Run(options)
    if not len(run.p):
        # Nothing is left to decide.
        return remote.solve(options)
    with (Journal(f"{options.output}.journal", run.head()) as journal,
          remote.account(options) as run.session):
        if options.max_charge is not None:
            bill.check(options, _plans(run))
        _calls(run, journal)
        run.tell(None)
        return _deliver(run, journal, time.monotonic() - began)


def _calls(run, journal):
    """The calls that are still to be made, each into journal and samples file."""
    options, before = run.options, run.energy if run.known else None
    for number, (variables, last) in run.calls():
        known = number > 0 or run.known
        if known and run.energy == run.bound:
            return
        if number < len(journal.lines):
            run.bits = _bits(journal.lines[number], len(run.p))
            # The job file of an answer that is in the journal.
            with contextlib.suppress(FileNotFoundError):
                os.remove(jobs.path_of(f"{options.output}.call-{number + 1}", b""))
        else:
            part = windows.window(run.p, run.bits, variables)
            call = _options_of(options, number)
            if options.solver == "qpu":
                run.embedded(part, variables)
            with remote.answered(
                    call, part,
                    lambda text: run.tell(text and f"call {number + 1}, {text}"),
                    run.session, again=True) as answer:
                runner.checked(call, part, answer)
                run.bits = windows.improved(run.p, run.bits, variables, answer.bits, known)
                run.check()
                journal.append(_line(run, number, variables, answer, run.bits))
                run.samples(journal.lines).save(options.output)
            run.tell(None)
            if not options.quiet and not options.json:
                runner.say(options, f"call {len(journal.lines)}: {_state(run, journal)}")
        # Without a bound to end at, a pass that gains nothing is the last.
        if last and run.bound is None and run.energy == before:
            return
        before = run.energy if last else before


def _charge(lines):
    """Seconds charged so far."""
    return sum(line["charge_seconds"] for line in lines)


def _state(run, journal):
    """The best state known, and the charge, in words."""
    said = "" if run.bound_of in (None, "--bound") else f" (stated by {run.bound_of})"
    bound = (f", bound {run.real(run.bound)}{said}, gap {run.real(run.energy - run.bound)}"
             if run.bound_of else ", bound not known")
    charge = f", charged {_charge(journal.lines):,.3f} s"
    return f"energy {run.real(run.energy)}{bound}" + charge * bool(
        registry.find(run.options.solver).paid)


def _deliver(run, journal, seconds):
    """Write the samples file once more: the last call's may be missing; print the result."""
    options, done = run.options, journal.lines
    run.samples(done).save(options.output)
    proven = run.proven
    gap = None if run.bound is None else run.energy - run.bound
    text = (f"{options.solver}: {len(done)} calls, {_state(run, journal)}"
            f"{' (proven optimal)' * proven}; {seconds:.1f} s\n{options.output}: written")
    if run.bound is None:
        text += "\nTo prove it and to end at once, give --bound: `qstereo reduce` prints it"
    elif gap == 0 and not proven:
        text += (f"\nIt meets the lower bound that {run.bound_of} states. To have that checked: "
                 "`qstereo reduce --certificate C.qpf`, then `qstereo verify`")
    if not done:
        text += ("\nNo call was made: the labelling that it begins from meets the bound. "
                 "--alone begins without it")
    runner.show(options, text, {
        "solver": options.solver, "energy": run.real(run.energy),
        "best_energy": run.real(run.energy), "lower_bound": run.real(run.bound),
        "bound_of": run.bound_of, "gap": run.real(gap), "proven_optimal": proven, "samples": 1,
        "feasible": int(run.p.feasible(run.bits)[0]) if run.p.groups_say_all else None,
        "calls": len(done),
        "variables_of_calls": [line["variables"] for line in done],
        "energies_of_calls": [line["energy"] for line in done],
        "charge_seconds": _charge(done), "seconds": round(seconds, 3)})


def _plans(run):
    """What each call would send, at most: dicts. On a chip with its embedding, which is kept."""
    options, plans = run.options, []
    if run.known and run.energy == run.bound:
        return plans
    for number, (variables, _) in run.calls():
        part, chains = windows.window(run.p, run.bits, variables), {}
        if options.solver == "qpu":
            figures = run.embedded(part, variables).figures()
            chains = {"embedded_qubits": figures.pop("qubits"), **figures, "fits": True}
        call = _options_of(options, number)
        plans.append({"call": number + 1, **bill.plan(call, run.session, part),
                      **chains})
    return plans


def dry_run(options):
    """The command `solve --windows --dry-run`."""
    bill.show(options, "calls", planned(options))


def planned(options):
    """What each call would send, at most: dicts."""
    run = _Run(options)
    with remote.account(options) as run.session:
        found = _plans(run)
    run.tell(None)
    return found
