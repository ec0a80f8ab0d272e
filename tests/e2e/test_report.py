"""qstereo-bridge report: what the page tells, and how a browser shows it."""

import base64
import html
import io
import json
import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from library import BRIDGE, QSTEREO, ROOT
from PIL import Image
from qstereo_bridge.desk import cli

pytest.importorskip("matplotlib")
SAMPLE = ROOT / "samples" / "rendered"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
needs_browser = pytest.mark.skipif(
    CHROMIUM is None, reason="chromium is not there; make check-all installs it")


def call(program, *arguments, status=0):
    done = subprocess.run([str(word) for word in (program, *arguments)], capture_output=True,
                          text=True)
    assert done.returncode == status, done.stderr
    return done


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Results of each kind, and the page of them."""
    made = tmp_path_factory.mktemp("report")
    out, problem = made / "out", made / "p.qcf"
    out.mkdir()
    for name in ("left", "right", "truth"):
        shutil.copy(SAMPLE / f"{name}.png", out)
    call(QSTEREO, "encode", SAMPLE / "left.png", SAMPLE / "right.png", "-o", problem,
         "--disparity", "2:14", "--lambda", "20", "--roi", "60,30,40,30")
    said = call(QSTEREO, "compare", problem, "--truth", out / "truth.png", "--maps", out,
                "--trace", out / "t.csv", "--json").stdout
    (out / "<p> & co.json").write_text(said)
    (out / "core.json").write_text(call(
        QSTEREO, "reduce", problem, "-o", made / "core.qcf", "--target", "200", "--trace",
        out / "reduced.csv", "--json").stdout)
    journal = [{"schema": 1, "format": "qstereo-journal"}, *(
        {"call": number, "energy": 4000 - 7 * number, "charge_seconds": 0.25}
        for number in (1, 2, 3))]
    (out / "s.qsf.journal").write_text("".join(json.dumps(line) + "\n" for line in journal))
    (out / "other.json").write_text('["of something else"]')
    call(BRIDGE, "report", out, "-o", made / "r.html", "--title", "A <title>")
    return made


def test_what_the_page_tells(folder):
    page = (folder / "r.html").read_text()
    said = json.loads((folder / "out" / "<p> & co.json").read_text())
    text = html.unescape(re.sub(r"<[^>]+>", " ", page))
    assert [html.unescape(name) for name in re.findall("<h2>(.*?)</h2>", page)] == [
        "<p> & co", "core", "reduced", "s.qsf"]
    for result in said["results"]:
        assert f"{result['energy']:,}" in text and f"{result['bad_1_0']:.2f}" in text
    assert page.count('class="proven"') == 1 + sum(
        result["proven_optimal"] for result in said["results"])
    # Pair, maps with the truth, errors.
    assert page.count("<img ") == 2 + 8 + 7
    core = json.loads((folder / "out" / "core.json").read_text())
    assert f"{core['variables_after']} variables left by proof" in text
    assert "3 calls, 0.75 seconds charged" in text


def test_results_of_many_frames_are_first_told_together(tmp_path):
    frames = [{"name": name, "variables": 90, "variables_left": 7, "lower_bound": 10, "results": [
        {"solver": "anneal", "energy": energy, "gap": energy - 10, "charge": charge,
         "proven_optimal": energy == 10}]} for name, energy, charge in
        (("first", 10, 0.5), ("second", 12, 0.0))]
    (tmp_path / "summary.json").write_text(json.dumps({"problems": frames}))
    call(BRIDGE, "report", tmp_path / "summary.json", "-o", tmp_path / "r.html")
    page = (tmp_path / "r.html").read_text()
    table = page[:page.index("<h2>first")]
    assert re.findall("<h2>(.*?)</h2>", page) == ["All results", "first", "second"]
    assert [re.findall("<t[hd]>(.*?)</t", row) for row in table.split("<tr")[1:]] == [
        ["name", "method", "energy", "gap", "charge, s"],
        ["first", "anneal", "10", "0", "0.500"], ["second", "anneal", "12", "2", "0.000"]]
    assert "90 variables, 7 variables left by proof" in page and "<svg" not in page


def test_a_page_needs_nothing_but_itself(folder):
    page = (folder / "r.html").read_text()
    assert not re.search(r"""(src|href)=["'](?!data:|#)""", page)
    assert "<script" not in page and not re.search(r"url\((?!#)", page)
    marks = re.findall(r' id="([^"]+)"', page)
    assert len(marks) == len(set(marks))


