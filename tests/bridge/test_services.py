"""D-Wave's services through its real clients, on the loopback stand-in: what is sent, what comes
back, limits, messages."""

import base64
import io
import json
import math
import sys
import warnings
from dataclasses import replace
from types import SimpleNamespace

import dimod
import networkx as nx
import numpy as np
import pytest
from dwave.optimization import Model
from problems import Table, Toeplitz, all_states, grid, make, pack_qcf, random_problem
from service import TOKEN, described
from qstereo_bridge.desk import cli
from qstereo_bridge.ocean import hybrid, qpu, services
from qstereo_bridge.core import models, qsf, text
from qstereo_bridge.samplers import solvers

HYBRIDS = ["hybrid-bqm", "hybrid-cqm", "hybrid-nl"]
SERVICES = ["qpu", *HYBRIDS]
SMALL = grid(2, 2, 3)


def least(problem):
    return int(models.energies(problem, all_states(problem.linear.size)).min())


def solved(path):
    return qsf.parse_qsf(path.read_bytes())


@pytest.fixture
def solve(problem_file, tmp_path, main, service):
    """Solves tiny.qcf (or `problem`) and gives (status, stdout, stderr)."""
    def run(solver, *options, problem=None):
        if problem is not None:
            problem_file.write_bytes(pack_qcf(problem))
        return main("solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", solver, *options)
    return run


def sent(service):
    """The last problem: its data (decoded by dimod or dwave.optimization where it was uploaded) and
    its job."""
    job = list(service.problems.values())[-1].job
    if job["data"]["format"] == "qp":
        return None, job
    read = {"bqm": dimod.BinaryQuadraticModel.from_file,
            "cqm": dimod.ConstrainedQuadraticModel.from_file, "nl": Model.from_file}[job["type"]]
    return read(io.BytesIO(service.uploads[job["data"]["data"]]["whole"])), job


@pytest.mark.parametrize("immediate", [True, False], ids=["at once", "polled"])
@pytest.mark.parametrize("solver", SERVICES)
@pytest.mark.parametrize("problem", [SMALL, grid(2, 2, 3, dense=True)], ids=["sparse", "dense"])
def test_answers(solver, immediate, problem, solve, service, tmp_path):
    service.immediate, service.pending, service.delay = (immediate, 0 if immediate else 1, 0
                                                         if immediate else 1)
    status, out, err = solve(solver, "--json", problem=problem)
    found, read = json.loads(out), solved(tmp_path / "s.qsf")
    assert (status == 0 and "Traceback" not in err and sorted(path.name
                                                              for path in tmp_path.iterdir())
            == ["s.qsf", "tiny.qcf"])
    assert found["best_energy"] == found["energy"] == least(problem) and found["feasible"] >= 1
    assert ((read.records["energy"] == models.energies(problem, read.bits)).all()
            and read.solver == solver)
    (problem_id, at_service), = service.problems.items()
    assert (read.info["problem_id"] == problem_id and read.info["service_solver"]
            == at_service.job["solver"]["name"])
    assert read.info["parameters"]["label"] == "tiny" and at_service.label.startswith("tiny ")
    timing = read.info["timing"]
    assert ({"qpu_access_time"} < set(timing) and all(isinstance(value, (int, float))
                                                      for value in timing.values()))


def test_every_timing_key_of_the_qpu_is_kept(solve, tmp_path):
    from service import QPU_TIMING
    solve("qpu")
    assert solved(tmp_path / "s.qsf").info["timing"] == QPU_TIMING


def test_bqm_is_the_problem(solve, service):
    solve("hybrid-bqm", "--label", "a name", "--time-limit", 7)
    bqm, job = sent(service)
    assert (bqm == models.to_bqm(SMALL) and job["params"] == {"time_limit": 7}
            and job["label"].startswith("a name "))
    solve("hybrid-bqm")
    assert sent(service)[1]["params"] == {"time_limit": 3}


def test_cqm_is_the_problem_without_penalties(solve, service, tmp_path):
    solve("hybrid-cqm")
    cqm, job = sent(service)
    assert (len(cqm.constraints) == 4 and cqm.discrete == {0, 1, 2, 3}
            and job["params"] == {"time_limit": 5})
    states = all_states(12)
    assert np.allclose(cqm.objective.energies((states, range(12))), models.energies(SMALL, states,
        penalties=False))


def test_energies_of_infeasible_cqm_answers_are_h(solve, service, tmp_path):
    """The service leaves the penalties out of its energies, the .qsf has them in."""
    def spoil(answer):
        answer["data"] = dimod.SampleSet.from_samples_cqm(np.eye(12)[:2],
                                                          sent(service)[0]).to_serializable()
        assert answer["data"]["info"].keys() == {"constraint_labels"}
        return answer
    service.spoil = spoil
    status, out, _ = solve("hybrid-cqm", "--json", "--no-postprocess")
    assert status == 0 and json.loads(out)["feasible"] == 0
    read = solved(tmp_path / "s.qsf")
    assert ((read.records["energy"] == models.energies(SMALL, np.eye(12, dtype=np.uint8)[:2])).all()
            and "constraint_labels" not in read.info)


def nl_energies(problem, states):
    model = models.to_nl(problem)
    with model.lock():
        model.states.resize(1)
        decision, = model.iter_decisions()
        for state in states:
            decision.set_state(0, state)
            yield model.objective.state(0)


