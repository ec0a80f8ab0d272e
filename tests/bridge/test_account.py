"""What a user does with the account: its configuration, what comes from the service in messages,
and the bill beforehand."""

import json
import threading

import dimod
import numpy as np
import pytest
from problems import grid, pack_qcf
from service import TOKEN
from qstereo_bridge.runs import jobs
from qstereo_bridge.core import output, text
from qstereo_bridge.ocean import qpu, services
from qstereo_bridge.samplers import solvers

HOSTILE = "a\x1b[2J\x9bm\u202eb"
HARMLESS = r"a\x1b[2J\x9bm\u202eb"


@pytest.fixture(autouse=True)
def nothing_hidden(monkeypatch):
    monkeypatch.setattr(text, "_hidden", set())


@pytest.fixture
def solve(problem_file, tmp_path, main, service):
    def run(solver="hybrid-nl", *options):
        return main("solve", problem_file, "-o", tmp_path / "s.qsf", "--solver", solver, *options)
    return run


@pytest.fixture
def configure(tmp_path, monkeypatch):
    """Writes dwave.conf and has it taken, without the environment's account."""
    def write(content):
        path = tmp_path / "dwave.conf"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        for name in ("TOKEN", "ENDPOINT"):
            monkeypatch.delenv(f"DWAVE_API_{name}")
        monkeypatch.setenv("DWAVE_CONFIG_FILE", str(path))
    return write


# Configurations.


@pytest.mark.parametrize("token", [f" {TOKEN}", f"{TOKEN}\n", f"\t{TOKEN} \r\n"])
def test_a_token_with_blanks_around_it(token, solve, monkeypatch):
    monkeypatch.setenv("DWAVE_API_TOKEN", token)
    assert solve()[0] == 0


@pytest.mark.parametrize("content, said", [("[defaults]\ntoken =\n",
                                            "token of your D-Wave account is empty"),
                                           ("[defaults]\ntoken = \t\n", "is empty"),
                                           ("[defaults]\nendpoint = https://x\n",
                                            "no D-Wave account is configured"),
                                           (
    "[defaults]\ntoken = 12345678\nendpoint = cloud.example.com/sapi\n",
    "cloud.example.com/sapi does not begin with https://"),
                                           (
    f"[defaults]\ntoken = 12345678\nendpoint = ftp://{HOSTILE}\n",
    f"ftp://{HARMLESS} does not begin with https://"), (
    "[defaults]\ntoken = 12345678\nendpoint = http://cloud.example.com/\n", "is plain http"),
                                           (
    "[defaults]\ntoken = 12345678\nendpoint = http://127.0.0.1.example.com/\n", "is plain http"),
                                           (b"[defaults]\ntoken = \xff\xfe\n",
                                            "configuration file cannot be used"),
                                           ("no section\n", "configuration file cannot be used")])
def test_configurations_that_cannot_be_meant(content, said, configure, solve):
    configure(content)
    status, out, err = solve()
    assert ((status, out) == (5, "") and said in err and err.count("\n") == 1
            and "Error:" not in err and "12345678" not in err)


def test_a_profile_that_there_is_not(solve, monkeypatch):
    monkeypatch.setenv("DWAVE_PROFILE", "prodd")
    status, _, err = solve()
    assert (status == 5 and "'prodd' not found" in err and "dwave config" in err
            and "ValueError" not in err)


@pytest.mark.parametrize("endpoint", ["http://127.0.0.1:9/", "http://localhost:9/",
                                      "http://[::1]:9/", "https://example.com"])
def test_endpoints_that_are_taken(endpoint, monkeypatch):
    monkeypatch.setenv("DWAVE_API_ENDPOINT", endpoint)
    monkeypatch.setenv("DWAVE_API_TOKEN", TOKEN)
    assert services.configuration() == {"token": TOKEN, "endpoint": endpoint}


def test_plain_http_where_it_is_asked_for(monkeypatch):
    monkeypatch.setenv("DWAVE_API_TOKEN", TOKEN)
    monkeypatch.setenv("DWAVE_API_ENDPOINT", "http://example.com")
    for allowed, takes in (("", False), ("0", False), ("1", True)):
        monkeypatch.setenv("QSTEREO_PLAIN_HTTP", allowed)
        if takes:
            assert services.configuration()["endpoint"] == "http://example.com"
        else:
            with pytest.raises(solvers.SolverError, match="plain http"):
                services.configuration()


# What the service says.


def test_a_refusal_is_made_harmless(solve, service, monkeypatch):
    handler = service.server.RequestHandlerClass
    said = {"error_code": 400, "error_msg": f"{HOSTILE}\n{TOKEN} no"}
    monkeypatch.setattr(handler, "_create", lambda self, job: said)
    status, _, err = solve()
    assert (status == 5 and f"refuses the problem: {HARMLESS} (token) no" in err
            and "\x1b" not in err and err.count("\n") == 1)


