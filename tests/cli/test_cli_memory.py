"""--memory-limit is the memory of the whole command, known before the work."""

import json
import re
import resource
import struct

import numpy as np
import pytest
from camera_tools import calibration, write_storage
from cli_tools import chunks_of, random_pair, run, succeed, with_chunk, write_pgm

NAMED = re.compile(r"needs more than the memory limit of \d+ MiB: raise --memory-limit to (\d+)\n")
# The program itself, with its libraries, beside what it counts.
PROGRAM_MIB = 8


def needed(line, limit):
    """What the refusal of a command under a limit names."""
    done = run(*line, "--memory-limit", limit)
    assert (done.status, done.out) == (4, b""), done.err
    return int(NAMED.search(done.err)[1])


def address_space(mib):
    return lambda: resource.setrlimit(resource.RLIMIT_AS, (mib << 20, mib << 20))


@pytest.fixture
def pair_of(tmp_path):
    *_, left, right = random_pair(tmp_path, 320, 240)
    return left, right


@pytest.mark.parametrize("ending", ["pgm", "pfm"])
@pytest.mark.parametrize("solver", ["icm", "best", "trws"])
def test_match_names_what_it_needs(pair_of, folder, pnm_only, solver, ending):
    """With the limit named last the command runs, and takes no more memory. One far below is
    about right: it is foreseen from few rows, and best keeps some memory for any size."""
    line = ["match", *pair_of, "-o", folder / f"m.{ending}", "--color", "--solver", solver]
    line += ["--disparity", "0:31", "--iterations", 1]
    about = needed(line, 2)
    mib = needed(line, int(about * 0.85))
    assert 0.8 * about <= mib <= 1.2 * about
    while run(*line, "--memory-limit", mib).status == 4:
        about, mib = mib, needed(line, mib)
        assert about < mib <= 1.1 * about
    assert needed(line, mib - 1) == mib
    done = run(
        *line,
        "--memory-limit",
        mib,
        program=pnm_only,
        preexec_fn=address_space(mib + PROGRAM_MIB),
    )
    assert done.status == 0, done.err


def test_no_work_before_a_refusal(pair_of, folder):
    """A solver that would never end does not begin."""
    line = ["match", *pair_of, "-o", folder / "m.pgm", "--solver", "anneal", "--iterations", 2**60]
    assert needed(line, 3) > 3
    assert not list(folder.iterdir())


def test_a_large_pair_is_refused_at_once(tmp_path, folder):
    """Nothing is laid out before: the address space has no room for more than the pictures."""
    large = tmp_path / "large.pgm"
    large.write_bytes(b"P5\n6000 4000\n255\n" + bytes(6000 * 4000))
    done = run(
        "match",
        large,
        large,
        "-o",
        folder / "m.pgm",
        "--disparity",
        "0:63",
        preexec_fn=address_space(1024),
    )
    assert done.status == 4
    assert int(NAMED.search(done.err)[1]) > 6000 * 4000 * 64 * 4 >> 20


def with_picture(problem, width, height, path):
    """A problem whose window lies in a picture of that size."""
    labels = bytearray(chunks_of(problem)["labl"])
    struct.pack_into("<II", labels, 40, width, height)
    return with_chunk(problem, "labl", bytes(labels), path)


@pytest.mark.parametrize("ending", ["pgm", "pfm"])
def test_a_small_file_that_names_a_large_picture(tmp_path, folder, solved, pnm_only, ending):
    large = with_picture(solved.problem, 10000, 10000, tmp_path / "large.qcf")
    assert run("solve", large, "-o", tmp_path / "large.qsf", "--solver", "icm").status == 0
    line = ["decode", large, tmp_path / "large.qsf", "-o", folder / f"m.{ending}"]
    assert needed(line, 300) == (4 * 10**8 >> 20) + 1
    assert not list(folder.iterdir())
    medium = with_picture(solved.problem, 1000, 1000, tmp_path / "medium.qcf")
    assert run("solve", medium, "-o", tmp_path / "medium.qsf", "--solver", "icm").status == 0
    line = ["decode", medium, tmp_path / "medium.qsf", "-o", folder / f"m.{ending}"]
    mib = needed(line, 1)
    limit = address_space(mib + PROGRAM_MIB)
    assert run(*line, "--memory-limit", mib, program=pnm_only, preexec_fn=limit).status == 0


def test_a_png_needs_more_than_a_pgm(tmp_path, folder, solved, opencv):
    """Its writer holds all samples several times."""
    large = with_picture(solved.problem, 10000, 10000, tmp_path / "large.qcf")
    assert run("solve", large, "-o", tmp_path / "large.qsf", "--solver", "icm").status == 0
    decode = ["decode", large, tmp_path / "large.qsf", "-o"]
    plain, compressed = (needed([*decode, folder / f"m.{end}"], 300) for end in ("pgm", "png"))
    assert compressed > 2 * plain
    assert not list(folder.iterdir())


def test_compare_looks_before_it_solves(tmp_path, folder, solved):
    large = with_picture(solved.problem, 10000, 10000, tmp_path / "large.qcf")
    line = ["compare", large, "--maps", folder / "maps", "--solvers", "anneal"]
    assert needed([*line, "--iterations", 2**60], 300) > 300
    assert not list(folder.iterdir())


def test_pictures_count(tmp_path):
    """A PGM of 2 MiB is no more than its bytes, the samples and the map."""
    large = tmp_path / "large.pgm"
    large.write_bytes(b"P5\n2048 1024\n255\n" + b"\x08" * 2048 * 1024)
    line = ["score", large, large, "--json"]
    mib = needed(line, 4)
    assert 6 <= mib <= 32
    done = run(*line, "--memory-limit", 32)
    assert json.loads(done.out)["pixels"] == 2048 * 1024


