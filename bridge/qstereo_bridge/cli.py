"""The command qstereo-bridge. Results go to stdout, messages and progress to stderr."""

import difflib
import importlib
import json
import os
import sys
import textwrap
from types import SimpleNamespace

import click

from . import __version__
from .failure import OK, USAGE, Failure, failing
from .registry import ALIASES, EVERY, SOLVERS, find, name_label
from .text import lines


def _spelt(option):
    return f"--{option.replace('_', '-')}"


def _same(*names):
    """Whether two of the files are one."""
    named = [os.path.realpath(name) for name in names if name not in (None, "-")]
    return len(set(named)) < len(named)


def _table_of_solvers():
    """The solvers and the options that each takes, as lines of at most 80 columns."""
    said = []
    for name, solver in EVERY.items():
        takes = ", ".join(
            _spelt(option) + (f" ({default:g})" if default is not None else "")
            for option, default in solver.options.items()) or "no options"
        for text, first in (solver.summary, f"  {name:<12} "), ("takes " + takes, " " * 15):
            said += textwrap.wrap(text, 80, initial_indent=first, subsequent_indent=" " * 15,
                                  break_on_hyphens=False)
    return "\n".join(said)


SOLVE_EPILOG = f"""\
Solvers, their options, and the defaults of these:
{_table_of_solvers()}

stride is another name of hybrid-nl: D-Wave calls it so. MODULE:CLASS can be any
installed dimod sampler, such as dwave.samplers:TreeDecompositionSolver or
openjij:SASampler.

exact proves the minimum of the QUBO. If the state that it finds is not
feasible, the penalty is too small, and nothing is proven about labellings.

ilp leaves the penalties out. It looks only at states in which each one-hot
group has exactly one variable at 1, and proves the minimum of these. With
one-hot and one-hot-sparse these are the labellings. It is hundreds of times
faster with one-hot-sparse, and with reduced problems, than with other
encodings. This writes a reduced problem as one-hot-sparse:
  qstereo reduce core.qcf -o sparse.qcf --encoding one-hot-sparse
--time-limit is for all of its work. If the time runs out, the lower bound still
holds. ilp needs scipy: pip install 'qstereo-bridge[exact]'.

D-Wave's services (qpu, hybrid-nl, hybrid-bqm, hybrid-cqm) use your own account:
run `dwave config create`, or set the environment variable DWAVE_API_TOKEN. Only
the coefficients and the label are sent. A job file, S.qsf.job, is written
before the upload, and removed when the samples are written. If anything
interrupts the command, `qstereo-bridge collect S.qsf.job` fetches the answer,
and nothing is charged twice.

Before anything is sent, the command makes sure that it can write the output. If
it fails, it writes no output, and an older file of that name stays as it was.

Exit status:
  0    done
  1    the answer is no: of several problems one failed, this problem was sent
       already, or the charge may be above --max-charge
  2    wrong usage
  3    bad input
  4    a file cannot be read or written, or the memory limit is too low
  5    the solver or its service failed or refused
  130  interrupted (128 + the signal)

Examples:
  qstereo-bridge solve p.qcf -o s.qsf
  qstereo-bridge solve p.qcf -o s.qsf --num-reads 50 --seed 1 --json
  qstereo-bridge solve p.qcf -o s.qsf --solver ilp --time-limit 60
  qstereo-bridge solve p.qcf -o s.qsf --solver dwave.samplers:TabuSampler \\
      --param tenure=10
  qstereo-bridge solve p.qcf --solver hybrid-cqm --dry-run
  qstereo-bridge solve p.qcf -o s.qsf --solver qpu --num-reads 1000 \\
      --annealing-time 50
  qstereo-bridge solve p.qcf -o s.qsf --solver hybrid-nl --no-wait
  qstereo-bridge collect s.qsf.job
  qstereo-bridge solve frames/*.qcf --out-dir answers --solver hybrid-nl \\
      --jobs 4"""