def test_an_error_is_made_harmless(solve, service, monkeypatch):
    monkeypatch.setattr(service.server.RequestHandlerClass, "_solvers",
                        lambda *_: (403, {"error_code": 403, "error_msg": HOSTILE}))
    handler = service.server.RequestHandlerClass
    monkeypatch.setattr(handler, "ROUTES", [(r"GET solvers.*",
                                             lambda *_: (403,
                                                         {"error_code": 403,
                                                          "error_msg": HOSTILE}))])
    status, _, err = solve()
    assert status == 5 and err.isascii() and "\x1b" not in err


def test_where_a_redirect_leads_is_made_harmless(solve, service):
    service.elsewhere = f"http://user:{TOKEN}@example.com/\x7f"
    service.fail("POST", "^problems", 307)
    status, _, err = solve()
    assert (status == 5 and "has moved" in err and "\x7f" not in err and TOKEN not in err
            and not service.problems)


def test_names_of_solvers_are_made_harmless(main, service):
    data = service.solvers.pop("hybrid_nl_solver")
    data["identity"] = {**data["identity"], "name": HOSTILE}
    service.solvers[HOSTILE] = data
    status, out, err = main("solvers")
    assert (status, err) == (0, "") and HARMLESS in out and "\x1b" not in out


# Names of today.


def test_stride_is_the_nonlinear_solver(solve, service, main, problem_file):
    assert solve("stride")[0] == 0 and next(iter(service.problems.values())).job["type"] == "nl"
    assert ("Stride" in main("solve", problem_file, "--solver", "hybrid-nl", "--dry-run")[1]
            and "Stride" in main("solvers")[1])
    assert solve("stride", "--no-wait")[0] == 0


# The bill.


@pytest.fixture
def frames(tmp_path):
    for number in range(3):
        (tmp_path / f"frame{number}.qcf").write_bytes(pack_qcf(grid(2, 2, 3, seed=number)))
    return sorted(tmp_path.glob("frame*.qcf"))


@pytest.mark.parametrize("solver, each", [("hybrid-nl", 5), ("hybrid-bqm", 3), ("qpu", None)])
def test_a_dry_run_of_many_adds_up_the_bill(solver, each, frames, tmp_path, main, service):
    many = "solve", *frames, "--out-dir", tmp_path / "out", "--solver", solver
    found = json.loads(main(*many, "--dry-run", "--json")[1])
    charges = [one["charge_seconds"] for one in found["problems"]]
    assert (found["charge_seconds"] == pytest.approx(sum(charges)) and len(charges) == 3
            and all(charges))
    assert each is None or charges == [each] * 3
    status, out, err = main(*many, "--dry-run")
    assert ((status, err) == (0, "") and out.count("\n") == 4
            and f"in all {sum(charges):,.3f} s" in out and "3 problems" in out)
    assert not service.problems and not (tmp_path / "out").exists()
    assert main("solve", frames[0], "--out-dir", tmp_path / "out", "--solver", solver)[0] == 0
    found = json.loads(main(*many, "--dry-run", "--json")[1])
    assert (found["problems"][0]["skipped"] and found["charge_seconds"]
            == pytest.approx(sum(one["charge_seconds"] for one in found["problems"][1:])))


def test_a_dry_run_of_many_here(frames, tmp_path, main):
    status, out, err = main("solve", *frames, "--out-dir", tmp_path / "out", "--solver", "anneal",
                            "--dry-run")
    assert (status, err) == (0, "") and "3 problems; runs on this machine" in out


def test_a_charge_that_is_too_high_is_refused(solve, service, tmp_path):
    for solver, charge, more in (("hybrid-nl", 5, ()), ("hybrid-bqm", 3, ()),
                                 ("hybrid-bqm", 9, ("--time-limit", 9))):
        status, out, err = solve(solver, "--max-charge", charge - 0.1, *more)
        assert ((status, out) == (1, "") and f"may be {charge:.3f} s" in err
                and not service.problems and not service.uploads)
        assert [path.name for path in tmp_path.iterdir()] == ["tiny.qcf"]
        assert solve(solver, "--max-charge", charge, *more)[0] == 0
        service.problems.clear()
        service.uploads.clear()
        (tmp_path / "s.qsf").unlink()
    status, _, err = solve("qpu", "--max-charge", 0.01)
    assert status == 1 and not service.problems
    assert solve("qpu", "--max-charge", 10)[0] == 0
    assert solve("anneal", "--max-charge", 10)[0] == 2


def test_a_charge_that_cannot_be_told_is_refused(solve, service):
    service.solvers["Advantage2_mock"]["properties"].pop("problem_timing_data")
    status, _, err = solve("qpu", "--max-charge", 10)
    assert status == 1 and "does not say what it will charge" in err and not service.problems


def test_many_that_are_too_dear_are_not_begun(frames, tmp_path, main, service):
    many = "solve", *frames, "--out-dir", tmp_path / "out", "--solver", "hybrid-nl", "--max-charge"
    status, out, err = main(*many, 14.9)
    assert (status, out) == (1, "") and "may be 15.000 s" in err and not service.problems
    assert main(*many, 15)[0] == 0 and len(service.problems) == 3
    assert main(*many, 1)[0] == 0 and len(service.problems) == 3


