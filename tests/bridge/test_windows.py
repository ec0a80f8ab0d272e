"""Windows: plans, folded problems, and runs of many calls that go on after any end."""

import dataclasses
import io
import itertools
import json
import os
import random
import signal
import struct
import sys

import dimod
import numpy as np
import pytest
import qstereo_bridge as qb
from hypothesis import given
from hypothesis import strategies as st
from problems import (Table, all_states, carrying, domain_walls, grid, make, nothing, pack_qcf,
                      random_problem)
from qstereo_bridge.runs import jobs
from qstereo_bridge.core import merging, models
from qstereo_bridge.samplers import windows
from qstereo_bridge.core.problem import made


seeds = st.integers(0, 10**6)
LOCAL = ["--num-reads", 3, "--num-sweeps", 20, "--seed", 1]


def problem_of(coefficients):
    return made(dataclasses.replace(coefficients, digest=bytes(range(32))))


def labl(encoding, *kept):
    """The side chunk of an encoding, and perhaps `kept` with this width."""
    sides = [("labl", struct.pack("<16I", encoding, 0, 0, 2, 1, *[0] * 11))]
    return sides + [("kept", struct.pack("<II", 1, width)) for width in kept]


@given(seeds, st.integers(4, 20))
def test_a_pass_takes_every_variable(seed, size):
    problem = random_problem(seed, 30)
    p, group = problem_of(problem), problem.of_variables(np.arange(problem.sizes.size))
    for number in range(2):
        calls = windows.passes(p, size, number, 7)
        assert set(np.concatenate(calls)) == set(range(len(p)))
        for call in calls:
            assert call.size <= size and (np.diff(call) > 0).all()
            assert np.isin(group, np.unique(group[call])).sum() == call.size
        for part in p.parts():
            # What fits is in one call, whole.
            assert part.size > size or sum(np.isin(part, call).all() for call in calls) == 1


def test_the_plan_follows_from_digest_seed_and_number():
    p = problem_of(domain_walls(8, 8, 2)[0])
    calls = [qb.plan(p, 20, number, 3) for number in range(12)]
    for at in random.Random(1).sample(range(12), 12):
        assert (qb.plan(p, 20, at, 3) == calls[at]).all()
    assert any(not np.array_equal(qb.plan(p, 20, at, 4), calls[at]) for at in range(12))
    p.digest = bytes(32)
    assert any(not np.array_equal(qb.plan(p, 20, at, 3), calls[at]) for at in range(12))
    with pytest.raises(qb.InputError, match="a group has 3 variables"):
        qb.plan(problem_of(domain_walls(2, 2, 4)[0]), 2)


@given(seeds)
def test_energies_of_a_window_are_those_of_the_whole(seed):
    problem, rng = random_problem(seed, 14), np.random.default_rng(seed)
    p, bits = problem_of(problem), rng.integers(0, 2, problem.linear.size)
    chosen = rng.integers(0, 2, problem.sizes.size).astype(bool)
    chosen[rng.integers(chosen.size)] = True
    variables = np.flatnonzero(problem.of_variables(chosen))
    part = qb.window(p, bits, variables)
    states = rng.integers(0, 2, (8, variables.size))
    whole = np.tile(bits, (8, 1))
    whole[:, variables] = states
    assert (part.energies(states) == p.energies(whole)).all()
    assert part.digest != p.digest and part.scale == p.scale


def test_a_window_takes_whole_groups():
    p = problem_of(domain_walls(2, 2, 3)[0])
    with pytest.raises(qb.InputError, match="whole groups"):
        qb.window(p, np.zeros(8), np.array([0]))


@pytest.fixture
def core(tmp_path):
    """A .qcf of 12 sites in domain walls, and its least energy."""
    problem = domain_walls(4, 3, 2, seed=5)[0]
    path = tmp_path / "core.qcf"
    path.write_bytes(pack_qcf(problem))
    return path, int(models.energies(problem, all_states(12)).min())


