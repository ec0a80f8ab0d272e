"""One page of HTML on results: pairs, maps, errors, energies and their bounds, sizes.

It reads what `qstereo compare --json --maps` printed, or a folder of such files. A page holds its
pictures and drawings itself: no network, no script.
"""

import base64
import csv
import html
import io
import json
import re
import zlib
from pathlib import Path

import matplotlib
import matplotlib.image
import numpy as np
from matplotlib.figure import Figure

from .failure import InputError

# A drawing's ink becomes the page's own, so that it is right on dark paper, too.
INK = "#010203"
matplotlib.rcParams.update({
    "svg.fonttype": "none", "text.color": INK, "axes.edgecolor": INK, "axes.labelcolor": INK,
    "xtick.color": INK, "ytick.color": INK, "font.family": "sans-serif", "font.size": 9,
    "axes.spines.top": False, "axes.spines.right": False, "svg.hashsalt": "qstereo"})
COLUMNS = {"solver": "method", "energy": "energy", "gap": "gap", "rms": "rms, pixels",
           "bad_0_5": "bad-0.5, %", "bad_1_0": "bad-1.0, %", "seconds": "seconds",
           "feasible": "feasible", "samples": "samples", "charge": "charge, s"}
DIGITS = {"rms": 2, "bad_0_5": 2, "bad_1_0": 2, "seconds": 3}
STYLE = """
:root { color-scheme: light dark; --ink: #1b1f24; --paper: #fff; --rule: #d5dae0;
        --soft: #5b6570; --good: #1a7f37 }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e4e8ec; --paper: #14171a; --rule: #353b42; --soft: #9aa4ae; --good: #57c878 } }
body { color: var(--ink); background: var(--paper); font: 16px/1.5 system-ui, sans-serif;
       max-width: 75rem; margin: 0 auto; padding: 1rem }
h1 { font-size: 1.6rem } h2 { font-size: 1.25rem; border-top: 1px solid var(--rule);
     padding-top: 1rem; margin-top: 2rem } h3 { font-size: 1rem }
p, figcaption { max-width: 45rem } figcaption, .soft { color: var(--soft); font-size: .875rem }
.maps { display: grid; gap: .75rem; grid-template-columns: repeat(auto-fill, minmax(9rem, 1fr)) }
figure { margin: 0 } .maps img { width: 100%; image-rendering: pixelated; border-radius: 3px;
         background: #fff }
.wide { overflow-x: auto } svg { max-width: 100%; height: auto }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .875rem }
th, td { padding: .2rem .6rem; text-align: right; border-bottom: 1px solid var(--rule);
         white-space: nowrap } th:first-child, td:first-child { text-align: left }
.proven { color: var(--good) }
@media print { body { max-width: none } h2 { break-before: auto } figure, tr, svg {
               break-inside: avoid } }
"""


