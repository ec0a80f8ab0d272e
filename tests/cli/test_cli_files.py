"""Outputs appear whole or not at all, whatever goes wrong; standard streams."""

import json
import os
import pty
import resource
import signal
import stat
import subprocess

import numpy as np
import pytest
from cli_tools import LONG, random_pair, run, signal_at_output, started, succeed, write_pgm

ENCODE = ["--disparity", "0:3"]


@pytest.fixture
def commands(solved):
    """Each command that writes a file, with the ending of what it writes."""
    return {
        "encode": ([*solved.pair.paths, *ENCODE], ".qcf"),
        "decode": ([solved.problem, solved.samples], ".pgm"),
        "solve": ([solved.problem], ".qsf"),
        "match": ([*solved.pair.paths, *ENCODE], ".pgm"),
    }


@pytest.mark.parametrize("name", ["encode", "decode", "solve", "match"])
class TestOutputs:
    def test_replaces_what_was_there(self, commands, folder, name):
        arguments, ending = commands[name]
        output = folder / f"out{ending}"
        output.write_text("as it was")
        output.chmod(0o640)
        succeed(name, *arguments, "-o", output)
        assert output.read_bytes()[:2] in (b"\x89Q", b"P5")
        assert stat.S_IMODE(output.stat().st_mode) == 0o640
        assert list(folder.iterdir()) == [output]

    def test_new_files_obey_the_umask(self, commands, folder, name):
        arguments, ending = commands[name]
        succeed(name, *arguments, "-o", folder / f"out{ending}", preexec_fn=lambda: os.umask(0o027))
        assert stat.S_IMODE((folder / f"out{ending}").stat().st_mode) == 0o640

    def test_follows_links(self, commands, folder, name):
        arguments, ending = commands[name]
        (folder / "real").write_text("as it was")
        link = folder / f"link{ending}"
        link.symlink_to("real")
        succeed(name, *arguments, "-o", link)
        assert link.is_symlink() and (folder / "real").read_bytes() != b"as it was"

    def test_replaces_links_that_lead_nowhere(self, commands, folder, name):
        arguments, ending = commands[name]
        link = folder / f"link{ending}"
        link.symlink_to("none")
        succeed(name, *arguments, "-o", link)
        assert link.is_file() and list(folder.iterdir()) == [link] and not link.is_symlink()

    @pytest.mark.parametrize("operand", [0, -1])
    @pytest.mark.parametrize("link", [os.symlink, os.link])
    def test_refuses_its_own_inputs(self, commands, folder, name, operand, link):
        arguments, ending = commands[name]
        operands = [path for path in arguments if os.path.isabs(path)]
        before = operands[operand].read_bytes()
        output = folder / f"out{ending}"
        link(operands[operand], output)
        done = run(name, *arguments, "-o", output)
        assert (done.status, done.out) == (2, b"")
        assert (
            done.err
            == f"qstereo {name}: {output}: is an input of this command: name another file to "
            "write\n"
        )
        assert operands[operand].read_bytes() == before and list(folder.iterdir()) == [output]

    def test_a_reader_that_is_gone(self, commands, folder, name):
        arguments, ending = commands[name]
        reader, writer = os.pipe()
        os.close(reader)
        done = run(
            name,
            *arguments,
            "-o",
            folder / f"out{ending}",
            stdout=writer,
            stderr=subprocess.PIPE,
            capture_output=False,
        )
        os.close(writer)
        assert done.status == 141
        assert not list(folder.iterdir())

    def test_missing_folder(self, commands, folder, name):
        arguments, ending = commands[name]
        output = folder / "none" / f"out{ending}"
        done = run(name, *arguments, "-o", output)
        assert (done.status, done.out) == (4, b"")
        assert (
            done.err == f"qstereo {name}: {output}: cannot be written, make its folder first: "
            "No such file or directory\n"
        )

    def test_a_folder_in_its_place(self, commands, folder, name):
        arguments, ending = commands[name]
        output = folder / f"out{ending}"
        output.mkdir()
        done = run(name, *arguments, "-o", output)
        assert (done.status, "Is a directory" in done.err) == (4, True)
        assert list(folder.iterdir()) == [output] and not list(output.iterdir())

    @pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
    def test_unwritable_folder(self, commands, folder, name):
        arguments, ending = commands[name]
        folder.chmod(0o555)
        done = run(name, *arguments, "-o", folder / f"out{ending}")
        folder.chmod(0o755)
        assert (done.status, "Permission denied" in done.err) == (4, True)

    def test_a_full_device(self, commands, name):
        arguments, _ = commands[name]
        done = run(name, *arguments, "-o", "/dev/full", "--json")
        assert (done.status, done.out) == (4, b"")
        assert (
            done.err == f"qstereo {name}: /dev/full: cannot be written: No space left on device\n"
        )

    def test_no_room(self, commands, folder, name):
        arguments, ending = commands[name]
        output = folder / f"out{ending}"
        output.write_text("as it was")
        done = run(
            name,
            *arguments,
            "-o",
            output,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20, 20)),
        )
        assert done.status == 4
        assert done.err == f"qstereo {name}: {output}: cannot be written: File too large\n"
        assert list(folder.iterdir()) == [output] and output.read_text() == "as it was"

    def test_a_result_that_cannot_be_printed(self, commands, folder, name):
        arguments, ending = commands[name]
        with open("/dev/full", "w") as full:
            done = run(
                name,
                *arguments,
                "-o",
                folder / f"out{ending}",
                stdout=full,
                stderr=subprocess.PIPE,
                capture_output=False,
            )
        assert done.status == 4
        assert "standard output: cannot be written: No space left on device" in done.err
        assert not list(folder.iterdir())

    def test_no_binary_to_a_terminal(self, commands, name):
        arguments, _ = commands[name]
        master, terminal = pty.openpty()
        done = run(
            name,
            *arguments,
            "-o",
            "-",
            stdout=terminal,
            stderr=subprocess.PIPE,
            capture_output=False,
        )
        os.close(terminal)
        os.close(master)
        assert (done.status, "terminal" in done.err) == (2, True)

    def test_a_result_that_cannot_be_printed_brings_the_old_file_back(
        self, commands, folder, name
    ):
        arguments, ending = commands[name]
        output = folder / f"out{ending}"
        output.write_text("as it was")
        with open("/dev/full", "w") as full:
            done = run(
                name,
                *arguments,
                "-o",
                output,
                stdout=full,
                stderr=subprocess.PIPE,
                capture_output=False,
            )
        assert done.status == 4
        assert list(folder.iterdir()) == [output] and output.read_text() == "as it was"

    def test_closed_standard_output(self, commands, folder, name):
        arguments, ending = commands[name]
        output = folder / f"out{ending}"
        done = run(
            name,
            *arguments,
            "-o",
            output,
            preexec_fn=lambda: os.close(1),
            stdout=None,
            stderr=subprocess.PIPE,
            capture_output=False,
        )
        assert done.status == 4
        assert not output.exists()