@pytest.mark.parametrize("solver", ["anneal", "tabu", "dwave.samplers:SimulatedAnnealingSampler"])
def test_windows_reach_the_optimum(solver, core, tmp_path, main):
    path, least = core
    options = {"anneal": LOCAL, "tabu": ["--num-reads", 2, "--time-limit", 0.1, "--seed", 1],
               "dwave.samplers:SimulatedAnnealingSampler": ["--num-reads", 3, "--seed", 1]}[solver]
    status, out, err = main("solve", path, "-o", tmp_path / "s.qsf", "--solver", solver,
                            "--windows", 8, "--calls", 30, "--bound", least, *options, "--json")
    told = json.loads(out)
    assert status == 0 and told["proven_optimal"] and told["energy"] == least
    assert told["feasible"] is None  # domain walls: `qstereo validate` tells
    assert max(told["variables_of_calls"]) <= 8 and len(told["variables_of_calls"]) == told["calls"]
    assert (np.diff(told["energies_of_calls"]) <= 0).all()
    samples, p = qb.load_samples(tmp_path / "s.qsf"), qb.load(path)
    assert (p.energies(samples.bits) == [least]).all() and samples.info["lower_bound"] == least
    # The run is over: the same command makes no more calls.
    journal = (tmp_path / "s.qsf.journal").read_bytes()
    assert main("solve", path, "-o", tmp_path / "s.qsf", "--solver", solver, "--windows", 8,
                "--calls", 30, "--bound", least, *options, "--quiet") == (0, "", "")
    assert (tmp_path / "s.qsf.journal").read_bytes() == journal


def test_a_pass_that_gains_nothing_is_the_last(core, tmp_path, main):
    path, least = core
    status, out, err = main("solve", path, "-o", tmp_path / "s.qsf", "--windows", 12, *LOCAL)
    assert status == 0 and err.count("bound not known") == 2 and "2 calls" in out
    assert "give --bound" in out


class Stuck(dimod.Sampler):
    """A sampler that answers zeros for `left` calls, then ones."""

    parameters, properties, left = {}, {}, 0

    def sample(self, bqm, **_):
        Stuck.left -= 1
        return dimod.SampleSet.from_samples_bqm(
            dict.fromkeys(bqm.variables, int(Stuck.left < 0)), bqm)


def test_with_a_bound_it_goes_on_after_a_pass_without_gain(tmp_path, main):
    """Four variables gain if all of them are 1; neither descent nor merging leads there."""
    path = tmp_path / "p.qcf"
    path.write_bytes(pack_qcf(make(
        [1] * 4, [Table(np.array([[-4]], "<i4"))],
        [{"block": 0, "g": 0, "h": 1, "count": 3, "weight": 1}], [3, 3, 2, 3], [(0, 0)] * 4)))

    def energies(name, *more):
        Stuck.left = 5
        status, out, err = main("solve", path, "--solver", f"{__name__}:Stuck", "--windows", 4,
                                "--json", "-o", tmp_path / name, "--calls", 15, *more)
        assert status == 0, err
        return json.loads(out)["energies_of_calls"]
    found = energies("met.qsf", "--bound", -1)
    assert found == [0] * (len(found) - 1) + [-1] and len(found) > 5
    assert len(energies("below.qsf", "--bound", -2)) == 15
    # Without a bound the second pass, which gains nothing, is the last.
    passes = [len(windows.passes(qb.load(path), 4, number)) for number in range(2)]
    assert energies("none.qsf") == [0] * sum(passes)


def test_the_start_is_where_it_begins(core, tmp_path, main):
    path, least = core
    begin = tmp_path / "s0.qsf"
    assert main("solve", path, "-o", begin, "--solver", "exact")[0] == 0
    status, out, _ = main("solve", path, "-o", tmp_path / "s.qsf", "--windows", 5, "--start", begin,
                          "--calls", 9, *LOCAL, "--json")
    told = json.loads(out)
    # It is the optimum already: a pass gains nothing, and there is no bound to prove it.
    assert status == 0 and set(told["energies_of_calls"]) == {least} and not told["proven_optimal"]
    status, out, _ = main("solve", path, "-o", tmp_path / "t.qsf", "--windows", 5, "--start", begin,
                          "--bound", least, *LOCAL, "--json")
    assert json.loads(out)["calls"] == 0 and json.loads(out)["proven_optimal"]
    status, _, err = main("solve", path, "-o", tmp_path / "u.qsf", "--windows", 5, "--start", begin,
                          "--bound", least + 1, *LOCAL)
    assert status == 3 and "none of this problem" in err and not (tmp_path / "u.qsf").exists()


