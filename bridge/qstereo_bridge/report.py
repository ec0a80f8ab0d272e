"""One page of HTML on results: pairs, maps, errors, energies and their bounds, sizes.

A page holds its pictures and drawings itself: no network, no script.
"""

import csv
import html
import io
import json
import re
from pathlib import Path

import numpy as np
from PIL import Image

from . import drawing as draw, runner
from .failure import InputError
from .failure import io as reading
from .output import save
from .qsf import parse_qsf

COLUMNS = {"solver": "method", "energy": "energy", "gap": "gap", "rms": "rms, pixels",
           "bad_0_5": "bad-0.5, %", "bad_1_0": "bad-1.0, %", "seconds": "seconds",
           "feasible": "feasible", "samples": "samples", "charge_seconds": "charge, s"}
DIGITS = {"rms": 2, "bad_0_5": 2, "bad_1_0": 2, "seconds": 3, "charge_seconds": 3}
# What is told of a problem where its file has it. Shares are shown in percent.
FACTS = {"width": "columns", "height": "rows", "labels": "labels", "variables": "variables",
         "variables_before": "variables", "variables_after": "variables left by proof",
         "decided": "of the sites decided by proof", "quadratic_terms": "quadratic terms",
         "penalty_max": "the largest penalty of a site", "pair_penalty_max": "that of a pair",
         "qubits": "qubits", "calls_done": "calls", "charge_seconds": "seconds charged",
         "lower_bound": "proven lower bound", "upper_bound": "best energy known"}
TRACE = ["solver", "seconds", "iteration", "energy", "bound", "variables"]
BESIDE = ("left", "right", "truth", "confidence")
STYLE = """
:root { color-scheme: light dark; --ink: #1b1f24; --paper: #fff; --rule: #d5dae0;
        --soft: #5b6570; --good: #1a7f37 }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e4e8ec; --paper: #14171a; --rule: #353b42; --soft: #9aa4ae; --good: #57c878 } }
body { color: var(--ink); background: var(--paper); font: 16px/1.5 system-ui, sans-serif;
       max-width: 75rem; margin: 0 auto; padding: 1rem; overflow-wrap: anywhere }
h1 { font-size: 1.6rem } h2 { font-size: 1.25rem; border-top: 1px solid var(--rule);
     padding-top: 1rem; margin-top: 2rem } h3 { font-size: 1rem }
p, figcaption { max-width: 45rem } figcaption, .soft { color: var(--soft); font-size: .875rem }
.maps { display: grid; gap: .75rem; margin: .75rem 0;
        grid-template-columns: repeat(auto-fill, minmax(9rem, 1fr)) }
figure { margin: 0 } .maps img { width: 100%; image-rendering: pixelated; border-radius: 3px;
         background: #fff; outline: 1px solid var(--rule) }
.wide { overflow-x: auto } svg { max-width: 100%; height: auto; display: block }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .875rem }
th, td { padding: .2rem .6rem; text-align: right; border-bottom: 1px solid var(--rule);
         white-space: nowrap } th:first-child, td:first-child { text-align: left }
.proven { color: var(--good) }
@media print { body { max-width: none } .wide { overflow: visible } figure, tr, svg {
               break-inside: avoid } }
"""


def load(path):
    """Results as a list of problems: dicts with "name", "folder", "results" and what is known.

    path  a file that `compare --json` or `reduce --json` printed, or with a list of such objects
          under "problems"; the journal of a run in windows; a trace; or a folder of such files
    Raises InputError, FileError.
    """
    path = Path(path)
    files = sorted(file for file in path.rglob("*") if file.suffix in KINDS) \
        if path.is_dir() else [path]
    problems = []
    for file in files:
        try:
            with reading(file, "be read"):
                found = KINDS.get(file.suffix, read_json)(file)
        except (ValueError, TypeError, AttributeError, KeyError) as error:
            if path.is_dir():
                continue
            raise InputError(f"{file}: holds no results: {error}") from error
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
    said = json.loads(file.read_text(encoding="utf-8"))
    return [one for one in said.get("problems", [said])
            if isinstance(one.get("results"), list) or "variables_after" in one]


