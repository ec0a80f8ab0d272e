"""One page of HTML on results: pairs, maps, errors, energies and their bounds, sizes.

A page holds its pictures and drawings itself: no network, no script. How it is written is in
report.html.j2.
"""

import csv
import io
import re
from pathlib import Path

import jinja2
import numpy as np
from PIL import Image

from ..core.failure import Error, InputError
from ..core.failure import io as reading
from ..core.output import save
from ..core.qsf import parse_qsf
from ..core.text import parse
from ..runs import runner
from . import drawing as draw

COLUMNS = {"solver": "method", "energy": "energy", "gap": "gap", "rms": "rms, pixels",
           "bad_0_5": "bad-0.5, %", "bad_1_0": "bad-1.0, %", "seconds": "seconds",
           "feasible": "feasible", "samples": "samples", "charge": "charge, s"}
DIGITS = {"rms": 2, "bad_0_5": 2, "bad_1_0": 2, "seconds": 3, "charge": 3}
# What says nothing where it is the same in all rows.
USUAL = {"feasible": 1, "samples": 1, "charge": 0}
# What is told of a problem where its file has it.
FACTS = {
    "width": "{:,} columns", "height": "{:,} rows", "labels": "{:,} labels",
    "variables": "{:,} variables", "variables_before": "{:,} variables",
    "variables_after": "{:,} variables left by proof",
    "variables_left": "{:,} variables left by proof",
    "decided": "{:.2%} of the sites decided by proof", "quadratic_terms": "{:,} quadratic terms",
    "penalty_max": "the largest penalty of a site: {:,.12g}",
    "pair_penalty_max": "that of a pair: {:,.12g}", "qubits": "{:,} qubits",
    "calls_done": "{:,} calls", "charge_seconds": "{:,.12g} seconds charged",
    "lower_bound": "proven lower bound: {:,.12g}", "upper_bound": "best energy known: {:,.12g}"}
TRACE = ["solver", "seconds", "iteration", "energy", "bound", "variables"]
NOTE = "Black: more than one pixel off; grey: more than half a pixel; white: right, or unknown."


def load(path):
    """Results as a list of problems: dicts with "name", "folder", "results" and what is known.

    path  a file that `compare --json` or `reduce --json` printed, or with a list of such objects
          under "problems"; the journal of a run in windows; a trace; or a folder of such files
    Raises InputError, FileError.
    """
    path, problems = Path(path), []
    for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
        if path.is_dir() and file.suffix not in KINDS:
            continue
        try:
            with reading(file, "be read"):
                found = KINDS.get(file.suffix, read_json)(file)
        except (ValueError, TypeError, AttributeError, KeyError) as error:
            if path.is_dir():
                continue
            raise InputError(f"{file}: holds no results of `qstereo compare --json`, of `reduce "
                             f"--json` or of --trace: {error}") from error
        problems += [{"name": file.stem, "folder": file.parent, "results": [], **one}
                     for one in found]
    # A trace that a problem names is shown with it, not once more by itself.
    named = {place(one, one["trace"]).resolve() for one in problems
             if isinstance(one.get("trace"), str)}
    problems = [one for one in problems if one.get("course_of") not in named]
    if not problems:
        raise InputError(f"{path}: holds no results; `qstereo compare P.qcf --json --maps DIR` "
                         "prints them, `make paper` makes a folder of them")
    return problems


def read_json(file):
    said = parse(file.read_text(encoding="utf-8"))
    return [one for one in said.get("problems", [said])
            if isinstance(one.get("results"), list) or "variables_after" in one]


def read_journal(file):
    """The journal of a run in windows; its bound is in the samples beside it."""
    lines = [parse(line) for line in file.read_text(encoding="utf-8").splitlines()]
    if lines[0].get("format") != "qstereo-journal":
        raise ValueError("it is no journal of a run in windows")
    bound = None
    if file.with_suffix("").exists():
        bound = parse_qsf(file.with_suffix("").read_bytes()).info.get("lower_bound")
    return [{"calls": lines[1:], "calls_done": len(lines) - 1, "lower_bound": bound,
             "charge_seconds": sum(line["charge_seconds"] for line in lines[1:])}]