@pytest.fixture
def carried(tmp_path):
    """save(labels, bound) -> path: the core of 12 sites, with a labelling and a bound in it."""
    def save(numbers, bound):
        path = tmp_path / "carrying.qcf"
        said, best = carrying(3, 2, numbers, bound)
        kept = ("kept", struct.pack("<II", 12, 1) + bytes(12 * [255] + 12 * [3]))
        path.write_bytes(pack_qcf(domain_walls(4, 3, 2, seed=5)[0], sides=[said, kept, best]))
        return path
    return save


def best_numbers(problem):
    states = all_states(12)
    return states[models.energies(problem, states).argmin()].tolist()


def test_what_the_file_carries_is_where_it_begins_and_ends(core, carried, tmp_path, main):
    """No answer is called proven by a bound that a file states."""
    _, least = core
    best = best_numbers(domain_walls(4, 3, 2, seed=5)[0])
    path = carried(best, least)
    status, out, _ = main("solve", path, "-o", tmp_path / "s.qsf", "--windows", 5, *LOCAL, "--json")
    told = json.loads(out)
    assert status == 0 and (told["calls"], told["energy"], told["gap"]) == (0, least, 0)
    assert told["lower_bound"] == least and told["bound_of"] == str(path)
    assert not told["proven_optimal"]
    info = qb.load_samples(tmp_path / "s.qsf").info
    assert (info["lower_bound"], info["bound_of"]) == (least, str(path))
    status, out, _ = main("solve", path, "-o", tmp_path / "a.qsf", "--windows", 12, "--alone",
                          *LOCAL, "--json")
    told = json.loads(out)
    assert told["calls"] > 0 and told["lower_bound"] is told["bound_of"] is None
    status, out, _ = main("solve", path, "-o", tmp_path / "t.qsf", "--windows", 5, *LOCAL)
    assert status == 0 and f"bound {least} (stated by {path}), gap 0" in out
    assert "proven" not in out and "No call was made" in out
    assert f"meets the lower bound that {path} states" in out and "qstereo verify" in out
    for alone, count in (([], 0), (["--alone", "--calls", 2], 2)):
        status, out, _ = main("solve", path, "--windows", 12, *alone, "--dry-run", "--json")
        assert status == 0 and len(json.loads(out)["calls"]) == count
    # The user's word is another matter.
    status, out, _ = main("solve", path, "-o", tmp_path / "u.qsf", "--windows", 5, "--bound", least,
                          *LOCAL, "--json")
    told = json.loads(out)
    assert told["proven_optimal"] and told["calls"] == 0 and told["bound_of"] == "--bound"
    # It takes the place of what the file states, also where it is lower.
    status, out, _ = main("solve", path, "-o", tmp_path / "v.qsf", "--windows", 5, "--bound",
                          least - 1, "--calls", 1, *LOCAL, "--json")
    assert json.loads(out)["lower_bound"] == least - 1 and json.loads(out)["calls"] == 1


def test_a_start_takes_the_place_of_what_the_file_carries(core, carried, tmp_path, main):
    _, least = core
    path = carried([0] * 12, least - 3)
    worse = int(qb.load(path).energies(np.zeros(12))[0])
    assert worse > least
    status, out, _ = main("solve", path, "-o", tmp_path / "s.qsf", "--windows", 12, "--calls", 9,
                          *LOCAL, "--json")
    told = json.loads(out)
    assert status == 0 and told["energy"] == least and told["gap"] == 3
    assert main("solve", path, "-o", tmp_path / "s0.qsf", "--solver", "exact")[0] == 0
    status, out, err = main("solve", path, "-o", tmp_path / "t.qsf", "--windows", 5, "--start",
                          tmp_path / "s0.qsf", "--calls", 1, *LOCAL, "--json")
    assert status == 0, err
    told = json.loads(out)
    # These samples state no bound: that of the file stays.
    assert (told["energies_of_calls"], told["lower_bound"]) == ([least], least - 3)


def test_a_file_that_contradicts_itself_is_refused(core, carried, tmp_path, main):
    _, least = core
    path = carried(best_numbers(domain_walls(4, 3, 2, seed=5)[0]), least + 1)
    for words in (["--windows", 5], ["--solver", "ilp"], []):
        status, _, err = main("solve", path, "-o", tmp_path / "s.qsf", *words)
        assert status == 3 and "one of them is wrong" in err
    assert not (tmp_path / "s.qsf").exists()


