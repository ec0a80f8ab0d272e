"""The programs of examples/, as make builds them."""
import subprocess

import numpy as np
import pytest

from library import ROOT

FOLDER = ROOT / "build" / "examples"


def call(name, *arguments, cwd, status=0, **more):
    command = [str(FOLDER / name), *map(str, arguments)]
    done = subprocess.run(command, cwd=cwd, capture_output=True, **more)
    assert done.returncode == status, done.stderr
    return done


def write_pgm(path, grey):
    path.write_bytes(b"P5\n%d %d\n255\n" % grey.shape[::-1] + grey.astype(np.uint8).tobytes())


def read_pgm(path):
    kind, size, most, pixels = path.read_bytes().split(b"\n", maxsplit=3)
    assert (kind, most) == (b"P5", b"255")
    return np.frombuffer(pixels, np.uint8).reshape([int(n) for n in size.split()[::-1]])


def write_pair(folder):
    """Random dots at disparity 2, and before them a square at disparity 5."""
    dots = np.random.default_rng(5).integers(1, 256, (24, 48))
    right = np.roll(dots, -2, axis=1)
    right[6:18, 13:31] = dots[6:18, 18:36]
    write_pgm(folder / "left.pgm", dots)
    write_pgm(folder / "right.pgm", right)


def test_a_map_is_that_of_match(run, tmp_path):
    write_pair(tmp_path)
    done = call("pictures_to_map", "left.pgm", "right.pgm", "example.pgm", 8, cwd=tmp_path)
    said = run("qstereo", "match", "left.pgm", "right.pgm", "-o", "match.pgm",
               "--disparity", "0:7", "--lambda", 20, "--scale", 8, "--json")
    assert done.stdout.decode() == f"energy {said['energy']}, lower bound {said['lower_bound']}\n"
    example = read_pgm(tmp_path / "example.pgm")
    assert np.array_equal(example, read_pgm(tmp_path / "match.pgm"))
    assert (example[:, :7] == 0).all() and example[2, 20] == 16 and example[12, 27] == 40


@pytest.mark.parametrize("arguments", [(), ("l.pgm", "r.pgm", "map.pgm", 0), ("a", "b", "c", 33)])
def test_a_map_refuses(arguments, tmp_path):
    assert b"usage" in call("pictures_to_map", *arguments, cwd=tmp_path, status=2).stderr


def test_a_map_names_a_file_that_is_none(tmp_path):
    done = call("pictures_to_map", "none.pgm", "none.pgm", "map.pgm", 4, cwd=tmp_path, status=3)
    assert b"none.pgm" in done.stderr


def test_a_grid_without_noise(tmp_path):
    *rows, last = call("denoise_grid", cwd=tmp_path).stdout.decode().splitlines()
    clean = ["0000003333330000"] * 4 + ["1111111111111111"] * 2 + ["1111111111112222"] * 2
    assert [row.split()[1] for row in rows] == clean
    noisy = [row.split()[0] for row in rows]

    def energy(picture):
        grey = np.array([[int(c) for c in row] for row in picture])
        wanted = np.array([[int(c) for c in row] for row in noisy])
        steps = np.concatenate([np.diff(grey, axis=0).ravel(), np.diff(grey, axis=1).ravel()])
        return 4 * np.abs(grey - wanted).sum() + 3 * np.minimum(np.abs(steps), 2).sum()

    assert last == f"energy before {energy(noisy)}, after {energy(clean)}"


def test_a_qcf_out_and_a_qsf_in(run, tmp_path):
    call("qcf_out_qsf_in", "ring.qcf", cwd=tmp_path)
    run("qstereo-bridge", "solve", "ring.qcf", "-o", "ring.qsf", "--solver", "exact")
    done = call("qcf_out_qsf_in", "ring.qcf", "ring.qsf", cwd=tmp_path)
    lines = done.stdout.decode().splitlines()
    # Five tasks on a ring: one of them needs day 2, the others take turns.
    assert lines
    for line in lines:
        energy, days = line.removeprefix("energy ").split(", days ")
        days = [int(day) for day in days.split()]
        assert int(energy) == sum(days) == 4 and days[0] == 0
        assert all(days[task] != days[task - 1] for task in range(5))
    call("qcf_out_qsf_in", "other.qcf", cwd=tmp_path)
    with open(tmp_path / "other.qcf", "r+b") as file:
        file.write(b"x")
    call("qcf_out_qsf_in", "other.qcf", "ring.qsf", cwd=tmp_path, status=3)


def test_a_streaming_encoder(run, tmp_path):
    sizes = []
    for height in (30, 300):
        done = call("streaming_encoder", 64, height, cwd=tmp_path)
        written, workspace = (int(word) for word in done.stderr.split() if word.isdigit())
        assert written == len(done.stdout)
        sizes.append(workspace)
        (tmp_path / "bands.qcf").write_bytes(done.stdout)
    assert sizes[0] == sizes[1] < 2000  # a row, whatever the number of rows
    info = run("qstereo", "info", "bands.qcf", "--json")
    assert info["sites"] == 64 * 300
    run("qstereo", "solve", "bands.qcf", "-o", "bands.qsf")
    run("qstereo", "decode", "bands.qcf", "bands.qsf", "-o", "bands.pgm", "--scale", 2)
    bands = read_pgm(tmp_path / "bands.pgm")
    assert [np.unique(bands[100 * i : 100 * i + 100]).tolist() for i in range(3)] == [[1], [2], [4]]
