"""Pictures and drawings of a report, each as text that stands in a page by itself."""

import base64
import io
import re
import zlib

import matplotlib
import matplotlib.image
import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure

# A drawing's ink becomes the page's own, so that it is right on dark paper, too.
INK = "#010203"
BLUE, RED = "#4c83c4", "#d1495b"
matplotlib.rcParams.update({
    "svg.fonttype": "none", "text.color": INK, "axes.edgecolor": INK, "axes.labelcolor": INK,
    "xtick.color": INK, "ytick.color": INK, "font.family": "sans-serif", "font.size": 9,
    "axes.spines.top": False, "axes.spines.right": False, "svg.hashsalt": "qstereo"})


def image(values, colours="gray", low=0, high=255):
    """The address of a picture that holds it: H x W x 3 bytes, or H x W values from `low` to
    `high`, in colours, without any where a value is NaN."""
    out = io.BytesIO()
    matplotlib.image.imsave(out, values, format="png", cmap=colours, vmin=low, vmax=high)
    return "data:image/png;base64," + base64.b64encode(out.getvalue()).decode()


def svg(figure):
    """A figure as the text of an SVG file."""
    out = io.StringIO()
    figure.savefig(out, format="svg", bbox_inches="tight", metadata={"Date": None},
                   transparent=True)
    return out.getvalue()


def drawing(figure):
    """A figure as <svg> in the page's ink, without what is only right in a file."""
    text = svg(figure)
    text = text[text.index("<svg"):].replace(INK, "currentColor")
    # Names are addresses to no page; the names of parts are unique in a file, not in a page.
    text = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", text, flags=re.S)
    mark = f"f{zlib.crc32(text.encode()):08x}-"
    return Markup(re.sub(r'(id="|href="#|url\(#)', rf"\g<1>{mark}", text))


def bar(low, high):
    """The scale bar of maps."""
    figure = Figure(figsize=(3.2, 0.45))
    axes = figure.add_axes((0, 0.5, 1, 0.5))
    axes.imshow(np.linspace(0, 1, 256)[None], aspect="auto", cmap="turbo",
                extent=(low, high, 0, 1))
    axes.set_yticks([])
    axes.set_xlabel("disparity, pixels")
    return figure


def sheet(maps, low, high):
    """Maps side by side, with their bar: one figure for a file. maps: list of (name, array)."""
    columns = min(5, len(maps))
    rows = -(-len(maps) // columns)
    figure = Figure(figsize=(2 * columns + 0.5, 2.2 * rows), layout="constrained")
    places = figure.subplots(rows, columns, squeeze=False).ravel()
    for place in places:
        place.axis("off")
    for place, (name, values) in zip(places, maps):
        shown = place.imshow(values, "turbo", vmin=low, vmax=high, interpolation="none")
        place.set_title(name)
    figure.colorbar(shown, ax=places.tolist(), label="disparity, pixels")
    return figure


def energies(results, low, what):
    """The energies of results above `low`, which is `what`, as bars."""
    figure = Figure(figsize=(4.5, 0.3 * len(results) + 0.7))
    axes, above = figure.subplots(), [one["energy"] - low for one in results]
    # Two results may have one name; bars of one name would lie on each other.
    bars = axes.barh(range(len(results)), above, color=BLUE)
    axes.bar_label(bars, [f"+{value:,.10g}" if value else "0" for value in above], padding=3)
    axes.set_yticks(range(len(results)), [one["solver"] for one in results])
    axes.axvline(0, color=RED)
    axes.invert_yaxis()
    axes.set_xscale("symlog", linthresh=1)
    axes.set_xlim(0, 9 * max(above) + 1)
    axes.set_xlabel(f"energy above {what} {low:,.10g} (red)")
    return figure


def course(traces, across, up, keys=("energy", "bound"), low=0):
    """What `keys` name, the second dashed, above `low`; None where no trace tells it.

    traces      name -> rows of `--trace`, or lines of a journal
    across      the column of places along the x axis
    up          what stands beside the y axis
    """
    figure = Figure(figsize=(4.5, 2.8), layout="constrained")
    axes = figure.subplots()
    for number, (name, rows) in enumerate(traces.items()):
        for key, line in zip(keys, ("-", "--")):
            points = [(float(row[across]), float(row[key]) - low) for row in rows
                      if row.get(key) not in (None, "")]
            if points:
                axes.step(*zip(*points), line, where="post", color=f"C{number % 10}",
                          marker="." if len(points) < 100 else None,
                          label=name if key == keys[0] else None)
    if not axes.lines:
        return None
    # Most of the way is made at once.
    axes.set_yscale("symlog", linthresh=1)
    axes.yaxis.get_major_locator().set_params(numticks=7)
    if across == "seconds":
        axes.set_xscale("symlog", linthresh=0.01)
        axes.set_xlim(left=0)
    else:
        axes.xaxis.get_major_locator().set_params(integer=True)
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    if len(traces) > 1:
        figure.legend(frameon=False, fontsize=8, labelcolor=INK, loc="outside right upper")
    return figure