def test_every_solver_merges_with_what_the_file_carries(core, carried, tmp_path, main):
    _, least = core
    path = carried(best_numbers(domain_walls(4, 3, 2, seed=5)[0]), least - 1)
    poor = ["--num-reads", 1, "--num-sweeps", 1, "--seed", 3]
    status, out, _ = main("solve", path, "-o", tmp_path / "s.qsf", *poor)
    assert status == 0 and f"merged with the labelling that {path} carries" in out
    samples = qb.load_samples(tmp_path / "s.qsf")
    result = samples.info["result"]
    assert result["known"] and samples.records["energy"][result["sample"]] == least
    assert main("solve", path, "-o", tmp_path / "r.qsf", "--no-postprocess", *poor)[0] == 0
    raw = qb.load_samples(tmp_path / "r.qsf")
    assert raw.records.size == 1 and "result" not in raw.info
    status, out, _ = main("solve", path, "-o", tmp_path / "a.qsf", "--alone", *poor)
    assert status == 0 and "carries" not in out
    assert "known" not in qb.load_samples(tmp_path / "a.qsf").info["result"]


def test_another_run_is_refused(core, tmp_path, main):
    path, _ = core
    out = tmp_path / "s.qsf"
    assert main("solve", path, "-o", out, "--windows", 8, *LOCAL)[0] == 0
    status, _, err = main("solve", path, "-o", out, "--windows", 7, *LOCAL)
    assert status == 1 and "the journal of another run" in err


def test_a_picture_that_is_not_reduced_is_refused(tmp_path, main):
    raw = grid(3, 3, 2)
    for sides, refused in ((labl(2), True), (labl(2, 0), True), (labl(2, 1), False), ([], False)):
        raw.raw.sides = sides
        path = tmp_path / "raw.qcf"
        path.write_bytes(pack_qcf(raw))
        status, out, err = main("solve", path, "--windows", 8, "--dry-run")
        assert (status == 3) == refused
        if refused:
            assert "qstereo reduce" in err and "qstereo-bridge solve core.qcf" in err
            # One call takes all of it: that is no window.
            assert main("solve", path, "--windows", 18, "--dry-run")[0] == 0


@pytest.mark.parametrize("options, said", [
    (["--calls", 3], "--calls is for --windows"), (["--bound", 3], "--bound is for --windows"),
    (["--windows", 3, "--no-wait"], "--no-wait"), (["--windows", 3, "-o", "-"], "-o a file"),
    (["--windows", 3, "--solver", "qpu", "--copies", 2], "--copies")])
def test_options_that_do_not_go_together(options, said, core, main):
    status, _, err = main("solve", core[0], "-o", "s.qsf", *options)
    assert status == 2 and said in err


def test_nothing_to_decide(tmp_path, main):
    path = tmp_path / "p.qcf"
    path.write_bytes(pack_qcf(nothing(5)))
    assert main("solve", path, "-o", tmp_path / "s.qsf", "--windows", 9)[0] == 0
    assert main("solve", path, "--windows", 9, "--dry-run")[0] == 0


def test_the_dry_run_tells_chains_and_charge(core, tmp_path, main, service):
    status, out, _ = main("solve", core[0], "--windows", 8, "--calls", 4, "--solver", "qpu",
                          "--dry-run", "--json")
    told = json.loads(out)
    assert status == 0 and not service.problems and len(told["calls"]) == 4
    for call in told["calls"]:
        assert call["variables"] <= 8 <= call["embedded_qubits"] + 8
        assert call["longest_chain"] >= 1 and call["charge_seconds"] > 0
    assert told["charge_seconds"] == pytest.approx(sum(c["charge_seconds"] for c in told["calls"]))
    status, out, _ = main("solve", core[0], "--windows", 8, "--calls", 4, "--solver", "qpu",
                          "--dry-run")
    assert status == 0 and out.count("qubits, chains of") == 4 and "nothing was sent" in out
    status, _, err = main("solve", core[0], "--windows", 8, "--calls", 4, "--solver", "qpu", "-o",
                          tmp_path / "s.qsf", "--max-charge", told["charge_seconds"] / 2)
    assert status == 1 and "--max-charge allows" in err and not service.problems


