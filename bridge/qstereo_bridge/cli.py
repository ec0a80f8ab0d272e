"""The command qstereo-bridge. Results go to stdout, messages and progress to stderr."""

import difflib
import importlib
import json
import os
import sys
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


SOLVE_EPILOG = "\n".join([
    "Solvers:",
    *(f"  {name:<12} {solver.summary}\n" + " " * 15 + "takes " + (", ".join(
        _spelt(option) + (f" ({default:g})" if default is not None else "")
        for option, default in solver.options.items()) or "no options")
      for name, solver in EVERY.items()),
    """
MODULE:CLASS is any dimod sampler that is installed, as dwave.samplers:TreeDecompositionSolver
or openjij:SASampler. hybrid-nl is called stride as well, D-Wave's own name for it.

exact proves the minimum of the QUBO; where that is infeasible, the penalty is too small, and
nothing is proven of labellings. ilp leaves the penalties out and proves the minimum over the states
with one variable at 1 in each one-hot group: in one-hot and one-hot-sparse, over the labellings. It
takes one-hot-sparse, and reduced problems, hundreds of times faster than other encodings. Where
--time-limit ends it the bound still holds.

exit status: 0 done, 1 a no (several problems: one of them failed; this problem was sent already; no
answer yet), 2 usage, 3 bad input, 4 cannot read or write or over the memory limit, 5 the solver or
its service failed or refused, 130 interrupted (128 + the signal). A failed command leaves no output
file, and an existing one as it was.

examples:
  qstereo-bridge solve p.qcf -o s.qsf --num-reads 50 --seed 1 --json
  qstereo-bridge solve p.qcf -o s.qsf --solver ilp --time-limit 60
  qstereo-bridge solve p.qcf -o s.qsf --solver dwave.samplers:TabuSampler --param tenure=10
  qstereo-bridge solve p.qcf --solver hybrid-cqm --dry-run
  qstereo-bridge solve p.qcf -o s.qsf --solver hybrid-nl --no-wait
  qstereo-bridge collect s.qsf.job
  qstereo-bridge solve frames/*.qcf --out-dir answers --solver hybrid-nl --jobs 4

D-Wave's services (qpu, hybrid-nl, hybrid-bqm, hybrid-cqm) use your own account: `dwave config
create`, or the environment variable DWAVE_API_TOKEN. Only coefficients are sent, with the label.
From before the upload until the samples are written a job file, S.qsf.job, says how far the problem
is; whatever interrupts it, `collect` fetches the answer and nothing is charged twice."""])

EMBED_EPILOG = """\
A window of a picture with k labels in the encoding one-hot-sparse is laid out in the chip's own
tiles at once, in chains of 2 ceil(k / 8) qubits, as far as the chip reaches; every other problem is
searched for by minorminer, whose result depends on the seed. The shortest embedding seen of a
problem's graph into a chip is kept in the folder qstereo of the user's cache.

exit status: as of solve; 1: no embedding was found

examples:
  qstereo-bridge embed p.qcf --topology zephyr:12 -o e.json --picture e.png
  qstereo-bridge embed p.qcf --topology Advantage2_system1 --seed 1 --timeout 300 -o e.json"""


class _Command(click.Command):
    """A command whose epilog is printed as it stands."""

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
            self.fail(f"{value} is no {self.name}", param, ctx)
        if value not in self.also and not self.low <= number <= self.high:
            self.fail(f"{value} is not between {self.low:g} and {self.high:g}", param, ctx)
        return number


def _solver(ctx, param, name):
    name = ALIASES.get(name, name)
    if name not in SOLVERS and ":" not in name:
        near = difflib.get_close_matches(name, SOLVERS, 1)
        raise click.BadParameter(f"{name} is none of {', '.join(EVERY)}"
                                 + (f"; did you mean {near[0]}?" if near else ""))
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
            raise click.BadParameter(f"{word} is no KEY=JSON; a text wants quotes: "
                                     f"'{key}=\"{text}\"'") from None
    return found or None


WHOLE, SEED = Number(int, 1, 2**31 - 1), Number(int, 0, 2**31 - 1)
SECONDS, POSITIVE = Number(float, 1e-6, 1e9), Number(float, 1e-3, 1e9)
COMMON = [
    click.option("--json", is_flag=True, help="print the result as one JSON object"),
    click.option("--memory-limit", type=Number(int, 1, 1 << 40), default=8192, metavar="MIB",
                 help="memory for the problem (8192)"),
    click.option("--quiet", is_flag=True, help="no progress and no result lines, only errors")]