def test_nonlinear_models_have_the_energies_of_the_problem():
    """All labellings of one-hot problems, all states of others; groups of several sizes, tables and
    Toeplitz blocks, all weights."""
    one_hot = 0
    for problem in [*(random_problem(seed, 8) for seed in range(150)), grid(2, 2, 3),
                    grid(2, 2, 3, dense=True)]:
        states = all_states(problem.linear.size)
        if problem.one_hot.all():
            one_hot += 1
            states = states[models.feasible(problem, states)]
            starts = problem.starts
            decisions = [[int(state[a:b].argmax()) for a, b in zip(starts, starts[1:])]
                         for state in states]
        else:
            decisions = states
        assert list(nl_energies(problem, decisions)) == models.energies(problem, states).tolist()
    assert 10 < one_hot < 140


def test_blocks_as_arrays():
    for seed in range(60):
        problem = random_problem(seed)
        for block, raw in zip(problem.blocks, problem.raw.blocks):
            rows, columns = block.shape
            assert (block.tolist() == [[raw.entry(i, j) for j in range(columns)]
                                               for i in range(rows)])


def test_nonlinear_models_of_potts_are_small():
    """Neither the labels nor the weights become a table: nodes do not grow with the picture."""
    for dense in (False, True):
        small, large = (models.to_nl(grid(size, size, 8, dense)) for size in (3, 30))
        assert (small.num_nodes() == large.num_nodes() < 25
                and large.decision_state_size() == 8 * 900)


def test_nonlinear_without_one_hot_groups(solve, tmp_path):
    problem = make([3, 2], [Toeplitz((3, 2), 0, 0, np.array([-7], "<i4"))],
                   [{"weight": 1, "g": 0, "h": 1}], [4, -1, 2, -3, 5], [(0, 0)] * 2)
    assert solve("hybrid-nl", problem=problem)[0] == 0
    assert solved(tmp_path / "s.qsf").records["energy"].min() == least(problem)


# The quantum annealer.


def test_qpu_parameters(solve, service, tmp_path):
    assert solve("qpu", "--num-reads", 50, "--annealing-time", 35, "--chain-strength", 123,
                 "--no-postprocess")[0] == 0
    job, info = sent(service)[1], solved(tmp_path / "s.qsf").info
    assert job["params"] == {"num_reads": 50, "annealing_time": 35} and job["type"] == "ising"
    assert (info["chain_strength"] == 123 and info["chip"] == "Advantage2_mock"
            and "majority" in info["broken_chains"])
    assert solved(tmp_path / "s.qsf").records["occurrences"].sum() == 50
    assert solve("qpu", "--chain-strength", "auto")[0] == 0
    from dwave.embedding.chain_strength import uniform_torque_compensation
    expected = uniform_torque_compensation(models.to_bqm(SMALL).change_vartype("SPIN",
        inplace=False))
    assert solved(tmp_path / "s.qsf").info["chain_strength"] == pytest.approx(expected)


def test_parameters_by_their_own_names(solve, service, tmp_path):
    assert (solve("qpu", "--param", "auto_scale=false", "--param",
                  "anneal_schedule=[[0, 0], [5, 1]]")[0] == 0)
    params = sent(service)[1]["params"]
    assert params == {"num_reads": 1000, "auto_scale": False, "anneal_schedule": [[0, 0], [5, 1]]}
    assert solved(tmp_path / "s.qsf").info["parameters"]["auto_scale"] is False
    status, _, err = solve("qpu", "--param", "auto_scal=false")
    assert (status == 2 and "no parameter auto_scal; it has anneal_schedule" in err
            and len(service.problems) == 1)


def one_future(samples, variables, occurrences=None):
    return SimpleNamespace(sampleset=dimod.SampleSet.from_samples((samples, variables), "SPIN",
        energy=np.zeros(len(samples)), num_occurrences=occurrences), timing={})


def test_broken_chains_are_mended_by_majority():
    """Chains of three, two and one qubits on a problem of three variables; qubits in an order of
    their own."""
    problem = make([1, 1, 1], [], [], [1, 2, 3], [(0, 0)] * 3)
    job = SimpleNamespace(chains=[[5, 9, 7], [2, 4], [11]], warnings=[], chip=None, embedding={},
                          parameters={"chain_strength": 1})
    qubits = [11, 9, 4, 2, 5, 7]
    rows = {(1, 1, 1, 1, 1, 1): ([1, 1, 1], 0), (-1, 1, -1, 1, -1, -1): ([0, 1, 0], 2 / 3),
            (1, -1, -1, -1, 1, 1): ([1, 0, 1], 1 / 3)}
    answer = qpu.Qpu(problem, None).decode(one_future(list(rows), qubits, [3, 2, 1]), job)
    assert answer.bits.tolist() == [bits for bits, _ in rows.values()]
    assert (np.allclose(answer.broken, [share for _, share in rows.values()])
            and answer.occurrences.tolist() == [3, 2, 1])