def read_journal(file):
    """The journal of a run in windows; its bound is in the samples beside it."""
    lines = [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]
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
        if rows.fieldnames != TRACE:
            return []
        return [{"rows": list(rows), "course_of": file.resolve()}]


KINDS = {".json": read_json, ".journal": read_journal, ".csv": read_trace}


def place(problem, name):
    """Where a file is that a problem names: seen from the results' folder, or as it is."""
    inside = problem["folder"] / name
    return inside if inside.exists() else Path(name)


def picture(problem, name):
    """A picture of a problem as an array, or None if the problem has none."""
    if not name:
        return None
    path = place(problem, name)
    with reading(path, "be read"):
        try:
            with Image.open(path) as opened:
                return np.asarray(opened)
        except (ValueError, SyntaxError, Image.UnidentifiedImageError) as error:
            raise InputError(f"{path}: is no picture: {error}; write maps as PNG") from error


def of_pair(problem, name):
    """A picture that the problem names, or else that lies beside its results as NAME.png."""
    beside = problem["folder"] / f"{name}.png"
    named = problem.get(name) or (beside if problem["results"] and beside.exists() else None)
    return picture(problem, named)


def levels(values, scale):
    """A map in pixels of disparity, NaN where it has no value."""
    if values is None:
        return None
    values = values if values.ndim == 2 else values[..., 0]
    return np.where(values == 0, np.nan, values / scale)


