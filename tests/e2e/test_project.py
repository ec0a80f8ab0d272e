"""The project as a whole: one version, documents that keep their word, what a stranger finds."""

import json
import os
import re
import shutil
import subprocess
import sys

import numpy as np
import qstereo_bridge
from PIL import Image
from library import HEADERS, QSTEREO, QSTEREO_PNM, ROOT

HEADER_TEXT = "".join(path.read_text() for path in HEADERS)


def read(name):
    return (ROOT / name).read_text()


def test_one_version():
    version = re.search(r'QS_VERSION +"(.*)"', HEADER_TEXT)[1]
    parts = [
        re.search(rf"QS_VERSION_{part} +(\d+)", HEADER_TEXT)[1]
        for part in ("MAJOR", "MINOR", "PATCH")
    ]
    assert version == ".".join(parts)
    assert qstereo_bridge.__version__ == version
    assert version in subprocess.run([QSTEREO, "--version"], capture_output=True, text=True).stdout
    assert read("NEWS").startswith(f"qstereo {version}")
    assert re.search(r"^version: (.*)$", read("CITATION.cff"), re.M)[1] == version


def test_every_link_in_every_page_leads_somewhere():
    pages = [
        path
        for pattern in ("*.md", "docs/*.md", "samples/**/*.md", "bridge/*.md", "tests/**/*.md")
        for path in ROOT.glob(pattern)
    ]
    assert len(pages) > 10
    for page in pages:
        for link in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text()):
            assert (page.parent / link).exists(), f"{page.name}: {link}"


def test_the_readme_begins_with_what_a_stranger_needs():
    screen = "\n".join(read("README.md").splitlines()[:45])
    for word in ("QUBO", "make run", "make check", "docs/result.png", "compiler", "Python"):
        assert word in screen, word
    for command in (
        "qstereo encode",
        "qstereo-bridge solve",
        "qstereo validate",
        "qstereo decode",
        "qstereo score",
    ):
        assert command in read("README.md")


def test_the_commands_of_the_readme_work(run, tmp_path):
    """In its order, on the sample pair, with one read of the annealer."""
    for name in ("left", "right", "truth"):
        shutil.copy(ROOT / "samples" / "rendered" / f"{name}.png", tmp_path)
    text = read("README.md").split("## By hand")[1].split("### With your own")[0]
    text = text.replace("\\\n", "").replace("--num-reads 50", "--num-reads 1")
    commands = [line.split() for line in text.splitlines() if re.match("    qstereo", line)]
    assert len(commands) == 15
    for command in commands:
        run(*command)


def test_the_overview_names_every_header():
    overview = read("libqstereo/include/qstereo.h")
    for path in HEADERS:
        if path.name != "qstereo.h":
            assert f'#include "qstereo/{path.name}"' in overview
            assert re.search(rf"^ \*   {path.stem} ", overview, re.M), (
                f"{path.stem} is not in the drawing"
            )


def test_the_design_describes_every_room():
    design = read("docs/DESIGN.md")
    rooms = {path.name for path in (ROOT / "libqstereo" / "src").iterdir()}
    drawing = design.split("## The rooms of the library")[1].split("## Decisions")[0]
    assert set(re.findall(r"^\| ([a-z]+) \| ", drawing, re.M)) == {"room"} | rooms


def test_public_machines_run_what_ours_runs():
    workflow = read(".github/workflows/check.yml")
    assert re.search(r"run: \.ci/run$", workflow, re.M)
    assert os.access(ROOT / ".ci" / "run", os.X_OK) and read(".ci/run").rstrip().endswith(
        "make check"
    )


def test_the_demo_without_opencv(tmp_path):
    """With qstereo's own solver in the bridge's place: the annealer takes its time, and is tested
    elsewhere.
    """
    (tmp_path / "qstereo").symlink_to(QSTEREO_PNM)
    bin_folder = tmp_path / "bin"
    bin_folder.mkdir()
    for name, line in (
        ("python", f'"{sys.executable}" "$@"'),
        ("qstereo-bridge", f'"{QSTEREO_PNM}" "$1" "$2" "$3" "$4" --solver icm'),
    ):
        (bin_folder / name).write_text(f"#!/bin/sh\nexec {line}\n")
        (bin_folder / name).chmod(0o755)
    done = subprocess.run(
        [ROOT / "scripts" / "demo"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        env={**os.environ, "BUILD": str(tmp_path), "BIN": str(bin_folder), "OPENCV": "0"},
    )
    assert done.returncode == 0, done.stderr
    assert re.search(r"energies agree +true", done.stdout)
    assert (tmp_path / "demo" / "disparity.pgm").read_bytes().startswith(b"P5")
    assert (tmp_path / "demo" / "disparity.color.ppm").read_bytes().startswith(b"P6")
    assert json.loads((tmp_path / "demo" / "score.json").read_text())["pixels"] > 20000
    # The pictures that it renders are the sample's.
    for name in ("left.ppm", "right.ppm", "truth.pgm"):
        sample = (ROOT / "samples" / "rendered" / name).with_suffix(".png")
        rendered = np.asarray(Image.open(tmp_path / "demo" / name))
        assert np.array_equal(rendered, np.asarray(Image.open(sample))), name
