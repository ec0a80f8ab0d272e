"""Help, versions, the parser, and the man page, which must say the same as --help."""
import re

import pytest
from cli_tools import ROOT, has_opencv, run

COMMANDS = ["encode", "reduce", "info", "solve", "validate", "decode", "score", "match", "compare"]
MAN = (ROOT / "docs" / "qstereo.1").read_text()


def help_of(command):
    done = run(command, "--help")
    assert (done.status, done.err) == (0, "")
    return done.out.decode()


def options_in_help(command):
    """Of each option its argument ("" = a flag) and its default."""
    rows = re.findall(r"^  (?:-\w, |    )--([\w.-]+)(?: (\S+))?  +(.*)$", help_of(command), re.M)
    return {name: (argument, (re.findall(r"\(default (.*?)\)$", text) or [""])[0]) for name, argument, text in rows}


def options_in_man(command):
    section = re.search(rf"^\.SS {command}$(.*?)(?=^\.S[SH] )", MAN, re.M | re.S).group(1)
    plain = re.sub(r"\\f[BIR]", "", section).replace("\\-", "-")
    found = {}
    for line, text in re.findall(r"^\.TP\n(.*)\n((?:(?!\.TP|\.P|\.S).*\n)*)", plain, re.M):
        name, argument = re.match(r"(?:-\w, )?--([\w.-]+)(?: (\S+))?$", line).groups()
        found[name] = (argument or "", (re.findall(r"\(default (.*?)\)\.?$", text.replace("\n", " ").strip()) or [""])[0])
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
    assert all(len(line) < 125 for line in text.splitlines())


@pytest.mark.parametrize("command", COMMANDS)
def test_the_man_page_has_the_same_options(command):
    in_help = options_in_help(command)
    assert in_help.pop("help") == ("", "")
    assert "json" in in_help
    assert options_in_man(command) == in_help


def test_the_man_page_has_the_same_commands_and_version():
    assert re.findall(r"^\.SS (\w+)$", MAN.split(".SH COMMANDS")[1].split(".SH")[0], re.M) == COMMANDS
    version = run("--version").out.decode().split()[1]
    assert f'"qstereo {version}"' in MAN.splitlines()[0]


def test_the_man_page_names_every_key(solved, folder):
    import json
    outputs = [run("info", solved.problem, "--json"), run("info", solved.samples, "--json"),
               run("validate", solved.problem, solved.samples, "--json"),
               run("decode", solved.problem, solved.samples, "-o", folder / "m.pgm", "--json"),
               run("score", folder / "m.pgm", folder / "m.pgm", "--json"),
               run("solve", solved.problem, "-o", folder / "s.qsf", "--json"), run("compare", solved.problem, "--json")]
    section = MAN.split(".SH JSON")[1].split(".SH")[0]
    for done in outputs:
        facts = json.loads(done.out)
        for key in [*facts, *facts.get("results", [{}])[0]]:
            assert re.search(rf"\b{key}\b", section.replace("\\-", "-")), key


def test_version():
    text = run("--version").out.decode()
    assert re.fullmatch(r"qstereo 0\.1\.0 \(file format 1, pictures: (OpenCV \d+\.\d+\.\d+\S*|PNM only)\)\n", text)
    assert has_opencv() == ("OpenCV" in text)


@pytest.mark.parametrize("arguments, words", [
    (["encod"], "encod is no command: did you mean encode? The commands: encode reduce info solve validate decode score match"),
    (["fly"], "fly is no command. The commands: encode reduce info solve validate decode score match"),
    (["--verbose"], "--verbose is no command"),
    (["help", "fly"], "fly is no command"),
    (["info"], "the operand FILE is missing"),
    (["encode", "a", "b"], "-o FILE is missing"),
    (["encode", "a", "-o", "c"], "the operand RIGHT is missing"),
    (["encode", "a", "b", "c", "-o", "d"], "c is one operand too many"),
    (["encode", "-", "-", "-o", "d"], "only one operand can be -"),
    (["info", "a", "--json=yes"], "--json takes no argument"),
    (["info", "a", "--jso"], "did you mean --json?"),
    (["info", "a", "-x"], "-x is no option"),
    (["info", ""], "the operand FILE is empty"),
    (["encode", "a", "b", "-o"], "-o needs its argument, FILE"),
    (["encode", "a", "b", "-o", "--json"], "-o needs its argument, FILE"),
    (["encode", "a", "b", "--lambda="], "--lambda: the argument L is empty"),
    (["info", "a", "--memory-limit", "0"], "--memory-limit 0: not a whole number from 1"),
    (["info", "a", "--memory-limit", "4G"], "--memory-limit 4G: not a whole number"),
])
def test_usage_errors(arguments, words):
    done = run(*arguments)
    assert (done.status, done.out) == (2, b"")
    assert words in done.err and done.err.count("\n") == 1
    assert "--help)" in done.err


def test_options_stand_anywhere(tmp_path, pair):
    left, right = pair.paths
    spellings = [["--disparity", "0:3", "-o", "1", left, right], [left, "--disparity=0:3", right, "-o2"],
                 [left, right, "--output=3", "--disparity", "9:1", "--disparity", "0:3"], ["-o", "4", "--disparity=0:3", "--", left, right]]
    for arguments in spellings:
        done = run("encode", *arguments, cwd=tmp_path)
        assert done.status == 0, done.err
    assert len({(tmp_path / name).read_bytes() for name in "1234"}) == 1
