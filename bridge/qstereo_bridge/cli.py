"""The command qstereo-bridge. Results go to stdout, messages and progress to stderr."""

import argparse
import contextlib
import importlib
import json
import os
import sys
import time
from dataclasses import dataclass

from . import __version__
from .failure import BAD_INPUT, IO, OK, SERVICE, USAGE, Failure, io


@dataclass(frozen=True)
class Solver:
    """One row of the table of solvers: where its function is, and the options that it takes with their defaults.

    kind        the name of the class of one of D-Wave's services; None = it runs on this machine
    """

    module: str
    summary: str
    options: dict
    kind: str = None

    def run(self, name, *arguments):
        return getattr(importlib.import_module("." + self.module, __package__), self.kind or name.replace("-", "_"))(*arguments)


SERVICE_OPTIONS = {"solver_name": None, "label": None}


# No module of a solver is imported before it runs: --help does not wait for numpy, local solvers not for the cloud client.
SOLVERS = {
    "anneal": Solver("solvers", "simulated annealing, finished by steepest descent (the default)",
                     {"num_reads": 20, "num_sweeps": 1000, "seed": None, "time_limit": None}),
    "tabu": Solver("solvers", "tabu search; --time-limit is for all reads together",
                   {"num_reads": 10, "seed": None, "time_limit": 10.0}),
    "exact": Solver("solvers", "every state; at most 24 variables; writes up to 100 of the best, feasible ones first", {}),
    "ilp": Solver("ilp", "integer programs solved by HiGHS, one for each connected part: the proven least labelling",
                  {"time_limit": None}),
    "qpu": Solver("qpu", "D-Wave's quantum annealer, by minor embedding",
                  {"num_reads": 1000, "annealing_time": None, "chain_strength": None, "fast_anneal": None, "reverse_from": None,
                   "embedding": None, "copies": 1, "seed": None, **SERVICE_OPTIONS}, "Qpu"),
    "hybrid-nl": Solver("hybrid", "D-Wave's nonlinear hybrid solver, one integer a site: for pictures of more than a few thousand pixels",
                        {"time_limit": None, **SERVICE_OPTIONS}, "Nl"),
    "hybrid-bqm": Solver("hybrid", "D-Wave's hybrid solver, penalties in the model", {"time_limit": None, **SERVICE_OPTIONS}, "Bqm"),
    "hybrid-cqm": Solver("hybrid", "D-Wave's hybrid solver, one-hot groups as constraints, no penalties",
                         {"time_limit": None, **SERVICE_OPTIONS}, "Cqm"),
}

EPILOG = "\n".join([
    "solvers:",
    *(f"  {name:<11} {solver.summary}\n" + " " * 14 + "takes " + (", ".join(
        f"--{option.replace('_', '-')}" + (f" ({default:g})" if default is not None else "")
        for option, default in solver.options.items()) or "no options") for name, solver in SOLVERS.items()),
    """
exit status: 0 done, 1 a no (several problems: one of them failed; this problem was sent already; no answer yet), 2 usage, 3 bad
input, 4 cannot read or write or over the memory limit, 5 the solver or its service failed or refused, 130 interrupted (128 + the
signal). A failed command leaves no output file, and an existing one as it
was; that the output can be written is seen to before anything is sent.

exact proves the minimum of the QUBO. Where that is infeasible, the penalty is too small, and nothing is proven of labellings.
ilp leaves the penalties out and proves the minimum over the states with one variable at 1 in each one-hot group: in one-hot
and one-hot-sparse, over the labellings. It takes one-hot-sparse, and reduced problems, hundreds of times faster than other
encodings (`qstereo reduce core.qcf -o sparse.qcf --encoding one-hot-sparse` writes a core anew). --time-limit is for the search
in all parts together; where it ends it the bound still holds. It needs HiGHS: pip install qstereo-bridge[exact].

examples:
  qstereo-bridge solve p.qcf -o s.qsf
  qstereo-bridge solve p.qcf -o s.qsf --num-reads 50 --seed 1 --json
  qstereo-bridge solve p.qcf -o s.qsf --solver ilp --time-limit 60
  qstereo-bridge solve p.qcf --solver hybrid-cqm --dry-run
  qstereo-bridge solve p.qcf -o s.qsf --solver qpu --num-reads 1000 --annealing-time 50
  qstereo-bridge solve p.qcf -o s.qsf --solver hybrid-nl --no-wait && qstereo-bridge collect s.qsf.job
  qstereo-bridge solve frames/*.qcf --out-dir answers --solver hybrid-nl --jobs 4

D-Wave's services (qpu, hybrid-nl, hybrid-bqm, hybrid-cqm) use your own account: `dwave config create`, or the environment
variable DWAVE_API_TOKEN. Only coefficients are sent, with the label. From before the upload until the samples are written a job
file, S.qsf.job, says how far the problem is; whatever interrupts it, `collect` fetches the answer and nothing is charged twice."""])


