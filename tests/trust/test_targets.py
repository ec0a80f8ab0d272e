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
    "quadratic": ["one-hot"],
}
SOLVED = ["one-hot", "one-hot-sparse", "domain-wall"]


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
                f"info {name}-bp.qsf",
                f"decode {name}.qcf {name}-trws.qsf -o {name}.pfm --repair --color",
                f"reduce {name}.qcf -o {name}-small.qcf --target 40 --truncate --json",
                f"info {name}-small.qcf",
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


def contents(path):
    """A file's bytes; of samples the chunks, for the time that a solver took is in one of them."""
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
    assert refused == ["info", "solve"] and len(said) > 180 and len(files) > 160, (
        refused,
        len(said),
        len(files),
    )
    print(f"{target}: {len(said)} commands and {len(files)} files agree")