EMBED_EPILOG = """\
There are two ways to an embedding. If the problem is a window of a picture with
k labels in the encoding one-hot-sparse, it is laid out in the tiles of the
chip, with chains of 2 ceil(k / 8) qubits. This takes no search, but the window
has to fit on the chip. For every other problem minorminer searches; its result
depends on the seed. The folder qstereo of your cache keeps the shortest
embedding that was found for each problem and chip.

Exit status:
  0    done
  1    no embedding was found
  2    wrong usage
  3    bad input
  4    a file cannot be read or written, or the memory limit is too low
  5    the service does not tell which qubits the solver has
  130  interrupted
A command that fails leaves no file.

Examples:
  qstereo-bridge embed p.qcf --topology zephyr:12 -o e.json --picture e.png
  qstereo-bridge embed p.qcf --topology Advantage2_system1 --seed 1 \\
      --timeout 300 -o e.json"""


class _Command(click.Command):
    """A command whose epilog is printed as it is written."""

    def format_epilog(self, ctx, formatter):
        formatter.write(f"\n{self.epilog}\n" if self.epilog else "")


class Number(click.ParamType):
    """A number from `low` to `high`, or one of the words `also`, a dict of their values."""

    def __init__(self, kind, low, high, **also):
        self.kind, self.low, self.high, self.also = kind, low, high, also
        self.name = " or ".join(["number" if kind is float else "whole number", *also])

    def convert(self, value, param, ctx):
        try:
            number = self.also[value] if value in self.also else self.kind(value)
        except ValueError:
            self.fail(f"{value} is not a {self.name}", param, ctx)
        if value not in self.also and not self.low <= number <= self.high:
            self.fail(f"{value} is not between {self.low:g} and {self.high:g}", param, ctx)
        return number


def _solver(ctx, param, name):
    name = ALIASES.get(name, name)
    if name not in SOLVERS and ":" not in name:
        near = difflib.get_close_matches(name, SOLVERS, 1)
        raise click.BadParameter(f"{name} is not one of {', '.join(EVERY)}"
                                 + (f" (did you mean {near[0]}?)" if near else ""))
    return name


def _parameters(ctx, param, words):
    """{key: value} of the words KEY=JSON, None without any."""
    found = {}
    for word in words:
        key, _, text = word.partition("=")
        if key in found:
            raise click.BadParameter(f"{key} is given twice")
        try:
            found[key] = json.loads(text)
        except ValueError:
            raise click.BadParameter(f"{word} is not KEY=JSON; put a text in quotes: "
                                     f"'{key}=\"{text}\"'") from None
    return found or None


WHOLE, SEED = Number(int, 1, 2**31 - 1), Number(int, 0, 2**31 - 1)
SECONDS, POSITIVE = Number(float, 1e-6, 1e9), Number(float, 1e-3, 1e9)
COMMON = [
    click.option("--json", is_flag=True, help="print the result as one JSON object"),
    click.option("--memory-limit", type=Number(int, 1, 1 << 40), default=8192, metavar="MIB",
                 help="the most memory for the problem (default 8192)"),
    click.option("--quiet", is_flag=True, help="no progress and no result lines, only errors")]
NO_POSTPROCESS = click.option(
    "--no-postprocess", is_flag=True, help="write the samples as the solver gave them; else "
    "steepest descent and merging make the best state of them, and where it is better than all of "
    "them it is one more sample, the last")
