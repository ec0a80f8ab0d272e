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

OK, NO, USAGE, BAD_INPUT, IO, SERVICE = 0, 1, 2, 3, 4, 5


@dataclass(frozen=True)
class Solver:
    """One row of the table of solvers: where its function is, and the options that it takes with their defaults."""

    module: str
    summary: str
    options: dict

    def run(self, name, *arguments):
        module = importlib.import_module("." + self.module, __package__)
        return getattr(module, name.replace("-", "_"))(*arguments)


# No module of a solver is imported before it runs: --help does not wait for numpy, local solvers not for the cloud client.
SOLVERS = {
    "anneal": Solver("solvers", "simulated annealing, finished by steepest descent (the default)",
                     {"num_reads": 20, "num_sweeps": 1000, "seed": None, "time_limit": None}),
    "tabu": Solver("solvers", "tabu search; --time-limit is for all reads together",
                   {"num_reads": 10, "seed": None, "time_limit": 10.0}),
    "exact": Solver("solvers", "every state; at most 24 variables; writes up to 100 of the best, feasible ones first", {}),
    "ilp": Solver("ilp", "integer programs solved by HiGHS, one for each connected part: the proven least labelling",
                  {"time_limit": None}),
    "qpu": Solver("services", "D-Wave's quantum annealer, by minor embedding",
                  {"num_reads": 1000, "annealing_time": None, "chain_strength": None, "label": None}),
    "hybrid-bqm": Solver("services", "D-Wave's hybrid solver, penalties in the model",
                         {"time_limit": None, "label": None}),
    "hybrid-cqm": Solver("services", "D-Wave's hybrid solver, one-hot groups as constraints, no penalties",
                         {"time_limit": None, "label": None}),
}

EPILOG = "\n".join([
    "solvers:",
    *(f"  {name:<11} {solver.summary}\n" + " " * 14 + "takes " + (", ".join(
        f"--{option.replace('_', '-')}" + (f" ({default:g})" if default is not None else "")
        for option, default in solver.options.items()) or "no options") for name, solver in SOLVERS.items()),
    """
exit status: 0 done, 2 usage, 3 bad input, 4 cannot read or write or over the memory limit, 5 the solver or its service
failed or refused, 130 interrupted (128 + the signal). A failed command leaves no output file, and an existing one as it
was; that the output can be written is seen to before anything is sent.

exact proves the minimum of the QUBO. Where that is infeasible, the penalty is too small, and nothing is proven of labellings.
ilp leaves the penalties out and proves the minimum over the labellings, the states with one variable at 1 in each one-hot
group. It likes one-hot-sparse best, and reduced problems; --time-limit is for all parts together, and where it ends the
search the bound still holds. It needs HiGHS: pip install qstereo-bridge[exact].

examples:
  qstereo-bridge solve p.qcf -o s.qsf
  qstereo-bridge solve p.qcf -o s.qsf --num-reads 50 --seed 1 --json
  qstereo-bridge solve p.qcf -o s.qsf --solver ilp --time-limit 60
  qstereo-bridge solve p.qcf --solver hybrid-cqm --dry-run
  qstereo-bridge solve p.qcf -o s.qsf --solver qpu --num-reads 1000 --annealing-time 50

D-Wave's services (qpu, hybrid-bqm, hybrid-cqm) use your own account: `dwave config create`, or the environment
variable DWAVE_API_TOKEN. Only coefficients are sent, with the label."""])

# What helps against a chip that is too small.
SMALLER = ("make it smaller with `qstereo reduce` or a smaller window (encode --roi), or encode it with fewer couplers "
           "(--encoding one-hot-sparse or domain-wall); another --seed or a longer --timeout may do as well")
EMBED_EPILOG = """
A window of a picture with k labels in the encoding one-hot-sparse is laid out in the chip's own tiles at once, in chains of
2 ceil(k / 8) qubits, as far as the chip reaches; every other problem is searched for by minorminer, whose result depends on the seed.
The shortest embedding seen of a problem's graph into a chip is kept in the folder qstereo of the user's cache.

exit status: 0 done, 1 no embedding found, 2 usage, 3 bad input, 4 cannot read or write or over the memory limit, 5 the
service does not give the solver's graph, 130 interrupted. A failed command leaves no file.

examples:
  qstereo-bridge embed p.qcf --topology zephyr:12 -o e.json --picture e.png
  qstereo-bridge embed p.qcf --topology Advantage2_system1 --seed 1 --timeout 300 -o e.json"""


class Failure(Exception):
    """An end of the command: exit status and message."""

    def __init__(self, status, message):
        super().__init__(message)
        self.status = status


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