@pytest.mark.parametrize("arguments", [["--version"], ["--help"], ["encode", "--help"]])
def test_full_standard_output(arguments):
    with open("/dev/full", "w") as full:
        done = run(*arguments, stdout=full, stderr=subprocess.PIPE, capture_output=False)
    assert (done.status, "standard output: cannot be written" in done.err) == (4, True)


@pytest.mark.parametrize(
    "number, status",
    [
        (signal.SIGINT, 130),
        (signal.SIGTERM, 143),
        (signal.SIGHUP, 129),
        (signal.SIGQUIT, 131),
        (signal.SIGPIPE, 141),
        (signal.SIGALRM, 142),
        (signal.SIGUSR1, 138),
        (signal.SIGUSR2, 140),
        (signal.SIGXCPU, 152),
    ],
)
def test_a_signal_while_reading(folder, pair, number, status):
    fifo = folder.parent / "slow.pgm"
    os.mkfifo(fifo)
    process = started("encode", fifo, pair.paths[1], "-o", folder / "p.qcf", *ENCODE)
    with open(fifo, "wb") as writer:
        writer.write(b"P5\n12 5\n")
        writer.flush()
        process.send_signal(number)
        assert process.wait(LONG) == status
    assert not list(folder.iterdir())


@pytest.mark.parametrize(
    "number, status",
    [
        (signal.SIGINT, 130),
        (signal.SIGTERM, 143),
        (signal.SIGHUP, 129),
        (signal.SIGQUIT, 131),
        (signal.SIGPIPE, 141),
        (signal.SIGALRM, 142),
        (signal.SIGUSR1, 138),
        (signal.SIGUSR2, 140),
        (signal.SIGXCPU, 152),
    ],
)
def test_a_signal_while_writing(folder, number, status):
    """The temporary is there, and gone after the signal; what was there before stays."""
    random = np.random.default_rng(1)
    paths = [
        write_pgm(folder.parent / f"{side}.pgm", random.integers(0, 256, (1000, 1500)))
        for side in ("left", "right")
    ]
    (folder / "p.qcf").write_text("as it was")
    process = started("encode", *paths, "-o", folder / "p.qcf", "--disparity", "0:255")
    signal_at_output(process, folder, 2, number)
    assert process.wait(LONG) == status
    assert [path.name for path in folder.iterdir()] == ["p.qcf"]
    assert (folder / "p.qcf").read_text() == "as it was"