SOLVE = [
    click.argument("problems", metavar="P.qcf...", nargs=-1, required=True),
    click.option("-o", "--output", metavar="S.qsf",
                 help="samples file to write, - is standard output (not needed for --dry-run)"),
    click.option("--out-dir", metavar="D", help="write the samples of each P.qcf to D/P.qsf. If "
                 "one problem fails, the others are still solved; those with samples are left out"),
    click.option("--jobs", type=Number(int, 1, 64), metavar="N",
                 help="with --out-dir: solve N problems at a time (default 1)"),
    click.option("--solver", callback=_solver, default="anneal", metavar="NAME",
                 help="one of the solvers below (default anneal)"),
    click.option("--num-reads", type=WHOLE, metavar="N", help="how many samples to take"),
    click.option("--num-sweeps", type=WHOLE, metavar="N", help="sweeps of each annealing read"),
    click.option("--seed", type=SEED, metavar="N", help="seed of the random numbers (default a "
                 "random one). With qpu it is the seed of the search for an embedding, and an "
                 "embedding found before is not used"),
    click.option("--time-limit", type=SECONDS, metavar="S",
                 help="stop after S seconds (hybrid solvers: default the shortest they allow)"),
    click.option("--param", callback=_parameters, multiple=True, metavar="KEY=JSON",
                 help="set a parameter of the sampler or the QPU by its own name; may be given "
                 "several times"),
    click.option("--spin-reversals", type=WHOLE, metavar="N",
                 help="sample N times, each time with the values of other variables exchanged"),
    click.option("--annealing-time", type=POSITIVE, metavar="US",
                 help="microseconds of each anneal (default that of the chip)"),
    click.option("--chain-strength", type=Number(float, 1e-6, 1e9, auto=None), metavar="X",
                 help="strength of the couplers in a chain (default auto: uniform torque "
                 "compensation)"),
    click.option("--fast-anneal", is_flag=True, default=None,
                 help="use the fast-anneal protocol; needs --annealing-time"),
    click.option("--reverse-from", metavar="S0.qsf",
                 help="anneal backwards from the best sample of S0.qsf, then forwards again"),
    click.option("--embedding", metavar="E.json",
                 help="embedding to use (default one found before, or else a new one)"),
    click.option("--copies", type=Number(int, 1, 2**31 - 1, auto="auto"), metavar="N",
                 help="put N copies of the problem side by side on the chip, so that each read "
                 "samples them all; auto puts as many as fit (default 1)"),
    click.option("--solver-name", metavar="NAME",
                 help="solver of your account (default the first that fits)"),
    click.option("--label", metavar="TEXT",
                 help="name of the problem at the service (default the file's without .qcf)"),
    click.option("--no-wait", is_flag=True,
                 help="send, write S.qsf.job and end; `collect` fetches the answer"),
    click.option("--resubmit", is_flag=True,
                 help="send although a job file says that it was sent; it is charged again"),
    click.option("--max-charge", type=POSITIVE, metavar="S", help="send nothing if the charge may "
                 "be above S seconds; of several problems their sum counts"),
    click.option("--dry-run", is_flag=True,
                 help="send nothing; say what would be sent, and which limits apply"),
    NO_POSTPROCESS,
    click.option("--windows", type=WHOLE, metavar="N", help="solve a reduced problem in calls of "
                 "at most N variables, each merged into the best state known. The same command "
                 "goes on after an interruption; its journal is S.qsf.journal"),
    click.option("--calls", type=WHOLE, metavar="K",
                 help="with --windows: at most K calls (default 10)"),
    click.option("--start", metavar="S0.qsf", help="with --windows: begin from the best sample of "
                 "S0.qsf; a lower bound in it (of `qstereo solve`) ends the calls"),
    click.option("--bound", type=Number(float, -1e15, 1e15), metavar="E", help="with --windows: "
                 "end at this proven lower bound, in real units; `qstereo reduce` prints one")]


@click.group(no_args_is_help=False, subcommand_metavar="COMMAND ...",
             context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, "-V", "--version", message="%(prog)s %(version)s")
def bridge():
    """Solve QUBO files (.qcf) on this machine or with D-Wave's services."""


def _command(module, file, *options, epilog=None):
    """Makes a command of the function below it. That function completes the options. It may return
    the name of the function of `module` to run; without, the name is that of the command. Errors
    name the file of the option `file`."""
    def make(complete):
        def run(**values):
            given = SimpleNamespace(**{"command": complete.__name__, "problem": None, **values})
            function = complete(given) or complete.__name__
            return _run(module, function, given, getattr(given, file or "", None))
        for option in reversed(options):
            run = option(run)
        return bridge.command(complete.__name__, cls=_Command, help=complete.__doc__,
                              epilog=epilog)(run)
    return make