EMBED_EPILOG = """
A window of a picture with k labels in the encoding one-hot-sparse is laid out in the chip's own tiles at once, in chains of
2 ceil(k / 8) qubits, as far as the chip reaches; every other problem is searched for by minorminer, whose result depends on the seed.
The shortest embedding seen of a problem's graph into a chip is kept in the folder qstereo of the user's cache.

exit status: 0 done, 1 no embedding found, 2 usage, 3 bad input, 4 cannot read or write or over the memory limit, 5 the
service does not give the solver's graph, 130 interrupted. A failed command leaves no file.

examples:
  qstereo-bridge embed p.qcf --topology zephyr:12 -o e.json --picture e.png
  qstereo-bridge embed p.qcf --topology Advantage2_system1 --seed 1 --timeout 300 -o e.json"""


class _Parser(argparse.ArgumentParser):
    def error(self, message):
        raise Failure(USAGE, f"{message}; see {self.prog} --help")


def _number(kind, low, high):
    def parse(text):
        value = kind(text)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{text} is not between {low:g} and {high:g}")
        return value
    parse.__name__ = "number" if kind is float else "whole number"
    return parse


def _or_auto(number, auto):
    """The type of an option that takes a number, or the word auto for the value `auto`."""
    def parse(text):
        return auto if text == "auto" else number(text)
    parse.__name__ = f"{number.__name__} or auto"
    return parse


