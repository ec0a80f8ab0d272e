"""One run of the command: read a problem, have it solved, check the answer, write and tell it."""

import contextlib
import json
import sys
import time

import numpy as np

from ..core import merging, models, problem as api, qsf
from ..core.answers import Answer, nothing_to_decide, samples_of
from ..core.container import FormatError, OverLimit
from ..core.failure import IO, Failure, SolverError, io
from ..core.output import Output
from ..core.qcf import DOMAIN_WALL, read_qcf
from ..core.text import line, lines, say


def progress(options):
    """A function that shows one line of progress on a terminal, elsewhere nothing; with None it
    clears the line."""
    if options.quiet or hasattr(options, "said") or not sys.stderr.isatty():
        return lambda text: None
    began = time.monotonic()

    def show(text):
        seconds = time.monotonic() - began
        said = "" if text is None else f"{options.solver}: {text}, {seconds:.0f} s"
        print(f"\r\033[K{said}", end="", file=sys.stderr, flush=True)
    return show


def read(options):
    """The qcf.Coefficients of the problem that the options name."""
    name = options.problem
    with io(name, "read"), open(0 if name == "-" else name, "rb", closefd=name != "-") as stream:
        problem = read_qcf(stream, options.memory_limit)
    models.check_known(problem)
    if getattr(options, "alone", False):
        problem.known = problem.stated_bound = None
    return problem


def show(options, text, facts):
    """A result: `text`, or with --json `facts`, on stdout, or on stderr where the samples go to
    stdout. One of several problems keeps it in `options.said`."""
    if hasattr(options, "said"):
        options.said.append((text, facts))
        return
    dry_run = getattr(options, "dry_run", False)
    aside = getattr(options, "output", None) == "-" and not dry_run
    if options.json or dry_run or not getattr(options, "quiet", False):
        with io("stderr" if aside else "stdout", "write"):
            print(json.dumps({"schema": 1, **facts}) if options.json else lines(text),
                  file=sys.stderr if aside else sys.stdout, flush=True)


@contextlib.contextmanager
def output_of(options, last=True):
    """deliver(data, text, facts) for a `with` in which the work is done: it writes the bytes, shows
    the result, and gives the file its name last, when all else has gone well."""
    def deliver(data, text, facts):
        with io(options.output, "write"):
            output.write(data)
        show(options, text, facts)
        with io(options.output, "write"):
            output.keep()
    with io(options.output, "write"):
        output = Output(options.output, last)
    with output:
        yield deliver


def solve(options, ask):
    """Solve, check, write, show.

    ask(problem, progress) -> a context of the Answer in which it is written; of None, where nothing
    is.
    """
    with (output_of(options, last=not hasattr(options, "said")) as deliver,
          contextlib.ExitStack() as stack):
        problem = read(options)
        began, tell = time.monotonic(), progress(options)
        stack.callback(tell, None)
        with (contextlib.nullcontext(nothing_to_decide(problem)) if problem.linear.size == 0 else
              ask(problem, tell)) as answer:
            tell(None)
            if answer is not None:
                samples = checked(options, problem, answer)
                if not getattr(options, "no_postprocess", False) and answer.lower_bound is None:
                    try:
                        samples = merging.finished(problem, samples, problem.known)
                    except OverLimit as error:
                        raise Failure(IO, f"{error}. With --no-postprocess the samples are written "
                                          "as they are") from None
                told = _summary(options, problem, answer, samples, time.monotonic() - began)
                deliver(_sound(qsf.pack_qsf(samples)), *told)


def merge(options):
    """The command `merge`."""
    with output_of(options) as deliver:
        began = time.monotonic()
        problem = api.made(read(options))
        found = merging.merge(problem, *(api.load_samples(name, options.memory_limit)
                                         for name in options.samples))
        deliver(_sound(qsf.pack_qsf(found)), *_summary(
            options, problem, Answer(found.bits), found, time.monotonic() - began))


def checked(options, problem, answer):
    """The Samples of the answer; its warnings are told. Raises SolverError where the solver's
    energies are not the recomputed ones, but for floating point's rounding."""
    samples = samples_of(problem, options.solver, answer)
    expected = samples.records["energy"]
    if not expected.size:
        raise SolverError("the solver's answer has no samples")
    if answer.energies is not None:
        if answer.objective:
            expected = models.energies(problem, answer.bits, False)
        rounding = 0.5 + float(problem.magnitude(np.int64)) * 2**-44
        wrong = ~(np.abs(answer.energies - expected) <= rounding)
        if wrong.any():
            at = wrong.argmax()
            raise SolverError(f"internal error: the solver says that sample {at} has energy "
                              f"{answer.energies[at]}, it has {expected[at]}; please report this")
    for warning in [] if options.quiet else answer.info.get("warnings", []):
        say(options, f"warning: {line(str(warning))}")
    return samples


def _sound(data):
    """The bytes of a .qsf, read once more: what cannot be read again does not end a job."""
    try:
        qsf.parse_qsf(data, sys.maxsize)
    except FormatError as error:
        raise SolverError(f"internal error: the samples would make no sound .qsf ({error}); "
                          "please report this") from None
    return data


def real(energy, scale):
    """An energy in real units; a whole number stays one."""
    return None if energy is None else energy // scale if energy % scale == 0 else energy / scale


def _summary(options, problem, answer, samples, seconds):
    """(text, facts) of the samples."""
    energies = samples.records["energy"]
    good = energies[models.feasible(problem, samples.bits)]
    told = problem.groups_say_all
    least, bound = min(energies.tolist(), default=None), answer.lower_bound
    # A minimum of H that is no labelling proves nothing of the labellings.
    proven = bound is not None and bool((good == bound).any())
    # Of the states of domain walls only labellings are those of an integer program.
    of_what = ("optimal" if told else "best of all labellings"
               if answer.objective and problem.encoding == DOMAIN_WALL else "least of the QUBO")
    figures = {key: real(value, problem.scale) for key, value in {
        "energy": least, "lower_bound": bound, "gap": None if bound is None else least - bound,
        "best_energy": min(good.tolist(), default=None)}.items()}
    bounded = ("" if bound is None else
               f" (proven {of_what})" if proven else
               f" (at most {figures['gap']} above the least)" if bound < least else
               " (the minimum of the QUBO is infeasible: the penalty is too small)")
    best = ("`qstereo validate` says which samples are labellings" if not told else
            f"{good.size} feasible, best energy of these {figures['best_energy']}" if good.size else
            "none feasible")
    count = "1 sample" if energies.size == 1 else f"{energies.size} samples"
    if samples.info.get("result", {}).get("known"):
        count += f" (merged with the labelling that {options.problem} carries)"
    return (f"{options.solver}: {count}, best energy {figures['energy']}{bounded}; {best}; "
            f"{seconds:.1f} s\n{options.output}: written",
            {"solver": options.solver, **figures, "proven_optimal": proven if told else None,
             "iterations": answer.iterations, "seconds": round(seconds, 3),
             "samples": energies.size, "feasible": good.size if told else None})