def test_broken_chains_reach_the_samples_file(solve, service, tmp_path):
    """Every qubit of the answer at random: chains of more than one qubit break."""
    class Random:
        def sample(self, bqm, num_reads):
            rng = np.random.default_rng(1)
            return dimod.SampleSet.from_samples_bqm((rng.choice([-1, 1], (num_reads, len(bqm))),
                                                     list(bqm.variables)), bqm)
    service.sampler = Random()
    problem = grid(2, 2, 4, dense=True)
    status, _, err = solve("qpu", "--num-reads", 5, "--no-postprocess", problem=problem)
    read = solved(tmp_path / "s.qsf")
    assert (status == 0 and read.records["broken"].max() > 0
            and (read.records["broken"] != qsf.NO_CHAINS).all())
    assert ("warning: the best samples have broken chains" in err and any("broken" in said
        for said in read.info["warnings"]))
    assert read.info["embedding"]["longest_chain"] > 1 and 0 < read.info["mean_broken_share"] < 1


def test_warnings_in_plain_words(solve, tmp_path):
    wide = make([1, 1], [Table(np.array([[1]], "<i4"))], [{"weight": 1, "g": 0, "h": 1}],
                [5000, 0], [(0, 0)] * 2)
    assert ("warning: some coefficients are a thousand times smaller" in solve("qpu",
        problem=wide)[2])
    status, out, err = solve("qpu", "--chain-strength", 1, problem=grid(2, 2, 4, dense=True))
    assert status == 0 and "warning: couplings of the problem are as strong as the chains" in err
    assert solve("qpu", "--chain-strength", 1, "--quiet")[1:] == ("", "")


def test_coefficients_of_0_are_not_small_ones():
    import dimod
    bqm = dimod.BinaryQuadraticModel.from_ising({0: 0.0, 1: -1000.0}, {(0, 1): 1.0})
    assert not qpu.wide(bqm) and not qpu.wide(dimod.BinaryQuadraticModel(2, "SPIN"))
    bqm.add_linear(0, 0.5)
    assert qpu.wide(bqm)


def test_ocean_has_the_warnings_that_we_put_into_words():
    import dwave.system.warnings as ocean
    named = {name for name in vars(ocean) if name.endswith("Warning") and name != "UserWarning"}
    assert set(qpu.WARNINGS) == named


def test_embedding_of_the_user(solve, service, tmp_path):
    from qstereo_bridge.ocean import embedding
    with services.connect("qpu") as session:
        chip = embedding.Chip.of_solver(session.solver)
    found = embedding.find(embedding.Source.of(SMALL), chip, 7)
    (tmp_path / "e.json").write_text(found.to_json())
    assert solve("qpu", "--embedding", tmp_path / "e.json")[0] == 0
    lin = np.frombuffer(base64.b64decode(sent(service)[1]["data"]["lin"]), "<f8")
    used = {qubit for qubit, bias in zip(service.solvers["Advantage2_mock"]["properties"]["qubits"],
                                         lin) if not np.isnan(bias)}
    assert used == {qubit for chain in found.chains.values() for qubit in chain}
    (tmp_path / "e.json").write_text(replace(found, chains={**found.chains,
                                                            0: found.chains[1]}).to_json())
    status, _, err = solve("qpu", "--embedding", tmp_path / "e.json")
    assert (status == 3 and "e.json: on Advantage2_mock" in err
            and "embed the problem on this chip again" in err)
    (tmp_path / "e.json").write_text("{}")
    status, _, err = solve("qpu", "--embedding", tmp_path / "e.json")
    assert status == 3 and err.count("e.json") == 1 and "no embedding file" in err
    assert solve("qpu", "--embedding", tmp_path / "none.json")[0] == 4


def test_chip_of_the_solver_is_that_of_the_topology(service):
    from qstereo_bridge.ocean import embedding
    with services.connect("qpu") as session:
        chip, named = embedding.Chip.of_solver(session.solver), embedding.Chip.named("zephyr:3")
    assert (chip.digest, chip.family, chip.size) == (named.digest, named.family, named.size)


def test_an_embedding_is_looked_for_once(solve, monkeypatch):
    from qstereo_bridge.ocean import embedding
    problem = grid(3, 2, 3, dense=True)
    assert solve("qpu", problem=problem)[0] == 0
    monkeypatch.setattr(embedding, "find", None)
    assert solve("qpu", problem=problem)[0] == 0


@pytest.fixture
def small_chip(service):
    """The annealer of the service is a Zephyr of 2 x 2 tiles: each copy's search takes its time."""
    service.solvers.update(json.loads(described(tiles=2)))


def parts_sent(service):
    """The couplers sent with a bias tie qubits together: these parts, and h."""
    data, chip = sent(service)[1]["data"], service.solvers["Advantage2_mock"]["properties"]
    h = dict(zip(chip["qubits"], np.frombuffer(base64.b64decode(data["lin"]), "<f8")))
    used = {qubit for qubit, bias in h.items() if not np.isnan(bias)}
    active = [(p, q) for p, q in chip["couplers"] if p in used and q in used]
    graph = nx.Graph(pair for pair, bias in zip(active, np.frombuffer(
        base64.b64decode(data["quad"]), "<f8")) if bias)
    assert set(graph) == used
    return list(nx.connected_components(graph)), h