def test_an_ignored_signal_stays_ignored(folder, pair):
    fifo = folder.parent / "slow.pgm"
    os.mkfifo(fifo)
    process = started(
        "encode",
        fifo,
        pair.paths[1],
        "-o",
        folder / "p.qcf",
        *ENCODE,
        stderr=None,
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN),
    )
    with open(fifo, "wb") as writer:
        process.send_signal(signal.SIGHUP)
        writer.write(pair.paths[0].read_bytes())
    assert process.wait(LONG) == 0
    process.stdout.close()


def test_refuses_inputs_that_are_no_operands(tmp_path, solved):
    """Standard input, the truth, and a map in colours that would lie on a picture."""
    problem = solved.problem.read_bytes()
    with open(solved.problem, "rb") as file:
        done = run("solve", "-", "-o", solved.problem, stdin=file)
    assert (done.status, "is an input" in done.err) == (2, True)
    assert solved.problem.read_bytes() == problem
    truth = write_pgm(tmp_path / "truth.pgm", np.full((5, 12), 8))
    picture = solved.pair.paths[0].rename(tmp_path / "map.color.ppm")
    for arguments, kept in (
        (["-o", truth, "--truth", truth], truth),
        (["-o", tmp_path / "map.pgm", "--color"], picture),
    ):
        before = kept.read_bytes()
        done = run("match", picture, solved.pair.paths[1], *ENCODE, *arguments)
        assert (done.status, f"{kept}: is an input" in done.err) == (2, True), done.err
        assert kept.read_bytes() == before and not (tmp_path / "map.pgm").exists()


def test_names_that_look_like_options(tmp_path):
    left, right, left_path, right_path = random_pair(tmp_path, 5, 2)
    left_path.rename(tmp_path / "--left.pgm")
    done = succeed("encode", "-o", "p.qcf", *ENCODE, "--", "--left.pgm", "right.pgm", cwd=tmp_path)
    assert (tmp_path / "p.qcf").exists()


def test_two_outputs_are_both_written_or_none(folder, pair):
    for name in ("m.pgm", "m.color.ppm"):
        (folder / name).write_text(name)
    line = ["match", *pair.paths, "-o", folder / "m.pgm", "--color", *ENCODE]
    with open("/dev/full", "w") as full:
        done = run(*line, stdout=full, stderr=subprocess.PIPE, capture_output=False)
    assert done.status == 4
    assert {path.name: path.read_text() for path in folder.iterdir()} == {
        name: name for name in ("m.pgm", "m.color.ppm")
    }
    assert run(*line).status == 0
    assert sorted(path.name for path in folder.iterdir()) == ["m.color.ppm", "m.pgm"]
    assert (folder / "m.color.ppm").read_bytes()[:2] == b"P6"


def test_a_temporary_has_the_mode_of_its_target(folder, tmp_path):
    *_, left, right = random_pair(tmp_path, 400, 300)
    (folder / "m.pgm").write_text("secret")
    (folder / "m.pgm").chmod(0o600)
    line = ["match", left, right, "-o", folder / "m.pgm", "--solver", "anneal"]
    process = started(*line, "--iterations", 10**9)
    signal_at_output(process, folder, 2, signal.SIGSTOP)
    modes = {stat.S_IMODE(path.stat().st_mode) for path in folder.iterdir()}
    process.send_signal(signal.SIGTERM)
    process.send_signal(signal.SIGCONT)
    assert process.wait(20) == 143
    process.communicate()
    assert modes == {0o600}
    assert [path.read_text() for path in folder.iterdir()] == ["secret"]