@pytest.mark.parametrize("solver", ["qpu", "hybrid-bqm", "hybrid-cqm", "hybrid-nl"])
def test_every_service_answers_windows(solver, core, tmp_path, main, service):
    path, least = core
    status, out, err = main("solve", path, "-o", tmp_path / "s.qsf", "--solver", solver,
                            "--windows", 8, "--calls", 8, "--bound", least, "--json")
    told = json.loads(out)
    assert status == 0 and len(service.problems) == told["calls"] and told["charge_seconds"] > 0
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "core.qcf", "s.qsf", "s.qsf.journal"]


def mortal(arguments, environment, out, fatal, counted):
    """The command, killed at its `fatal`-th moment: before and after each step to the disk and each
    request. The file `counted` gets the number of moments."""
    os.dup2(os.open(out, os.O_CREAT | os.O_WRONLY | os.O_APPEND), 2)
    os.environ.update(environment)
    sys.argv, jobs.PAUSES, jobs.ARRIVED = ["qstereo-bridge", *arguments], (0.01, 0.02), 0.05
    moments = itertools.count(1)

    def moment():
        now = next(moments)
        counted.write_text(str(now))
        if now == fatal:
            os.kill(os.getpid(), signal.SIGKILL)

    def around(act):
        def step(*given, **named):
            moment()
            done = act(*given, **named)
            moment()
            return done
        return step
    import requests
    os.fsync, requests.Session.send = around(os.fsync), around(requests.Session.send)
    from qstereo_bridge.__main__ import run
    run()


def test_killed_at_random_moments_each_of_ten_calls_is_charged_once(
        core, tmp_path, processes, environment, service):
    """The moments are spread over what is left of the run. QSTEREO_KILLS=50 kills fifty times."""
    path, rng, counted = core[0], random.Random(1), tmp_path / "counted"

    def run(name, fatal):
        arguments = ["solve", str(path), "-o", str(tmp_path / name), "--solver", "qpu", "--windows",
                     "3", "--calls", "10", "--num-reads", "3", "--quiet"]
        process = processes.Process(target=mortal, args=(arguments, environment, str(
            tmp_path / "stderr"), fatal, counted), daemon=True)
        process.start()
        process.join()
        assert process.exitcode in (0, -signal.SIGKILL), (tmp_path / "stderr").read_text()
        return process.exitcode
    assert run("whole.qsf", 0) == 0 and len(service.problems) == 10
    whole, bits = int(counted.read_text()), qb.load_samples(tmp_path / "whole.qsf").bits
    kills = int(os.environ.get("QSTEREO_KILLS", 4))
    while kills:
        for name in ("s.qsf", "s.qsf.journal"):
            (tmp_path / name).unlink(missing_ok=True)
        service.problems.clear()
        left = whole
        while run("s.qsf", rng.randint(1, left) if kills else 0) != 0:
            kills, left = kills - 1, max(
                whole // 8, left - int(counted.read_text()))
        assert len(service.problems) == 10
        assert (qb.load_samples(tmp_path / "s.qsf").bits == bits).all()
        assert not list(tmp_path.glob("*.job"))


def test_a_window_has_no_file():
    p = problem_of(random_problem(3, 12))
    part = qb.window(p, np.zeros(len(p), np.uint8), windows.plan(p, 12))
    with pytest.raises(qb.InputError, match="no file of its own"):
        part.save(io.BytesIO())


def test_an_answer_too_large_to_merge_stays_to_be_collected(
        core, tmp_path, main, service, monkeypatch):
    path, job = core[0], tmp_path / "s.qsf.job"
    monkeypatch.setattr(merging, "ENTRY_BYTES", 1 << 40)
    for words in (["solve", path, "-o", tmp_path / "s.qsf", "--solver", "hybrid-bqm"],
                  ["collect", job]):
        status, _, err = main(*words)
        assert status == 4 and "With --no-postprocess the samples are written" in err
        assert f"qstereo-bridge collect {job}" in err
        assert job.exists() and not (tmp_path / "s.qsf").exists()
    status, _, err = main("collect", job, "--no-postprocess")
    assert status == 0, err
    assert len(service.problems) == 1 and not job.exists()
    assert qb.load_samples(tmp_path / "s.qsf").records.size
