"""The face for Python, the files of `export`, and the inspector."""

import io
import json
import subprocess
import sys
import types

import dimod
import numpy as np
import pytest
import qstereo_bridge as qb
from dimod.serialization import coo
from hypothesis import given, settings
from hypothesis import strategies as st
from problems import (
    Table,
    all_states,
    domain_walls,
    energy_by_definition,
    grid,
    make,
    nothing,
    pack_qcf,
    random_problem,
)
from qstereo_bridge.core import models
from qstereo_bridge.samplers import windows


def problem_of(problem):
    return qb.load(io.BytesIO(pack_qcf(problem)))


SEEDS = st.integers(0, 2**32 - 1)


def some(seed, variables=9):
    return problem_of(random_problem(seed, variables))


@settings(deadline=None, max_examples=40)
@given(SEEDS)
def test_models_and_energies(seed):
    problem = random_problem(seed, 9)
    p, states = problem_of(problem), all_states(problem.linear.size)
    expected = [energy_by_definition(problem, x) for x in states.tolist()]
    assert (
        p.energies(states).tolist() == expected and p.energies(states[0]).tolist() == expected[:1]
    )
    assert p.to_bqm().energies((states, range(len(p)))).tolist() == expected
    sound = p.feasible(states.tolist())
    assert [
        p.to_cqm().check_feasible(dict(enumerate(x))) for x in states.tolist()
    ] == sound.tolist()


def test_nonlinear_model():
    p = problem_of(grid(2, 2, 3))
    model = p.to_nl()
    with model.lock():
        model.states.resize(1)
        next(model.iter_decisions()).set_state(0, [0, 1, 2, 0])
        assert model.objective.state(0) == p.energies(np.eye(3, dtype=int)[[0, 1, 2, 0]].ravel())[0]


@settings(deadline=None, max_examples=60)
@given(SEEDS)
def test_parts_share_no_coupling(seed):
    p = some(seed, 14)
    parts = p.parts()
    assert sorted(np.concatenate(parts).tolist()) == list(range(len(p)))
    assert [part.size for part in parts] == sorted((part.size for part in parts), reverse=True)
    of = np.empty(len(p), int)
    for k, part in enumerate(parts):
        of[part] = k
    _, (rows, columns, _), _ = models.expand(p)
    assert (of[rows] == of[columns]).all()


def test_parts_are_connected():
    assert [part.size for part in problem_of(grid(5, 4, 3)).parts()] == [60]
    assert [
        part.tolist()
        for part in problem_of(
            make(
                [1, 2, 1],
                [Table(np.ones((1, 1), "<i4"))],
                [{"weight": 1, "g": 0, "h": 2}],
                [0] * 4,
                [(0, 0)] * 3,
            )
        ).parts()
    ] == [[0, 3], [1, 2]]
    assert problem_of(nothing()).parts() == []


@pytest.mark.parametrize("vartype", ["BINARY", "SPIN"])
@pytest.mark.parametrize("seed", range(6))
def test_samples_in_any_order(vartype, seed, tmp_path):
    p, rng = some(seed), np.random.default_rng(seed)
    order, bits = rng.permutation(len(p)), rng.integers(0, 2, (5, len(p)))
    values = bits if vartype == "BINARY" else 2 * bits - 1
    found = dimod.SampleSet.from_samples(
        (values[:, order], order.tolist()),
        vartype,
        energy=[0] * 5,
        num_occurrences=[1, 2, 3, 4, 5],
        info={"a": np.float64(1)},
        sort_labels=False,
    )
    s = p.samples(found, "mine")
    assert (
        (s.bits == bits).all()
        and (s.records["energy"] == p.energies(bits)).all()
        and s.solver == "mine"
    )
    s.save(tmp_path / "s.qsf")
    again = qb.load_samples(tmp_path / "s.qsf")
    assert (
        again.info == {"a": 1}
        and again.digest == p.digest
        and again.records["occurrences"].tolist() == [1, 2, 3, 4, 5]
    )
    back = again.sampleset(p)
    assert (
        (back.record.sample == bits).all()
        and (back.record.energy == p.energies(bits)).all()
        and back.vartype is dimod.BINARY
    )
    assert "chain_break_fraction" not in back.record.dtype.names
    stream = io.BytesIO()
    again.save(stream)
    assert (
        stream.getvalue() == (tmp_path / "s.qsf").read_bytes()
        and len(list(tmp_path.iterdir())) == 1
    )


def test_broken_chains_are_kept():
    p = problem_of(grid(1, 1, 2))
    found = dimod.SampleSet.from_samples(
        [[0, 1]], "BINARY", energy=[0], chain_break_fraction=[0.25]
    )
    assert p.samples(found).sampleset(p).record.chain_break_fraction.tolist() == [0.25]


