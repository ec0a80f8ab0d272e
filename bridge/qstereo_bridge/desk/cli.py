"""The command qstereo-bridge. Results go to stdout, messages and progress to stderr."""

import difflib
import os
import sys
import textwrap
from types import SimpleNamespace

import click

from .. import __version__
from ..core.failure import OK, USAGE, Failure, failing
from ..core.text import lines, parse
from ..runs.registry import ALIASES, EVERY, SOLVERS, at, find, name_label


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


STATUS = """\
Exit status: 0 done; 1 the answer is no (of several problems one failed, sent
already, no answer yet, above --max-charge, no embedding, not valid); 2 wrong
usage; 3 bad input; 4 a file cannot be read or written, or too little memory;
5 the solver or its service failed or refused; 130 interrupted (128 + signal).
A command that fails leaves no new file, and an older one as it was."""
SOLVE_EPILOG = f"""\
Solvers, their options, and the defaults of these (stride is hybrid-nl):
{_table_of_solvers()}

exact proves the minimum of the QUBO, ilp the best labelling; where the time is
over, ilp's lower bound still holds. ilp is best on reduced problems.

D-Wave's services (qpu, hybrid-..) use your own account: `dwave config create`,
or the environment variable DWAVE_API_TOKEN. Only coefficients and the label are
sent. The job file S.qsf.job lies beside the samples until these are written:
whatever interrupts the command, `qstereo-bridge collect S.qsf.job` fetches the
answer, and nothing is charged twice.

{STATUS}

Examples:
  qstereo-bridge solve p.qcf -o s.qsf --num-reads 50 --seed 1 --json
  qstereo-bridge solve p.qcf -o s.qsf --solver ilp --time-limit 60
  qstereo-bridge solve p.qcf -o s.qsf --solver dwave.samplers:TabuSampler \\
      --param tenure=10
  qstereo-bridge solve p.qcf --solver hybrid-cqm --dry-run
  qstereo-bridge solve p.qcf -o s.qsf --solver hybrid-nl --no-wait
  qstereo-bridge solve frames/*.qcf --out-dir answers --solver hybrid-nl"""
EMBED_EPILOG = f"""\
A window of a picture in the encoding one-hot-sparse is laid out in the tiles of
the chip, with chains of 2 ceil(k / 8) qubits for k labels. minorminer searches
for all others. The shortest embedding of each problem and chip is kept in the
folder qstereo of your cache.

{STATUS}

Example:
  qstereo-bridge embed p.qcf --topology zephyr:12 -o e.json --picture e.png"""
REPORT_EPILOG = f"""\
RESULTS is a file that `qstereo compare --json` or `qstereo reduce --json` has
printed, a file of `--trace`, the journal of a run in windows, or a folder of
such files. left.png, right.png, truth.png and confidence.png beside a file of
compare are shown with it; keys of these names beside "results" name others.
"scale" and "truth_scale" are the grey levels of a pixel (default 8).

{STATUS}

Example:
  qstereo compare p.qcf --json --maps out --trace out/t.csv >out/p.json
  qstereo-bridge report out -o report.html"""


FRAMES_EPILOG = f"""\
A frame that fails does not stop the others; they are named at the end, and the
exit status is 1. A second run does what is missing. With --windows solve begins
from the best labelling that reduce knows, and knows the bound.

The workers of a scheduler need qstereo-bridge, the command qstereo and the same
folders. Paid calls go to workers with the resource qpu: dask worker ADDRESS
--resources qpu=1. A call that was interrupted is not charged again: a second
run fetches its answer.

{STATUS}

Examples:
  qstereo-bridge frames pairs --out-dir out --encode '--disparity 0:31' \\
      --solve '--windows 1000 --seed 1' --score '--truth-scale 4'
  qstereo-bridge frames list.txt --out-dir out --scheduler tcp://10.0.0.1:8786 \\
      --solve '--solver qpu --windows 1000 --calls 3' --max-charge 60"""


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
            form = "g" if self.kind is float else ","
            self.fail(f"{value} is not between {self.low:{form}} and {self.high:{form}}", param,
                      ctx)
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
            found[key] = parse(text)
        except ValueError:
            raise click.BadParameter(f"{word} is not KEY=JSON; put a text in quotes: "
                                     f"'{key}=\"{text}\"'") from None
    return found or None


def _option(name, kind, metavar, help, **more):
    return click.option(*name.split(), type=kind, metavar=metavar, help=help, **more)


def _flag(name, help):
    return click.option(name, is_flag=True, help=help)


