"""match --threads: the same maps, reports, refusals and limits with any number of threads; and
how the time of a limit is shared, by a clock that does not wait.
"""

import json
import os
import subprocess

import numpy as np
import pytest
from cli_tools import ROOT, random_pair, run, succeed, write_pgm

FAST = ["--preset", "fast", "--disparity", "0:7:1", "--after", "halves,check,fill"]


@pytest.fixture
def shifted(tmp_path):
    """A pair whose left third is nearer, with some noise."""
    random = np.random.default_rng(7)
    scene = random.integers(0, 256, (40, 80))
    left, right = scene[:, 10:70].copy(), scene[:, 13:73]
    left[:, :20] = scene[:, 8:28]
    noisy = np.clip(right + random.integers(-6, 7, right.shape), 0, 255)
    return [write_pgm(tmp_path / "l.pgm", left), write_pgm(tmp_path / "r.pgm", noisy)]


def matched(paths, output, *options, **how):
    """The facts of a match, without its time, and the bytes of its map."""
    facts = json.loads(succeed("match", *paths, "-o", output, "--json", *options, **how).out)
    del facts["seconds"]
    return facts, output.read_bytes()


@pytest.mark.parametrize("options", [
    FAST, [*FAST, "--after", "check"], [*FAST, "--after", "none"],
    [*FAST, "--roi", "20,5,30,20"], [*FAST, "--after", "refine,check,fill,median"],
    ["--preset", "accurate", "--disparity", "0:7"],
    ["--preset", "accurate", "--disparity", "0:7", "--after", "refine,check"],
    *([*FAST, "--solver", solver, "--iterations", 6, "--seed", 3]
      for solver in ("icm", "anneal", "expansion", "bp", "best")),
], ids=str)
def test_the_same_with_more_threads(shifted, tmp_path, options):
    one = matched(shifted, tmp_path / "m.pfm", *options, "--threads", 1)
    assert matched(shifted, tmp_path / "m.pfm", *options) == one
    for count in (2, 3, 7, 32):
        assert matched(shifted, tmp_path / "m.pfm", *options, "--threads", count) == one


def test_the_right_picture_is_solved_and_not_the_left_one_again(shifted, tmp_path):
    """What --after check takes out with two threads are holes that only the right map knows."""
    _, unchecked = matched(shifted, tmp_path / "m.pfm", *FAST, "--after", "none", "--threads", 2)
    _, checked = matched(shifted, tmp_path / "m.pfm", *FAST, "--after", "check", "--threads", 2)
    values, kept = (np.frombuffer(data[-4 * 60 * 40:], "<f4") for data in (unchecked, checked))
    holes = ~np.isfinite(kept)
    assert 0 < holes.sum() < 1200 and (values[~holes] == kept[~holes]).all()


def sequence(pair, folder, frames):
    for number in range(frames):
        for path, side in zip(pair, "lr"):
            (folder / f"{side}_{number}.pgm").symlink_to(path)