def test_a_picture_that_grows_when_it_is_decoded(tmp_path, opencv, folder):
    """A PNG says its size before it is decoded: here it ends after that."""
    from PIL import Image

    small = tmp_path / "small.png"
    Image.new("L", (12000, 12000)).save(small)
    small.write_bytes(small.read_bytes()[:1000])
    line = ["match", small, small, "-o", folder / "m.pgm"]
    assert needed(line, 100) > 12000 * 12000 * 3 >> 20


def test_json_of_a_stream_counts(tmp_path, pair_of, folder):
    """--json keeps the file in memory, for which there may be no room."""
    line = ["encode", *pair_of, "-o", folder / "p.qcf"]
    assert run(*line, "--memory-limit", 2).status == 0
    (folder / "p.qcf").unlink()
    done = run(*line, "--memory-limit", 2, "--json")
    assert (done.status, done.out) == (4, b"")
    assert "needs more than the memory limit of 2 MiB" in done.err
    assert not list(folder.iterdir())


@pytest.mark.parametrize("solver", ["icm", "trws"])
def test_makers_name_what_they_need(tmp_path, folder, solver):
    """The model and the solver's work, before either begins."""
    grey = np.random.default_rng(1).integers(0, 256, (240, 320))
    noisy = write_pgm(tmp_path / "noisy.pgm", grey)
    line = ["restore", noisy, "-o", folder / "out.pgm", "--step", 8, "--solver", solver]
    line += ["--iterations", 1]
    about = needed(line, 2)
    mib = needed(line, int(about * 0.85))
    assert 0.9 * about <= mib <= 1.1 * about
    while run(*line, "--memory-limit", mib).status == 4:
        about, mib = mib, needed(line, mib)
        assert about < mib <= 1.1 * about
    assert (folder / "out.pgm").exists()


@pytest.mark.parametrize("command", ["solve", "reduce"])
def test_a_certificate_counts(tmp_path, folder, pair_of, command):
    problem = tmp_path / "p.qcf"
    assert run("encode", *pair_of, "-o", problem, "--disparity", "0:31").status == 0
    line = [command, problem, "-o", folder / "out", "--iterations", 1]
    line += ["--solver", "trws"] if command == "solve" else []
    certified = [*line, "--certificate", folder / "proof.qpf"]
    limit = needed(line, 20) - 1
    assert needed(certified, limit) > needed(line, limit) + 1


SMALL = "{left} {right} --disparity 0:5 -o"
LINES = {
    "encode": f"encode {SMALL} e.qcf --encoding domain-wall",
    "encode --json": f"encode {SMALL} e.qcf --json",
    "encode --reduce": f"encode {SMALL} e.qcf --reduce --truncate",
    "encode of arcs": f"encode {SMALL} e.qcf --encoding st-cut-arcs --smoothness linear",
    "info": "info p.qcf --complexity",
    "solve": "solve p.qcf -o o.qsf --iterations 1",
    "solve, proven": "solve p.qcf -o o.qsf --iterations 1 --certificate o.qpf",
    "reduce": "reduce p.qcf -o o.qcf --iterations 1 --certificate o.qpf --samples o.qsf",
    "decode": "decode p.qcf p.qsf -o o.pgm",
    "segment": "segment {left} seeds.pgm -o o.pgm --iterations 1 --solver icm",
    "restore": "restore {left} -o o.pgm --iterations 1 --step 32",
    "flow": "flow {left} {right} -o o.flo --iterations 1 --solver icm",
    "rectify": "rectify large.pgm large.pgm -o o.pgm o2.pgm --calibration c.yml",
    "floats": "score large.pfm large.pfm",
    "colours": "score large.ppm large.ppm --as picture",
}


@pytest.fixture(scope="session")
def small_and_large(tmp_path_factory):
    """Inputs of all LINES: a pair of 200 x 120 and its problem, and large pictures."""
    folder = tmp_path_factory.mktemp("memory")
    *_, left, right = random_pair(folder, 200, 120)
    seeds = np.zeros((120, 200), int)
    seeds[:9], seeds[-9:] = 1, 2
    write_pgm(folder / "seeds.pgm", seeds)
    grey = np.full((1024, 2048), 9)
    write_pgm(folder / "large.pgm", grey)
    (folder / "large.pfm").write_bytes(b"Pf\n2048 1024\n-1\n" + grey.astype("<f4").tobytes())
    (folder / "large.ppm").write_bytes(b"P6\n2048 4096\n255\n" + bytes(3 * 2048 * 4096))
    write_storage(folder / "c.yml", calibration(size=(2048, 1024)))
    succeed("encode", left, right, "-o", folder / "p.qcf", "--disparity", "0:5", "--lambda", 20)
    succeed("solve", folder / "p.qcf", "-o", folder / "p.qsf", "--solver", "icm")
    return folder, left, right


@pytest.mark.parametrize("name", LINES)
def test_each_refusal_names_more(small_and_large, pnm_only, name):
    """From the least limit on, what a refusal names is more than before, and soon enough. Then the
    command takes no more memory than that."""
    folder, left, right = small_and_large
    line = LINES[name].format(left=left, right=right).split()
    mib, named = 1, []

    def attempt():
        limit = address_space(mib + PROGRAM_MIB)
        return run(*line, "--memory-limit", mib, cwd=folder, program=pnm_only, preexec_fn=limit)

    while (done := attempt()).status == 4:
        assert (found := NAMED.search(done.err)), done.err
        named.append(int(found[1]))
        assert named[-1] > mib and len(named) <= 6
        mib = named[-1]
    assert done.status == 0, done.err