def grey(values):
    return values if values.dtype == np.uint8 else (values // 257).astype(np.uint8)


def errors(values, truth):
    with np.errstate(invalid="ignore"):
        off = np.abs(values - truth)
        return np.where(off > 1, 0, np.where(off > 0.5, 150, 255)).astype(np.uint8)


def window(maps, shape):
    """The part of pictures of a shape in which maps have values, as two slices."""
    known = np.zeros(shape, bool)
    for _, values in maps:
        known |= ~np.isnan(values) if values.shape == shape else False
    rows, columns = (np.flatnonzero(known.any(axis)) for axis in (1, 0))
    return tuple(slice(at[0], at[-1] + 1) if at.size else slice(None) for at in (rows, columns))


def all_maps(problem):
    """[(name, map)] of the results, (name, truth) or None, and [(name, picture)] of the pair, all
    cut to where the results have values."""
    scale, known = problem.get("scale", 8), {name: of_pair(problem, name) for name in BESIDE}
    found = [(one["solver"], levels(picture(problem, one.get("map")), scale))
             for one in problem["results"] if one.get("map")]
    truth = levels(known["truth"], problem.get("truth_scale", 8))
    shape = found[0][1].shape if found else ()
    cut = window(found, shape) if found else ()

    def part(values):
        return values[cut] if values.shape[:2] == shape else values
    return ([(name, part(values)) for name, values in found],
            truth[cut] if truth is not None and truth.shape == shape else None,
            [(name, part(grey(known[name]))) for name in ("left", "right", "confidence")
             if known[name] is not None])


def maps(problem, keep):
    """Pair, maps and error maps of a problem, in one colour scale."""
    found, truth, pair = all_maps(problem)
    page = grid([(name, draw.image(values, name)) for name, values in pair])
    if not found:
        return page
    shown = ([("truth", truth)] if truth is not None else []) + found
    # The truth's range, where there is one: a few wrong pixels would take the colours of all.
    known = np.concatenate([values[~np.isnan(values)] for _, values in shown[:1 if truth is not None
                                                                              else None]])
    low, high = (known.min(), known.max()) if known.size else (0, 1)
    keep("maps.svg", lambda: draw.svg(draw.sheet(shown, low, high)))
    page += grid([(name, draw.image(draw.coloured(values, low, high), f"map of {name}"))
                  for name, values in shown])
    page += draw.drawing(draw.bar(low, high, "disparity, pixels"))
    if truth is not None:
        page += "<h3>Errors</h3>" + grid([
            (name, draw.image(errors(values, truth), f"errors of {name}"))
            for name, values in found if values.shape == truth.shape])
        page += '<p class="soft">Black: more than one pixel off; grey: more than half a pixel; ' \
                "white: right, or unknown.</p>"
    return page


def grid(figures):
    return '<div class="maps">' + "".join(
        f"<figure>{picture}<figcaption>{html.escape(name)}</figcaption></figure>"
        for name, picture in figures) + "</div>" if figures else ""


def traces_of(problem):
    """The courses that a problem's trace has: name -> rows."""
    rows = problem.get("rows", [])
    if problem.get("trace"):
        with reading(problem["trace"], "be read"):
            rows = [row for one in read_trace(place(problem, problem["trace"]))
                    for row in one["rows"]]
    found = {}
    for row in rows:
        found.setdefault(row["solver"], []).append(row)
    return found


def cell(key, value):
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


def table(rows, columns, proven=()):
    """A table of HTML. rows: dicts; columns: key -> heading; proven: rows in green."""
    head = "".join(f"<th>{html.escape(text)}</th>" for text in columns.values())
    body = ""
    for row in rows:
        cells = "".join(f"<td>{html.escape(cell(key, row.get(key)))}</td>" for key in columns)
        kind = ' class="proven"' if any(row is one for one in proven) else ""
        body += f"<tr{kind}>{cells}</tr>"
    return f'<div class="wide"><table><tr>{head}</tr>{body}</table></div>'


def results_table(problem, keep):
    rows = problem["results"]
    if not rows:
        return ""
    columns = {key: text for key, text in COLUMNS.items()
               if any(row.get(key) is not None for row in rows)}
    keep("results.csv", lambda: csv_text(rows, columns))
    proven = [row for row in rows if row.get("proven_optimal")]
    note = '<p class="soft"><span class="proven">Green</span>: proven optimal.</p>' \
        if proven else ""
    return table(rows, columns, proven) + note


def facts(problem):
    told = []
    for key, text in FACTS.items():
        value = problem.get(key)
        if value is not None:
            number = f"{100 * value:.4g} %" if key == "decided" else f"{value:,.12g}"
            told.append(f"{text}: {number}" if "bound" in key or "penalty" in key
                        else f"{number} {text}")
    return f"<p>{html.escape(', '.join(told))}.</p>" if told else ""


def section(problem, keep):
    """A problem's part of the page. keep: takes the name and the maker of a file for --parts."""
    bound, traces = problem.get("lower_bound"), traces_of(problem)
    answered = [one for one in problem["results"] if one.get("energy") is not None]
    drawn = {"energies": draw.energies(answered, bound) if answered else None,
             "course": draw.course(traces, "seconds", "energy; bound dashed", bound=bound),
             "left": draw.course(traces, "seconds", "variables left", ["variables"],
                                 scale="symlog"),
             "calls": draw.course({"calls": problem.get("calls", [])}, "call", "energy",
                                  bound=bound)}
    page = f"<h2>{html.escape(str(problem['name']))}</h2>" + facts(problem)
    page += maps(problem, keep) + results_table(problem, keep)
    for name, figure in drawn.items():
        if figure:
            keep(f"{name}.svg", lambda figure=figure: draw.svg(figure))
            page += draw.drawing(figure)
    return page


def page_of(problems, title, before="", after="", parts=None):
    """The page as text.

    problems       of `load`
    before, after  HTML that stands before and after the problems
    parts          dict, gets the text of each table and drawing under the name of a file; or None
    """
    body = ""
    for number, problem in enumerate(problems, 1):
        stem = f"{number:02}-" + re.sub(r"[^\w.]+", "-", str(problem["name"])).strip("-")

        def keep(name, make, stem=stem):
            if parts is not None:
                parts[f"{stem}-{name}"] = make()
        body += section(problem, keep)
    return ('<!doctype html><html lang="en"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>{html.escape(title)}</title><style>{STYLE}</style></head><body>"
            f"<h1>{html.escape(title)}</h1>{before}{body}{after}</body></html>\n")


def command(options):
    problems, parts = load(options.results), {}
    page = page_of(problems, options.title, parts=parts if options.parts else None).encode()
    if options.parts:
        with reading(options.parts, "be made"):
            Path(options.parts).mkdir(parents=True, exist_ok=True)
        for name, part in parts.items():
            save(Path(options.parts, name), part.encode())
    save(options.output, page)
    runner.show(options, f"{options.output}: {len(problems)} problem{'s' * (len(problems) != 1)}, "
                f"{len(page):,} bytes", {"output": options.output, "problems": len(problems),
                                    "bytes": len(page), "parts": sorted(parts)})
