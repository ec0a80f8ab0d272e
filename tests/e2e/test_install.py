"""What `make` builds and installs, and what it asks of the machine."""

import os
import re
import subprocess

import pytest
from library import HEADERS, ROOT

OUTER = ("MAKEFLAGS", "MAKELEVEL", "MFLAGS")
ENVIRONMENT = {name: value for name, value in os.environ.items() if name not in OUTER}


def make(*arguments, status=0, **environment):
    done = subprocess.run(["make", *map(str, arguments)], cwd=ROOT, capture_output=True, text=True,
                          env={**ENVIRONMENT, **environment})
    assert done.returncode == status, done.stderr
    return done


def said_by(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def files_under(folder):
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if not path.is_dir()}


def flags_of(root):
    """What pkg-config says of the library installed under root/usr."""
    paths = {"PATH": "/usr/bin:/bin", "PKG_CONFIG_PATH": f"{root}/usr/lib/pkgconfig",
             "PKG_CONFIG_SYSROOT_DIR": str(root), "PKG_CONFIG_ALLOW_SYSTEM_CFLAGS": "1",
             "PKG_CONFIG_ALLOW_SYSTEM_LIBS": "1"}
    return subprocess.run(["pkg-config", "--cflags", "--libs", "qstereo"], capture_output=True,
                          text=True, check=True, env=paths).stdout.split()


def test_installed_library_builds_a_program(tmp_path):
    root = tmp_path / "root"
    make("-s", "install", f"DESTDIR={root}", "PREFIX=/usr", "NEED=")
    flags = flags_of(root)
    (tmp_path / "main.c").write_text("#include <stdio.h>\n#include <qstereo.h>\n"
                                     "int main(void) { puts(qs_status_text(QS_OK)); }\n")
    subprocess.run(["cc", "-std=c99", "main.c", *flags, "-o", "main"], cwd=tmp_path, check=True)
    done = subprocess.run([tmp_path / "main"], env={"LD_LIBRARY_PATH": f"{root}/usr/lib"},
                          capture_output=True, text=True, check=True)
    assert done.stdout == "done\n"
    (tmp_path / "main.cpp").write_text("#include <qstereo.h>\n"
                                       "int main() { return qs_status_text(QS_OK) == nullptr; }\n")
    subprocess.run(["c++", "-Wall", "-Werror", "main.cpp", *flags, "-o", "main"], cwd=tmp_path,
                   check=True)
    make("-s", "uninstall", f"DESTDIR={root}", "PREFIX=/usr")
    assert files_under(root) == set()


def test_folders_of_ones_own_and_no_symbols(tmp_path):
    where = [f"DESTDIR={tmp_path}", "PREFIX=/usr", "LIBDIR=/usr/lib/machine", "MANDIR=/man",
             "DOCDIR=/documents"]
    make("-s", "install", *where, "NEED=", "INSTALL_STRIP=1")
    installed = files_under(tmp_path)
    assert {"usr/bin/qstereo", "usr/lib/machine/libqstereo.so", "man/man1/qstereo.1",
            "usr/lib/machine/pkgconfig/qstereo.pc", "usr/share/zsh/site-functions/_qstereo",
            "usr/share/bash-completion/completions/qstereo"} <= installed
    package = (tmp_path / "usr/lib/machine/pkgconfig/qstereo.pc").read_text()
    assert "libdir=${prefix}/lib/machine\n" in package
    # What headers and man page refer to is there to be read.
    texts = "".join(path.read_text() for path in (*HEADERS, ROOT / "docs" / "qstereo.1"))
    named = set(re.findall(r"\b(?:docs/)?([A-Z]+\.md)\b", texts))
    assert "FORMAT.md" in named and {f"documents/docs/{name}" for name in named} <= installed
    assert {f"documents/examples/{path.name}" for path in (ROOT / "examples").glob("*.c")} <= (
        installed)
    for name in ("bin/qstereo", "lib/machine/libqstereo.so", "lib/machine/libqstereo.a"):
        sections = said_by("objdump", "-h", tmp_path / "usr" / name)
        assert ".text" in sections and ".debug" not in sections, name
    assert "qstereo" in said_by(tmp_path / "usr/bin/qstereo", "--version")
    (tmp_path / "documents" / "of-another").touch()
    make("-s", "uninstall", *where)
    assert files_under(tmp_path) == {"documents/of-another"}


def symbols(name, *options):
    lines = said_by("nm", *options, ROOT / "build" / name).splitlines()
    return {words[2] for words in map(str.split, lines) if len(words) == 3}


def test_the_shared_library_exports_what_headers_declare_and_nothing_else():
    text = "".join(path.read_text() for path in HEADERS)
    text = re.sub(r"/\*.*?\*/|^#.*?$|typedef[^;{]*;", "", text, flags=re.S | re.M)
    declared = set(re.findall(r"\b(qs_\w+)\(", text))
    defined = symbols("libqstereo.a", "-g", "--defined-only")
    assert len(declared) > 50 and declared <= defined
    assert symbols("libqstereo.so", "-D", "--defined-only") == declared
    assert len(defined - declared) > 50  # what its files share among themselves, it hides


@pytest.fixture
def bare_machine(tmp_path):
    """A PATH on which nothing is installed and apt-get writes down what it is asked for."""
    programs = {"dpkg-query": "exit 1", "apt-get": f'echo "$@" >> {tmp_path}/asked',
                "sudo": 'exec "$@"'}
    for name, does in programs.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{does}\n")
        (tmp_path / name).chmod(0o755)
    return {"PATH": f"{tmp_path}:{os.environ['PATH']}", "CXX": "false", "OPENCV": "1",
            "BUILD": str(tmp_path / "build")}


def test_plain_make_names_what_is_missing_and_installs_nothing(bare_machine, tmp_path):
    stamp = tmp_path / "build" / ".opencv"
    said = make(stamp, status=2, **bare_machine).stderr
    assert "apt-get install" in said and "libopencv-imgcodecs-dev" in said
    assert "make OPENCV=0" in said
    assert not (tmp_path / "asked").exists() and not stamp.exists()


@pytest.mark.parametrize("target", ["run", "check"])
def test_run_and_check_install_it(target, bare_machine, tmp_path):
    would = make("-n", target, **bare_machine).stdout.replace("\\\n", "")
    command = next(line for line in would.splitlines() if "libopencv-imgcodecs-dev" in line)
    subprocess.run(["sh", "-c", command], cwd=ROOT, check=True, capture_output=True,
                   env={**ENVIRONMENT, **bare_machine})
    assert "libopencv-imgcodecs-dev" in (tmp_path / "asked").read_text()


def test_the_kind_of_the_build_is_remembered(tmp_path):
    """Without a compiler: what matters is which command would be linked, and what is said."""
    quick = [f"BUILD={tmp_path}", "CC=true", "AR=true", "Q=@true ", "NEED="]
    assert "remembered" in make(*quick, "OPENCV=0").stdout
    again = make("-n", *quick).stdout
    assert "remembered" in again and "opencv_core" not in again
    assert "opencv_core" in make("-n", *quick, "OPENCV=1").stdout
