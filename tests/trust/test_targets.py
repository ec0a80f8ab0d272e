"""Other machines write the same bytes: 32 bits, and big-endian, run beside this one's command
without OpenCV.

QSTEREO_TARGETS names their commands: NAME=COMMAND WITH ITS EMULATOR, several with colons between
them.
"""

import itertools
import os
import re
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "cli"))
from camera_tools import calibration, write_storage  # noqa: E402
from cli_tools import SOLVERS, chunks_of, write_pgm  # noqa: E402

TARGETS = dict(
    entry.strip().split("=", 1)
    for entry in os.environ.get("QSTEREO_TARGETS", "").split(":")
    if entry.strip()
)
HERE = os.environ.get("QSTEREO_PNM")
SECONDS = re.compile(
    rb'("[a-z_]*seconds": )[0-9.e+-]+|\b[0-9.]+ s\b|(\.qsf version 1\), )[0-9]+ bytes'
)
# What each smoothness may be written in, and with which penalties.
ENCODINGS = {
    "potts": ["one-hot", "one-hot-sparse", "domain-wall", "multiway-cut"],
    "linear": ["one-hot", "one-hot-sparse", "domain-wall", "st-cut", "st-cut-arcs"],
    "linear --truncation 2": ["one-hot", "one-hot-sparse", "domain-wall"],
    "quadratic": ["one-hot", "domain-wall"],
}
SOLVED = ["one-hot", "one-hot-sparse", "domain-wall"]


def cut_commands(smoothness, name):
    """Cuts, with what proves their bound, where one cut finds the optimum."""
    if smoothness not in ["linear", "quadratic"]:
        return []
    return [
        f"solve {name}.qcf -o {name}-cut.qsf --solver cut --certificate {name}-cut.qpf --json",
        f"verify {name}.qcf {name}-cut.qsf {name}-cut.qpf --json",
    ]


def match_commands():
    """Presets, costs, half pixels, disparities below 0, and what follows the labels."""
    for number, words in enumerate(
        [
            "--disparity 0:5 --preset accurate --confidence sure.pgm --mask made.pgm",
            "--disparity 0:5:1 --preset fast --after halves,check,fill",
            "--disparity 0:3:0.5 --preset accurate",
            "--disparity -3:2 --preset fast --color --palette viridis --scale-bar",
            "--disparity -2:2:0.5 --smoothness quadratic --solver trws --iterations 20",
            "--disparity 0:3 --cost bt:40+2*census:5x3 --contrast 8,2 --border leave-out",
            "--disparity 0:3 --cost ad:40 --border keep --after refine,check,fill,median",
        ]
    ):
        yield [f"match l.pgm r.pgm -o match{number}.pfm --json {words}"]
    for number, words in enumerate(["0:3:0.5", "-3:0", "-2:1:0.5"]):
        yield [
            f"encode l.pgm r.pgm -o part{number}.qcf --disparity {words} --smoothness linear",
            f"solve part{number}.qcf -o part{number}.qsf --solver expansion",
            f"decode part{number}.qcf part{number}.qsf -o part{number}.pfm",
            f"info part{number}.qcf --json",
        ]


def camera_commands():
    """Calibrations, depths, points and sequences; pictures of 16 bits too."""
    for kind in ["yml", "xml"]:
        yield [
            f"rectify wide_l.pgm wide_r.pgm -o {kind}_l.pgm {kind}_r.pgm --calibration c.{kind} "
            "--json",
            f"match wide_l.pgm wide_r.pgm -o {kind}.pfm --calibration c.{kind} --disparity 0:3",
            f"depth {kind}.pfm -o {kind}.pgm --calibration c.{kind} --unit m --json",
            f"depth {kind}.pfm -o {kind}.ply --calibration c.{kind} --unit m --color {kind}_l.pgm",
            f"depth {kind}.pfm -o {kind}-grey.ply --calibration c.{kind} --unit cm",
        ]
    yield [
        "match n_%02d_l.pgm n_%02d_r.pgm -o n_%d.pfm --disparity 0:3 --json",
        "match pairs.y4m --sbs -o y_%d.pgm --disparity 0:3 --json",
        "match pairs.ppm --sbs -o p_%d.pgm --disparity 0:3 --json",
    ]


