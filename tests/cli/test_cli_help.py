"""Help, versions, the parser, and the man page, which must say the same as --help."""

import re
import shutil
import subprocess

import pytest
from cli_tools import LONG, QSTEREO, ROOT, has_opencv, run, succeed

COMMANDS = ["encode", "reduce", "info", "solve", "validate", "verify", "decode", "score", "match",
            "rectify", "depth", "compare", "restore", "label", "segment", "flow", "register",
            "detect"]
MAN = (ROOT / "docs" / "qstereo.1").read_text()


def help_of(command):
    done = run(command, "--help")
    assert (done.status, done.err) == (0, "")
    return done.out.decode()


def options_in_help(command):
    """Of each option its argument ("" = a flag) and its default."""
    section = help_of(command).split("\nOptions, ")[1].split("\n\nExamples:")[0]
    found = {}
    for row in re.split(r"\n(?=  (?:-\w, |    )--)", section)[1:]:
        row = " ".join(row.split())
        name, argument = re.match(
            r"(?:-\w, )?--([\w.-]+)(?: ([A-Z]\S*(?: RIGHT2)?|\S+\.q[cps]f))? ", row
        ).groups()
        found[name] = (argument or "", (re.findall(r"\(default (.*?)\)$", row) or [""])[0])
    return found


def options_in_man(command):
    section = re.search(rf"^\.SS {command}$(.*?)(?=^\.S[SH] )", MAN, re.M | re.S).group(1)
    plain = re.sub(r"\\f[BIR]", "", section).replace("\\-", "-")
    found = {}
    for line, text in re.findall(r"^\.TP\n(.*)\n((?:(?!\.TP|\.P|\.S).*\n)*)", plain, re.M):
        name, argument = re.match(r"(?:-\w, )?--([\w.-]+)(?: (\S+(?: RIGHT2)?))?$", line).groups()
        found[name] = (
            argument or "",
            (re.findall(r"\(default (.*?)\)\.?$", text.replace("\n", " ").strip()) or [""])[0],
        )
    return found


def test_overview():
    done = run("--help")
    assert (done.status, done.err) == (0, "")
    assert re.findall(r"^  (\w+) ", done.out.decode(), re.M) == COMMANDS
    assert run("help").out == run("-h").out == done.out
    alone = run()
    assert (alone.status, alone.out, alone.err) == (2, b"", done.out.decode())


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_commands(command):
    text = help_of(command)
    assert text.startswith(f"usage: qstereo {command} ")
    assert f"Examples:\n  qstereo {command} " in text
    assert run("help", command).out.decode() == text
    assert run(command, "-h", "--nonsense").out.decode() == text
    assert all(len(line) <= 80 for line in text.splitlines())


@pytest.mark.parametrize("command", COMMANDS)
def test_a_word_for_a_file_means_one_file(command):
    """S.qsf is not what is read here and what is written there; S is no time beside a scale."""
    operands = re.findall(r" ([A-Z]\S*\.\w+)", help_of(command).split(" -o ")[0].splitlines()[0])
    words = operands + [word for word, _ in options_in_help(command).values() if "." in word]
    assert len(set(words)) == len(words), words
    assert options_in_help(command).get("time-limit", ("SECONDS",))[0] == "SECONDS"


@pytest.mark.parametrize("command", COMMANDS)
def test_the_man_page_has_the_same_options(command):
    in_help = options_in_help(command)
    assert in_help.pop("help") == ("", "")
    assert "json" in in_help
    assert options_in_man(command) == in_help


def test_the_man_page_has_the_same_commands_and_version():
    assert (
        re.findall(r"^\.SS (\w+)$", MAN.split(".SH COMMANDS")[1].split(".SH")[0], re.M) == COMMANDS
    )
    version = run("--version").out.decode().split()[1]
    assert f'"qstereo {version}"' in MAN.splitlines()[0]


def test_the_man_page_names_every_key(solved, folder):
    import json

    outputs = [
        run("info", solved.problem, "--json"),
        run("info", solved.samples, "--json"),
        run("validate", solved.problem, solved.samples, "--json"),
        run("decode", solved.problem, solved.samples, "-o", folder / "m.pgm", "--json"),
        run("score", folder / "m.pgm", folder / "m.pgm", "--json"),
        run("solve", solved.problem, "-o", folder / "s.qsf", "--json"),
        run("compare", solved.problem, "--json"),
    ]
    section = MAN.split(".SH JSON")[1].split(".SH")[0]
    for done in outputs:
        facts = json.loads(done.out)
        for key in [*facts, *facts.get("results", [{}])[0]]:
            assert re.search(rf"\b{key}\b", section.replace("\\-", "-")), key


def test_version():
    text = run("--version", program=QSTEREO).out.decode()
    assert run("-V", program=QSTEREO).out.decode() == text
    assert re.fullmatch(
        r"qstereo \d+\.\d+\.\d+ "
        r"\(file format 1, pictures: (OpenCV \d+\.\d+\.\d+\S*|PNM only)\)\n",
        text,
    )
    assert has_opencv() == ("OpenCV" in text)