def test_any_sampler(problem_file, tmp_path):
    p = qb.load(problem_file)
    s = p.sample(dimod.ExactSolver())
    assert s.solver == "ExactSolver" and s.bits.shape == (4096, 12)
    assert s.records["energy"].min() == p.energies(all_states(12)).min()
    s = p.sample(
        dimod.StructureComposite(dimod.RandomSampler(), range(12), p.to_bqm().quadratic),
        num_reads=3,
    )
    assert s.bits.shape == (3, 12)
    with open(problem_file, "rb") as stream:
        assert qb.load(stream).digest == p.digest


def test_errors(problem_file, tmp_path):
    p = qb.load(problem_file)
    with pytest.raises(qb.FileError, match="none.qcf: cannot read: No such file"):
        qb.load(tmp_path / "none.qcf")
    with pytest.raises(qb.FileError, match="cannot write: there is no folder"):
        p.sample(dimod.RandomSampler(), num_reads=1).save(tmp_path / "none" / "s.qsf")
    with pytest.raises(qb.OverLimit, match="tiny.qcf: "):
        qb.load(problem_file, memory_limit=100)
    problem_file.write_bytes(problem_file.read_bytes()[:-1])
    with pytest.raises(qb.Truncated, match="tiny.qcf: byte") as caught:
        qb.load(problem_file)
    assert caught.value.status == 3
    for bits in ([[0, 1]], np.full((2, 12), 2), np.zeros((1, 1, 12))):
        with pytest.raises(qb.InputError, match="bits are 0 and 1 in an array"):
            p.energies(bits)
    with pytest.raises(ValueError, match="no method sample"):
        p.sample(object())
    with pytest.raises(qb.SolverError, match="not the 12"):
        p.samples(dimod.SampleSet.from_samples([[0, 1]], "BINARY", energy=[0]))
    with pytest.raises(qb.InputError, match="of another problem"):
        p.sample(dimod.RandomSampler(), num_reads=1).sampleset(some(1))
    for error in ("FileError", "OverLimit", "Truncated", "InputError", "SolverError"):
        assert issubclass(getattr(qb, error), qb.Error)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        qb.nothing  # noqa: B018


def test_core_needs_numpy_and_dimod_alone(problem_file):
    """In a process in which nothing of the extras can be imported."""
    code = f"""
import sys
for name in "dwave minorminer networkx scipy matplotlib click highspy orjson".split():
    sys.modules[name] = None
import dimod, qstereo_bridge as qb
p = qb.load({str(problem_file)!r})
s = p.sample(dimod.ExactSolver())
p.to_cqm(), p.parts(), s.sampleset(p)
print(s.records["energy"].min())"""
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (
        found.stderr == ""
        and int(found.stdout) == models.energies(grid(2, 2, 3), all_states(12)).min()
    )


@pytest.mark.parametrize(
    "make_one",
    [lambda: grid(3, 2, 3), lambda: domain_walls(2, 2, 4)[0], lambda: random_problem(3), nothing],
)
def test_export(make_one, tmp_path, main):
    problem = make_one()
    (tmp_path / "p.qcf").write_bytes(pack_qcf(problem))
    p = qb.load(tmp_path / "p.qcf")
    bqm, states = p.to_bqm(), np.random.default_rng(1).integers(0, 2, (64, len(p)))
    for end in ("bqm", "coo", "lp", "qubo"):
        status, out, err = main("export", tmp_path / "p.qcf", "-o", tmp_path / f"x.{end}", "--json")
        assert (status, err) == (0, "") and json.loads(out)["variables"] == len(p)
        assert json.loads(out)["bytes"] == (tmp_path / f"x.{end}").stat().st_size
    assert dimod.BinaryQuadraticModel.from_file((tmp_path / "x.bqm").read_bytes()) == bqm
    text = (tmp_path / "x.coo").read_text()
    read = coo.loads(text)
    read.offset = int(text.split("# offset ")[1].split()[0])
    assert read == bqm
    words = [line.split() for line in (tmp_path / "x.qubo").read_text().splitlines()]
    ((_, _, _, n, nodes, couplers),) = [line for line in words if line[0] == "p"]
    terms = [tuple(map(int, line)) for line in words if line[0] not in "cp"]
    assert int(n) == len(p) and int(nodes) + int(couplers) == len(terms)
    read = dimod.BinaryQuadraticModel({v: 0 for v in range(len(p))}, {}, int(words[0][2]), "BINARY")
    for u, v, value in terms:
        read.add_linear(u, value) if u == v else read.add_quadratic(u, v, value)
    assert read == bqm
    if len(p):
        states[0] = windows.begin(p)
        assert p.feasible(states[0]).all()
        cqm = dimod.lp.load(str(tmp_path / "x.lp"))
        cqm.relabel_variables({f"x{v}": v for v in range(len(p))})
        assert cqm.objective.is_equal(p.to_cqm().objective) and len(cqm.constraints) == len(
            p.to_cqm().constraints
        )
        assert [cqm.check_feasible(dict(enumerate(x))) for x in states.tolist()] == p.feasible(
            states
        ).tolist()