WHOLE, SEED = Number(int, 1, 2**31 - 1), Number(int, 0, 2**31 - 1)
SECONDS, POSITIVE = Number(float, 1e-6, 1e9), Number(float, 1e-3, 1e9)
PROBLEM = click.argument("problem", metavar="P.qcf")
COMMON = [
    _flag("--json", "print the result as one JSON object"),
    _option("--memory-limit", Number(int, 1, 1 << 40), "MIB",
            "the most memory for the problem (default 8192)", default=8192),
    _flag("--quiet", "no progress and no result lines, only errors")]
NO_POSTPROCESS = _flag(
    "--no-postprocess", "write the samples as the solver gave them. Else descent and merging make "
    "the best state of them; where it is better than all of them it is one more sample, the last")
ALONE = _flag("--alone", "use neither the labelling nor the lower bound that P.qcf carries: what "
              "the solver finds alone")
SOLVE = [
    click.argument("problems", metavar="P.qcf...", nargs=-1, required=True),
    _option("-o --output", str, "S.qsf", "samples file to write, - is standard output"),
    _option("--out-dir", str, "D", "write the samples of each P.qcf to D/P.qsf. If one problem "
            "fails, the others are still solved; those with samples are left out"),
    _option("--solver", str, "NAME", "one of the solvers below (default anneal)",
            callback=_solver, default="anneal"),
    _option("--num-reads", WHOLE, "N", "how many samples to take"),
    _option("--num-sweeps", WHOLE, "N", "sweeps of each annealing read"),
    _option("--seed", SEED, "N", "seed of the random numbers (default a random one); with qpu of "
            "the search for an embedding, so that one found before is not used"),
    _option("--time-limit", SECONDS, "S",
            "stop after S seconds (hybrid solvers: default the shortest they allow)"),
    _option("--param", str, "KEY=JSON", "set a parameter of the sampler or the QPU by its own "
            "name; may be given several times", callback=_parameters, multiple=True),
    _option("--spin-reversals", WHOLE, "N", "sample N times, each time with the values of other "
            "variables exchanged; with qpu N of its --copies, in one request"),
    _option("--annealing-time", POSITIVE, "US",
            "microseconds of each anneal (default that of the chip)"),
    _option("--chain-strength", Number(float, 1e-6, 1e9, auto=None), "X", "strength of the "
            "couplers in a chain (default auto: uniform torque compensation)"),
    _option("--embedding", str, "E.json",
            "embedding to use (default one found before, or else a new one)"),
    _option("--copies", Number(int, 1, 2**31 - 1, auto="auto"), "N", "put N copies of the problem "
            "on the chip, so that each read samples them all; auto: as many as fit (default 1)"),
    _option("--solver-name", str, "NAME",
            "solver of your account (default the newest hybrid solver, the largest chip)"),
    _option("--label", str, "TEXT", "name of the problem at the service (default the file's)"),
    _flag("--no-wait", "send, write S.qsf.job and end; `collect` fetches the answer"),
    _flag("--resubmit", "send although a job file says that it was sent; it is charged again"),
    _option("--max-charge", POSITIVE, "S", "send nothing if the charge may be above S seconds; of "
            "several problems their sum counts"),
    _flag("--dry-run", "send nothing; say what would be sent, and which limits apply"),
    NO_POSTPROCESS, ALONE,
    _option("--windows", WHOLE, "N", "solve a reduced problem in calls of at most N variables, "
            "each merged into the best state known, at first the one that the file of `qstereo "
            "reduce` carries. After an interruption the same command goes on, by its journal, "
            "S.qsf.journal"),
    _option("--calls", WHOLE, "K", "with --windows: at most K calls (default 10). It "
            "ends earlier at the lower bound, where one is known, else after a pass over all "
            "variables that gains nothing"),
    _option("--start", str, "S0.qsf", "with --windows: begin from the best sample of S0.qsf, and "
            "end at the lower bound that S0.qsf states"),
    _option("--bound", Number(float, -1e15, 1e15), "E", "with --windows: end at this lower bound, "
            "in real units, which you know to be proven (default the one that the file states)")]


@click.group(no_args_is_help=False, subcommand_metavar="COMMAND ...",
             context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, "-V", "--version", message="%(prog)s %(version)s")
def bridge():
    """Solve QUBO files (.qcf) on this machine or with D-Wave's services."""