def _parser():
    parser = _Parser(prog="qstereo-bridge", description="Solve QUBO coefficient files with D-Wave's samplers.")
    parser.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True, parser_class=_Parser)
    whole, positive = _number(int, 1, 2**31 - 1), _number(float, 1e-6, 1e9)
    solve = commands.add_parser(
        "solve", help="solve a .qcf, write a .qsf", epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Solve the problem in a .qcf and write the samples found to a .qsf; or several, each to its own.")
    add = solve.add_argument
    add("problems", metavar="P.qcf", nargs="+", help="the problem, - is stdin; several with --out-dir")
    add("-o", "--output", metavar="S.qsf", help="the samples; - is stdout; needed unless --dry-run")
    add("--out-dir", metavar="D", help="solve each P.qcf to D/P.qsf, going on where one fails; those that are there already are skipped")
    add("--jobs", type=_number(int, 1, 64), metavar="N", help="with --out-dir: problems under way at a time (1)")
    add("--solver", choices=SOLVERS, default="anneal", metavar="NAME", help="one of the solvers below (anneal)")
    add("--num-reads", type=whole, metavar="N", help="samples to take")
    add("--num-sweeps", type=whole, metavar="N", help="sweeps of each annealing read")
    add("--seed", type=_number(int, 0, 2**31 - 1), metavar="N", help="seed of the random numbers (a random one); qpu: of the search of an embedding, a remembered one is passed by")
    add("--time-limit", type=positive, metavar="S", help="seconds; hybrid solvers: the least they allow")
    add("--annealing-time", type=_number(float, 1e-3, 1e9), metavar="US", help="microseconds of each anneal (the chip's default)")
    add("--chain-strength", type=_or_auto(_number(float, 1e-6, 1e9), None), metavar="X",
        help="coupling in a chain (auto: uniform torque compensation)")
    add("--fast-anneal", action="store_true", default=None, help="the fast-anneal protocol; wants an --annealing-time")
    add("--reverse-from", metavar="S0.qsf", help="anneal backwards from the best sample of S0.qsf, then forwards again")
    add("--embedding", metavar="E.json", help="the embedding to use (one that is remembered, or a new one)")
    add("--copies", type=_or_auto(whole, "auto"), metavar="N",
        help="copies of the problem side by side on the chip: each read samples them all; auto: as many as are found (1)")
    add("--solver-name", metavar="NAME", help="the solver of your account (the first that fits)")
    add("--label", metavar="TEXT", help="the problem's name at the service (the file's name without .qcf)")
    add("--no-wait", action="store_true", help="send, write S.qsf.job and return; `collect` fetches the answer")
    add("--resubmit", action="store_true", help="send although a job file says that it was sent: it is charged again")
    add("--dry-run", action="store_true", help="say what would be sent, and against which limits; send nothing")
    _common(add)
    collect = commands.add_parser(
        "collect", help="fetch the answer of a problem that was sent",
        description="Fetch the answer of a problem that `solve` sent to D-Wave, and write the samples. The job file is removed "
        "when they are written.")
    collect.add_argument("job", metavar="S.qsf.job", help="the job file that solve wrote")
    collect.add_argument("-o", "--output", metavar="S.qsf", help="the samples (the job file's name without .job); - is stdout")
    collect.add_argument("--problem", metavar="P.qcf", help="the problem (where it was when it was sent)")
    collect.add_argument("--no-wait", action="store_true", help="exit 1 where there is no answer yet")
    _common(collect.add_argument)
    _add_embed(commands)
    solvers = commands.add_parser("solvers", help="list the solvers that your account reaches",
                                  description="List the solvers that your D-Wave account reaches: name, kind, limits, load.")
    solvers.add_argument("--json", action="store_true", help="print the list as one JSON object")
    return parser


def _common(add):
    add("--json", action="store_true", help="print the result as one JSON object")
    add("--memory-limit", type=_number(int, 1, 1 << 40), default=8192, metavar="MIB", help="memory for the problem (8192)")
    add("--quiet", action="store_true", help="no progress and no result lines, only errors")


def _add_embed(commands):
    embed = commands.add_parser(
        "embed", help="find a minor embedding of a .qcf's QUBO", formatter_class=argparse.RawDescriptionHelpFormatter, epilog=EMBED_EPILOG,
        description="Find a minor embedding of a .qcf's QUBO: a chain of the chip's qubits for each variable.")
    add = embed.add_argument
    add("problem", metavar="P.qcf", help="the problem; - is stdin")
    add("-o", "--output", metavar="E.json", required=True, help="the embedding; - is stdout")
    add("--topology", metavar="NAME", required=True,
        help="pegasus:16, zephyr:12 (or another size; all qubits work), or a solver of your account: the qubits that work there")
    add("--seed", type=_number(int, 0, 2**31 - 1), metavar="N", help="seed of the search (a random one)")
    add("--timeout", type=_number(float, 1e-6, 1e9), default=100.0, metavar="S", help="seconds of search (100); minorminer looks at its clock rarely, so that a large problem may take some times as long")
    add("--picture", metavar="E.png", help="draw the problem's graph and the chip, each chain in the colour of its variable")
    _common(add)
    embed.set_defaults(solver="embed")


def _options(arguments):
    """Parse and complete the options. Raises Failure."""
    options = _parser().parse_args(arguments)
    if options.command == "solve":
        _complete_solve(options)
    if options.command == "embed":
        _check_embed(options)
    if options.command == "collect":
        options.output = options.output or options.job.removesuffix(".job")
        if os.path.realpath(options.output) == os.path.realpath(options.job):
            raise Failure(USAGE, f"{options.job} does not end in .job; name the samples file with -o")
    if options.command != "solvers":
        options.memory_limit <<= 20
    if getattr(options, "output", None) == "-":
        if options.json:
            raise Failure(USAGE, "-o - and --json both want stdout; give -o a file")
        if os.isatty(1):
            raise Failure(USAGE, "-o - would write binary to a terminal; redirect stdout, or give -o a file")
    return options


def _check_embed(options):
    named = [name for name in (options.problem, options.output, options.picture) if name not in (None, "-")]
    if len({os.path.realpath(name) for name in named}) < len(named):
        raise Failure(USAGE, "problem, embedding and picture are files of their own; give them three names")
    if options.picture == "-":
        raise Failure(USAGE, "a picture does not go to stdout; give --picture a file")


def _complete_solve(options):
    solver = SOLVERS[options.solver]
    for option in sorted({option for other in SOLVERS.values() for option in other.options}):
        if getattr(options, option) is None:
            setattr(options, option, solver.options.get(option))
        elif option not in solver.options:
            takers = ", ".join(name for name, other in SOLVERS.items() if option in other.options)
            raise Failure(USAGE, f"{options.solver} takes no --{option.replace('_', '-')}, only {takers} do")
    if options.fast_anneal and options.annealing_time is None:
        raise Failure(USAGE, "--fast-anneal wants an --annealing-time, in microseconds")
    if options.fast_anneal and options.reverse_from:
        raise Failure(USAGE, "a fast anneal cannot begin from a state; leave out --fast-anneal or --reverse-from")
    if options.embedding and options.seed is not None and options.copies == 1:
        raise Failure(USAGE, "--seed is for the search of an embedding, --embedding gives one; leave one of them out")
    if (options.no_wait or options.resubmit) and not solver.kind:
        raise Failure(USAGE, f"{options.solver} runs here; --no-wait and --resubmit are for D-Wave's services")
    if options.label is not None:
        # Bytes of the command line that are no UTF-8: neither the service nor the .qsf could hold them.
        options.label = options.label.encode("utf-8", "replace").decode()
    if options.out_dir is None:
        _complete_one(options)
    elif options.output is not None or options.dry_run:
        raise Failure(USAGE, "--out-dir does not go with -o or --dry-run")
    elif "-" in options.problems:
        raise Failure(USAGE, "--out-dir names the samples after the problems; stdin has no name")


def _complete_one(options):
    if len(options.problems) > 1:
        raise Failure(USAGE, "several problems want --out-dir, the folder for their samples")
    if options.jobs:
        raise Failure(USAGE, "--jobs is for several problems, with --out-dir")
    options.problem = options.problems[0]
    if options.output is None and not options.dry_run:
        raise Failure(USAGE, "name the samples file with -o S.qsf (or ask for --dry-run)")
    if not options.dry_run and os.path.realpath(options.output) == os.path.realpath(options.problem) != os.path.realpath("-"):
        raise Failure(USAGE, f"{options.output} is the problem itself; give -o another name")
    name_label(options)


def name_label(options):
    """A service gets to know the problem by its file's name, unless by another."""
    if "label" in SOLVERS[options.solver].options and options.label is None and options.problem != "-":
        options.label = os.path.splitext(os.path.basename(options.problem))[0].encode("utf-8", "replace").decode()


def progress(options):
    """A function that shows one line of progress on a terminal, elsewhere nothing; with None it clears the line."""
    if options.quiet or getattr(options, "out_dir", None) or not sys.stderr.isatty():
        return lambda text: None
    began = time.monotonic()

    def show(text):
        line = "" if text is None else f"{options.solver}: {text}, {time.monotonic() - began:.0f} s"
        print(f"\r\033[K{line}", end="", file=sys.stderr, flush=True)
    return show


def read(options):
    """The Problem; its file's SHA-256 becomes `options.digest`."""
    import hashlib
    from .qcf import read_qcf

    stdin = options.problem == "-"
    with io(options.problem, "read"), open(0 if stdin else options.problem, "rb", closefd=not stdin) as stream:
        problem, data = read_qcf(stream, options.memory_limit)
    options.digest = hashlib.sha256(data).digest()
    return problem


def _dry_run(options):
    from .remote import plan, planned
    problem = read(options)
    if problem.linear.size == 0:
        found = {"variables": 0, "quadratic_terms": 0, "upload_bytes": 0, "fits": True}
        return (json.dumps({"schema": 1, "solver": options.solver, "dry_run": True, **found}) if options.json
                else f"{options.solver}: 0 variables, 0 quadratic terms\nnothing is left to decide; nothing is ever sent")
    if SOLVERS[options.solver].kind:
        found = plan(options, problem)
        return json.dumps({"schema": 1, "solver": options.solver, "dry_run": True, **found}) if options.json else planned(options, found)
    from .models import Terms
    found = {"variables": problem.linear.size, "quadratic_terms": Terms(problem).count}
    if options.json:
        return json.dumps({"schema": 1, "solver": options.solver, "dry_run": True, **found})
    return (f"{options.solver}: {found['variables']:,} variables, {found['quadratic_terms']:,} quadratic terms\n"
            "runs on this machine; nothing is ever sent")


def _check_energies(answer, energies, problem):
    """The solver's own energies must be the recomputed ones, but for the rounding of its floating point."""
    import numpy as np
    from .models import energies as recompute
    from .solvers import SolverError

    if answer.energies is None:
        return
    expected = recompute(problem, answer.bits, penalties=False) if answer.objective else energies
    rounding = 0.5 + float(problem.magnitude(np.int64)) * 2**-44
    wrong = ~(np.abs(answer.energies - expected) <= rounding)
    if wrong.any():
        at = wrong.argmax()
        raise SolverError(f"internal error: the solver says that sample {at} has energy {answer.energies[at]}, it has "
                          f"{expected[at]}; please report this")


def _records(answer, energies):
    import numpy as np
    from .qsf import BROKEN_UNITS, NO_CHAINS, RECORD
    from .solvers import check_occurrences

    check_occurrences(answer.occurrences)
    records = np.empty(energies.size, RECORD)
    records["energy"] = energies
    records["occurrences"] = 1 if answer.occurrences is None else answer.occurrences
    records["broken"] = NO_CHAINS if answer.broken is None else np.rint(answer.broken * BROKEN_UNITS)
    return records


def _real(energy, scale):
    """An energy in real units; a whole number stays one."""
    return None if energy is None else energy // scale if energy % scale == 0 else energy / scale


def _summary(options, problem, answer, energies, seconds):
    from .models import feasible

    good = energies[feasible(problem, answer.bits)]
    told = problem.groups_say_all
    least, bound = min(energies.tolist(), default=None), answer.lower_bound
    # A minimum of H that is no labelling proves nothing of the labellings.
    proven = bound is not None and bool((good == bound).any())
    real = {key: _real(value, problem.scale) for key, value in {
        "energy": least, "lower_bound": bound, "gap": None if bound is None else least - bound,
        "best_energy": min(good.tolist(), default=None)}.items()}
    if options.json:
        return json.dumps({"schema": 1, "solver": options.solver, **real, "proven_optimal": proven if told else None,
                           "iterations": answer.iterations, "seconds": round(seconds, 3), "samples": energies.size,
                           "feasible": good.size if told else None})
    bounded = ("" if bound is None else f" (proven {'optimal' if told else 'least of the QUBO'})" if proven else
               f" (at most {real['gap']} above the least)" if bound < least else
               " (the minimum of the QUBO is infeasible: the penalty is too small)")
    best = ("`qstereo validate` says which samples are labellings" if not told else
            f"{good.size} feasible, best energy of these {real['best_energy']}" if good.size else "none feasible")
    return (f"{options.solver}: {energies.size} samples, best energy {real['energy']}{bounded}; {best}; {seconds:.1f} s\n"
            f"{options.output}: written")


def show(options, text):
    """A result, on stdout, or on stderr where the samples go to stdout."""
    dry_run = getattr(options, "dry_run", False)
    stream = sys.stderr if getattr(options, "output", None) == "-" and not dry_run else sys.stdout
    if options.json or dry_run or not getattr(options, "quiet", False):
        with io("stderr" if stream is sys.stderr else "stdout", "write"):
            print(text, file=stream, flush=True)


def solve(options, session=None, print_result=show):
    """Solve, check, write, print. A regular file gets its name last, when all else has gone well."""
    from .jobs import keeping
    from .output import Output
    from .remote import solve_there
    from .solvers import nothing_to_decide

    there = SOLVERS[options.solver].kind
    problem, job = read(options) if options.no_wait else None, None
    if options.no_wait and problem.linear.size:
        return solve_there(options, problem, session, progress(options), print_result)
    with io(options.output, "write"):
        output = Output(options.output, last=options.out_dir is None)
    with output:
        problem = problem or read(options)
        began, tell = time.monotonic(), progress(options)
        try:
            if problem.linear.size == 0:
                answer = nothing_to_decide(problem)
            elif there:
                answer, job = solve_there(options, problem, session, tell)
            else:
                answer = SOLVERS[options.solver].run(options.solver, problem, options, tell)
        finally:
            tell(None)
        with keeping(job):
            deliver(options, problem, answer, output, began, print_result)


def deliver(options, problem, answer, output, began, print_result=show):
    """Check the answer, write it to `output`, print the result."""
    from .container import FormatError
    from .models import energies as recompute
    from .qsf import Samples, pack_qsf, parse_qsf
    from .solvers import SolverError

    energies = recompute(problem, answer.bits)
    if SOLVERS[options.solver].kind and not energies.size:
        raise SolverError("the service's answer has no samples")
    _check_energies(answer, energies, problem)
    for warning in [] if options.quiet else answer.info.get("warnings", []):
        print(f"qstereo-bridge {options.command}: warning: {warning}", file=sys.stderr)
    data = pack_qsf(Samples(options.digest, options.solver, _records(answer, energies), answer.bits, answer.info))
    try:
        # What cannot be read again does not end a job.
        parse_qsf(data, sys.maxsize)
    except FormatError as error:
        raise SolverError(f"internal error: the samples would make no sound .qsf ({error}); please report this") from None
    with io(options.output, "write"):
        output.write(data)
    print_result(options, _summary(options, problem, answer, energies, time.monotonic() - began))
    with io(options.output, "write"):
        output.keep()


def _run(options):
    """The command, whatever goes wrong in it a Failure."""
    if options.command == "solve" and options.out_dir is None:
        with failing(options.problem):
            show(options, _dry_run(options)) if options.dry_run else solve(options)
        return OK
    if options.command == "embed":
        from .embed import embed
        with failing(options.problem):
            embed(options)
        return OK
    from . import remote
    with failing(getattr(options, "job", None)):
        return getattr(remote, options.command if options.command != "solve" else "solve_all")(options)


@contextlib.contextmanager
def failing(name):
    """Whatever goes wrong with the file `name` is a Failure."""
    from .container import FormatError, OverLimit
    from .solvers import SolverError

    prefix = f"{name}: " if name else ""
    try:
        yield
    except MemoryError:
        raise Failure(IO, f"{prefix}this machine has not enough memory for it") from None
    except (FormatError, SolverError) as error:
        status = IO if isinstance(error, OverLimit) else BAD_INPUT if isinstance(error, FormatError) else SERVICE
        raise Failure(status, f"{prefix}{error}") from None


def main(arguments=None):
    """The command; returns the exit status."""
    name = "qstereo-bridge"
    # A file's name may be no UTF-8; a closed stdout is None.
    if sys.stdout is not None:
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        options = _options(arguments)
        name += f" {options.command}"
        return _run(options)
    except Failure as failure:
        print(f"{name}: {failure}", file=sys.stderr)
        return failure.status