STEERING = "a\x1b[2Jb\x07c\x7fd\u0085e\u202ef\u2066g"


@pytest.mark.parametrize("json_asked", [False, True])
def test_names_cannot_steer_a_terminal(folder, pair, json_asked):
    name = folder / f"{STEERING}\u00e4.pgm"
    line = ["match", *pair.paths, "-o", name, *ENCODE, *(["--json"] if json_asked else [])]
    done = run(*line)
    assert done.status == 0
    text = done.out.decode()
    assert not set(STEERING) - set("abcdefg[2J") & set(text)
    assert "\u00e4" in text  # a letter stays one
    if json_asked:
        assert json.loads(text)["map"] == str(name)
    else:
        assert "a\\x1b[2Jb\\x07c\\x7fd\\u0085e\\u202ef\\u2066g" in text


def test_messages_cannot_steer_a_terminal(folder):
    for name in (STEERING, b"\xff\x1b"):
        done = run("info", os.fsdecode(name) if isinstance(name, bytes) else name)
        assert done.status == 4
        assert not set(STEERING) - set("abcdefg[2J") & set(done.err)
        assert "\\x1b" in done.err
    assert "\\xff" in done.err
    assert "\\x1b" in run("info", "--\x1bx").err


def test_a_name_that_is_no_utf8_is_still_json(folder, pair):
    name = os.fsencode(folder) + b"/\xffm.pgm"
    done = run("match", *pair.paths, "-o", os.fsdecode(name), *ENCODE, "--json")
    assert done.status == 0
    assert json.loads(done.out.decode())["map"].endswith("/\ufffdm.pgm")


class TestTwoOutputs:
    """Two outputs of one command are two files, whatever they are called."""

    def match(self, pair, first, second, **more):
        return run("match", *pair.paths, *ENCODE, "-o", first, "--mask", second, **more)

    def refuse(self, pair, folder, first, second):
        before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
        done = self.match(pair, first, second, cwd=folder)
        assert done.status == 2 and "two outputs are one file" in done.err and done.out == b""
        assert {p: p.read_bytes() for p in folder.rglob("*") if p.is_file()} == before

    @pytest.mark.parametrize("is_there", [False, True])
    @pytest.mark.parametrize("second", ["m.pgm", "./m.pgm", "in/../m.pgm", "linked/m.pgm", None])
    def test_one_name(self, pair, folder, second, is_there):
        (folder / "in").mkdir()
        (folder / "linked").symlink_to(".")
        if is_there:
            (folder / "m.pgm").write_bytes(b"old")
        self.refuse(pair, folder, "m.pgm", second or folder / "m.pgm")

    @pytest.mark.parametrize("join", [os.symlink, os.link])
    def test_two_names_of_a_file(self, pair, folder, join):
        (folder / "m.pgm").write_bytes(b"old")
        join(folder / "m.pgm", folder / "n.pgm")
        self.refuse(pair, folder, "m.pgm", "n.pgm")
        self.refuse(pair, folder, "n.pgm", "m.pgm")

    def test_one_name_in_two_folders(self, pair, folder):
        (folder / "in").mkdir()
        done = self.match(pair, "m.pgm", "in/m.pgm", cwd=folder)
        assert done.status == 0 and (folder / "m.pgm").exists() and (folder / "in/m.pgm").exists()

    def test_a_device_is_no_file(self, pair):
        assert self.match(pair, "/dev/null", "/dev/null").status == 0

    def test_only_one_is_standard_output(self, pair, solved, tmp_path):
        """What a command says, and its main output, are not mixed up with another output."""
        q = tmp_path / "q.pgm"
        cases = {
            "mask": ["match", *pair.paths, *ENCODE, "-o", q, "--mask"],
            "confidence": ["match", *pair.paths, *ENCODE, "-o", q, "--json", "--confidence"],
            "certificate": ["solve", solved.problem, "-o", q, "--certificate"],
            "samples": ["reduce", solved.problem, "-o", "-", "--samples"],
            "answer": ["reduce", solved.problem, "-o", q, "--answer"],
            "trace": ["solve", solved.problem, "-o", q, "--trace"],
        }
        for option, words in cases.items():
            done = run(*words, "-")
            assert done.status == 2 and f"--{option} cannot go to standard output" in done.err
            assert done.out == b"" and not q.exists()
