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


SOLVE_EPILOG = "\n".join([
    "Solvers:",
    *(f"  {name:<12} {solver.summary}\n" + " " * 15 + "takes " + (", ".join(
        _spelt(option) + (f" ({default:g})" if default is not None else "")
        for option, default in solver.options.items()) or "no options")
      for name, solver in EVERY.items()),
    """
MODULE:CLASS is any dimod sampler that is installed, as dwave.samplers:TreeDecompositionSolver
or openjij:SASampler. hybrid-nl is called stride as well, D-Wave's own name for it.

exit status: 0 done, 1 a no (several problems: one of them failed; this problem was sent already; no
answer yet), 2 usage, 3 bad input, 4 cannot read or write or over the memory limit, 5 the solver or
its service failed or refused, 130 interrupted (128 + the signal). A failed command leaves no output
file, and an existing one as it was; that the output can be written is seen to before anything is
sent.

exact proves the minimum of the QUBO. Where that is infeasible, the penalty is too small, and
nothing is proven of labellings. ilp leaves the penalties out and proves the minimum over the states
with one variable at 1 in each one-hot group: in one-hot and one-hot-sparse, over the labellings. It
takes one-hot-sparse, and reduced problems, hundreds of times faster than other encodings
(`qstereo reduce core.qcf -o sparse.qcf --encoding one-hot-sparse` writes a core anew). --time-limit
is for all of its work; where it ends it the bound still holds. It needs scipy:
pip install 'qstereo-bridge[exact]'.

examples:
  qstereo-bridge solve p.qcf -o s.qsf
  qstereo-bridge solve p.qcf -o s.qsf --num-reads 50 --seed 1 --json
  qstereo-bridge solve p.qcf -o s.qsf --solver ilp --time-limit 60
  qstereo-bridge solve p.qcf -o s.qsf --solver dwave.samplers:TabuSampler --param tenure=10
  qstereo-bridge solve p.qcf --solver hybrid-cqm --dry-run
  qstereo-bridge solve p.qcf -o s.qsf --solver qpu --num-reads 1000 --annealing-time 50
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

exit status: 0 done, 1 no embedding found, 2 usage, 3 bad input, 4 cannot read or write or over the
memory limit, 5 the service does not give the solver's graph, 130 interrupted. A failed command
leaves no file.

examples:
  qstereo-bridge embed p.qcf --topology zephyr:12 -o e.json --picture e.png
  qstereo-bridge embed p.qcf --topology Advantage2_system1 --seed 1 --timeout 300 -o e.json"""


def _nearest(word, known):
    near = difflib.get_close_matches(word, known, 1)
    return f"; did you mean {near[0]}?" if near else ""


class _Command(click.Command):
    """A command whose epilog is printed as it stands."""

    def format_epilog(self, ctx, formatter):
        formatter.write(f"\n{self.epilog}\n" if self.epilog else "")


class _Group(click.Group):
    command_class = _Command

    def parse_args(self, ctx, args):
        if not args:
            ctx.fail(f"name a COMMAND: {', '.join(self.commands)}")
        return super().parse_args(ctx, args)

    def resolve_command(self, ctx, args):
        if self.get_command(ctx, args[0]) is None:
            near = _nearest(args[0], self.commands)
            ctx.fail(f"no COMMAND {args[0]}{near or ', only ' + ', '.join(self.commands)}")
        return super().resolve_command(ctx, args)


class Number(click.ParamType):
    """A number from `low` to `high`, or one of the words `also`, a dict of their values."""

    def __init__(self, kind, low, high, **also):
        self.kind, self.low, self.high, self.also = kind, low, high, also
        self.name = "number" if kind is float else "whole number"

    def convert(self, value, param, ctx):
        if value in self.also:
            return self.also[value]
        try:
            number = self.kind(value)
        except ValueError:
            self.fail(f"{value} is no {' or '.join([self.name, *self.also])}", param, ctx)
        if not self.low <= number <= self.high:
            self.fail(f"{value} is not between {self.low:g} and {self.high:g}", param, ctx)
        return number


def _solver(ctx, param, name):
    name = ALIASES.get(name, name)
    if name not in SOLVERS and ":" not in name:
        raise click.BadParameter(f"{name} is none of {', '.join(EVERY)}{_nearest(name, SOLVERS)}")
    return name


def _parameters(ctx, param, words):
    """{key: value} of the words KEY=JSON, None without any."""
    found = {}
    for word in words:
        key, equals, text = word.partition("=")
        try:
            value = json.loads(text)
        except ValueError:
            raise click.BadParameter(
                f"{word} is no KEY=JSON" + (f"; a text wants quotes: '{key}=\"{text}\"'" if equals
                                            else "")) from None
        if key in found:
            raise click.BadParameter(f"{key} is given twice")
        found[key] = value
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
    click.option("--max-charge", type=POSITIVE, metavar="S",
                 help="send nothing that may be charged "
                 "more seconds than this; of several problems, more in all"),
    click.option("--dry-run", is_flag=True,
                 help="say what would be sent, and against which limits; send nothing")]


def _takes(*options):
    def give(function):
        for option in reversed(options):
            function = option(function)
        return function
    return give


@click.group(cls=_Group, no_args_is_help=False, subcommand_metavar="COMMAND ...",
             context_settings={"max_content_width": 100})
@click.version_option(__version__, message="%(prog)s %(version)s")
def bridge():
    """Solve QUBO coefficient files with D-Wave's samplers."""


@bridge.command(epilog=SOLVE_EPILOG)
@_takes(*SOLVE, *COMMON)
def solve(**options):
    """Solve the problem in a .qcf (- is stdin) and write the samples found to a .qsf; or several,
    each to its own, with --out-dir."""
    options = SimpleNamespace(command="solve", problem=None, **options)
    _complete_solve(options)
    one = "solve" if options.out_dir is None else "solve_all"
    function = "dry_run" if options.dry_run else one
    return _run("remote", function, options, options.problem)


@bridge.command()
@click.argument("job", metavar="S.qsf.job")
@click.option("-o", "--output", metavar="S.qsf",
              help="the samples (the job file's name without .job); - is stdout")
@click.option("--problem", metavar="P.qcf", help="the problem (where it was when it was sent)")
@click.option("--no-wait", is_flag=True, help="exit 1 where there is no answer yet")
@_takes(*COMMON)
def collect(**options):
    """Fetch the answer of a problem that `solve` sent to D-Wave, and write the samples. The job
    file is removed when they are written."""
    options = SimpleNamespace(command="collect", **options)
    options.output = options.output or options.job.removesuffix(".job")
    if os.path.realpath(options.output) == os.path.realpath(options.job):
        raise Failure(USAGE, f"{options.job} does not end in .job; name the samples file with -o")
    return _run("remote", "collect", options, options.job)


@bridge.command(epilog=EMBED_EPILOG)
@click.argument("problem", metavar="P.qcf")
@click.option("-o", "--output", metavar="E.json", required=True, help="the embedding; - is stdout")
@click.option("--topology", metavar="NAME", required=True, help="pegasus:16, zephyr:12 (or another "
              "size; all qubits work), or a solver of your account: the qubits that work there")
@click.option("--seed", type=SEED, metavar="N", help="seed of the search (a random one)")
@click.option("--timeout", type=SECONDS, default=100.0, metavar="S", help="seconds of search (100);"
              " minorminer looks at its clock rarely: a large problem may take some times as long")
@click.option("--picture", metavar="E.png", help="draw the problem's graph and the chip, each "
              "chain in the colour of its variable")
@_takes(*COMMON)
def embed(**options):
    """Find a minor embedding of a .qcf's QUBO (- is stdin): a chain of the chip's qubits for each
    variable."""
    options = SimpleNamespace(command="embed", solver="embed", **options)
    named = [name for name in (options.problem, options.output, options.picture)
             if name not in (None, "-")]
    if len({os.path.realpath(name) for name in named}) < len(named):
        raise Failure(USAGE, "problem, embedding and picture are files of their own; give them "
                      "three names")
    if options.picture == "-":
        raise Failure(USAGE, "a picture does not go to stdout; give --picture a file")
    return _run("embed", "embed", options, options.problem)


@bridge.command()
@click.argument("problem", metavar="P.qcf")
@click.option("-o", "--output", metavar="FILE", required=True, help="p.bqm (dimod's own), p.coo, "
              "p.lp (an integer program) or p.qubo (qbsolv's): the end names the format")
@_takes(*COMMON)
def export(**options):
    """Write the problem in a .qcf (- is stdin) as a file that other tools read. Numbers are the
    .qcf's integer units."""
    return _run("export", "export", SimpleNamespace(command="export", **options),
                options["problem"])


@bridge.command()
@click.argument("samples", metavar="S.qsf")
@click.option("--problem", metavar="P.qcf", help="the problem of the samples; needed")
@click.option("--embedding", metavar="E.json", help="its embedding (the one in the samples)")
@_takes(*COMMON)
def inspect(**options):
    """Open D-Wave's inspector on samples of the solver qpu, where it is installed."""
    return _run("inspection", "inspect", SimpleNamespace(command="inspect", **options), None)


@bridge.command()
@click.argument("problem", metavar="P.qcf")
@click.argument("other", metavar="S.qsf")
@click.argument("certificate", metavar="C.qpf")
@_takes(*COMMON)
def verify(**options):
    """Check a certificate of `qstereo solve` or `reduce`, without their library: the proof of a
    lower bound of P.qcf. The best sample in S.qsf must be as good as it states. In the place of
    S.qsf may stand the .qcf that reduce has written. Exits with 1 if it is not valid."""
    return _run("verify", "command", SimpleNamespace(command="verify", **options),
                options["certificate"])


@bridge.command()
@click.option("--json", is_flag=True, help="print the list as one JSON object")
def solvers(**options):
    """List the solvers that your D-Wave account reaches: name, kind, limits, load."""
    return _run("remote", "solvers", SimpleNamespace(command="solvers", **options), None)


def _complete_solve(options):
    solver = find(options.solver)
    for option in sorted({option for other in EVERY.values() for option in other.options}):
        if getattr(options, option) is None:
            setattr(options, option, solver.options.get(option))
        elif option not in solver.options:
            takers = ", ".join(name for name, other in EVERY.items() if option in other.options)
            raise Failure(USAGE, f"{options.solver} takes no {_spelt(option)}, only {takers} do")
    if options.fast_anneal and options.annealing_time is None:
        raise Failure(USAGE, "--fast-anneal wants an --annealing-time, in microseconds")
    if options.fast_anneal and options.reverse_from:
        raise Failure(USAGE, "a fast anneal cannot begin from a state; leave out --fast-anneal or "
                      "--reverse-from")
    if options.embedding and options.seed is not None and options.copies == 1:
        raise Failure(USAGE, "--seed is for the search of an embedding, --embedding gives one; "
                      "leave one of them out")
    if (options.no_wait or options.resubmit) and not solver.kind:
        raise Failure(USAGE, f"{options.solver} runs here; --no-wait and --resubmit are for "
                      "D-Wave's services")
    if options.label is not None:
        # Bytes of the command line that are no UTF-8: neither service nor .qsf could hold them.
        options.label = options.label.encode("utf-8", "replace").decode()
    if options.out_dir is None:
        _complete_one(options)
    elif options.output is not None:
        raise Failure(USAGE, "--out-dir does not go with -o")
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
    if not options.dry_run and options.output != "-" and (
            os.path.realpath(options.output) == os.path.realpath(options.problem)):
        raise Failure(USAGE, f"{options.output} is the problem itself; give -o another name")
    name_label(options)


def _run(module, function, options, file):
    """The exit status of the function, whose module is imported now: --help waits for none."""
    if hasattr(options, "memory_limit"):
        options.memory_limit <<= 20
    if getattr(options, "output", None) == "-":
        if options.json:
            raise Failure(USAGE, "-o - and --json both want stdout; give -o a file")
        if os.isatty(1):
            raise Failure(USAGE, "-o - would write binary to a terminal; redirect stdout, or give "
                          "-o a file")
    with failing(file):
        module = importlib.import_module("." + module, __package__)
        return getattr(module, function)(options) or OK


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
