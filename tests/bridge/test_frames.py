"""Many frames on workers of dask: all are done whatever dies, and nothing is done twice."""

import contextlib
import csv
import json
import os
import shlex
import signal
import subprocess
import sys
from pathlib import Path
from unittest import mock

import pytest
from bridge_tools import COMMAND
from dask import config
from PIL import Image

distributed = pytest.importorskip("distributed")
ROOT = Path(__file__).parents[2]
QSTEREO = Path(os.environ.get("QSTEREO", ROOT / "build" / "qstereo")).absolute()
NAMES = [f"{number:02}" for number in range(6)]
WORDS = ["--encode", "--disparity 0:7", "--solve", "--windows 500 --seed 1 --num-reads 3"]
# Stands for qstereo: notes each call, and kills the worker that makes a call in KILLS, once.
NOTING = """\
#!/bin/sh
echo "$@" >> {0}/calls
for call in $KILLS; do
    case "$1 $2" in *"$call"*) mkdir "{0}/died-${{call##*/}}" 2>/dev/null && kill -9 $PPID;; esac
done
exec {1} "$@"
"""


@pytest.fixture
def pairs(tmp_path):
    """A folder of six pairs with truth, windows of the rendered sample."""
    folder = tmp_path / "my pairs"
    folder.mkdir()
    for side in ("left", "right", "truth"):
        whole = Image.open(ROOT / "samples" / "rendered" / f"{side}.png")
        for at, name in enumerate(NAMES):
            whole.crop((20 * at, 60, 20 * at + 32, 80)).save(folder / f"{side}_{name}.png")
    return folder


@pytest.fixture
def noted(tmp_path, monkeypatch):
    """The calls of qstereo since the last time that it was asked: the first word of each."""
    program = tmp_path / "qstereo"
    program.write_text(NOTING.format(shlex.quote(str(tmp_path)), shlex.quote(str(QSTEREO))))
    program.chmod(0o755)
    monkeypatch.setenv("QSTEREO", str(program))
    calls = tmp_path / "calls"

    def made():
        said = calls.read_text().splitlines() if calls.exists() else []
        calls.unlink(missing_ok=True)
        return sorted(line.split()[0] for line in said)
    return made


@pytest.fixture(scope="module")
def cluster():
    """A scheduler with two workers in this process, without the resource qpu."""
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=False,
                                  dashboard_address=":0") as found:
        yield found.scheduler_address


@pytest.fixture
def frames(main, cluster, tmp_path):
    """Runs the command on the cluster: (exit status, stdout, stderr)."""
    def run(place, *words):
        return main("frames", place, "--out-dir", tmp_path / "out", "--scheduler", cluster, *WORDS,
                    *words)
    return run


def summary(tmp_path):
    return json.loads((tmp_path / "out" / "summary.json").read_text())