@pytest.mark.parametrize("missing", [0, 20])
@pytest.mark.parametrize("copies", [4, "auto"])
@pytest.mark.parametrize("problem", [SMALL, grid(2, 2, 3, dense=True)], ids=["sparse", "dense"])
def test_copies_share_a_read(problem, copies, missing, solve, small_chip, service, tmp_path):
    chip = service.solvers["Advantage2_mock"]["properties"]
    gone = set(np.random.default_rng(2).choice(chip["qubits"], missing, replace=False).tolist())
    chip.update(qubits=[qubit for qubit in chip["qubits"] if qubit not in gone],
                couplers=[pair for pair in chip["couplers"] if not gone & set(pair)])
    status, out, _ = solve("qpu", "--num-reads", 10, "--copies", copies, "--seed", 1, "--json",
                           problem=problem)
    read, (parts, h) = solved(tmp_path / "s.qsf"), parts_sent(service)
    found = read.info["embedding"]
    assert (status == 0 and len(parts) == found["copies"] == (max(5, len(parts)) if copies == "auto"
                                                              else 4))
    assert (sum(map(len, parts)) == found["qubits"] and sent(service)[1]["params"]
            == {"num_reads": 10})
    assert read.records["occurrences"].tolist() == [1] * 10 * len(parts)
    assert ((read.records["energy"] == models.energies(problem, read.bits)).all()
            and json.loads(out)["best_energy"] == least(problem))
    fields = sum(models.to_bqm(problem).change_vartype("SPIN", inplace=False).linear.values())
    assert ([sum(h[qubit] for qubit in part) for part in parts] == pytest.approx([fields]
        * len(parts)))


def test_copies_are_samples_of_their_own():
    """Two copies of two variables, a read after the other; each has its own share of broken chains.
    """
    problem = make([1, 1], [], [], [1, 2], [(0, 0)] * 2)
    job = SimpleNamespace(chains=[[0], [1, 2], [3, 5], [4]], warnings=[], chip=None,
                          embedding={"copies": 2}, parameters={"chain_strength": 1})
    answer = qpu.Qpu(problem, None).decode(one_future([(1, -1, -1, 1, -1, -1),
                                                       (-1, 1, 1, -1, 1, -1)], range(6), [3, 2]),
                                           job)
    assert answer.bits.tolist() == [[1, 0], [1, 0], [0, 1], [0, 1]]
    assert answer.broken.tolist() == [0, 0.5, 0, 0] and answer.occurrences.tolist() == [3, 3, 2, 2]


@pytest.mark.parametrize("counts", [[-1, 3], [0, 0], [2**40, 1]])
def test_reads_that_cannot_be_are_refused(counts):
    problem = make([1], [], [], [1], [(0, 0)])
    job = SimpleNamespace(chains=[[0]], warnings=[], chip=None, embedding={},
                          parameters={"chain_strength": 1})
    with warnings.catch_warnings(), pytest.raises(solvers.SolverError,
                                                  match="never seen, or too often"):
        warnings.simplefilter("error")
        qpu.Qpu(problem, None).decode(one_future([(1,), (-1,)], [0], np.array(counts)), job)


def test_reads_that_cannot_be_from_the_service(solve, service, tmp_path):
    def spoil(answer):
        counts = np.frombuffer(base64.b64decode(answer["num_occurrences"]), "<i4").copy()
        counts[0] = -1
        return {**answer, "num_occurrences": base64.b64encode(counts.tobytes()).decode()}
    service.spoil = spoil
    status, _, err = solve("qpu")
    assert (status == 5 and "never seen, or too often" in err and "Warning" not in err
            and not (tmp_path / "s.qsf").exists())


@pytest.mark.parametrize("solver", HYBRIDS)
def test_uploaded_file_is_closed(solver, solve, monkeypatch):
    files, prepare = [], hybrid.Hybrid.prepare

    def kept(*arguments):
        request = prepare(*arguments)
        files.append(request.upload)
        return request
    monkeypatch.setattr(hybrid.Hybrid, "prepare", kept)
    assert solve(solver)[0] == 0 and [file.closed for file in files] == [True]


def test_nonlinear_model_is_built_once(solve, monkeypatch):
    built, build = [], models.to_nl
    monkeypatch.setattr(models, "to_nl", lambda *arguments: built.append(1) or build(*arguments))
    assert solve("hybrid-nl")[0] == 0 and len(built) == 1


def test_copies_of_a_problem_that_fits_once(solve, service, tmp_path):
    from qstereo_bridge.ocean import embedding
    chip = service.solvers["Advantage2_mock"]["properties"]
    with services.connect("qpu") as session:
        found = embedding.find(embedding.Source.of(SMALL), embedding.Chip.of_solver(session.solver),
                               7)
    used = {qubit for chain in found.chains.values() for qubit in chain}
    chip.update(qubits=sorted(used), couplers=[pair for pair in chip["couplers"]
                                               if used >= set(pair)])
    status, _, err = solve("qpu", "--copies", 2)
    assert (status == 5 and "1 of 2 copies found" in err and "--copies auto" in err
            and "does not fit" not in err and not service.problems)
    assert (solve("qpu", "--copies", "auto")[0] == 0 and solved(tmp_path / "s.qsf").info[
        "embedding"]["copies"] == 1)


def test_copies_are_looked_for_once(solve, small_chip, monkeypatch, tmp_path):
    """Those of each number, and those of auto, beside the embedding of one."""
    from qstereo_bridge.ocean import embedding
    options = [("--copies", "auto"), ("--copies", 3), ()]
    def run():
        for more in options:
            assert solve("qpu", "--num-reads", 5, *more)[0] == 0
            yield solved(tmp_path / "s.qsf").info["embedding"]
    before = list(run())
    assert before[0]["copies"] > 3 and [one["copies"] for one in before[1:]] == [3, 1]
    monkeypatch.setattr(embedding, "find", None)
    assert list(run()) == before