def problem_commands():
    """The other problems, each in one go and by way of its files."""
    for name, words in {
        "restore": "restore l.pgm -o restored.pgm --lambda 2 --json",
        "segment": "segment l.pgm strokes.pgm -o segments.pgm --json",
        "flow": "flow l.pgm r.pgm -o flow.flo --radius 2 --json",
        "register": "register l.pgm r.pgm -o register.flo --radius 2 --json",
        "detect": "detect boxes.csv -o kept.csv --json",
        "label": "label costs.npy -o labels.npy --smoothness linear --truncation 2 --json",
    }.items():
        operands = words.split(" -o ")[0].split(" ", 1)[1]
        yield [
            words,
            f"encode --problem {name} {operands} -o {name}.qcf",
            f"info {name}.qcf --json",
        ]


def commands():
    """[command line, ..] for each group of command lines that build on each other; groups stand
    alone."""
    for (smoothness, encodings), extra in itertools.product(
        ENCODINGS.items(), ["", "--truncate", "--reduce"]
    ):
        for encoding in encodings:
            name = re.sub(r"\W+", "-", f"{smoothness}{extra} {encoding}")
            yield [
                f"encode l.pgm r.pgm -o {name}.qcf --disparity 0:3 --lambda 6.25 "
                f"--smoothness {smoothness} --encoding {encoding} {extra}",
                f"info {name}.qcf --json",
                *([f"decode {name}.qcf -o {name}.pgm"] if extra == "--reduce" else []),
            ]
    for smoothness, encoding in itertools.product(ENCODINGS, SOLVED):
        if encoding in ENCODINGS[smoothness]:
            name = re.sub(r"\W+", "-", f"solve-{smoothness} {encoding}")
            yield [
                f"encode l.pgm r.pgm -o {name}.qcf --disparity 1:4 --lambda 3 "
                f"--smoothness {smoothness} --encoding {encoding} --penalty minimal",
                *itertools.chain.from_iterable(
                    (
                        f"solve {name}.qcf -o {name}-{solver}.qsf --solver {solver} "
                        "--seed 7 --iterations 20",
                    )
                    for solver in SOLVERS
                ),
                f"validate {name}.qcf {name}-best.qsf --json",
                f"solve {name}.qcf -o {name}-c.qsf --solver trws --iterations 20 "
                f"--certificate {name}.qpf",
                f"verify {name}.qcf {name}-c.qsf {name}.qpf --json",
                *cut_commands(smoothness, name),
                f"info {name}-bp.qsf",
                f"decode {name}.qcf {name}-trws.qsf -o {name}.pfm --repair --color",
                f"reduce {name}.qcf -o {name}-small.qcf --target 40 --truncate --json",
                f"info {name}-small.qcf",
                f"reduce {name}.qcf -o {name}-core.qcf --iterations 30 --samples {name}-core.qsf "
                f"--answer {name}-whole.qsf --certificate {name}-core.qpf --json",
                f"verify {name}.qcf {name}-core.qcf {name}-core.qpf --json",
                f"validate {name}-core.qcf {name}-core.qsf --json",
            ]
    yield [
        "encode l.pgm r.pgm -o paper.qcf --disparity 0:3 --penalty paper --encoding one-hot",
        "info paper.qcf --complexity --json",
        "info paper.qcf --complexity",
    ]
    yield [
        "encode l.pgm r.pgm -o given.qcf --penalty 812 --lambda 2 --disparity 0:2",
        "compare given.qcf --truth truth.pgm --maps maps --json",
    ]
    yield [
        "match l.pgm r.pgm -o match.pgm --disparity 0:5 --truth truth.pgm --json --color",
        "score match.pgm truth.pgm --json",
        "score match.pgm truth.pgm",
    ]
    yield from match_commands()
    yield from camera_commands()
    yield from problem_commands()
    yield [
        "info l.pgm",
        "encode l.pgm r.pgm -o big.qcf --disparity 0:3 --lambda 999999999",
        "solve nothing.qcf -o s.qsf",
        "help",
        "--version",
    ]