def test_workers_die_and_all_frames_are_done(pairs, noted, tmp_path, environment):
    command = [*COMMAND, "frames", pairs, "--out-dir", tmp_path / "out", "--workers", "2", *WORDS]
    for name in NAMES[4:]:
        (pairs / f"left_{name}.png").unlink()
    kills = {"KILLS": "left_02.png decode"}
    done = subprocess.run(command, capture_output=True, text=True, timeout=600,
                          env={**environment, **kills, "QSTEREO": str(tmp_path / "qstereo")})
    assert done.returncode == 0, done.stderr
    assert len(list(tmp_path.glob("died-*"))) == 2
    assert "dashboard at http://127.0.0.1:" in done.stderr and "4 of 4 frames" in done.stdout
    told = summary(tmp_path)
    assert not told["failed"] and [one["name"] for one in told["problems"]] == NAMES[:4]
    for one in told["problems"]:
        result = one["results"][0]
        assert result["energy"] == one["lower_bound"] and result["proven_optimal"]
        assert 0 <= result["rms"] < 8 and one["variables_left"] < one["variables"]
        for file in (one["left"], one["right"], one["truth"], result["map"]):
            assert Image.open(tmp_path / "out" / file).size == (32, 20)
    with open(tmp_path / "out" / "summary.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows] == NAMES[:4]
    assert [float(row["rms"]) for row in rows] == [
        one["results"][0]["rms"] for one in told["problems"]]


def test_a_second_run_does_what_is_missing(pairs, noted, frames, tmp_path):
    assert frames(pairs)[0] == 0
    assert noted() == sorted(["encode", "reduce", "decode", "score"] * 6)
    first = summary(tmp_path)
    stamps = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").glob("frame_*")}
    assert frames(pairs, "--quiet") == (0, "", "")
    assert noted() == [] and summary(tmp_path) == first
    assert stamps == {path: path.stat().st_mtime_ns for path in (tmp_path / "out").glob("frame_*")}
    # Other words, or other pictures, and what follows from them is made anew.
    assert frames(pairs, "--decode", "--scale=16 --color", "--quiet")[0] == 0
    assert noted() == sorted(["decode", "score"] * 6)
    assert [one["results"][0]["rms"] for one in summary(tmp_path)["problems"]] == [
        one["results"][0]["rms"] for one in first["problems"]]
    assert (tmp_path / "out" / "frame_03.color.png").exists()
    (tmp_path / "out" / "frame_01.png").unlink()
    (pairs / "left_02.png").write_bytes((pairs / "left_03.png").read_bytes())
    assert frames(pairs, "--decode", "--scale=16 --color", "--quiet")[0] == 0
    assert noted() == sorted(["encode", "reduce", "decode", "score", "decode", "score"])


def test_a_broken_frame_does_not_stop_the_others(pairs, noted, frames, tmp_path):
    good = (pairs / "right_03.png").read_bytes()
    (pairs / "right_03.png").write_bytes(b"no picture")
    (pairs / "right_05.png").unlink()
    status, out, err = frames(pairs, "--json")
    assert status == 1 and json.loads(out)["failed"] == ["03", "05"]
    assert "03: " in err and "right_03.png" in err and "right_05.png: cannot read" in err
    told = summary(tmp_path)
    assert [one["name"] for one in told["failed"]] == ["03", "05"] and len(told["problems"]) == 4
    noted()
    (pairs / "right_03.png").write_bytes(good)
    assert frames(pairs)[0] == 1 and noted() == ["decode", "encode", "reduce", "score"]


def test_a_list_names_pairs(pairs, frames, tmp_path):
    listed = tmp_path / "list.txt"
    listed.write_text("# left right truth\n\n'my pairs/left_01.png' 'my pairs/right_01.png'\n"
                      f"'{pairs}/left_02.png' 'my pairs/right_02.png' 'my pairs/truth_02.png'\n")
    assert frames(listed)[0] == 0
    first, second = summary(tmp_path)["problems"]
    assert (first["name"], second["name"]) == ("0003", "0004") and first["truth"] is None
    assert "rms" not in first["results"][0] and "rms" in second["results"][0]


@pytest.mark.parametrize("line, said", [
    ("only-one", "line 1 has 1 words"), ("'a b", "line 1: No closing"), ("# none", "no pair")])
def test_lists_that_are_none(line, said, frames, tmp_path):
    (tmp_path / "list.txt").write_text(line)
    status, _, err = frames(tmp_path / "list.txt")
    assert status == 3 and said in err and not (tmp_path / "out").exists()


@pytest.mark.parametrize("words, said", [
    (["--solve", "--solver nobody"], "nobody is not one of"), (["--workers", 2], "--workers"),
    (["--solve", "--no-wait --solver qpu"], "--solve does not take --no-wait"),
    (["--solve", "-o s.qsf"], "--solve does not take -o"),
    (["--decode", "--scale"], "--decode: --scale needs a number"),
    (["--score", "--truth-scale=4x"], "--score: --truth-scale needs a number")])
def test_words_that_no_frame_takes(words, said, pairs, frames, tmp_path):
    status, _, err = frames(pairs, *words)
    assert status == 2 and said in err and not (tmp_path / "out").exists()


def test_paid_calls_go_to_workers_with_a_chip(pairs, main, frames, tmp_path, service):
    for name in NAMES[2:]:
        (pairs / f"left_{name}.png").unlink()
    status, _, err = frames(pairs, "--solve", "--solver hybrid-nl")
    assert status == 5 and "no worker has the resource qpu" in err and not service.problems
    with distributed.LocalCluster(n_workers=1, threads_per_worker=2, processes=False,
                                  resources={"qpu": 1}, dashboard_address=":0") as found:
        for _ in range(2):
            status, _, err = main(
                "frames", pairs, "--out-dir", tmp_path / "out", "--scheduler",
                found.scheduler_address, *WORDS, "--solve", "--solver hybrid-nl", "--reduce",
                "--target 150 --encoding one-hot-sparse", "--decode", "--repair")
            assert status == 0, err
            assert len(service.problems) == 2
    charged = [one["results"][0]["charge"] for one in summary(tmp_path)["problems"]]
    assert len(charged) == 2 and min(charged) > 0


PAID = ["--solve", "--solver qpu --windows 60 --calls 2 --num-reads 5", "--reduce",
        "--target 110 --encoding domain-wall"]


@pytest.fixture
def paid(pairs, main, tmp_path, service, environment, processes):
    """Runs the command for two pairs on one worker with a chip, a process of its own, the chip's
    service being the stand-in. `paid.pid()` is the worker's process."""
    for name in NAMES[2:]:
        (pairs / f"left_{name}.png").unlink()
    # What dask leaves in the environment makes later commands some times as slow
    # (MALLOC_TRIM_THRESHOLD_): it goes with the worker.
    with (mock.patch.dict(os.environ),
          config.set({"distributed.worker.multiprocessing-method": "forkserver"}),
          distributed.LocalCluster(n_workers=1, threads_per_worker=1, resources={"qpu": 1},
                                   dashboard_address=":0", env=environment) as cluster):
        def run(*words):
            return main("frames", pairs, "--out-dir", tmp_path / "out", "--scheduler",
                        cluster.scheduler_address, *WORDS, *PAID, *words)
        run.pid = lambda: cluster.workers[0].pid
        yield run


def test_the_charge_of_all_frames_is_bounded(paid, service):
    status, out, err = paid("--dry-run", "--json")
    told = json.loads(out)
    assert status == 0 and not service.problems, err
    assert [(one["frame"], one["calls"]) for one in told["frames"]] == [("00", 2), ("01", 2)]
    charges = [one["charge_seconds"] for one in told["frames"]]
    assert min(charges) > 0 and told["charge_seconds"] == pytest.approx(sum(charges))
    # Each frame by itself is cheap enough.
    status, _, err = paid("--max-charge", 0.9 * sum(charges))
    assert status == 1 and "--max-charge allows" in err and not service.problems
    assert paid("--max-charge", 1.1 * sum(charges))[0] == 0
    sent = len(service.problems)
    assert 2 <= sent <= 4
    # What is done costs nothing more.
    status, out, _ = paid("--dry-run")
    assert status == 0 and out.count("skipped") == 2 and "in all 0.000 s" in out
    assert paid("--max-charge", 0.001)[0] == 0 and len(service.problems) == sent


@pytest.mark.parametrize("method, path, when", [
    ("POST", r"^problems/$", "drop after"), ("GET", r"^problems/.+", "drop")])
def test_a_worker_that_dies_in_a_paid_call_is_charged_once(method, path, when, paid, service,
                                                           tmp_path):
    """Killed when the service has carried out the request of a call, or is asked for its answer;
    then the run is repeated. Once a test: dask gives a worker up that dies in its start."""
    deaths = []

    def strike():
        deaths.append(paid.pid())
        os.kill(deaths[0], signal.SIGKILL)
        return when
    service.fail(method, path, strike)
    assert paid()[0] == 0 and len(deaths) == 1
    sent = len(service.problems)
    calls = [line for journal in (tmp_path / "out").glob("*.journal")
             for line in journal.read_text().splitlines()[1:]]
    assert sent == len(calls) >= 2 and not list((tmp_path / "out").glob("*.job"))
    assert paid()[0] == 0 and len(service.problems) == sent


def test_without_a_worker_for_paid_calls_it_ends(pairs, main, tmp_path, service, environment,
                                                 monkeypatch):
    """The only worker with a chip is killed in a paid call, and nothing starts it again: the frames
    fail. With another worker the same command goes on, and collects what was sent."""
    for name in NAMES[1:]:
        (pairs / f"left_{name}.png").unlink()
    monkeypatch.setattr("qstereo_bridge.desk.frames.PATIENCE", 0)
    with distributed.LocalCluster(n_workers=0, dashboard_address=":0") as cluster:
        address = cluster.scheduler_address

        @contextlib.contextmanager
        def worker():
            process = subprocess.Popen(
                [sys.executable, "-m", "distributed.cli.dask_worker", address, "--no-nanny",
                 "--nthreads", "1", "--resources", "qpu=1", "--no-dashboard"],
                env={**os.environ, **service.environment}, stderr=subprocess.DEVNULL)
            try:
                with distributed.Client(address) as client:
                    client.wait_for_workers(1)
                yield process
            finally:
                process.kill()
                process.wait()

        def run():
            return main("frames", pairs, "--out-dir", tmp_path / "out", "--scheduler", address,
                        *WORDS, *PAID)
        with worker() as process:
            def strike():
                process.kill()
                return "drop after"
            service.fail("POST", r"^problems/$", strike)
            status, out, err = run()
        assert status == 1 and "failed: 00" in out and len(service.problems) == 1
        assert "00: no worker with the resource qpu is left; start one" in err
        assert summary(tmp_path)["failed"][0]["name"] == "00"
        with worker():
            status, _, err = run()
        assert status == 0, err
    sent = [line for journal in (tmp_path / "out").glob("*.journal")
            for line in journal.read_text().splitlines()[1:]]
    assert len(service.problems) == len(sent) >= 1


def test_options_that_are_for_all_frames(pairs, main, tmp_path):
    for words, said in ((["--solve", "--solver qpu --max-charge 3"], "give it to frames"),
                        (["--solve", "--dry-run"], "give it to frames"),
                        (["--max-charge", 3], "charges nothing")):
        status, _, err = main("frames", pairs, "--out-dir", tmp_path / "out", *words)
        assert status == 2 and said in err and not (tmp_path / "out").exists()


def test_a_scheduler_that_is_not_there(pairs, main, tmp_path):
    with config.set({"distributed.comm.timeouts.connect": "200ms"}):
        status, _, err = main("frames", pairs, "--out-dir", tmp_path / "out", "--scheduler",
                              "tcp://127.0.0.1:1", *WORDS)
    assert status == 5 and "cannot reach this scheduler" in err


def test_without_dask_it_says_what_to_install(pairs, main, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "dask.distributed", None)
    status, _, err = main("frames", pairs, "--out-dir", tmp_path / "out")
    assert status == 5 and "./bridge[dask]" in err