def _parser():
    parser = _Parser(prog="qstereo-bridge", description="Solve QUBO coefficient files with D-Wave's samplers.")
    parser.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True, parser_class=_Parser)
    solve = commands.add_parser(
        "solve", help="solve a .qcf, write a .qsf", epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Solve the problem in a .qcf and write the samples found to a .qsf.")
    add, whole = solve.add_argument, _number(int, 1, 2**31 - 1)
    positive = _number(float, 1e-6, 1e9)
    add("problem", metavar="P.qcf", help="the problem; - is stdin")
    add("-o", "--output", metavar="S.qsf", help="the samples; - is stdout; needed unless --dry-run")
    add("--solver", choices=SOLVERS, default="anneal", metavar="NAME", help="one of the solvers below (anneal)")
    add("--num-reads", type=whole, metavar="N", help="samples to take")
    add("--num-sweeps", type=whole, metavar="N", help="sweeps of each annealing read")
    add("--seed", type=_number(int, 0, 2**31 - 1), metavar="N", help="seed of the random numbers (a random one)")
    add("--time-limit", type=positive, metavar="S", help="seconds; hybrid solvers: the least they allow")
    add("--annealing-time", type=positive, metavar="US", help="microseconds of each anneal (the chip's default)")
    add("--chain-strength", type=positive, metavar="X", help="coupling in a chain (uniform torque compensation)")
    add("--label", metavar="TEXT", help="the problem's name at the service (the file's name without .qcf)")
    add("--dry-run", action="store_true", help="say what would be sent, and against which limits; send nothing")
    add("--json", action="store_true", help="print the result as one JSON object")
    add("--memory-limit", type=_number(int, 1, 1 << 40), default=8192, metavar="MIB", help="memory for the problem (8192)")
    add("--quiet", action="store_true", help="no progress and no result lines, only errors")
    _add_embed(commands)
    return parser


def _add_embed(commands):
    embed = commands.add_parser(
        "embed", formatter_class=argparse.RawDescriptionHelpFormatter, epilog=EMBED_EPILOG,
        description="Find a minor embedding of a .qcf's QUBO: a chain of the chip's qubits for each variable.")
    add = embed.add_argument
    add("problem", metavar="P.qcf", help="the problem; - is stdin")
    add("-o", "--output", metavar="E.json", required=True, help="the embedding; - is stdout")
    add("--topology", metavar="NAME", required=True,
        help="pegasus:16, zephyr:12 (or another size; all qubits work), or a solver of your account: the qubits that work there")
    add("--seed", type=_number(int, 0, 2**31 - 1), metavar="N", help="seed of the search (a random one)")
    add("--timeout", type=_number(float, 1e-6, 1e9), default=100.0, metavar="S", help="seconds of search (100)")
    add("--picture", metavar="E.png", help="draw the problem's graph and the chip, each chain in the colour of its variable")
    add("--json", action="store_true", help="print the figures as one JSON object")
    add("--memory-limit", type=_number(int, 1, 1 << 40), default=8192, metavar="MIB", help="memory for the problem (8192)")
    add("--quiet", action="store_true", help="no progress and no result lines, only errors")
    embed.set_defaults(solver="embed", dry_run=False)


def _options(arguments):
    """Parse and complete the options. Raises Failure."""
    options = _parser().parse_args(arguments)
    options.memory_limit <<= 20
    return _solve_options(options) if options.command == "solve" else _embed_options(options)


def _embed_options(options):
    named = [name for name in (options.problem, options.output, options.picture) if name not in (None, "-")]
    if len({os.path.realpath(name) for name in named}) < len(named):
        raise Failure(USAGE, "problem, embedding and picture are files of their own; give them three names")
    if options.output == "-" and options.json:
        raise Failure(USAGE, "-o - and --json both want stdout; give -o a file")
    if options.picture == "-":
        raise Failure(USAGE, "a picture does not go to stdout; give --picture a file")
    return options


def _solve_options(options):
    solver = SOLVERS[options.solver]
    for option in sorted({option for other in SOLVERS.values() for option in other.options}):
        if getattr(options, option) is None:
            setattr(options, option, solver.options.get(option))
        elif option not in solver.options:
            takers = ", ".join(name for name, other in SOLVERS.items() if option in other.options)
            raise Failure(USAGE, f"{options.solver} takes no --{option.replace('_', '-')}, only {takers} do")
    if "label" in solver.options and options.label is None and options.problem != "-":
        options.label = os.path.splitext(os.path.basename(options.problem))[0]
    if options.label is not None:
        # Bytes of the command line that are no UTF-8: neither the service nor the .qsf could hold them.
        options.label = options.label.encode("utf-8", "replace").decode()
    if options.output is None and not options.dry_run:
        raise Failure(USAGE, "name the samples file with -o S.qsf (or ask for --dry-run)")
    if not options.dry_run and os.path.realpath(options.output) == os.path.realpath(options.problem) != os.path.realpath("-"):
        raise Failure(USAGE, f"{options.output} is the problem itself; give -o another name")
    if options.output == "-" and options.json:
        raise Failure(USAGE, "-o - and --json both want stdout; give -o a file")
    if options.output == "-" and os.isatty(1):
        raise Failure(USAGE, "-o - would write binary to a terminal; redirect stdout, or give -o a file")
    return options


def _progress(options):
    """A function that shows one line of progress on a terminal, elsewhere nothing; with None it clears the line."""
    if options.quiet or not sys.stderr.isatty():
        return lambda text: None
    began = time.monotonic()

    def show(text):
        line = "" if text is None else f"{options.solver}: {text}, {time.monotonic() - began:.0f} s"
        print(f"\r\033[K{line}", end="", file=sys.stderr, flush=True)
    return show


@contextlib.contextmanager
def _io(name, what):
    """What the system refuses is a Failure that names the file."""
    try:
        yield
    except OSError as error:
        raise Failure(IO, f"{name}: cannot {what}: {error.strerror or error}") from None


def _read(options):
    """The Problem and the file's SHA-256."""
    import hashlib
    from .qcf import read_qcf

    stdin = options.problem == "-"
    with _io(options.problem, "read"), open(0 if stdin else options.problem, "rb", closefd=not stdin) as stream:
        problem, data = read_qcf(stream, options.memory_limit)
    return problem, hashlib.sha256(data).digest()


def _dry_run(options, problem):
    from .services import plan

    nothing = problem.linear.size == 0
    found = {"schema": 1, "solver": options.solver, "dry_run": True, **(
        {"variables": 0, "quadratic_terms": 0, "upload_bytes": 0, "fits": True} if nothing
        else plan(options.solver, problem, options.memory_limit))}
    if options.json:
        return json.dumps(found)
    lines = [f"{options.solver}: {found['variables']:,} variables, {found['quadratic_terms']:,} quadratic terms"]
    if nothing:
        return lines[0] + "\nnothing is left to decide; nothing is ever sent"
    if SOLVERS[options.solver].module != "services":
        return lines[0] + "\nruns on this machine; nothing is ever sent"
    if options.solver == "qpu":
        if found["fits"] is None:
            lines.append(f"largest degree {found['largest_degree']}; linear terms {found['linear_min']} to {found['linear_max']}, "
                         f"quadratic terms {found['quadratic_min']} to {found['quadratic_max']}")
        lines.append(f"upload at least {found['upload_bytes']:,} bytes, the embedding adds to them")
        lines += [f"{chip}: {qubits:,} qubits (as published)" for chip, qubits in found["qubits"].items()]
    else:
        lines.append(f"upload about {found['upload_bytes']:,} bytes; least time limit {found['minimum_time_limit']:,.1f} s")
        lines += [f"{found[key]:,} {key} of the {limit:,} that the service takes (as published)"
                  for key, limit in found["limits"].items()]
    fits = {True: "it fits", False: "it does not fit", None: "whether it fits, the embedding will show"}[found["fits"]]
    return "\n".join([*lines, f"{fits}; nothing was sent"])


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
    least, bound = min(energies.tolist(), default=None), answer.lower_bound
    # A minimum of H that is no labelling proves nothing of the labellings.
    proven = bound is not None and bool((good == bound).any())
    real = {key: _real(value, problem.scale) for key, value in {
        "energy": least, "lower_bound": bound, "gap": None if bound is None else least - bound,
        "best_energy": min(good.tolist(), default=None)}.items()}
    if options.json:
        return json.dumps({"schema": 1, "solver": options.solver, **real, "proven_optimal": proven,
                           "iterations": answer.iterations, "seconds": round(seconds, 3), "samples": energies.size,
                           "feasible": good.size})
    bounded = ("" if bound is None else " (proven optimal)" if proven else
               f" (at most {real['gap']} above the least)" if bound < least else
               " (the minimum of the QUBO is infeasible: the penalty is too small)")
    best = f"{good.size} feasible, best energy of these {real['best_energy']}" if good.size else "none feasible"
    return (f"{options.solver}: {energies.size} samples, best energy {real['energy']}{bounded}; {best}; {seconds:.1f} s\n"
            f"{options.output}: written")


def _show(options, text):
    stream = sys.stderr if options.output == "-" and not options.dry_run else sys.stdout
    if options.json or options.dry_run or not options.quiet:
        with _io("stderr" if stream is sys.stderr else "stdout", "write"):
            print(text, file=stream, flush=True)


def _solve(options):
    """Solve, check, write, print. A regular file gets its name last, when all else has gone well."""
    from .models import energies as recompute
    from .output import Output
    from .qsf import Samples, pack_qsf
    from .solvers import nothing_to_decide

    with _io(options.output, "write"):
        output = Output(options.output)
    with output:
        problem, digest = _read(options)
        began, progress = time.monotonic(), _progress(options)
        try:
            answer = (SOLVERS[options.solver].run(options.solver, problem, options, progress) if problem.linear.size
                      else nothing_to_decide(problem))
            energies = recompute(problem, answer.bits)
            _check_energies(answer, energies, problem)
        finally:
            progress(None)
        data = pack_qsf(Samples(digest, options.solver, _records(answer, energies), answer.bits, answer.info))
        with _io(options.output, "write"):
            output.write(data)
        _show(options, _summary(options, problem, answer, energies, time.monotonic() - began))
        with _io(options.output, "write"):
            output.keep()


def _embed(options):
    """Embed, draw, print. The embedding's file gets its name last."""
    from . import embedding
    from .output import Output

    picture, drawing = None, None
    if options.picture:
        from . import picture

        try:
            picture.require()
        except ImportError:
            raise Failure(IO, f"{options.picture}: a picture needs matplotlib; pip install 'qstereo-bridge[picture]'") from None
        with _io(options.picture, "write"), Output(options.picture):
            pass
    with _io(options.output, "write"):
        output = Output(options.output)
    with output:
        problem, _ = _read(options)
        try:
            chip = embedding.Chip.named(options.topology)
        except ValueError as error:
            raise Failure(USAGE, str(error)) from None
        source, progress = embedding.Source.of(problem, options.memory_limit), _progress(options)
        try:
            found = embedding.find(source, chip, options.seed, options.timeout, progress)
            embedding.keep(found, source, chip)
            if picture:
                progress("picture")
                drawing = picture.draw(source, chip, found)
        except embedding.NoEmbedding as error:
            raise Failure(NO, f"{options.problem}: {error}; {SMALLER}") from None
        finally:
            progress(None)
        with _io(options.output, "write"):
            output.write(found.to_json().encode())
        _show(options, _embed_summary(options, source, chip, found))
        with _io(options.output, "write"):
            output.keep()
    if picture:
        with _io(options.picture, "write"), Output(options.picture) as output:
            output.write(drawing)
            output.keep()


def _embed_summary(options, source, chip, found):
    figures = {"variables": source.variables, "couplers": int(source.rows.size), **found.figures(), "seconds": found.seconds,
               "chip_qubits": int(chip.qubits.size), "share": round(found.figures()["qubits"] / chip.qubits.size, 4)}
    if options.json:
        return json.dumps({"schema": 1, "topology": found.topology, "method": found.method, "seed": found.seed, **figures})
    return (f"{found.topology}: {figures['variables']:,} variables, {figures['couplers']:,} couplers on {figures['qubits']:,} qubits, "
            f"{100 * figures['share']:.1f} % of the chip; longest chain {figures['longest_chain']}, mean {figures['mean_chain']:.2f}; "
            f"{found.method}, {found.seconds:.1f} s\n" + "".join(f"{name}: written\n" for name in (options.output, options.picture)
                                                               if name))[:-1]


def _run(options):
    """The command, whatever goes wrong in it a Failure."""
    from .container import FormatError, OverLimit
    from .solvers import SolverError

    try:
        if options.dry_run:
            _show(options, _dry_run(options, _read(options)[0]))
        elif options.command == "embed":
            _embed(options)
        else:
            _solve(options)
    except MemoryError:
        raise Failure(IO, f"{options.problem}: this machine has not enough memory for it") from None
    except (FormatError, SolverError) as error:
        status = IO if isinstance(error, OverLimit) else BAD_INPUT if isinstance(error, FormatError) else SERVICE
        raise Failure(status, f"{options.problem}: {error}") from None


def main(arguments=None):
    """The command; returns the exit status."""
    name = "qstereo-bridge"
    # A file's name may be no UTF-8; a closed stdout is None.
    if sys.stdout is not None:
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        options = _options(arguments)
        name += f" {options.command}"
        _run(options)
    except Failure as failure:
        print(f"{name}: {failure}", file=sys.stderr)
        return failure.status
    return OK
