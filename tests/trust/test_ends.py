"""However a command ends - killed, interrupted, on a full disk, without memory - what was there
before is whole, or the new file is.

QSTEREO_FAULTS names the library that sends signals before the k-th call (faults.c).
"""

import resource
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from test_faults import FAULTS, PNM, contents, with_fault

sys.path.insert(0, str(Path(__file__).parents[1] / "cli"))
from cli_tools import random_pair, run  # noqa: E402

pytestmark = pytest.mark.skipif(
    FAULTS is None or PNM is None, reason="QSTEREO_FAULTS or QSTEREO_PNM names nothing"
)
COMMANDS = [
    "encode left.pgm right.pgm -o out --disparity 0:31",
    "reduce p.qcf -o out --iterations 1",
    "decode p.qcf s.qsf -o out.pfm",
    "solve p.qcf -o out --solver icm --keep-on-interrupt",
]
HANDLED = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGPIPE]


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    made = tmp_path_factory.mktemp("inputs")
    random_pair(made, 130, 60)
    for line in (
        "encode left.pgm right.pgm -o p.qcf --disparity 0:15",
        "solve p.qcf -o s.qsf --solver icm",
    ):
        assert run(*line.split(), cwd=made).status == 0
    return made


def target_of(line):
    words = line.split()
    return words[words.index("-o") + 1]


@pytest.mark.parametrize("line", COMMANDS)
def test_signals_while_writing(line, inputs, tmp_path):
    """Before each write, close, fsync and rename, each signal: what is named is old or whole, and
    a signal that can be handled leaves nothing."""
    folder, target, ends = tmp_path / "work", target_of(line), 0
    shutil.copytree(inputs, folder)
    before = contents(folder)
    counts = {
        call: with_fault(line, folder, call, 0)[3] for call in ["write", "close", "fsync", "rename"]
    }
    whole = (folder / target).read_bytes()
    for call, count in counts.items():
        for k, number in [
            (k, number) for k in range(1, count + 1) for number in [signal.SIGKILL, *HANDLED]
        ]:
            (folder / target).write_bytes(b"old")
            status, out, err, _ = with_fault(line, folder, call, k, -number, killed=True)
            found = contents(folder)
            left = {name for name in found if name not in before and name != target}
            done = found[target] == whole or (
                found[target][:4] == b"\x89QSF" and len(found[target]) >= len(whole) - 20
            )
            ends += status != 0
            assert found[target] == b"old" or done, (call, k, number)
            if number == signal.SIGKILL:
                assert status == -number and all(name.startswith(".qstereo-") for name in left)
            else:
                assert not left and status in (0, 128 + number) and (status != 0 or done), (
                    call,
                    k,
                    number,
                    status,
                    left,
                )
            for name in left:
                (folder / name).unlink()
    assert ends >= 5 * sum(counts.values()) - 5
    print(f"{line.split()[0]}: {ends} ends by signals")


@pytest.mark.parametrize("line", COMMANDS)
def test_a_full_disk(line, inputs, tmp_path):
    """The size of files is limited. With every limit below the size of the whole file the command
    fails and leaves nothing."""
    folder, target = tmp_path / "work", target_of(line)
    shutil.copytree(inputs, folder)
    before = contents(folder)
    assert run(*line.split(), program=PNM, cwd=folder).status == 0
    size = (folder / target).stat().st_size
    for most in sorted({0, 1, 4096, size // 2, size - 30}):
        (folder / target).write_bytes(b"old")
        done = run(
            *line.split(),
            program=PNM,
            cwd=folder,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most)),
        )
        assert done.status == (4 if most < size - 20 else 0) and (
            done.err.startswith("qstereo") or most >= size
        ), most
        assert contents(folder) == {**before, target: b"old"}, most


@pytest.mark.parametrize("line", COMMANDS)
def test_a_full_device(line, inputs, tmp_path):
    line = line.replace(f"-o {target_of(line)}", "-o /dev/full")
    done = run(*line.split(), program=PNM, cwd=inputs)
    assert done.status in (2, 4) and "qstereo" in done.err


@pytest.mark.parametrize(
    "line",
    [
        *COMMANDS,
        "match left.pgm right.pgm -o out.pgm --solver icm",
        "info p.qcf",
        "compare p.qcf --solvers bp",
    ],
)
def test_a_small_address_space(line, inputs, tmp_path):
    """From nothing to enough: an answer, or the message that memory is short; never a crash."""
    folder = tmp_path / "work"
    shutil.copytree(inputs, folder)
    before, ends = contents(folder), set()
    for kib in range(2600, 16000, 400):
        done = subprocess.run(
            [PNM, *line.split()],
            cwd=folder,
            capture_output=True,
            stdin=subprocess.DEVNULL,
            timeout=600,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (kib << 10, kib << 10)),
        )
        if (
            b"error while loading shared libraries" in done.stderr
            or done.returncode == -signal.SIGSEGV
            and not ends
        ):
            continue  # the program itself does not fit yet
        ends.add(done.returncode)
        assert done.returncode in (0, 4), (kib, done)
        if done.returncode:
            assert done.stderr.startswith(b"qstereo") and contents(folder) == before, kib
        else:
            for name in contents(folder).keys() - before.keys():
                (folder / name).unlink()
    assert 0 in ends and (4 in ends or line.startswith("encode"))  # encode needs next to nothing