def _command(place, file, *options, epilog=STATUS):
    """Makes a command of the function below it, which completes the options and may return the
    place of the function to run, else at `place`. Errors name the file of the option `file`. It is
    imported only then: --help need not wait for it."""
    def make(complete):
        def completed(values):
            given = SimpleNamespace(**{"command": complete.__name__, "problem": None, **values})
            other = complete(given)
            given.memory_limit = getattr(given, "memory_limit", 0) << 20
            return given, other or place

        def run(**values):
            given, place = completed(values)
            if getattr(given, "output", None) == "-":
                _refuse({"-o - and --json both write to stdout; give -o a file": given.json,
                         "-o - would write binary to a terminal; redirect stdout, or give -o a "
                         "file": os.isatty(1)})
            with failing(getattr(given, file or "", None)):
                return at(place)(given) or OK
        run.completed = completed
        for option in reversed(options):
            run = option(run)
        sentence = " ".join(complete.__doc__.split()).split(". ")[0].rstrip(".") + "."
        return bridge.command(complete.__name__, cls=_Command, help=complete.__doc__,
                              short_help=sentence, epilog=epilog)(run)
    return make


def options_of(name, words):
    """The completed options of a command from its words. Raises click.UsageError, Failure."""
    made = bridge.commands[name]
    return made.callback.completed(made.make_context(name, words).params)[0]


def _refuse(reasons):
    """Raises the Failure of the first reason, {message: whether it applies}, that applies."""
    for message, applies in reasons.items():
        if applies:
            raise Failure(USAGE, message)


@_command("runs.remote:solve", "problem", *SOLVE, *COMMON, epilog=SOLVE_EPILOG)
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
    _refuse({
        "--embedding gives the embedding; leave --seed and --copies out":
            options.embedding and (options.seed is not None or options.copies != 1),
        f"{options.solver} runs locally; --no-wait and --resubmit are for D-Wave's services":
            (options.no_wait or options.resubmit) and not solver.paid,
        "--out-dir does not go with -o": several and options.output is not None,
        "--out-dir names the samples after the problems; stdin has no name":
            several and "-" in options.problems,
        "several problems need --out-dir, the folder for their samples":
            not several and len(options.problems) > 1,
        "name the samples file with -o S.qsf (or ask for --dry-run)":
            not (several or options.output is not None or options.dry_run),
        f"{options.output} is the problem itself; give -o another name":
            not options.dry_run and _same(options.output, options.problem)})
    for option in ("calls", "start", "bound"):
        _refuse({f"{_spelt(option)} is for --windows":
                 getattr(options, option) is not None and not options.windows})
    if options.windows:
        _windows(options)
        return "runs.calls:dry_run" if options.dry_run else "runs.calls:solve"
    name = "dry_run" if options.dry_run else "solve_all" if several else "solve"
    return f"runs.remote:{name}"


def _windows(options):
    """Completes the options of `solve --windows`; refuses those that do not go with it."""
    options.calls = options.calls or 10
    for option in ("out_dir", "no_wait", "resubmit", "embedding", "no_postprocess"):
        _refuse({f"--windows does not go with {_spelt(option)}": getattr(options, option)})
    _refuse({"--windows does not go with --copies": options.copies not in (None, 1),
             "with --windows name the problem's file, not stdin": options.problem == "-",
             "--windows writes files beside the samples file; give -o a file":
                 options.output == "-"})


@_command("runs.remote:collect", "job", click.argument("job", metavar="S.qsf.job"),
          _option("-o --output", str, "S.qsf", "samples file to write, - is standard output "
                  "(default the job file's name without .job)"),
          _option("--problem", str, "P.qcf", "the problem (default the file that was sent)"),
          _flag("--no-wait", "do not wait: exit with 1 if there is no answer yet"),
          NO_POSTPROCESS, ALONE, *COMMON)
def collect(options):
    """Fetch the answer to a problem that was sent to D-Wave. When the samples are written, the job
    file is removed."""
    options.output = options.output or options.job.removesuffix(".job")
    _refuse({f"{options.job} does not end in .job; name the samples file with -o":
             _same(options.output, options.job)})


@_command("runs.runner:merge", "problem", PROBLEM,
          click.argument("samples", metavar="S.qsf...", nargs=-1, required=True),
          _option("-o --output", str, "M.qsf", "samples file to write, - is standard output",
                  required=True), *COMMON)
def merge(options):
    """Merge samples of one problem: steepest descent of each, then the best state that they hold
    together. M.qsf has all samples and, where it is better than all of them, this state as the
    last."""
    options.solver = "merge"
    _refuse({f"{options.output} is one of the files to merge; give -o another name":
             any(_same(options.output, name) for name in [options.problem, *options.samples])})