def load(path):
    """Results as a list of problems, each with "results" and, where known, pictures and facts.

    path  a file that `compare --json` printed, or with a list of such objects under "problems";
          or a folder: all such files in it and in its folders
    Raises InputError.
    """
    path = Path(path)
    files = sorted(path.rglob("*.json")) if path.is_dir() else [path]
    problems = []
    for file in files:
        try:
            said = json.loads(file.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            if path.is_dir():
                continue
            raise InputError(f"{file}: is no JSON file: {error}") from error
        listed = said.get("problems", [said]) if isinstance(said, dict) else []
        problems += [{"name": file.stem, "folder": file.parent, **one} for one in listed
                     if isinstance(one, dict) and isinstance(one.get("results"), list)]
    if not problems:
        raise InputError(f"{path}: holds no results; `qstereo compare P.qcf --json --maps DIR` "
                         "prints them, `make paper` makes a folder of them")
    return problems


def picture(problem, name):
    """A picture of a problem as an array, or None if the problem names none."""
    if not name:
        return None
    place = Path(name)
    place = place if place.is_absolute() or not (problem["folder"] / place).exists() \
        else problem["folder"] / place
    try:
        return np.asarray(matplotlib.image.imread(str(place)))
    except (OSError, ValueError, SyntaxError) as error:
        raise InputError(f"{place}: cannot be read: {error}; write maps as PNG") from error


def levels(problem, name, scale):
    """A map in pixels of disparity, NaN where it has no value."""
    values = picture(problem, name)
    if values is None:
        return None
    values = values if values.ndim == 2 else values[..., 0]
    if values.dtype.kind == "f":
        values = np.rint(values * (65535 if values.max(initial=0) * 255 % 1 else 255))
    return np.where(values == 0, np.nan, values / scale)


def image(values, alt):
    """An <img> that holds a picture: H x W x 3, or H x W, bytes."""
    out = io.BytesIO()
    matplotlib.image.imsave(out, values, format="png", cmap="gray", vmin=0, vmax=255)
    text = base64.b64encode(out.getvalue()).decode()
    return f'<img alt="{html.escape(alt, True)}" src="data:image/png;base64,{text}">'


def coloured(values, low, high, colours="turbo"):
    """A map in colours, white where it has no value: H x W x 3, bytes."""
    shown = matplotlib.colormaps[colours](np.clip((values - low) / max(high - low, 1), 0, 1))
    shown[np.isnan(values)] = 1
    return (255 * shown[..., :3]).astype(np.uint8)


def drawing(figure):
    """A figure as <svg> in the page's ink, without what is only right in a file."""
    out = io.StringIO()
    figure.savefig(out, format="svg", transparent=True, bbox_inches="tight",
                   metadata={"Date": None})
    text = out.getvalue()
    text = text[text.index("<svg"):].replace(INK, "currentColor")
    # The names of parts are unique in a file, not in a page of many.
    mark = f"f{zlib.crc32(text.encode()):08x}-"
    return re.sub(r'(id="|href="#|url\(#)', rf"\g<1>{mark}", text)


def bar(low, high):
    """The scale bar of the maps."""
    figure = Figure(figsize=(3.2, 0.45))
    axes = figure.add_axes((0, 0.5, 1, 0.5))
    axes.imshow(np.linspace(0, 1, 256)[None], aspect="auto", cmap="turbo",
                extent=(low, high, 0, 1))
    axes.set_yticks([])
    axes.set_xlabel("disparity, pixels")
    return figure


def energies(problem):
    """Energies of the methods above the proven bound, as bars."""
    shown = [one for one in problem["results"] if one.get("energy") is not None]
    bound = problem.get("lower_bound")
    low = bound if bound is not None else min(one["energy"] for one in shown)
    figure = Figure(figsize=(6, 0.3 * len(shown) + 0.7))
    axes = figure.subplots()
    names = [one["solver"] for one in shown]
    above = [one["energy"] - low for one in shown]
    axes.barh(names, above, color="#4c83c4")
    for place, value in enumerate(above):
        axes.annotate(f" +{value:g}" if value else " 0", (value, place), va="center")
    axes.axvline(0, color="#d1495b")
    axes.invert_yaxis()
    axes.set_xscale("symlog", linthresh=1)
    axes.set_xlabel(f"energy above {'the proven bound' if bound is not None else 'the lowest'}"
                    f", {low:g}")
    return figure


def course(traces, bound):
    """Energies and bounds over time. traces: name -> rows of `--trace`."""
    figure = Figure(figsize=(6, 2.8))
    axes = figure.subplots()
    for number, (name, rows) in enumerate(traces.items()):
        colour = f"C{number % 10}"
        for key, line in (("energy", "-"), ("bound", "--")):
            points = [(float(row["seconds"]), float(row[key])) for row in rows if row.get(key)]
            if points:
                axes.step(*zip(*points), line, where="post", color=colour,
                          label=name if key == "energy" else None)
    if bound is not None:
        axes.axhline(bound, color="#d1495b", lw=1, label="proven bound")
    axes.set_xlabel("seconds")
    axes.set_ylabel("energy, bound (dashed)")
    axes.legend(frameon=False, fontsize=8)
    return figure


def traces_of(problem):
    """The courses that a problem's results name, read."""
    found = {}
    for one in problem["results"]:
        if one.get("trace"):
            with open(problem["folder"] / one["trace"], encoding="utf-8", newline="") as file:
                found[one["solver"]] = list(csv.DictReader(file))
    return found


def cell(key, value):
    if value is None:
        return "-"
    return f"{value:.{DIGITS[key]}f}" if key in DIGITS else f"{value}"


def table(rows, columns, proven=()):
    """A table of HTML. rows: dicts; columns: key -> heading; proven: rows in green."""
    head = "".join(f"<th>{html.escape(text)}</th>" for text in columns.values())
    body = ""
    for row in rows:
        cells = "".join(f"<td>{html.escape(cell(key, row.get(key)))}</td>" for key in columns)
        kind = ' class="proven"' if any(row is one for one in proven) else ""
        body += f"<tr{kind}>{cells}</tr>"
    return f'<div class="wide"><table><tr>{head}</tr>{body}</table></div>'


def results_table(problem):
    rows = problem["results"]
    columns = {key: text for key, text in COLUMNS.items()
               if any(row.get(key) is not None for row in rows)}
    proven = [row for row in rows if row.get("proven_optimal")]
    note = '<p class="soft"><span class="proven">Green</span>: proven optimal.</p>' \
        if proven else ""
    return table(rows, columns, proven) + note


def maps(problem):
    """Pair, maps and error maps of a problem, in one colour scale."""
    scale, truth_scale = problem.get("scale", 8), problem.get("truth_scale", 8)
    shown = [(name, levels(problem, file, s)) for name, file, s in [
        ("truth", problem.get("truth"), truth_scale),
        *((one["solver"], one.get("map"), scale) for one in problem["results"])] if file]
    pair = [(side, picture(problem, problem.get(side))) for side in ("left", "right")]
    figures = [(side, image(as_bytes(values), side)) for side, values in pair
               if values is not None]
    page = ""
    if shown:
        low = min(np.nanmin(values) for _, values in shown)
        high = max(np.nanmax(values) for _, values in shown)
        figures += [(name, image(coloured(values, low, high), f"map of {name}"))
                    for name, values in shown]
        page = drawing(bar(low, high))
    page = grid(figures) + page
    if shown and problem.get("truth"):
        truth = shown[0][1]
        page += "<h3>Errors</h3>" + grid([
            (name, image(errors(values, truth), f"errors of {name}"))
            for name, values in shown[1:] if values.shape == truth.shape])
        page += '<p class="soft">Black: more than one pixel off; grey: more than half a pixel; ' \
                "white: right, or unknown.</p>"
    return page


def as_bytes(values):
    return values if values.dtype == np.uint8 else (255 * values[..., :3]
                                                    if values.ndim == 3 else 255 * values
                                                    ).astype(np.uint8)


def errors(values, truth):
    with np.errstate(invalid="ignore"):
        off = np.abs(values - truth)
        return np.where(off > 1, 0, np.where(off > 0.5, 150, 255)).astype(np.uint8)


def grid(figures):
    if not figures:
        return ""
    return '<div class="maps">' + "".join(
        f"<figure>{picture}<figcaption>{html.escape(name)}</figcaption></figure>"
        for name, picture in figures) + "</div>"


def section(problem, parts):
    """A problem's part of the page. parts: filled with its drawings and rows."""
    name = str(problem["name"])
    facts = [f"{problem[key]:,} {text}" for key, text in (
        ("width", "columns"), ("height", "rows"), ("labels", "labels"), ("variables", "variables"),
        ("variables_left", "variables left by proof")) if problem.get(key) is not None]
    page = f"<h2>{html.escape(name)}</h2>"
    page += f"<p>{', '.join(facts)}.</p>" if facts else ""
    drawn = {"energies": energies(problem)}
    traces = traces_of(problem)
    if traces:
        drawn["course"] = course(traces, problem.get("lower_bound"))
    for kind, figure in drawn.items():
        parts.append((f"{name}-{kind}.svg", figure))
    return page + maps(problem) + results_table(problem) + "".join(map(drawing, drawn.values()))


def write(problems, title="Results", before="", parts=None):
    """The page as text.

    problems  of `load`
    before    HTML that stands before the problems
    parts     a list, filled with a name and a drawing for each figure; or None
    """
    parts = [] if parts is None else parts
    body = "".join(section(problem, parts) for problem in problems)
    return ('<!doctype html><html lang="en"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>{html.escape(title)}</title><style>{STYLE}</style></head><body>"
            f"<h1>{html.escape(title)}</h1>{before}{body}</body></html>\n")
