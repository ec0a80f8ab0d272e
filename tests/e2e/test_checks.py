"""The checks of the source tree are themselves checked: each goes red for what it is there for."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from library import QSTEREO, ROOT

sys.path.insert(0, str(ROOT / "tests" / "bench"))
import bench_costs  # noqa: E402

SCRIPTS = ROOT / "scripts"


def run(script, *arguments):
    """(exit status, all that was said)."""
    done = subprocess.run([SCRIPTS / script, *map(str, arguments)], cwd=ROOT, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return done.returncode, done.stdout


# The order of the rooms, in a small library that keeps it.

FILES = {
    "include/qstereo/status.h": "",
    "include/qstereo/problem.h": '#include "status.h"\n',
    "src/base/bits.h": "",
    "src/problem/costs.h": """
#include "../base/bits.h"
#include "../../include/qstereo/problem.h"
""",
    "src/problem/costs.c": '#include "costs.h"\n',
    "src/problem/edges.h": "",
    "src/problem/edges.c": '#include "edges.h"\n#include "costs.h"\n',
}


@pytest.fixture
def library(tmp_path):
    for name, text in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    assert run("check-layers", tmp_path)[0] == 0
    return tmp_path


@pytest.mark.parametrize("planted, into, said", [
    ('#include "../problem/costs.h"', "src/base/bits.h",
     "src/base/bits.h (base) includes src/problem/costs.h (problem), which is not below it"),
    ('#include "edges.h"', "src/problem/costs.c", "a circle of files: "),
    ("", "src/attic/old.c", "src/attic/old.c: in no room that check-layers knows"),
    ("", "include/qstereo/new.h", "include/qstereo/new.h: in no room that check-layers knows"),
    ('#include "nowhere.h"', "src/base/bits.h", "src/base/bits.h includes nowhere.h"),
])
def test_layers(library, planted, into, said):
    path = library / into
    path.parent.mkdir(exist_ok=True)
    path.write_text((path.read_text() if path.exists() else "") + planted + "\n")
    status, text = run("check-layers", library)
    assert status == 1 and said in text


SOURCES = {
    "a.c": "void qs_b(void); void qs_a(void); void qs_a(void) { qs_b(); }",
    "b.c": "void qs_c(void); void qs_b(void); void qs_b(void) { qs_c(); }",
    "c.c": "void qs_c(void); void qs_c(void) { }",
}


def archive_of(folder, sources):
    """An archive of these files, a source text each."""
    for name, text in sources.items():
        (folder / name).write_text(text + "\n")
    subprocess.run(["cc", "-c", *sources], cwd=folder, check=True)
    archive = folder / "lib.a"
    archive.unlink(missing_ok=True)
    objects = [name.replace(".c", ".o") for name in sources]
    subprocess.run(["ar", "rcs", archive, *objects], cwd=folder, check=True)
    return archive


def test_circles(tmp_path):
    assert run("check-circles", archive_of(tmp_path, SOURCES))[0] == 0
    back = {"c.c": "void qs_a(void); void qs_c(void); void qs_c(void) { qs_a(); }"}
    status, text = run("check-circles", archive_of(tmp_path, SOURCES | back))
    assert status == 1 and "objects that need each other: a.o b.o c.o" in text


@pytest.mark.parametrize("source, said", [
    ("int puts(const char *); void qs_a(void); void qs_a(void) { puts(\"\"); }", "needs: puts"),
    ("void a(void); void a(void) { }", "defines names without qs_: a"),
    ("static int n; int qs_n(void); int qs_n(void) { return ++n; }", "has variables of its own"),
])
def test_symbols(tmp_path, source, said):
    assert run("check-symbols", archive_of(tmp_path, SOURCES))[0] == 0
    status, text = run("check-symbols", archive_of(tmp_path, SOURCES | {"d.c": source}))
    assert status == 1 and said in text


# Style.

@pytest.mark.parametrize("name, line, good", [
    ("libqstereo/src/base/a.c", "/* " + "x" * 94 + " */", True),
    ("libqstereo/src/base/a.c", "/* " + "x" * 95 + " */", False),
    ("libqstereo/include/a.h", "/* " + "x" * 75 + " */", False),
    ("scripts/a", "x" * 101, False),
    ("docs/A.md", "x" * 81, False),
    ("docs/A.md", "| " + "x" * 81 + " |", True),
    ("docs/A.md", "https://" + "x" * 81, True),
    ("cli/text/a.c", "int  a;", False),
    ("cli/text/a.c", "int a;", True),
    ("bridge/a.py", "b", False),
    ("bridge/a.py", "import os", True),
])
def test_style(tmp_path, name, line, good):
    path = tmp_path / name
    path.parent.mkdir(parents=True)
    path.write_text(line + "\n")
    for settings in (".clang-format", "libqstereo/include/.clang-format"):
        (tmp_path / settings).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / settings, tmp_path / settings)
    status, text = run("check-style", Path(sys.executable).parent, tmp_path)
    assert (status == 0) == good, text
    assert good or f"{name}:1:" in text


# Figures.

@pytest.fixture
def pages(tmp_path):
    """A copy of the pages and their figures."""
    shutil.copytree(ROOT / "docs", tmp_path / "docs")
    shutil.copy(ROOT / "README.md", tmp_path)
    return tmp_path


def test_pages_hold_the_figures_of_their_files():
    status, text = run("figures", "--check")
    assert status == 0, text


def test_a_figure_changed_by_hand_is_seen(pages):
    page = pages / "docs" / "DESIGN.md"
    good = page.read_text()
    block = re.search(r"<!-- figures: whole -->.*?(\d+).*?<!-- end", good, re.S)
    page.write_text(good[:block.start(1)] + "1" + good[block.start(1):])
    status, text = run("figures", "--check", "--root", pages)
    assert status == 1 and "docs/DESIGN.md" in text
    assert run("figures", "--root", pages)[0] == 0 and page.read_text() == good


def test_a_new_measurement_is_seen(pages):
    path = pages / "docs" / "figures" / "reduce.json"
    measured = json.loads(path.read_text())
    measured["figures"]["whole"][0]["energy"] += 1
    path.write_text(json.dumps(measured))
    assert run("figures", "--check", "--root", pages)[0] == 1


def test_what_the_costs_of_stereo_ask_of_a_chip_is_still_so():
    """Counts, not times: whoever changes an encoding measures again."""
    written = json.loads((ROOT / "docs" / "figures" / "costs.json").read_text())["figures"]
    assert bench_costs.measure(QSTEREO) == written


@pytest.mark.parametrize("name", ["README.md", "docs/DESIGN.md", "docs/DWAVE.md",
                                  "docs/EMBEDDING.md"])
def test_no_measurement_stands_outside_the_blocks(name):
    text = re.sub(r"<!-- figures: .*?<!-- end of figures -->", "", (ROOT / name).read_text(),
                  flags=re.S)
    assert re.findall(r"\d[\d.,]* (?:ms|s|us|seconds|minutes|GB/s|kB|MB|MiB|GB)\b", text) == []


def test_every_test_that_the_proofs_name_exists():
    tests = "".join(path.read_text() for path in (ROOT / "tests").rglob("test_*.[cp]*")
                    if path.suffix in (".c", ".py"))
    text = (ROOT / "docs" / "MATHS.md").read_text()
    named = set()
    for listed in re.findall(r"\*Tests?:\*(.*?)\n\n", text + "\n\n", re.S):
        named |= set(re.findall(r"`([a-z_]+)`", listed))
    assert len(named) > 20
    for name in set(re.findall(r"\btest_\w+\.(?:c|py)\b", text)):
        assert list((ROOT / "tests").rglob(name)), name
    assert {name for name in named if not re.search(rf"\b{name}\b", tests)} == set()