@_command("desk.frames:frames", None, click.argument("pairs", metavar="LIST|DIR"),
          _option("--out-dir", str, "D", "folder for the maps, the samples, a .json of each frame, "
                  "and the table of all, summary.json and summary.csv", required=True),
          _option("--scheduler", str, "ADDRESS", "scheduler of dask whose workers do the work "
                  "(default one for this run, with workers on this machine)"),
          _option("--workers", WHOLE, "N", "without --scheduler: how many workers (default one "
                  "for each core)"),
          _option("--max-charge", POSITIVE, "S", "send nothing if the charge of all frames "
                  "together may be above S seconds"),
          _flag("--dry-run", "encode and reduce, send nothing; say how many calls each frame "
                "takes, and what all of them may be charged"),
          *(_option(f"--{step}", str, "WORDS", f"options for `{program}`{default and ' '}"
                    f"{default and f'(default {default})'}", default=default)
            for step, program, default in (
                ("encode", "qstereo encode", ""),
                ("reduce", "qstereo reduce", "--encoding domain-wall --truncate"),
                ("solve", "qstereo-bridge solve", ""), ("decode", "qstereo decode", ""),
                ("score", "qstereo score", ""))),
          COMMON[0], COMMON[2], epilog=FRAMES_EPILOG)
def frames(options):
    """From many stereo pairs to maps: encode, reduce, solve, decode, and score where there is
    truth. LIST has a line `left right` or `left right truth` for each pair; DIR has left_NAME.png,
    right_NAME.png and perhaps truth_NAME.png."""
    _refuse({"--workers is for a cluster of this machine; leave it or --scheduler out":
             options.workers and options.scheduler})
    options.options_of = options_of


@_command("desk.embed:embed", "problem", PROBLEM,
          _option("-o --output", str, "E.json", "embedding to write, - is standard output",
                  required=True),
          _option("--topology", str, "NAME", "pegasus:16, zephyr:12 or another size (all qubits "
                  "work), or a solver of your account", required=True),
          _option("--seed", SEED, "N", "seed of the search (default a random one)"),
          _option("--timeout", SECONDS, "S", "stop the search after S seconds (default 100); "
                  "minorminer rarely looks at its clock", default=100.0),
          _option("--picture", str, "E.png", "draw the chip, each chain in a colour of its own"),
          *COMMON, epilog=EMBED_EPILOG)
def embed(options):
    """Find a minor embedding of the QUBO of a .qcf: for each variable a chain of qubits."""
    options.solver = "embed"
    _refuse({"problem, embedding and picture are three files; give them different names":
             _same(options.problem, options.output, options.picture),
             "a picture cannot go to stdout; give --picture a file": options.picture == "-"})


@_command("desk.export:export", "problem", PROBLEM,
          _option("-o --output", str, "FILE", "file to write; its end names the format: .bqm "
                  "(dimod's own), .coo, .lp (an integer program) or .qubo (qbsolv's)",
                  required=True), *COMMON)
def export(options):
    """Write the QUBO of a .qcf in a format of other tools, in the integer units of the .qcf."""


@_command("desk.export:inspect", None, click.argument("samples", metavar="S.qsf"),
          _option("--problem", str, "P.qcf", "the problem of the samples", required=True),
          _option("--embedding", str, "E.json", "its embedding (default the one in the samples)"),
          *COMMON)
def inspect(options):
    """Show samples of a QPU in D-Wave's inspector. The inspector has to be installed."""


@_command("desk.report:report", None, click.argument("results", metavar="RESULTS"),
          _option("-o --output", str, "R.html", "page to write, - is standard output",
                  required=True),
          _option("--title", str, "TEXT", "title of the page (default Results)",
                  default="Results"),
          COMMON[0], COMMON[2], epilog=REPORT_EPILOG)
def report(options):
    """Make one page of HTML of results: maps, errors, energies, bounds and sizes. It needs no
    network, and is light or dark as the reader's system is."""


@_command("desk.verify:verify", "certificate", PROBLEM, click.argument("other", metavar="S.qsf"),
          click.argument("certificate", metavar="C.qpf"), *COMMON)
def verify(options):
    """Check the certificate of a lower bound of P.qcf, without the library that made it. The best
    sample in S.qsf must be as good as it states. In the place of S.qsf may stand the .qcf that
    `qstereo reduce` has written."""


@_command("runs.remote:solvers", None, COMMON[0])
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