def _run(module, function, options, file):
    """Runs a function and returns its exit status. Its module is imported only now, so that
    --help need not wait for it."""
    if hasattr(options, "memory_limit"):
        options.memory_limit <<= 20
    if getattr(options, "output", None) == "-":
        _refuse({"-o - and --json both write to stdout; give -o a file": options.json,
                 "-o - would write binary to a terminal; redirect stdout, or give -o a file":
                     os.isatty(1)})
    with failing(file):
        module = importlib.import_module("." + module, __package__)
        return getattr(module, function)(options) or OK


def _refuse(reasons):
    """Raises the Failure of the first reason, {message: whether it applies}, that applies."""
    for message, applies in reasons.items():
        if applies:
            raise Failure(USAGE, message)


@_command("remote", "problem", *SOLVE, *COMMON, epilog=SOLVE_EPILOG)
def solve(options):
    """Solve the QUBO of a .qcf and write samples of it to a .qsf. P.qcf - is standard input. With
    --out-dir several problems are solved, each into a file of its own."""
    solver, several = find(options.solver), options.out_dir is not None
    for option in sorted({option for other in EVERY.values() for option in other.options}):
        if getattr(options, option) is None:
            setattr(options, option, solver.options.get(option))
        elif option not in solver.options:
            takers = ", ".join(name for name, other in EVERY.items() if option in other.options)
            raise Failure(USAGE, f"{options.solver} does not take {_spelt(option)}, only these do: "
                          f"{takers}")
    if not several:
        options.problem = options.problems[0]
        name_label(options)
    fast = options.fast_anneal
    _refuse({
        "--fast-anneal needs --annealing-time, in microseconds":
            fast and options.annealing_time is None,
        "a fast anneal cannot begin from a state; leave out --fast-anneal or --reverse-from":
            fast and options.reverse_from,
        "--seed is to search for an embedding, --embedding gives one; leave one of them out":
            options.embedding and options.seed is not None and options.copies == 1,
        f"{options.solver} runs locally; --no-wait and --resubmit are for D-Wave's services":
            (options.no_wait or options.resubmit) and not solver.kind,
        "--out-dir does not go with -o": several and options.output is not None,
        "--out-dir names the samples after the problems; stdin has no name":
            several and "-" in options.problems,
        "several problems need --out-dir, the folder for their samples":
            not several and len(options.problems) > 1,
        "--jobs is for several problems, with --out-dir": not several and options.jobs,
        "name the samples file with -o S.qsf (or ask for --dry-run)":
            not (several or options.output is not None or options.dry_run),
        f"{options.output} is the problem itself; give -o another name":
            not options.dry_run and _same(options.output, options.problem)})
    for option in ("calls", "start", "bound"):
        _refuse({f"{_spelt(option)} is for --windows":
                 getattr(options, option) is not None and not options.windows})
    if options.windows:
        _windows(options)
    return "dry_run" if options.dry_run else "solve_all" if several else "solve"


def _windows(options):
    """Completes the options of `solve --windows`; refuses those that do not go with it."""
    options.calls = options.calls or 10
    for option in ("out_dir", "no_wait", "resubmit", "embedding", "reverse_from", "no_postprocess"):
        _refuse({f"--windows does not go with {_spelt(option)}": getattr(options, option)})
    _refuse({"--windows does not go with --copies": options.copies not in (None, 1),
             "with --windows name the problem's file, not stdin": options.problem == "-",
             "--windows writes files beside the samples file; give -o a file":
                 options.output == "-"})


@_command("remote", "job", click.argument("job", metavar="S.qsf.job"),
          click.option("-o", "--output", metavar="S.qsf",
                       help="samples file to write, - is standard output (default the job "
                       "file's name without .job)"),
          click.option("--problem", metavar="P.qcf",
                       help="the problem (default the file that was sent)"),
          click.option("--no-wait", is_flag=True, 
                       help="do not wait: exit with 1 if there is no answer yet"),
          NO_POSTPROCESS, *COMMON)
def collect(options):
    """Fetch the answer to a problem that was sent to D-Wave. When the samples are written, the job
    file is removed."""
    options.output = options.output or options.job.removesuffix(".job")
    _refuse({f"{options.job} does not end in .job; name the samples file with -o":
             _same(options.output, options.job)})


