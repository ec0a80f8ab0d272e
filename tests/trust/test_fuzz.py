"""The corpora of the fuzz targets, run again: no crash, no broken promise, and both readers agree.

QSTEREO_FUZZ names the folder with the programs that replay a corpus.
"""

import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "cli"))
sys.path.insert(0, str(Path(__file__).parents[1] / "fuzz"))
import readers  # noqa: E402
from cli_tools import run  # noqa: E402
from hostile import hostile, sound  # noqa: E402

FUZZ = os.environ.get("QSTEREO_FUZZ")
# What the bridge does not look at, or has another limit for.
LABELS = (
    " of labl",
    " of kept",
    " of trnc",
    "labels that do not fit",
    "a site or terminal without a penalty",
    "memory limit",
)


def inputs(target):
    """[bytes]: the corpus, and of problems the files that were made to hurt."""
    made = [data for _, data, *_ in [*hostile(), *sound()]] if target == "qcf" else []
    return [data for _, data in readers.corpus(target)] + made


@pytest.mark.skipif(FUZZ is None, reason="QSTEREO_FUZZ names no folder")
@pytest.mark.parametrize("target", ["qcf", "qsf", "qpf", "pictures", "text", "frames"])
def test_replay(target, tmp_path):
    for number, data in enumerate(inputs(target)):
        (tmp_path / str(number)).write_bytes(data)
    done = subprocess.run(
        [f"{FUZZ}/replay-{target}", tmp_path],
        capture_output=True,
        text=True,
        timeout=600,
        env={
            **os.environ,
            "ASAN_OPTIONS": "allocator_may_return_null=1",
            "QSTEREO_GOLDEN": str(Path(__file__).parents[1] / "golden"),
        },
    )
    print(done.stdout)
    assert done.returncode == 0, done.stderr[-4000:]
    assert f" {number + 1} inputs" in done.stdout


@pytest.mark.parametrize("name", ["qcf", "qsf"])
def test_the_bridges_readers(name):
    """Over the corpus and over some changes of each file."""
    rng = random.Random(7)
    for data in inputs(name):
        readers.read(name, data)
        for _ in range(3):
            readers.read(name, readers.mutate(data, rng))


@pytest.mark.parametrize("name", ["qcf", "qsf"])
def test_both_readers_agree(name, tmp_path):
    """A file that one takes the other takes, but for the labels that the bridge does not read."""
    path, taken = tmp_path / "file", 0
    for number, data in enumerate(inputs(name)):
        path.write_bytes(data)
        here, there = readers.read(name, data), run("info", path)
        if here is None:
            continue
        taken += here
        agree = (there.status == 0) == here
        assert agree or (here and any(part in there.err for part in LABELS)), (
            number,
            here,
            there.err,
        )
    assert taken > 10