def completed_by_bash(folder, *words):
    """What bash offers for the last word of a command line."""
    (folder / "script").write_bytes(run("--completion", "bash").out)
    line = " ".join(word or "''" for word in words)
    ask = f"source ./script; COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _qstereo; "
    ask += "echo ${COMPREPLY[@]}"
    done = subprocess.run(["bash", "-c", ask], cwd=folder, capture_output=True, timeout=LONG)
    assert done.stderr == b""
    return done.stdout.decode().split()


@pytest.mark.skipif(not shutil.which("bash"), reason="bash is not installed")
def test_completion_of_bash(tmp_path):
    assert completed_by_bash(tmp_path, "qstereo", "enc") == ["encode"]
    assert completed_by_bash(tmp_path, "qstereo", "help", "comp") == ["compare"]
    assert completed_by_bash(tmp_path, "qstereo", "--completion", "") == ["bash", "zsh"]
    assert completed_by_bash(tmp_path, "qstereo", "--v") == ["--version"]
    (tmp_path / "p.qcf").touch()
    assert completed_by_bash(tmp_path, "qstereo", "info", "p") == ["p.qcf"]
    assert completed_by_bash(tmp_path, "qstereo", "solve", "-o", "p") == ["p.qcf"]
    for option in ("--solver", "--encoding", "--smoothness", "--penalty"):
        offered = completed_by_bash(tmp_path, "qstereo", "match", option, "")
        command = "solve" if option == "--solver" else "encode"
        listed = run(command, "l", *["r"] * (command == "encode"), "-o", "o", option, "x").err
        assert " ".join(offered) in listed.split("it can be: ")[1]
    offered = completed_by_bash(tmp_path, "qstereo", "match", "--preset", "")
    assert offered == ["paper", "accurate", "fast"]
    for command in COMMANDS:
        offered = completed_by_bash(tmp_path, "qstereo", command, "-")
        assert {word[2:] for word in offered if word[:2] == "--"} == set(options_in_help(command))


def test_completion_of_zsh(tmp_path):
    """The script has all commands and options, and zsh, if it is installed, can read it."""
    text = run("--completion", "zsh").out.decode()
    assert text.startswith("#compdef qstereo\n")
    for command in COMMANDS:
        section = re.search(rf"^    {command}\)$(.*?);;$", text, re.M | re.S).group(1)
        assert {*re.findall(r"'\*--([\w.-]+)\[", section), "help"} == set(options_in_help(command))
    assert re.search(r"'\*--solver\[[^\n]*:NAME:\(icm [a-z ]*best\)'", text)
    (tmp_path / "script").write_text(text)
    if shutil.which("zsh"):
        assert subprocess.run(["zsh", "-n", tmp_path / "script"]).returncode == 0


@pytest.mark.parametrize("arguments", [["--completion"], ["--completion", "fish"]])
def test_completion_of_other_shells(arguments):
    done = run(*arguments)
    assert (done.status, done.out) == (2, b"")
    assert "--completion needs the name of a shell: bash or zsh" in done.err


def test_both_builds_are_the_same_command(opencv, pnm_only):
    for command in COMMANDS:
        assert run(command, "--help").out == run(command, "--help", program=pnm_only).out


@pytest.mark.parametrize(
    "arguments, words",
    [
        (
            ["encod"],
            "unknown command encod: did you mean encode? The commands are: encode reduce "
            "info solve validate verify decode score match",
        ),
        (
            ["fly"],
            "unknown command fly: the commands are: encode reduce info solve validate verify "
            "decode score match",
        ),
        (["--verbose"], "unknown option --verbose"),
        (["help", "fly"], "unknown command fly"),
        (["info"], "the operand FILE is missing"),
        (["encode", "a", "b"], "-o FILE is missing"),
        (["encode", "a", "-o", "c"], "the operand RIGHT is missing"),
        (["encode", "a", "b", "c", "-o", "d"], "c is one operand too many"),
        (["encode", "-", "-", "-o", "d"], "only one operand can be -"),
        (["info", "a", "--json=yes"], "--json takes no argument"),
        (["info", "a", "--jso"], "did you mean --json?"),
        (["info", "a", "-x"], "unknown option -x"),
        (["info", ""], "the operand FILE is empty"),
        (["encode", "a", "b", "-o"], "-o needs an argument: FILE"),
        (["encode", "a", "b", "-o", "--json"], "-o needs an argument: FILE"),
        (["encode", "a", "b", "--lambda="], "--lambda: the argument L is empty"),
        (["info", "a", "--memory-limit", "0"], "--memory-limit 0 is not a whole number from 1"),
        (["info", "a", "--memory-limit", "4G"], "--memory-limit 4G is not a whole number"),
    ],
)
def test_usage_errors(arguments, words):
    done = run(*arguments)
    assert (done.status, done.out) == (2, b"")
    assert words in done.err and done.err.count("\n") == 1
    assert "--help)" in done.err


def test_options_stand_anywhere(tmp_path, pair):
    left, right = pair.paths
    spellings = [
        ["--disparity", "0:3", "-o", "1", left, right],
        [left, "--disparity=0:3", right, "-o2"],
        [left, right, "--output=3", "--disparity", "9:1", "--disparity", "0:3"],
        ["-o", "4", "--disparity=0:3", "--", left, right],
    ]
    for arguments in spellings:
        succeed("encode", *arguments, cwd=tmp_path)
    assert len({(tmp_path / name).read_bytes() for name in "1234"}) == 1