def test_parts(folder):
    from qstereo_bridge.desk import report

    parts = report.parts_of(report.sections_of(report.load(folder / "out")))
    assert sorted(parts) == [
        *(f"01-p-co-{name}" for name in ("course.svg", "energies.svg", "maps.svg", "results.csv")),
        "03-reduced-course.svg", "03-reduced-left.svg", "04-s.qsf-calls.svg"]
    rows = parts["01-p-co-results.csv"].splitlines()
    said = json.loads((folder / "out" / "<p> & co.json").read_text())["results"]
    assert [row.split(",")[:2] for row in rows[1:]] == [
        [one["solver"], str(one["energy"])] for one in said]
    for name, text in parts.items():
        if name.endswith(".svg"):
            assert ElementTree.fromstring(text).tag.endswith("svg")


def test_maps_are_cut_and_coloured_in_one_scale(folder):
    from qstereo_bridge.desk import drawing, report

    (problem,) = report.load(folder / "out" / "<p> & co.json")
    found, truth, pair = report.all_maps(problem)
    assert {values.shape for _, values in [*found, ("", truth)]} == {(30, 40)}
    assert [values.shape[:2] for _, values in pair] == [(30, 40)] * 2
    for name, values in found:
        assert 2 <= np.nanmin(values) <= np.nanmax(values) <= 14
        result = {one["solver"]: one for one in problem["results"]}[name]
        off = report.errors(values, truth)
        assert abs(100 * (off == 0).mean() - result["bad_1_0"]) < 1e-9
    address = drawing.image(np.array([[2.0, 14.0, np.nan]]), "turbo", 2, 14)
    shown = Image.open(io.BytesIO(base64.b64decode(address.partition(",")[2])))
    first, last, none = (shown.getpixel((x, 0)) for x in range(3))
    assert first != last and (first[3], last[3], none[3]) == (255, 255, 0)


@pytest.mark.parametrize("content, said", [
    ("{", "holds no results"), ("[]", "holds no results"), ("{}", "holds no results"),
    ('{"results": [{"solver": "x", "energy": "low"}]}', "not as qstereo writes them"),
    ('{"results": [{"energy": 1}, {"energy": 2}]}', "not as qstereo writes them (KeyError"),
    ('{"results": [], "labels": "ten"}', "not as qstereo writes them"),
    ('{"results": [{"solver": "x", "map": "none.png"}]}', "none.png: cannot be read"),
    ('{"results": [{"solver": "x", "map": "r.json"}]}', "r.json: is no picture"),
])
def test_what_is_refused(tmp_path, content, said, capsys):
    (tmp_path / "r.json").write_text(content)
    status = 4 if "cannot be read" in said else 3
    words = ["report", str(tmp_path / "r.json"), "-o", str(tmp_path / "r.html")]
    assert cli.main(words) == status
    assert said in capsys.readouterr().err and not (tmp_path / "r.html").exists()


def browse(folder, page, *options):
    """A page in the browser: its DOM, and what the console said."""
    done = call(CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                f"--user-data-dir={folder / 'profile'}", "--enable-logging=stderr",
                "--virtual-time-budget=5000", *options, f"file://{page}")
    return done.stdout, re.findall("CONSOLE.*", done.stderr)


@needs_browser
@pytest.mark.parametrize("width", [400, 1280])
def test_a_browser_shows_it_without_scrolling_sideways(folder, tmp_path, width):
    """The page stands in a frame of the width; the frame's page says how wide it is."""
    frame = html.escape((folder / "r.html").read_text(), quote=True)
    (tmp_path / "f.html").write_text(
        f'<iframe style="width:{width}px;height:900px;border:0" srcdoc="{frame}"></iframe><script>'
        "onload = () => { const shown = frames[0].document.documentElement; document.title = "
        "`${shown.scrollWidth} of ${shown.clientWidth}, ${frames[0].document.images.length}` }"
        "</script>")
    shown, console = browse(tmp_path, tmp_path / "f.html", "--dump-dom")
    assert f"<title>{width} of {width}, 17</title>" in shown
    assert console == []


@needs_browser
def test_it_prints(folder, tmp_path):
    _, console = browse(tmp_path, folder / "r.html", f"--print-to-pdf={tmp_path / 'r.pdf'}")
    assert console == []
    assert len(re.findall(rb"/Type ?/Page\b", (tmp_path / "r.pdf").read_bytes())) >= 2