def pictures(folder):
    folder.mkdir()
    random = np.random.default_rng(5)
    right = random.integers(0, 256, (6, 14))
    left = np.roll(right, 2, axis=1) + random.integers(-9, 10, right.shape)
    write_pgm(folder / "l.pgm", left.clip(0, 255))
    write_pgm(folder / "r.pgm", right)
    write_pgm(folder / "truth.pgm", np.full((6, 14), 16))
    strokes = np.zeros((6, 14))
    strokes[1, 1:4], strokes[4, 9:12] = 1, 2
    write_pgm(folder / "strokes.pgm", strokes)
    camera_pictures(folder, random)
    # Elements of one byte have no order, so that every machine reads them.
    np.save(folder / "costs.npy", random.integers(0, 100, (5, 4, 3)).astype("i1"))
    rows = ["a,1,1,10,10,0.9", "a,2,2,10,10,0.8", "a,30,30,8,8,0.7", "b,1,1,10,10,0.6"]
    (folder / "boxes.csv").write_text("\n".join(["picture,x,y,width,height,score", *rows, ""]))


def camera_pictures(folder, random):
    """A calibration, as OpenCV writes it, its pictures, and three kinds of sequences."""
    for kind in ["yml", "xml"]:
        write_storage(folder / f"c.{kind}", calibration(size=(48, 32)))
    for side in "lr":
        write_pgm(folder / f"wide_{side}.pgm", random.integers(0, 4096, (32, 48)), 4095)
    both = random.integers(0, 256, (2, 6, 28))
    for number, frame in enumerate(both):
        for side, half in zip("lr", np.hsplit(frame, 2)):
            write_pgm(folder / f"n_{number:02}_{side}.pgm", half)
    (folder / "pairs.y4m").write_bytes(
        b"YUV4MPEG2 W28 H6 F25:1 C420p10\n"
        + b"".join(
            b"FRAME\n" + (4 * frame).astype("<u2").tobytes() + bytes(2 * 2 * 14 * 3)
            for frame in both
        )
    )
    (folder / "pairs.ppm").write_bytes(
        b"".join(
            b"P6\n28 6\n255\n" + np.repeat(frame, 3).astype("u1").tobytes() for frame in both
        )
    )


def contents(path):
    """A file's bytes; of samples the chunks, for the time that a solver took is in one of them;
    of arrays the numbers, for they are in the order of the machine.
    """
    if path.suffix == ".npy":
        return np.load(path).tolist()
    return (
        path.read_bytes()
        if path.suffix != ".qsf"
        else {name: SECONDS.sub(rb"\1\2", held) for name, held in chunks_of(path).items()}
    )


def outputs(program, folder):
    """{command line: (status, standard output, standard error)} and {file: bytes}."""
    pictures(folder)

    def together(lines):
        found = {}
        for line in lines:
            done = subprocess.run(
                [*program, *line.split()],
                cwd=folder,
                capture_output=True,
                stdin=subprocess.DEVNULL,
                timeout=600,
            )
            found[line] = (
                done.returncode,
                SECONDS.sub(rb"\1\2", done.stdout),
                SECONDS.sub(rb"\1\2", done.stderr),
            )
        return found

    with ThreadPoolExecutor(2) as pool:
        said = {
            line: result
            for found in pool.map(together, commands())
            for line, result in found.items()
        }
    return said, {
        path.relative_to(folder): contents(path) for path in folder.rglob("*") if path.is_file()
    }


@pytest.fixture(scope="module")
def here(tmp_path_factory):
    if HERE is None:
        pytest.skip("QSTEREO_PNM names no command")
    return outputs([HERE], tmp_path_factory.mktemp("here") / "work")


@pytest.mark.parametrize(
    "target",
    TARGETS or [pytest.param("", marks=pytest.mark.skip("QSTEREO_TARGETS names no command"))],
)
def test_same_bytes(target, here, tmp_path):
    said, files = outputs(shlex.split(TARGETS[target]), tmp_path / "work")
    for line, (status, out, err) in here[0].items():
        assert said[line] == (status, out, err), line
    assert files.keys() == here[1].keys()
    assert [path for path in files if files[path] != here[1][path]] == []
    refused = [line.split()[0] for line, (status, *_) in said.items() if status != 0]
    assert refused == ["info", "solve"] and len(said) > 360 and len(files) > 320, (
        refused,
        len(said),
        len(files),
    )
    print(f"{target}: {len(said)} commands and {len(files)} files agree")
