"""Answers that cannot be: a clear error, exit status 5, and the job kept until a good one comes."""

import base64
import itertools
import zlib

import dimod
import numpy as np
import pytest
from problems import grid, pack_qcf
from service import MEDIA
from qstereo_bridge.ocean import services

SERVICES = ["qpu", "hybrid-bqm", "hybrid-cqm", "hybrid-nl"]


@pytest.fixture
def refused(problem_file, tmp_path, main, service):
    """Solves tiny.qcf, which the bad answer ends; once the answer is good, it is collected."""
    def run(solver, said, mend):
        samples = tmp_path / "s.qsf"
        status, out, err = main("solve", problem_file, "-o", samples, "--solver", solver)
        assert (status, out) == (5, "") and said in err and f"collect {samples}.job" in err, err
        assert err.count("\n") == 1 and len(err) < 1000 and "please report" not in err
        assert sorted(path.name for path in tmp_path.iterdir()) == ["s.qsf.job", "tiny.qcf"]
        mend()
        assert main("collect", f"{samples}.job")[0] == 0 and len(service.problems) == 1
        assert sorted(path.name for path in tmp_path.iterdir()) == ["s.qsf", "tiny.qcf"]
    service.immediate, service.delay = False, 1
    return run


@pytest.fixture
def spoiled(refused, service):
    """Like refused(), of an answer that went through `spoil`."""
    def run(solver, spoil, said):
        def mend():
            service.spoil = None
            for problem in service.problems.values():
                problem.answer = None
        service.spoil = spoil
        refused(solver, said, mend)
    return run


def changed(answer, change):
    """The answer of a hybrid solver with change(samples, energies) in place of both."""
    whole = dimod.SampleSet.from_serializable(answer["data"])
    samples, energies = change(whole.record.sample.astype(float), whole.record.energy.astype(float))
    found = dimod.SampleSet.from_samples((samples, list(whole.variables)), "INTEGER", energies)
    return {**answer, "data": found.to_serializable()}


def put(array, value):
    array = array.copy()
    array.flat[0] = value
    return array


@pytest.mark.parametrize("solver", ["hybrid-bqm", "hybrid-cqm"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_energies_that_are_no_numbers(solver, value, spoiled):
    """JSON has no word for them, and they end as a reply that cannot be read."""
    spoiled(solver, lambda answer: changed(answer, lambda x, e: (x, put(e, value))),
            "cannot be read")


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_energies_of_the_annealer_that_are_no_numbers(value, spoiled):
    def spoil(answer):
        energies = put(np.frombuffer(base64.b64decode(answer["energies"]), "<f8"), value)
        return {**answer, "energies": base64.b64encode(energies.tobytes()).decode()}
    spoiled("qpu", spoil, "energies that are not numbers")


@pytest.mark.parametrize("solver", ["hybrid-bqm", "hybrid-cqm"])
@pytest.mark.parametrize("value, said", [(2, "0 and 1"), (-1, "0 and 1"), (0.5, "0 and 1"),
                                         (np.nan, "cannot be read")])
def test_values_other_than_0_and_1(solver, value, said, spoiled):
    """JSON has no word for what is no number."""
    spoiled(solver, lambda answer: changed(answer, lambda x, e: (put(x, value), e)), said)


@pytest.mark.parametrize("value", [3, -1])
@pytest.mark.parametrize("one_hot", [True, False])
def test_decisions_outside_their_bounds(value, one_hot, spoiled, service, problem_file):
    """As the state file holds them: one double for each decision."""
    if not one_hot:
        problem_file.write_bytes(pack_qcf(grid(2, 2, 3), penalties=[(0, 0)] * 4))

    def spoil(answer):
        from dwave.optimization import Model
        model = Model()
        decision = model.integer(4 if one_hot else 12, lower_bound=-5, upper_bound=5)
        model.minimize(decision.sum())
        model.states.resize(1)
        with model.lock():
            decision.set_state(0, [value] + [0] * (3 if one_hot else 11))
            with model.states.to_file() as file:
                service.answers.update(dict.fromkeys(service.answers, file.read()))
        return answer
    spoiled("hybrid-nl", spoil, "answer")


@pytest.mark.parametrize("spoil", [lambda answer: {**answer, "solutions": answer["solutions"][:8]},
                                   lambda answer: {**answer,
                                                   "active_variables": base64.b64encode(np.arange(3,
    dtype="<i4").tobytes()).decode()}, lambda answer: {**answer,
                                                       "active_variables": base64.b64encode(
    np.full(24, 9999, "<i4").tobytes()).decode()}, lambda answer: {**answer,
    "energies": answer["energies"][:8]}, lambda answer: {**answer, "solutions": "!"},
                                   lambda answer: {**answer, "format": "other"},
                                   lambda answer: {"format": "qp"}, lambda answer: {},
                                   lambda answer: None])
def test_answers_of_the_annealer_of_wrong_length(spoil, spoiled):
    spoiled("qpu", spoil, "")


@pytest.mark.parametrize("solver", SERVICES[1:])
@pytest.mark.parametrize("answer", [{}, None, [], {"format": "bq"}, {"format": "bq", "data": {}},
                                    {"format": "binary-ref"}])
def test_answers_without_content(solver, answer, spoiled):
    spoiled(solver, lambda _: answer, "")


def bomb():
    """A compressed body of 10 MB that unpacks to 10 GB of blanks: the same block of it again and
    again."""
    packer = zlib.compressobj(9, zlib.DEFLATED, 31)
    mebibyte = bytes([32]) * (1 << 20)
    first, block = (packer.compress(mebibyte) + packer.flush(zlib.Z_FULL_FLUSH) for _ in range(2))
    return itertools.chain([first], itertools.repeat(block, 10 << 10))


@pytest.mark.parametrize("solver, path", [("qpu", r"^problems/.+"), ("hybrid-bqm", r"^problems/.+"),
                                          ("hybrid-nl", r"^problems/.+"),
                                          ("hybrid-nl", "^answers/"), ("hybrid-nl", "^problems/$")])
def test_replies_that_unpack_to_more_than_there_is_room_for(solver, path, refused, service,
                                                            monkeypatch):
    monkeypatch.setattr(services, "LARGEST_REPLY", 16 << 20)
    media = "problems" if path.endswith("$") else "problem"
    headers = {"Content-Type": MEDIA.format(media), "Content-Encoding": "gzip"}
    service.fail("GET", path, lambda: (headers, bomb()), times=99)
    refused(solver, "unpacks to more than 16 MiB", service.faults.clear)


@pytest.mark.parametrize("solver, path", [("qpu", r"^problems/.+"), ("hybrid-bqm", r"^problems/.+"),
                                          ("hybrid-nl", "^answers/"),
                                          ("hybrid-cqm", "^problems/$")])
@pytest.mark.parametrize("body", [[], [b"\x00"], [b"{"], [b"null"]])
def test_replies_with_nothing_in_them(solver, path, body, refused, service):
    media = "problems" if path.endswith("$") else "problem"
    service.fail("GET", path, lambda: ({"Content-Type": MEDIA.format(media)}, body), times=99)
    refused(solver, "", service.faults.clear)


def test_a_garbled_compression(refused, service):
    headers = {"Content-Type": MEDIA.format("problem"), "Content-Encoding": "gzip"}
    service.fail("GET", r"^problems/.+", lambda: (headers, [b"no gzip"]), times=99)
    refused("hybrid-bqm", "cannot be read", service.faults.clear)