def test_copies_are_collected(solve, tmp_path, main):
    assert solve("qpu", "--num-reads", 10, "--copies", 3, "--no-wait")[0] == 0
    assert (main("collect", tmp_path / "s.qsf.job")[0] == 0
            and len(solved(tmp_path / "s.qsf").records) == 30)


def test_dry_run_says_copies(solve, problem_file, main, service):
    dry_run = "solve", problem_file, "--solver", "qpu", "--dry-run", "--copies"
    assert ("copies" not in main(*dry_run, 1)[1] and json.loads(main(*dry_run, 3,
        "--json")[1])["copies"] == 3)
    assert "3 copies: 3,000 samples from 1,000 reads" in main(*dry_run, 3)[1]
    assert ("as many copies as are found on the chip, 1,000 samples of each" in main(*dry_run,
        "auto")[1])
    assert ("it does not fit" not in main(*dry_run, 28)[1] and "it does not fit" in main(*dry_run,
        29)[1] and not service.problems)
    assert main(*dry_run, 0)[0] == main(*dry_run, "some")[0] == 2


# Limits: nothing is sent.


@pytest.mark.parametrize("solver, name, properties, options, said",
                         [("hybrid-bqm", "hybrid_bqm_solver", {"maximum_number_of_variables": 11},
                           [], "12 variables, the service takes 11; hybrid-nl takes larger"),
                          ("hybrid-bqm", "hybrid_bqm_solver", {"maximum_number_of_biases": 35}, [],
                           "36 biases, the service takes 35"), ("hybrid-bqm", "hybrid_bqm_solver",
    {}, ["--time-limit", 2], "a time limit of 2 s, the service takes 3.0 to 3,600 s"),
                          ("hybrid-bqm", "hybrid_bqm_solver", {}, ["--time-limit", 4000],
                           "a time limit of 4000 s"), ("hybrid-cqm", "hybrid_cqm_solver",
                                                       {"maximum_number_of_constraints": 3}, [],
                                                       "4 constraints, the service takes 3"),
                          ("hybrid-cqm", "hybrid_cqm_solver", {}, ["--time-limit", 4],
                           "a time limit of 4 s"), ("hybrid-nl", "hybrid_nl_solver",
                                                    {"maximum_number_of_nodes": 5}, [],
                                                    "nodes, the service takes 5; take a"),
                          ("hybrid-nl", "hybrid_nl_solver", {"maximum_state_size": 5}, [],
                           "bytes of state, the service takes 5"), ("hybrid-nl", "hybrid_nl_solver",
    {"maximum_decision_state_size": 5}, [], "bytes of decisions, the service takes 5"),
                          ("hybrid-nl", "hybrid_nl_solver", {}, ["--time-limit", 1],
                           "a time limit of 1 s"), ("qpu", "Advantage2_mock", {},
                                                    ["--num-reads", 20000],
                                                    "20000 reads, this solver takes 1 to 10,000"),
                          ("qpu", "Advantage2_mock", {}, ["--annealing-time", 3000],
                           "3000 microseconds of annealing, this solver takes 0.5 to 2,000"),
                          ("qpu", "Advantage2_mock", {"qubits": [0], "couplers": []}, [],
                           "12 variables do not fit on a chip of 1 qubits"),
                          ("qpu", "Advantage2_mock", {}, ["--copies", 29],
                           "29 copies of 12 variables do not fit on a chip of 336 qubits"),
                          ("qpu", "Advantage2_mock", {"problem_run_duration_range": [0, 1e6]},
                           ["--num-reads", 10000, "--annealing-time", 2000], "allows 1 s"),
                          ("qpu", "hybrid_nl_solver", {},
                           ["--solver-name", "hybrid_nl_solver"], "no such solver"),
                          ("hybrid-nl", "hybrid_bqm_solver", {},
                           ["--solver-name", "hybrid_bqm_solver"], "is not a solver for hybrid-nl"),
                          ("hybrid-nl", "hybrid_bqm_solver", {}, ["--solver-name", "nothing"],
                           "no such solver")])
def test_limits(solver, name, properties, options, said, solve, service, tmp_path, main):
    """What `solve` refuses, the dry run says does not fit; where there is no such solver to ask it
    fails alike."""
    service.solvers[name]["properties"].update(properties)
    status, out, err = solve(solver, *options)
    assert (status, out) == (5, "") and said in err and err.count("\n") == 1
    dry_run = "solve", tmp_path / "tiny.qcf", "--solver", solver, "--dry-run", *options
    status, out, err = main(*dry_run)
    if "--solver-name" in options:
        assert (status, out) == (5, "") and said in err
    else:
        told = json.loads(main(*dry_run, "--json")[1])
        assert ((status, err) == (0, "") and f"it does not fit: {told['reason']}" in out
                and said in told["reason"] and told["fits"] is False)
    assert (not service.problems and not service.uploads
            and sorted(path.name for path in tmp_path.iterdir()) == ["tiny.qcf"])


def test_no_embedding(solve, service):
    service.solvers["Advantage2_mock"]["properties"].update(qubits=list(range(40)),
                                                            couplers=[[i, i + 1]
        for i in range(39)])
    status, _, err = solve("qpu")
    assert status == 5 and "does not fit on this chip: no embedding" in err and not service.problems