def test_a_sequence_with_two_threads(shifted, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sequence(shifted, tmp_path, 3)
    succeed("match", "l_%d.pgm", "r_%d.pgm", "-o", "d_%d.pfm", *FAST, "--threads", 2)
    _, alone = matched(shifted, tmp_path / "m.pfm", *FAST)
    assert [(tmp_path / f"d_{number}.pfm").read_bytes() for number in range(3)] == [alone] * 3


REFUSED = [
    (["--solver", "trws16", "--lambda", "9000"], "whose costs are too large for it"),
    (["--solver", "cut"], "--solver cut cannot solve the problem"),
    (["--solver", "trws16", "--smoothness", "quadratic", "--after", "check"],
     "it needs Potts or linear smoothness"),
]


@pytest.mark.parametrize("options, message", REFUSED)
def test_a_refusal_is_printed_once(shifted, tmp_path, options, message):
    done = [run("match", *shifted, "-o", tmp_path / "m.pfm", *FAST, *options, "--threads", count)
            for count in (1, 2)]
    for of in done:
        assert (of.status, of.out) == (2, b"") and message in of.err
        assert of.err.count("\n") == 1
    assert done[0].err == done[1].err
    assert not (tmp_path / "m.pfm").exists()


@pytest.mark.parametrize("preset", ["fast", "accurate"])
def test_two_threads_stay_under_the_memory_limit_that_they_name(tmp_path, preset):
    """Both works are there at once, so it is more than with one thread."""
    *_, left, right = random_pair(tmp_path, 320, 240)
    line = ["match", left, right, "-o", tmp_path / "m.pfm", "--preset", preset, "--disparity",
            "0:31", "--iterations", 1]

    def least(threads):
        mib = 2
        while (done := run(*line, "--threads", threads, "--memory-limit", mib)).status == 4:
            assert done.err.count("\n") == 1 and "raise --memory-limit to" in done.err
            mib = int(done.err.rsplit(" ", 1)[1])
        assert done.status == 0, done.err
        return mib

    one, two = least(1), least(2)
    assert 1.2 * one < two < 2.5 * one


@pytest.mark.parametrize("count", ["0", "33", "x", "-1", "1.5"])
def test_numbers_of_threads(shifted, tmp_path, count):
    done = run("match", *shifted, "-o", tmp_path / "m.pfm", "--threads", count)
    assert done.status == 2
    assert f"--threads {count} is not a whole number from 1 to 32" in done.err


# ---- The time of a limit. Each look at the clock is 10 ms later than the one before.


@pytest.fixture(scope="session")
def clock(tmp_path_factory):
    """What makes a command use that clock."""
    made = tmp_path_factory.mktemp("clock") / "clock.so"
    source = ROOT / "tests" / "cli" / "clock.c"
    subprocess.run([os.environ.get("CC", "cc"), "-shared", "-fPIC", source, "-o", made], check=True)
    return {"env": {**os.environ, "LD_PRELOAD": str(made)}}


@pytest.fixture
def noise(tmp_path):
    """A pair for which no solver ends by itself."""
    return random_pair(tmp_path, 60, 40)[2:]


def iterations(noise, folder, clock, solver, limit, *options):
    facts, _ = matched(noise, folder / "m.pfm", *FAST, "--solver", solver, "--iterations", 10**6,
                       "--time-limit", limit, *options, **clock)
    return facts["iterations"]


def test_trws16_leaves_time_for_what_follows_it(noise, tmp_path, clock):
    """trws16 looks at the clock once in an iteration. Of 100 looks in a second it leaves those that
    measure how long the end takes, twice the 10 ms that this takes by the clock, and 20 ms for the
    end of the command.
    """
    found = iterations(noise, tmp_path, clock, "trws16", 1, "--after", "none")
    assert 80 <= found <= 89


@pytest.mark.parametrize("solver", ["trws16", "bp"])
def test_the_right_picture_gets_half_of_the_time(noise, tmp_path, clock, solver):
    alone = iterations(noise, tmp_path, clock, solver, 2, "--after", "none")
    checked = iterations(noise, tmp_path, clock, solver, 2, "--after", "check")
    assert .45 * alone <= checked <= .55 * alone


def test_the_time_limit_is_that_of_each_frame(noise, tmp_path, clock, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sequence(noise, tmp_path, 4)
    done = succeed("match", "l_%d.pgm", "r_%d.pgm", "-o", "d_%d.pfm", *FAST, "--solver", "trws16",
                   "--iterations", 10**6, "--time-limit", 1, "--json", **clock)
    found = [json.loads(line)["iterations"] for line in done.out.splitlines()]
    assert len(found) == 4 and max(found) - min(found) <= 2 and min(found) > 30


@pytest.mark.parametrize("look", [40, 80], ids=["left", "right"])
def test_an_interrupted_sequence_ends_with_its_frame(noise, tmp_path, clock, monkeypatch, look):
    """Each picture of a frame takes 50 looks at the clock, or a few more."""
    monkeypatch.chdir(tmp_path)
    sequence(noise, tmp_path, 3)
    env = {**clock["env"], "INTERRUPT_AT": str(look)}
    succeed("match", "l_%d.pgm", "r_%d.pgm", "-o", "d_%d.pfm", *FAST, "--after", "check",
            "--iterations", 50, "--keep-on-interrupt", env=env)
    assert [path.name for path in tmp_path.glob("d_*")] == ["d_0.pfm"]
