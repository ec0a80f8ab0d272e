"""Files that were made to hurt are refused by both readers, at once and without a crash; those
beside them are read."""

import resource
import sys
from pathlib import Path

import pytest
from hostile import (
    chain,
    hostile,
    hostile_proofs,
    labl,
    parts,
    problem,
    proof,
    sound,
    sound_proofs,
)
from qstereo_bridge.core import qcf
from qstereo_bridge.core.container import FormatError
from qstereo_bridge.verify import verify

sys.path.insert(0, str(Path(__file__).parents[1] / "cli"))
from cli_tools import ROOT, run, succeed  # noqa: E402

HOSTILE = {name: (data, both) for name, data, both in hostile()}
FOUND = sorted((ROOT.parent / "shared/data/hostile").glob("*.qcf"))
COMMANDS = [
    ["info"],
    ["info", "--complexity"],
    ["solve", "-o", "out.qsf"],
    ["reduce", "-o", "out.qcf"],
    ["compare"],
    ["decode", "-o", "out.pgm"],
]


def a_second_of_work():
    """More than enough for any of these files, and no more."""
    resource.setrlimit(resource.RLIMIT_CPU, (2, 2))
    resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))


def outcomes(path, folder):
    return [
        run(command[0], path, *command[1:], cwd=folder, preexec_fn=a_second_of_work)
        for command in COMMANDS
    ]


@pytest.mark.parametrize("name", HOSTILE)
def test_refused(name, tmp_path):
    data, both = HOSTILE[name]
    path = tmp_path / "hostile.qcf"
    path.write_bytes(data)
    for done in outcomes(path, tmp_path):
        expected = 4 if name == "pairs in the header alone" else 3
        assert done.status == expected and str(path) in done.err, (done.status, done.err)
    assert [found.name for found in tmp_path.iterdir()] == ["hostile.qcf"]
    if both:
        with pytest.raises(FormatError):
            qcf.parse_qcf(data, 1 << 30)


@pytest.mark.parametrize(
    "name, data", list(sound()), ids=lambda value: value if isinstance(value, str) else ""
)
def test_the_sound_ones_beside_them_are_read(name, data, tmp_path):
    path = tmp_path / "sound.qcf"
    path.write_bytes(data)
    assert run("info", path).status == 0
    n, groups, couplings, _ = qcf.FIELDS.unpack_from(data, 24)
    read = qcf.parse_qcf(data)
    assert (read.linear.size, read.sizes.size, read.couplings.shape[1]) == (n, groups, couplings)


@pytest.mark.parametrize("path", FOUND, ids=lambda path: path.name)
def test_files_that_were_found(path, tmp_path):
    for done in outcomes(path, tmp_path):
        assert done.status == 3, (done.status, done.err)
    with pytest.raises(FormatError):
        qcf.parse_qcf(path.read_bytes(), 1 << 30)


@pytest.fixture(scope="module")
def answer(tmp_path_factory):
    """The problem that the certificates are about, and its samples."""
    folder = tmp_path_factory.mktemp("answer")
    problem, samples = folder / "p.qcf", folder / "s.qsf"
    problem.write_bytes(dict(sound())["chain"])
    succeed("solve", problem, "-o", samples)
    return problem, samples


PROOFS = {name: (data, 0) for name, data in sound_proofs()}
PROOFS |= {name: (data, 1 if is_sound else 3) for name, data, is_sound in hostile_proofs()}


@pytest.mark.parametrize("name", PROOFS)
def test_certificates(answer, name, tmp_path):
    """0: it holds; 1: it states what is not so; 3: it is no certificate. Both verifiers agree."""
    data, status = PROOFS[name]
    path = tmp_path / "c.qpf"
    path.write_bytes(data)
    done = run("verify", *answer, path, preexec_fn=a_second_of_work)
    assert done.status == status, done.err
    if status == 3:
        assert str(path) in done.err
        with pytest.raises(FormatError):
            verify(*answer, path)
    else:
        assert verify(*answer, path).valid == (status == 0)


def test_parts_of_4096_sites_and_not_of_one_more(tmp_path):
    """A chain of as many sites as a part may have, and one that is longer."""
    for sites, status in ((4096, 0), (4097, 3)):
        problem_file = problem(sites, runs=chain(sites), sides=[("labl", labl(2))]).pack()
        paths = [tmp_path / name for name in ("p.qcf", "s.qsf", "c.qpf")]
        held = parts(*range(sites))
        paths[0].write_bytes(problem_file)
        paths[2].write_bytes(proof(held, bound=0, about=(problem_file, sites)))
        succeed("solve", *paths[:1], "-o", paths[1], "--solver", "icm")
        done = run("verify", *paths)
        assert done.status == status, done.err
        if status == 0:
            assert verify(*paths).valid
        else:
            with pytest.raises(FormatError):
                verify(*paths)