def read_trace(file):
    with open(file, encoding="utf-8", newline="") as stream:
        rows = csv.DictReader(stream)
        return [{"rows": list(rows), "course_of": file.resolve()}] if rows.fieldnames == TRACE \
            else []


KINDS = {".json": read_json, ".journal": read_journal, ".csv": read_trace}


def place(problem, name):
    """Where a file is that a problem names: seen from the results' folder, or as it is."""
    inside = problem["folder"] / name
    return inside if inside.exists() else Path(name)


def picture(problem, name):
    """A picture of a problem as an array."""
    path = place(problem, name)
    with reading(path, "be read"):
        try:
            with Image.open(path) as opened:
                return np.asarray(opened)
        except (ValueError, SyntaxError, Image.UnidentifiedImageError) as error:
            raise InputError(f"{path}: is no picture: {error}; write maps as PNG") from error


def of_pair(problem, name):
    """A picture that the problem names, or else that lies beside its results as NAME.png; None if
    there is none."""
    beside = problem["folder"] / f"{name}.png"
    named = problem.get(name) or (beside if problem["results"] and beside.exists() else None)
    return picture(problem, named) if named else None


def levels(values, scale):
    """A map in pixels of disparity, NaN where it has no value."""
    values = values if values.ndim == 2 else values[..., 0]
    return np.where(values == 0, np.nan, values / scale)


def errors(values, truth):
    off = np.abs(values - truth)
    return np.where(off > 1, 0, np.where(off > 0.5, 150, 255)).astype(np.uint8)