SOLVE = [
    click.argument("problems", metavar="P.qcf...", nargs=-1, required=True),
    click.option("-o", "--output", metavar="S.qsf",
                 help="the samples; - is stdout; needed unless --dry-run"),
    click.option("--out-dir", metavar="D", help="solve each P.qcf to D/P.qsf, going on where one "
                 "fails; those that are there already are skipped"),
    click.option("--jobs", type=Number(int, 1, 64), metavar="N",
                 help="with --out-dir: problems under way at a time (1)"),
    click.option("--solver", callback=_solver, default="anneal", metavar="NAME",
                 help="one of the solvers below (anneal)"),
    click.option("--num-reads", type=WHOLE, metavar="N", help="samples to take"),
    click.option("--num-sweeps", type=WHOLE, metavar="N", help="sweeps of each annealing read"),
    click.option("--seed", type=SEED, metavar="N", help="seed of the random numbers (a random "
                 "one); qpu: of the search of an embedding, a remembered one is passed by"),
    click.option("--time-limit", type=SECONDS, metavar="S",
                 help="seconds; hybrid solvers: the least they allow"),
    click.option("--param", callback=_parameters, multiple=True, metavar="KEY=JSON",
                 help="a parameter of the sampler or the QPU by its own name; repeatable"),
    click.option("--spin-reversals", type=WHOLE, metavar="N",
                 help="sample N times, each with other variables turned round"),
    click.option("--annealing-time", type=POSITIVE, metavar="US",
                 help="microseconds of each anneal (the chip's default)"),
    click.option("--chain-strength", type=Number(float, 1e-6, 1e9, auto=None), metavar="X",
                 help="coupling in a chain (auto: uniform torque compensation)"),
    click.option("--fast-anneal", is_flag=True, default=None,
                 help="the fast-anneal protocol; wants an --annealing-time"),
    click.option("--reverse-from", metavar="S0.qsf",
                 help="anneal backwards from the best sample of S0.qsf, then forwards again"),
    click.option("--embedding", metavar="E.json",
                 help="the embedding to use (one that is remembered, or a new one)"),
    click.option("--copies", type=Number(int, 1, 2**31 - 1, auto="auto"), metavar="N",
                 help="copies of the problem side by side on the chip: each read samples them all; "
                 "auto: as many as are found (1)"),
    click.option("--solver-name", metavar="NAME",
                 help="the solver of your account (the first that fits)"),
    click.option("--label", metavar="TEXT",
                 help="the problem's name at the service (the file's name without .qcf)"),
    click.option("--no-wait", is_flag=True,
                 help="send, write S.qsf.job and return; `collect` fetches the answer"),
    click.option("--resubmit", is_flag=True,
                 help="send although a job file says that it was sent: it is charged again"),
    click.option("--max-charge", type=POSITIVE, metavar="S", help="send nothing that may be charged"
                 " more seconds than this; of several problems, more in all"),
    click.option("--dry-run", is_flag=True,
                 help="say what would be sent, and against which limits; send nothing")]


@click.group(no_args_is_help=False, subcommand_metavar="COMMAND ...",
             context_settings={"max_content_width": 100})
@click.version_option(__version__, message="%(prog)s %(version)s")
def bridge():
    """Solve QUBO coefficient files with D-Wave's samplers."""


