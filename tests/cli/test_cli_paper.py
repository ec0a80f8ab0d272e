"""scripts/paper: the paper's evaluation over a folder of scenes."""

import csv
import html
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from cli_tools import LONG, QSTEREO, ROOT, SOLVERS

pytest.importorskip("matplotlib")
BRIDGE = os.environ.get("QSTEREO_BRIDGE", str(Path(sys.executable).parent / "qstereo-bridge"))
PUBLISHED = json.loads((ROOT / "samples" / "paper" / "published.json").read_text())
ANNEALER = "QUBO, annealer"


def paper(*arguments):
    return subprocess.run(
        [sys.executable, ROOT / "scripts" / "paper", "--quick", "--time-limit", "0.05",
         "--qstereo", QSTEREO, "--bridge", BRIDGE, *map(str, arguments)],
        capture_output=True, text=True, timeout=LONG)


def service(folder, name, *words):
    """Samples as of a service, of the problem that the script makes with these words."""
    problem, samples = folder / f"{name}.qcf", folder / "samples"
    samples.mkdir(exist_ok=True)
    for line in (["encode", *words, "-o", problem],
                 ["solve", problem, "-o", samples / f"{name}.qsf", "--solver", "trws"]):
        subprocess.run([QSTEREO, *map(str, line)], check=True, capture_output=True)
    return samples


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The folder after a run on the sample scene, under the name of one of the paper's; with
    samples of this problem and of another."""
    folder = tmp_path_factory.mktemp("paper")
    scene = folder / "data" / "barn1"
    scene.mkdir(parents=True)
    for name in ("left", "right", "truth"):
        shutil.copy(ROOT / "samples" / "rendered" / f"{name}.png", scene)
    (folder / "data" / "scenes.json").write_text('{"barn1": {"disparity_max": 14}}')
    (folder / "reference.json").write_text(json.dumps(
        {"crop100": {"barn1": {"icm": 10**6, "optimum": 2}}}))
    service(folder, "barn1", scene / "left.png", scene / "right.png", "--disparity", "0:14",
            "--lambda", 20, "--roi", "84,59,32,32")
    example = ROOT / "samples" / "paper"
    samples = service(folder, "example", example / "left.pgm", example / "right.pgm",
                      "--disparity", "0:1", "--lambda", 10, "--penalty", 200)
    done = paper("-o", folder / "out", "--samples", samples, folder / "data")
    assert done.returncode == 0, done.stderr
    return folder, done


def results_of(folder):
    (found,) = json.loads((folder / "out" / "results.json").read_text())["problems"]
    return found, {result["solver"]: result for result in found["results"]}


def test_every_method_and_the_annealer(made):
    folder, done = made
    found, by_name = results_of(folder)
    assert [found[key] for key in ("width", "height", "labels")] == [32, 32, 15]
    assert list(by_name) == [*SOLVERS, ANNEALER]
    for result in by_name.values():
        assert result["gap"] == result["energy"] - found["lower_bound"] >= 0
        assert (folder / "out" / result["map"]).exists()
    assert by_name[ANNEALER]["energy"] < by_name["icm"]["energy"]
    assert re.search(r"index\.html: 1 problems, \d+\.\d s", done.stdout)


def test_references_and_published_numbers_stand_beside_ours(made):
    folder, done = made
    _, by_name = results_of(folder)
    assert by_name["icm"]["difference"] == by_name["icm"]["energy"] - 10**6 < 0
    assert by_name["best"]["reference"] == 2 and by_name["bp"]["reference"] is None
    assert "icm        at or below in 1 of 1" in done.stdout
    page = html.unescape((folder / "out" / "index.html").read_text())
    ours, trws = (PUBLISHED["errors"]["Barn"][name] for name in ("Ours", "TRW-S"))
    assert by_name[ANNEALER]["published"] == " / ".join(f"{value:.2f}" for value in ours)
    assert " / ".join(f"{value:.2f}" for value in trws) in page
    assert PUBLISHED["remark"] in page and "104,760" in page and "pegasus:16" in page


def test_variables_of_each_model(made):
    """Table 1's formulas, computed here by themselves, and what our files have."""
    with open(made[0] / "out" / "qubits.csv", newline="", encoding="utf-8") as file:
        rows = {row["model"].split(":")[0]: int(row["variables"]) for row in csv.DictReader(file)}
    n, m, k = 32, 32, 15
    assert rows["the paper"] == rows["qstereo, one-hot"] == n * m * k
    assert rows["qstereo, domain-wall"] == n * m * (k - 1)
    assert rows["Heidari et al. 2021"] == n * m * (k + 1) + 2
    assert rows["Heidari et al. 2022"] == rows["qstereo, multiway-cut"] == n * m * k + k * k
    grid = 7 * n * m * k + 9 * n * m - 2 * k * (n + m) - 2 * (n + m) + 2
    assert rows["Cruz-Santos et al. 2018"] == grid


def test_samples_of_a_service_are_found_by_their_problem(made):
    """Samples of this problem get a row, those of another none."""
    names = [result["solver"] for result in results_of(made[0])[0]["results"]]
    assert names == [*SOLVERS[:5], "trws", "trws", "best", ANNEALER]


def test_no_scenes(tmp_path):
    done = paper()
    assert done.returncode == 1 and "make paper DATA=folder" in done.stderr
    done = paper(tmp_path)
    assert done.returncode == 1 and "holds no scene" in done.stderr


def test_the_published_numbers_are_those_of_the_paper():
    sources = sorted((ROOT / ".." / "shared" / "paper").glob("*.txt"))
    if not sources:
        pytest.skip("the paper's text is not there")
    text = sources[0].read_text()
    table = text[text.index(r"\label{tab_evaluation}"):]
    table = table[:table.index(r"\end{tabular}")]
    cells = re.sub(r"\{\\color\{blue\}\s*([\d.]+)\}", r"\1", table)
    rows = re.findall(r"& *([A-Z][\w-]+) *& *([\d.]+) *& *([\d.]+) *& *([\d.]+) *\\\\", cells)
    said = [[name, *map(float, numbers)] for name, *numbers in rows]
    assert said == [[name, *numbers] for of in PUBLISHED["errors"].values()
                    for name, numbers in of.items()] and len(said) == 30
    scenes = re.findall(r"multirow\{5\}\{\*\}\{\\textit\{(\w+)\}\}", table)
    assert scenes == list(PUBLISHED["errors"])
    times = text[text.index(r"\label{tab_timing}"):]
    assert [float(number) for number in re.findall(r"\$ *([\d]+\.\d+)\$", times)] == list(
        PUBLISHED["timing_us"].values())
    formulas = text[text.index(r"\label{tab_comparison_qubit_complexity}"):].replace(" ", "")
    for _, formula in PUBLISHED["qubits"]:
        assert f"${formula.replace(' ', '')}$" in formulas