def test_export_refuses(problem_file, tmp_path, main):
    for name in ("p.xyz", "-"):
        status, out, err = main("export", problem_file, "-o", name)
        assert (status, out) == (2, "") and err.count("\n") == 1
    status, _, err = main("export", problem_file, "-o", tmp_path / "none" / "p.coo")
    assert status == 4 and "there is no folder" in err
    problem_file.write_bytes(b"")
    assert (
        main("export", problem_file, "-o", tmp_path / "p.coo")[0] == 3
        and not (tmp_path / "p.coo").exists()
    )


@pytest.fixture
def inspector(monkeypatch):
    """What the inspector would have been given: D-Wave's own needs a browser and an account."""
    import dwave.system

    shown, module = [], types.ModuleType("dwave.inspector")
    module.show = lambda *arguments, **named: shown.append((*arguments, named))
    monkeypatch.setitem(sys.modules, "dwave.inspector", module)
    monkeypatch.setattr("dwave.inspector", module, raising=False)
    monkeypatch.setattr(dwave.system, "DWaveSampler", lambda solver: solver)
    return shown


def test_inspect(inspector, problem_file, tmp_path, main):
    p = qb.load(problem_file)
    s = p.sample(dimod.RandomSampler(), num_reads=2)
    s.save(tmp_path / "s.qsf")
    assert main("inspect", tmp_path / "s.qsf", "--problem", problem_file)[0] == 3
    s.solver, s.info = "qpu", {
        "chains": [[v] for v in range(12)],
        "chain_strength": 2.5,
        "service_solver": "chip",
        "warnings": ["some chains are long"],
    }
    s.save(tmp_path / "s.qsf")
    status, _, err = main("inspect", tmp_path / "s.qsf")
    assert status == 2 and "--problem" in err
    assert main("inspect", tmp_path / "s.qsf", "--problem", problem_file) == (0, "", "")
    ((bqm, sampleset, sampler, _),) = inspector
    assert bqm == p.to_bqm() and (sampleset.record.sample == s.bits).all() and sampler == "chip"
    # What D-Wave's inspector 0.5.5 looks into; it fails on warnings that are no dicts.
    assert sampleset.info["embedding_context"] == {
        "embedding": {v: [v] for v in range(12)},
        "chain_strength": 2.5,
    }
    assert "warnings" not in sampleset.info
    del s.info["chains"]
    s.save(tmp_path / "s.qsf")
    status, _, err = main("inspect", tmp_path / "s.qsf", "--problem", problem_file)
    assert status == 2 and "give --embedding" in err
    status, _, err = main(
        "inspect", tmp_path / "s.qsf", "--problem", problem_file, "--embedding", problem_file
    )
    assert status == 3 and "no embedding file" in err


def test_inspect_without_the_inspector(tmp_path, main, monkeypatch):
    monkeypatch.setitem(sys.modules, "dwave.inspector", None)
    status, _, err = main("inspect", tmp_path / "s.qsf", "--problem", "p.qcf")
    assert status == 4 and "dwave install inspector" in err


@pytest.mark.parametrize(
    "arguments, extra",
    [
        (["solve", "P", "-o", "S"], "dwave"),
        (["solve", "P", "-o", "S", "--solver", "ilp"], "exact"),
        (["solve", "P", "-o", "S", "--solver", "tabu"], "dwave"),
        (["solve", "P", "-o", "S", "--solver", "qpu"], "dwave"),
        (["solve", "P", "-o", "S", "--solver", "hybrid-nl"], "dwave"),
        (["solve", "P", "-o", "S", "--solver", "hybrid-bqm"], "dwave"),
        (["solve", "P", "--solver", "hybrid-cqm", "--dry-run"], "dwave"),
        (["solvers"], "dwave"),
        (["embed", "P", "-o", "S", "--topology", "zephyr:3"], "dwave"),
        (["solve", "P", "-o", "S", "--solver", "exact"], None),
        (["solve", "P", "-o", "S", "--solver", "dimod:ExactSolver"], None),
        (["export", "P", "-o", "x.lp"], None),
    ],
)
def test_command_without_extras(arguments, extra, problem_file, tmp_path, environment):
    """One sentence says what to install; what needs no extra works."""
    code = """
import sys
for name in ("dwave", "minorminer", "networkx", "scipy", "matplotlib"):
    sys.modules[name] = None
from qstereo_bridge.desk.cli import main
sys.exit(main(sys.argv[1:]))"""
    words = [str(problem_file) if word == "P" else word for word in arguments]
    found = subprocess.run(
        [sys.executable, "-c", code, *words],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=environment,
    )
    if extra is None:
        assert (found.returncode, found.stderr) == (0, "")
    else:
        assert (
            found.returncode == 5
            and found.stderr.count("\n") == 1
            and f"pip install './bridge[{extra}]'" in found.stderr
        )