def _command(module, file, *options, epilog=None):
    """A command of the function below it, which completes the options and may name another function
    of `module` to run; without, the command's own name. `file` is the option whose file errors are
    of."""
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
    """The exit status of the function, whose module is imported now: --help waits for none."""
    if hasattr(options, "memory_limit"):
        options.memory_limit <<= 20
    if getattr(options, "output", None) == "-":
        _refuse({"-o - and --json both want stdout; give -o a file": options.json,
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
    """Solve the problem in a .qcf (- is stdin) and write the samples found to a .qsf; or several,
    each to its own, with --out-dir."""
    solver, several = find(options.solver), options.out_dir is not None
    for option in sorted({option for other in EVERY.values() for option in other.options}):
        if getattr(options, option) is None:
            setattr(options, option, solver.options.get(option))
        elif option not in solver.options:
            takers = ", ".join(name for name, other in EVERY.items() if option in other.options)
            raise Failure(USAGE, f"{options.solver} takes no {_spelt(option)}, only {takers} do")
    if not several:
        options.problem = options.problems[0]
        name_label(options)
    fast = options.fast_anneal
    _refuse({
        "--fast-anneal wants an --annealing-time, in microseconds":
            fast and options.annealing_time is None,
        "a fast anneal cannot begin from a state; leave out --fast-anneal or --reverse-from":
            fast and options.reverse_from,
        "--seed is for the search of an embedding, --embedding gives one; leave one of them out":
            options.embedding and options.seed is not None and options.copies == 1,
        f"{options.solver} runs here; --no-wait and --resubmit are for D-Wave's services":
            (options.no_wait or options.resubmit) and not solver.kind,
        "--out-dir does not go with -o": several and options.output is not None,
        "--out-dir names the samples after the problems; stdin has no name":
            several and "-" in options.problems,
        "several problems want --out-dir, the folder for their samples":
            not several and len(options.problems) > 1,
        "--jobs is for several problems, with --out-dir": not several and options.jobs,
        "name the samples file with -o S.qsf (or ask for --dry-run)":
            not (several or options.output is not None or options.dry_run),
        f"{options.output} is the problem itself; give -o another name":
            not options.dry_run and _same(options.output, options.problem)})
    return "dry_run" if options.dry_run else "solve_all" if several else "solve"


@_command("remote", "job", click.argument("job", metavar="S.qsf.job"),
          click.option("-o", "--output", metavar="S.qsf",
                       help="the samples (the job file's name without .job); - is stdout"),
          click.option("--problem", metavar="P.qcf",
                       help="the problem (where it was when it was sent)"),
          click.option("--no-wait", is_flag=True, help="exit 1 where there is no answer yet"),
          *COMMON)
def collect(options):
    """Fetch the answer of a problem that `solve` sent to D-Wave, and write the samples. The job
    file is removed when they are written."""
    options.output = options.output or options.job.removesuffix(".job")
    _refuse({f"{options.job} does not end in .job; name the samples file with -o":
             _same(options.output, options.job)})


@_command("embed", "problem", click.argument("problem", metavar="P.qcf"),
          click.option("-o", "--output", metavar="E.json", required=True,
                       help="the embedding; - is stdout"),
          click.option("--topology", metavar="NAME", required=True,
                       help="pegasus:16, zephyr:12 (or another size; all qubits work), or a solver "
                       "of your account: the qubits that work there"),
          click.option("--seed", type=SEED, metavar="N", help="seed of the search (a random one)"),
          click.option("--timeout", type=SECONDS, default=100.0, metavar="S",
                       help="seconds of search (100); minorminer looks at its clock rarely: a "
                       "large problem may take some times as long"),
          click.option("--picture", metavar="E.png", help="draw the problem's graph and the chip, "
                       "each chain in the colour of its variable"),
          *COMMON, epilog=EMBED_EPILOG)
def embed(options):
    """Find a minor embedding of a .qcf's QUBO (- is stdin): a chain of the chip's qubits for each
    variable."""
    options.solver = "embed"
    _refuse({"problem, embedding and picture are files of their own; give them three names":
             _same(options.problem, options.output, options.picture),
             "a picture does not go to stdout; give --picture a file": options.picture == "-"})


@_command("export", "problem", click.argument("problem", metavar="P.qcf"),
          click.option("-o", "--output", metavar="FILE", required=True,
                       help="p.bqm (dimod's own), p.coo, p.lp (an integer program) or p.qubo "
                       "(qbsolv's): the end names the format"), *COMMON)
def export(options):
    """Write the problem in a .qcf (- is stdin) as a file that other tools read. Numbers are the
    .qcf's integer units."""


@_command("inspection", None, click.argument("samples", metavar="S.qsf"),
          click.option("--problem", metavar="P.qcf", help="the problem of the samples; needed"),
          click.option("--embedding", metavar="E.json",
                       help="its embedding (the one in the samples)"), *COMMON)
def inspect(options):
    """Open D-Wave's inspector on samples of the solver qpu, where it is installed."""


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
    """List the solvers that your D-Wave account reaches: name, kind, limits, load."""


def main(arguments=None):
    """The command; returns the exit status."""
    # A file's name may be no UTF-8; a closed stdout is None.
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