@_command("runner", "problem", click.argument("problem", metavar="P.qcf"),
          click.argument("samples", metavar="S.qsf...", nargs=-1, required=True),
          click.option("-o", "--output", metavar="M.qsf", required=True,
                       help="samples file to write, - is standard output"), *COMMON)
def merge(options):
    """Merge samples of one problem: steepest descent of each, then the best state that they hold
    together. M.qsf has all samples and, where it is better than all of them, this state as the
    last."""
    options.solver = "merge"
    _refuse({f"{options.output} is one of the files to merge; give -o another name":
             any(_same(options.output, name) for name in [options.problem, *options.samples])})


@_command("embed", "problem", click.argument("problem", metavar="P.qcf"),
          click.option("-o", "--output", metavar="E.json", required=True,
                       help="embedding to write, - is standard output"),
          click.option("--topology", metavar="NAME", required=True,
                       help="pegasus:16, zephyr:12 or another size (a chip on which all qubits "
                       "work), or a solver of your account (the qubits that work there)"),
          click.option("--seed", type=SEED, metavar="N", 
                       help="seed of the search (default a random one)"),
          click.option("--timeout", type=SECONDS, default=100.0, metavar="S",
                       help="stop the search after S seconds (default 100). minorminer rarely "
                       "looks at its clock, so a large problem may take several times as long"),
          click.option("--picture", metavar="E.png", help="draw the problem's graph and the chip, "
                       "each chain in the colour of its variable"),
          *COMMON, epilog=EMBED_EPILOG)
def embed(options):
    """Find a minor embedding of the QUBO of a .qcf. For each variable it has a chain of qubits of
    the chip. P.qcf - is standard input."""
    options.solver = "embed"
    _refuse({"problem, embedding and picture are three files; give them different names":
             _same(options.problem, options.output, options.picture),
             "a picture cannot go to stdout; give --picture a file": options.picture == "-"})


@_command("export", "problem", click.argument("problem", metavar="P.qcf"),
          click.option("-o", "--output", metavar="FILE", required=True,
                       help="file to write; its end names the format: .bqm (dimod's own), .coo, "
                       ".lp (an integer program) or .qubo (qbsolv's)"), *COMMON)
def export(options):
    """Write the QUBO of a .qcf in a format of other tools. Numbers are in the integer units of the
    .qcf. P.qcf - is standard input."""


@_command("inspection", None, click.argument("samples", metavar="S.qsf"),
          click.option("--problem", metavar="P.qcf", help="the problem of the samples (required)"),
          click.option("--embedding", metavar="E.json",
                       help="its embedding (default the one in the samples)"), *COMMON)
def inspect(options):
    """Show samples of a QPU in D-Wave's inspector. The inspector has to be installed."""


@_command("verify", "certificate", click.argument("problem", metavar="P.qcf"),
          click.argument("other", metavar="S.qsf"), click.argument("certificate", metavar="C.qpf"),
          *COMMON)
def verify(options):
    """Check a certificate of `qstereo solve` or `reduce`, without their library: the proof of a
    lower bound of P.qcf. The best sample in S.qsf must be as good as it states. In the place of
    S.qsf may stand the .qcf that reduce has written. Exits with 1 if it is not valid."""
    return "command"


@_command("remote", None, COMMON[0])
def solvers(options):
    """List the solvers of your D-Wave account with limits and load."""


def main(arguments=None):
    """The command; returns the exit status."""
    # A file's name need not be UTF-8; a closed stdout is None.
    if sys.stdout is not None:
        sys.stdout.reconfigure(errors="backslashreplace")
    arguments = sys.argv[1:] if arguments is None else arguments
    name = " ".join(["qstereo-bridge", *(w for w in arguments[:1] if w in bridge.commands)])
    try:
        return bridge.main(arguments, "qstereo-bridge", standalone_mode=False) or OK
    except click.UsageError as error:
        said = " ".join(error.format_message().split())
        failure = Failure(USAGE, f"{said.rstrip('.')}; see {name} --help")
    except Failure as error:
        failure = error
    print(lines(f"{name}: {failure}"), file=sys.stderr)
    return failure.status