def all_maps(problem):
    """[(name, map)] of the results, (name, truth) or None, and [(name, picture)] of the pair, all
    cut to the rows and columns where the results have values."""
    scale = problem.get("scale", 8)
    found = [(one["solver"], levels(picture(problem, one["map"]), scale))
             for one in problem["results"] if one.get("map")]
    truth = of_pair(problem, "truth")
    truth = None if truth is None else levels(truth, problem.get("truth_scale", 8))
    pair = [(name, values if values.dtype == np.uint8 else (values // 257).astype(np.uint8))
            for name in ("left", "right", "confidence")
            if (values := of_pair(problem, name)) is not None]
    if not found:
        return [], None, pair
    shape = found[0][1].shape
    known = np.any([~np.isnan(values) for _, values in found if values.shape == shape], axis=0)
    rows, columns = (np.flatnonzero(known.any(axis)) for axis in (1, 0))
    cut = tuple(slice(at[0], at[-1] + 1) if at.size else slice(None) for at in (rows, columns))

    def part(pictures):
        return [(name, values[cut] if values.shape[:2] == shape else values)
                for name, values in pictures]
    return (part(found), truth[cut] if truth is not None and truth.shape == shape else None,
            part(pair))


def maps(problem):
    """(Pair, maps and error maps of a problem, in one colour scale, as grids of the page; the maps
    as figures: name -> figure)."""
    found, truth, pair = all_maps(problem)
    grids = [{"pictures": [(name, name, draw.image(values)) for name, values in pair]}]
    if not found:
        return grids, {}
    shown = found if truth is None else [("truth", truth), *found]
    # The truth's range, where there is one: a few wrong pixels would take the colours of all.
    known = np.concatenate([values[~np.isnan(values)]
                            for _, values in (shown if truth is None else shown[:1])])
    low = known.min() if known.size else 0
    high = max(known.max(initial=0), low + 1)
    grids.append({"bar": draw.drawing(draw.bar(low, high)), "pictures": [
        (name, f"map of {name}", draw.image(values, "turbo", low, high))
        for name, values in shown]})
    if truth is not None:
        grids.append({"head": "Errors", "note": NOTE, "pictures": [
            (name, f"errors of {name}", draw.image(errors(values, truth)))
            for name, values in found if values.shape == truth.shape]})
    return grids, {"maps": draw.sheet(shown, low, high)}


def courses(problem):
    """The courses that a problem's trace has: name -> rows."""
    rows, found = problem.get("rows", []), {}
    if problem.get("trace"):
        with reading(problem["trace"], "be read"):
            rows = [row for one in read_trace(place(problem, problem["trace"]))
                    for row in one["rows"]]
    for row in rows:
        found.setdefault(row["solver"], []).append(row)
    return found


def charts(problem):
    """The drawings of a problem: name -> figure."""
    traces, calls = courses(problem), problem.get("calls", [])
    answered = [one for one in problem["results"] if one.get("energy") is not None]
    told = [float(one["energy"]) for rows in (answered, calls, *traces.values()) for one in rows
            if one.get("energy") not in (None, "")]
    low, what = problem.get("lower_bound"), "the proven bound"
    if low is None:
        low, what = min(told, default=0), "the lowest"
    drawn = {"energies": draw.energies(answered, low, what) if len(answered) > 1 else None,
             "course": draw.course(traces, "seconds", f"energy above {what}\n(dashed: bounds)",
                                   low=low),
             "left": draw.course(traces, "seconds", "variables left", ["variables"]),
             "calls": draw.course({"calls": calls}, "call", f"energy above {what}", low=low)}
    return {name: figure for name, figure in drawn.items() if figure}


def cell(key, value):
    """A value of a table as the page shows it."""
    if value is None:
        return "-"
    return f"{value:.{DIGITS[key]}f}" if key in DIGITS else f"{value:,}" \
        if isinstance(value, int | float) else f"{value}"


def csv_text(rows, columns):
    out = io.StringIO()
    writer = csv.DictWriter(out, columns, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()


def told_of(rows, columns):
    """Those of the columns that tell the rows apart, or say what is not usual."""
    return {key: text for key, text in columns.items()
            if any(row.get(key) not in (None, USUAL.get(key)) for row in rows)}


def facts(problem):
    """What is known of a problem, as a sentence."""
    said = ", ".join(text.format(problem[key]) for key, text in FACTS.items()
                     if problem.get(key) is not None)
    return f"{said[:1].upper()}{said[1:]}." if said else ""


def sections_of(problems, columns=COLUMNS):
    """The sections of a page, as report.html.j2 takes them: one of each problem, and before them
    one of all that have a single result.

    problems    of `load`
    columns     key of a result -> heading in the table
    """
    made, single = [], [{"name": one["name"], **one["results"][0]} for one in problems
                        if len(one["results"]) == 1]
    if len(single) > 1:
        made.append({"name": "All results", "rows": single, "figures": {},
                     "columns": told_of(single, {"name": "name", **columns})})
    for problem in problems:
        drawn, (grids, sheet) = charts(problem), maps(problem)
        made.append({"name": problem["name"], "facts": facts(problem), "grids": grids,
                     "rows": problem["results"], "columns": told_of(problem["results"], columns),
                     "charts": [draw.drawing(figure) for figure in drawn.values()],
                     "figures": drawn | sheet})
    return made


def parts_of(sections):
    """The tables and drawings of sections as texts: name of a file -> text."""
    parts = {}
    for number, section in enumerate(sections, 1):
        stem = f"{number:02}-" + re.sub(r"[^\w.]+", "-", str(section["name"])).strip("-")
        if section["rows"]:
            parts[f"{stem}-results.csv"] = csv_text(section["rows"], section["columns"])
        for name, figure in section["figures"].items():
            parts[f"{stem}-{name}.svg"] = draw.svg(figure)
    return parts


def page_of(sections, title, before=()):
    """The page as text. before: paragraphs that stand before the sections."""
    template = jinja2.Environment(autoescape=True, trim_blocks=True).from_string(
        Path(__file__).with_name("report.html.j2").read_text(encoding="utf-8"))
    return template.render(sections=sections, title=title, before=before, cell=cell)


def report(options):
    """The command `report`."""
    try:
        problems = load(options.results)
        page = page_of(sections_of(problems), options.title).encode()
    except Error:
        raise
    except (ValueError, TypeError, AttributeError, KeyError) as error:
        raise InputError(f"{options.results}: its results are not as qstereo writes them "
                         f"({type(error).__name__}: {error})") from error
    save(options.output, page)
    runner.show(options, f"{options.output}: {len(problems)} problem{'s' * (len(problems) != 1)}, "
                f"{len(page):,} bytes", {"output": options.output, "problems": len(problems),
                                         "bytes": len(page)})