def test_solver_by_name(solve, service, tmp_path):
    from dwave.cloud.testing import mocks
    service.solvers["another"] = mocks.hybrid_nl_solver_data(name="another")
    assert solve("hybrid-nl", "--solver-name", "another")[0] == 0
    assert solved(tmp_path / "s.qsf").info["service_solver"] == "another"


# Messages.


@pytest.mark.parametrize("solver", SERVICES)
@pytest.mark.parametrize("method, path, how, said", [("GET", "solvers", 401,
                                                      "does not accept the token"),
                                                     ("GET", "solvers", 403,
                                                      "refuses it to this account"),
                                                     ("GET", "solvers", 429, "too many requests"),
                                                     ("GET", "solvers", 500, "error of its own"),
                                                     ("POST", "problems", 401,
                                                      "does not accept the token"),
                                                     ("POST", "problems", 403,
                                                      "refuses it to this account"),
                                                     ("POST", "problems", 400,
                                                      "D-Wave's service says: as it was told"),
                                                     ("POST", "problems", 404, "as it was told"),
                                                     ("POST", "problems", 429,
                                                      "too many requests")])
def test_refusals_before_anything_is_charged(solver, method, path, how, said, solve, service,
                                             tmp_path):
    service.fail(method, path, how, times=50)
    status, out, err = solve(solver)
    assert (status, out) == (5, "") and said in err and err.count("\n") == 1 and TOKEN not in err
    assert not service.problems and sorted(path.name for path in tmp_path.iterdir()) == ["tiny.qcf"]


def test_token_that_is_not_accepted(solve, service, monkeypatch):
    monkeypatch.setenv("DWAVE_API_TOKEN", TOKEN[:-1] + "8")
    status, _, err = solve("hybrid-nl")
    assert status == 5 and "does not accept the token" in err and "dwave config create" in err


def test_refused_by_the_solver(solve, service, monkeypatch):
    """The published range of reads says one thing, the service another."""
    service.solvers["Advantage2_mock"]["properties"]["num_reads_range"] = [1, 10]
    with monkeypatch.context() as patch:
        patch.setattr(qpu.Qpu, "refusal", lambda *arguments: None)
        status, _, err = solve("qpu", "--num-reads", 11)
    assert (status == 5 and "refuses the problem: num_reads must be in range [1, 10]" in err
            and not service.problems)


def errors():
    import dwave.cloud.exceptions as cloud
    return [(ValueError("API token not defined"), "dwave config create"),
            (cloud.ConfigFileReadError("gone"), "dwave config create"),
            (cloud.SolverAuthenticationError(), "does not accept the token"),
            (cloud.SolverNotFoundError(), "reaches no such solver"),
            (cloud.SolverOfflineError("asleep"), "is offline"), (cloud.CanceledFutureError(),
        "was cancelled"), (cloud.RequestTimeout(), "cannot be reached"), (cloud.PollingTimeout(),
        "cannot be reached"), (cloud.ProblemUploadError("part 1"), "cannot be reached"),
            (cloud.SolverFailureError("too many reads"), "says: too many reads"),
            (cloud.SolverError(error_msg="down", error_code=503), "error of its own"),
            (KeyError("x is not a parameter"), "not a parameter"), (ImportError("No module"),
        "pip install"), (cloud.InvalidAPIResponseError(f"token {TOKEN}"), "token (token)")]


@pytest.mark.parametrize("error, said", errors())
def test_errors_of_services(error, said):
    with pytest.raises(solvers.SolverError) as caught, services.explained():
        raise error
    assert (said in str(caught.value) and TOKEN not in str(caught.value)
            and "\n" not in str(caught.value))
    assert caught.value.__suppress_context__


def test_without_the_nonlinear_models(solve, service, problem_file, main, monkeypatch):
    monkeypatch.setitem(sys.modules, "dwave.optimization", None)
    for status, out, err in (solve("hybrid-nl"), main("solve", problem_file, "--solver",
                                                      "hybrid-nl", "--dry-run")):
        assert (status, out) == (5, "") and "pip install" in err and not service.problems


def test_tokens_of_the_configuration_are_left_out(monkeypatch, tmp_path):
    monkeypatch.setattr(text, "_hidden", set())
    monkeypatch.setenv("DWAVE_API_TOKEN", "short-secret")
    (tmp_path / "dwave.conf").write_text(
        "[defaults]\ntoken = from-the-file\n[one]\ntoken = e\n[two]\ntoken =  \n")
    monkeypatch.setenv("DWAVE_CONFIG_FILE", str(tmp_path / "dwave.conf"))
    said = services.explain(
                            ValueError(
        f"a short-secret, {TOKEN} and\nfrom-the-file\x1b[2J \u202e here"))
    assert said == "ValueError: a (token), (token) and (token)\\x1b[2J \\u202e here"


# Lists and plans.


