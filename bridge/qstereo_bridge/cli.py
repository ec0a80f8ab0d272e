"""The command qstereo-bridge. Results go to stdout, messages and progress to stderr."""

import argparse
import importlib
import os
import sys

from . import __version__
from .failure import OK, USAGE, Failure, failing
from .registry import SOLVERS, name_label


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


def _run(options):
    """The command, whatever goes wrong in it a Failure."""
    if options.command == "embed":
        place, function = "embed", "embed"
    elif options.command == "solve":
        place, function = "remote", "solve_all" if options.out_dir else "dry_run" if options.dry_run else "solve"
    else:
        place, function = "remote", options.command
    with failing(getattr(options, "problem", None) if options.command != "collect" else options.job):
        # Only now: --help does not wait for numpy.
        found = getattr(importlib.import_module("." + place, __package__), function)(options)
        if function == "dry_run":
            importlib.import_module(".runner", __package__).show(options, found)
            return OK
        return found or OK


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