def test_it_fits_where_the_embedding_is_known(solve, main, problem_file, service, tmp_path,
                                              monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path.parent / f"{tmp_path.name}.cache"))
    dry_run = "solve", problem_file, "--solver", "qpu", "--dry-run"
    assert json.loads(main(*dry_run, "--json")[1])["fits"] is None
    assert solve("qpu")[0] == 0
    assert (json.loads(main(*dry_run, "--json")[1])["fits"] is True
            and "it fits; nothing was sent" in main(*dry_run)[1])


def test_copies_auto_says_what_it_found(solve, service):
    status, _, err = solve("qpu", "--copies", "auto", "--num-reads", 10)
    count = json.loads(json.dumps(err.split(" copies found on ")[0].split()[-1]))
    assert (status == 0 and int(count) > 3 and f"{10 * int(count):,} samples from 10 reads" in err
            and "of 100 s" in err)
    assert "copies" not in solve("qpu", "--copies", "auto", "--quiet")[2]


def bits_of(numbers):
    return (np.array(numbers)[:, None] >> np.arange(12) & 1).astype(np.uint8)


@pytest.mark.parametrize("numbers, energies, counts, helps", [
    # Every read another state.
    (range(1000), range(1000), [1] * 1000, False),
    # States repeat, the best was seen once; it is common; it stands in two rows.
    ([1, 2, 3], [0, 5, 6], [1, 500, 499], True),
    ([1, 2, 3], [0, 5, 6], [400, 300, 300], False),
    ([1, 1, 2, 3], [0, 0, 5, 6], [50, 50, 500, 400], False),
    ([1, *range(2, 402)], [0, *range(1, 401)], [1] + [2] * 400, True)])
def test_more_reads_are_advised_where_they_help(numbers, energies, counts, helps):
    assert qpu.more_reads_help(bits_of(numbers), np.array(energies), np.array(counts)) is helps
    assert (qpu.WARNINGS["TooFewSamplesWarning"].index("free")
            < qpu.WARNINGS["TooFewSamplesWarning"].index("more reads"))


class OnceTheBest:
    """The best state once, all other reads alike."""

    def sample(self, bqm, num_reads):
        from dwave.samplers import SimulatedAnnealingSampler
        best = SimulatedAnnealingSampler().sample(bqm, num_reads=20, seed=1).first.sample
        others = [dict.fromkeys(bqm.variables, 1)] * (num_reads - 1)
        return dimod.SampleSet.from_samples_bqm([best, *others], bqm)


def test_more_reads_are_advised_where_nothing_follows_them(solve, service):
    """Descent and merging, which are free, make more of the reads than the best of them."""
    service.sampler = OnceTheBest()
    status, _, err = solve("qpu", "--no-postprocess")
    assert status == 0 and "lowest energy was seen in few samples" in err
    status, _, err = solve("qpu", "--seed", 1)
    assert status == 0 and "few samples" not in err


# Files.


def test_where_files_cannot_be_locked_nothing_is_sent(solve, service, tmp_path, monkeypatch):
    """As on Windows; what runs here does without."""
    monkeypatch.setattr(jobs, "fcntl", None)
    status, _, err = solve()
    assert (status == 4 and "WSL" in err and "Linux, macOS" in err and not service.problems
            and not service.uploads)
    assert [path.name for path in tmp_path.iterdir()] == ["tiny.qcf"]
    assert solve("anneal")[0] == 0


def test_no_link_that_was_planted_is_followed(tmp_path, solve, monkeypatch):
    """Not even under a temporary's very name."""
    kept = tmp_path / "kept"
    kept.write_text("kept")
    monkeypatch.setattr(jobs.secrets, "token_hex", lambda count: "0" * 2 * count)
    (tmp_path / f"s.qsf.job.{'0' * 16}.tmp").symlink_to(kept)
    status, _, err = solve("hybrid-nl", "--no-wait")
    assert status == 4 and "cannot write" in err and kept.read_text() == "kept"
    (tmp_path / f".qstereo-{'0' * 16}.tmp").symlink_to(kept)
    status, _, err = solve("anneal")
    assert status == 4 and "cannot write" in err and kept.read_text() == "kept"


def test_names_of_temporaries_are_not_to_be_guessed(tmp_path, monkeypatch):
    names = set()
    for _ in range(2):
        with output.Output(str(tmp_path / "s.qsf")) as made:
            names.add(made.temporary)
    assert len(names) == 2 and all(len(name.rsplit("/", 1)[1]) > 24 for name in names)


def test_two_writers_of_one_output_leave_one_whole_file(tmp_path):
    path, barrier = tmp_path / "s.qsf", threading.Barrier(4)

    def write(letter):
        with output.Output(str(path), last=False) as made:
            barrier.wait()
            made.write(letter * 1_000_000)
            made.keep()
    threads = [threading.Thread(target=write, args=(letter,)) for letter in (b"a", b"b", b"c",
        b"d")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(path.read_bytes())) == 1 and path.stat().st_size == 1_000_000
    assert [one.name for one in tmp_path.iterdir()] == ["s.qsf"]