def test_list_of_solvers(main, service):
    service.solvers["hybrid_nl_solver"]["status"] = "OFFLINE"
    status, out, err = main("solvers")
    assert ((status, err) == (0, "") and "zephyr:3" in out and "2000000 nodes" in out
            and "OFFLINE" in out)
    found = {one["name"]: one for one in json.loads(main("solvers", "--json")[1])["solvers"]}
    assert ({name: one["kind"] for name, one in found.items()} == {"Advantage2_mock": "qpu",
        "hybrid_bqm_solver": "hybrid-bqm", "hybrid_cqm_solver": "hybrid-cqm",
        "hybrid_nl_solver": "hybrid-nl"})
    assert (found["Advantage2_mock"]["limits"]["qubits"] == 336
            and not found["hybrid_nl_solver"]["online"])
    assert 0 <= found["hybrid_bqm_solver"]["load"] <= 1
    service.fail("GET", "solvers", 401, times=9)
    status, out, err = main("solvers")
    assert status == 5 and "does not accept the token" in err


@pytest.mark.parametrize("solver", SERVICES)
def test_dry_run_with_an_account_goes_by_the_solver(solver, problem_file, main, service):
    dry_run = "solve", problem_file, "--solver", solver, "--dry-run"
    status, out, err = main(*dry_run)
    assert ((status, err) == (0, "") and "as published" not in out and "estimated charge" in out
            and "nothing was sent" in out)
    found = json.loads(main(*dry_run, "--json")[1])
    assert (found["service_solver"] in service.solvers and found["charge_seconds"] > 0
            and found["variables"] == 12)
    for name in ("hybrid_bqm_solver", "hybrid_cqm_solver"):
        service.solvers[name]["properties"]["maximum_number_of_variables"] = 3
    service.solvers["hybrid_nl_solver"]["properties"]["maximum_number_of_nodes"] = 3
    service.solvers["Advantage2_mock"]["properties"].update(qubits=[0], couplers=[])
    assert "it does not fit" in main(*dry_run)[1] and not service.problems and not service.uploads


def planning(solver, problem, **options):
    options = SimpleNamespace(**{**cli.SOLVERS[solver].options, "solver": solver, **options})
    return cli.SOLVERS[solver].run(problem, options).plan(hybrid.PUBLISHED[solver])


@pytest.mark.parametrize("dense", [False, True])
def test_plans_agree_with_the_models(dense):
    problem = grid(5, 4, 4, dense)
    bqm, cqm, nl = models.to_bqm(problem), models.to_cqm(problem), models.to_nl(problem)
    plan = planning("hybrid-bqm", problem)
    with bqm.to_file(version=2) as file:
        assert plan["upload_bytes"] == len(file.read())
    assert ((plan["variables"], plan["quadratic_terms"]) == bqm.shape
            and plan["biases"] == sum(bqm.shape))
    plan = planning("hybrid-cqm", problem)
    assert plan["biases"] == cqm.num_biases() and plan["constraints"] == len(cqm.constraints)
    with cqm.to_file() as file:
        assert 0.8 < plan["upload_bytes"] / file.seek(0, 2) < 1.3
    plan = planning("hybrid-nl", problem)
    with nl.to_file() as file:
        assert plan["upload_bytes"] == file.seek(0, 2)
    assert (plan["nodes"], plan["bytes of decisions"]) == (nl.num_nodes(), 8 * 20)
    plan = planning("qpu", problem)
    assert (plan["upload_bytes"] == 4 * sum(math.ceil(8 * count / 3)
                                            for count in (4577, bqm.num_interactions)))


@pytest.mark.parametrize("options", [[], ["--copies", 3], ["--embedding", "E"],
                                     ["--num-reads", 2000, "--annealing-time", 70],
                                     ["--param", "anneal_schedule=[[0, 0], [40, 1]]"]])
def test_dry_run_of_a_known_embedding_is_exact(options, solve, service, tmp_path, main,
                                               monkeypatch):
    """Upload and charge are those of the problem that is sent, the charge by Ocean's own estimate
    of the parameters that were sent."""
    files = {"E": tmp_path.parent / f"{tmp_path.name}.json"}
    main("embed", tmp_path / "tiny.qcf", "--topology", "zephyr:3", "-o", files["E"])
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path.parent / f"{tmp_path.name}.cache"))
    options = [files.get(option, option) for option in options]
    dry_run = "solve", tmp_path / "tiny.qcf", "--solver", "qpu", "--dry-run", *options
    before = json.loads(main(*dry_run, "--json")[1])
    assert solve("qpu", *options)[0] == 0
    found, data, params = (json.loads(main(*dry_run, "--json")[1]), sent(service)[1]["data"],
                           sent(service)[1]["params"])
    qubits = solved(tmp_path / "s.qsf").info["embedding"]["qubits"]
    assert (found["upload_bytes"] == len(data["lin"]) + len(data["quad"])
            and found["embedded_qubits"] == qubits)
    with services.connect("qpu") as session:
        expected = session.solver.estimate_qpu_access_time(qubits, **params) / 1e6
    assert found["charge_seconds"] == pytest.approx(expected, rel=1e-12)
    if "--embedding" in options:
        assert before == found
    else:
        assert (before["upload_bytes"] <= found["upload_bytes"]
                and before["charge_seconds"] > found["charge_seconds"])
    assert (f"estimated charge {found['charge_seconds']:.3f} s" in main(*dry_run)[1]
            and len(service.problems) == 1)
    if "--embedding" not in options:
        assert json.loads(main(*dry_run, "--seed", 5, "--json")[1])["embedded_qubits"] is None


def test_dry_run_looks_at_the_files_that_it_is_given(problem_file, tmp_path, main, service):
    dry_run = "solve", problem_file, "--solver", "qpu", "--dry-run"
    assert main(*dry_run, "--embedding", tmp_path / "none.json")[0] == 4


@pytest.mark.parametrize("solver, options, said", [("hybrid-bqm", {"time_limit": 1},
                                                    "a time limit of 1 s"),
                                                   ("hybrid-nl", {"time_limit": 1},
                                                    "a time limit of 1 s"),
                                                   ("qpu", {"num_reads": 20000}, "20000 reads"),
                                                   ("qpu", {"copies": 500},
                                                    "500 copies of 12 variables do not fit")])
def test_plan_without_an_account_checks_as_much_as_is_published(solver, options, said):
    assert planning(solver, SMALL)["reason"] is None
    plan = planning(solver, SMALL, **options)
    assert plan["fits"] is False and said in plan["reason"]


@pytest.mark.parametrize("size, bqm, cqm", [((100, 100, 16), 600, 38), ((176, 178, 16), 600, 189)])
def test_least_time_limits(size, bqm, cqm):
    problem = grid(*size)
    assert planning("hybrid-bqm", problem)["minimum_time_limit"] == bqm
    assert planning("hybrid-cqm", problem)["minimum_time_limit"] == pytest.approx(cqm, rel=0.02)
    assert planning("hybrid-nl", problem)["minimum_time_limit"] == 5
    assert planning("hybrid-bqm", problem)["fits"] and not planning("qpu", problem)["fits"]


@pytest.mark.parametrize("name", HYBRIDS)
def test_least_times_are_those_of_oceans_samplers(name, service):
    import dwave.system
    problem = grid(30, 20, 4)
    sampler, build, least = {"hybrid-bqm": ("LeapHybridSampler", models.to_bqm, "min_time_limit"),
                             "hybrid-cqm": ("LeapHybridCQMSampler", models.to_cqm,
                                            "min_time_limit"), "hybrid-nl": ("LeapHybridNLSampler",
        models.to_nl, "estimated_min_time_limit")}[name]
    with getattr(dwave.system, sampler)() as sampler:
        expected = getattr(sampler, least)(build(problem))
        kind = cli.SOLVERS[name].run(problem, SimpleNamespace(time_limit=None))
        assert kind.least_time(sampler.properties) == pytest.approx(expected, rel=1e-12)


def test_plan_beyond_the_limits():
    problem = grid(384, 288, 16)
    assert (not planning("hybrid-bqm", problem)["fits"] and not planning("hybrid-cqm",
        problem)["fits"])
    assert planning("hybrid-nl", problem)["fits"]
    assert planning("qpu", SMALL)["fits"] is None
    assert planning("qpu", grid(41, 41, 4))["fits"] is False


def test_plan_of_repeated_pairs():
    """What cancels is not sent."""
    problem = make([1] * 3, [Table(np.array([[5]], "<i4"))],
                   [{"weight": 1, "h": 1}, {"weight": 2, "h": 1}, {"weight": 1, "h": 2},
                    {"weight": -1, "h": 2}], [0] * 3, [(0, 0)] * 3)
    assert planning("qpu", problem)["quadratic_terms"] == 1

def reversed_reads(problem, flips):
    """What the decoder makes of a read of all spins up, in copies with these flips."""
    n = problem.linear.size
    job = SimpleNamespace(chains=[[q] for q in range(len(flips) * n)], warnings=[], chip=None,
                          embedding={"copies": len(flips)}, parameters={"chain_strength": 1},
                          flips=flips)
    return qpu.Qpu(problem, None).decode(one_future([(1,) * len(flips) * n],
                                                    range(len(flips) * n)), job).bits.tolist()


def test_spin_reversals_are_undone():
    problem = make([1, 1], [], [], [1, 2], [(0, 0)] * 2)
    assert reversed_reads(problem, [[0, 0], [0, 1], [1, 0]]) == [[1, 1], [1, 0], [0, 1]]


@pytest.mark.parametrize("options", [["--spin-reversals", 1],
                                     ["--spin-reversals", 3, "--copies", 3]])
def test_spin_reversals_of_the_annealer_are_one_request(options, solve, service, tmp_path, main):
    """The fields that are sent have other signs; the samples are of the problem that was asked."""
    solve("qpu", "--seed", 1)
    plain = json.loads(json.dumps(sent(service)[1]["data"]))
    status, out, _ = solve("qpu", "--num-reads", 20, "--seed", 1, "--json", *options)
    read = solved(tmp_path / "s.qsf")
    assert status == 0 and len(service.problems) == 2 and sent(service)[1]["data"] != plain
    assert json.loads(out)["best_energy"] == least(SMALL)
    assert (read.records["energy"] == models.energies(SMALL, read.bits)).all()
    assert (read.info["parameters"]["spin_reversals"] == options[1]
            and "spin_reversals" not in sent(service)[1]["params"])
    assert solve("qpu", "--no-wait", *options)[0] == 0
    assert main("collect", tmp_path / "s.qsf.job", "--json")[0] == 0
    assert solved(tmp_path / "s.qsf").records["energy"].min() == least(SMALL)


def test_spin_reversals_that_would_be_charged_more_than_once(solve, service):
    status, _, err = solve("qpu", "--spin-reversals", 4)
    assert status == 5 and "--copies 4" in err and "each of which is charged" in err
    assert not service.problems
