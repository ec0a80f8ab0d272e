"""The project as a whole: one version, an installation that works, documents that keep their word."""

import re
import subprocess

import qstereo_bridge
from library import QSTEREO, ROOT


def test_one_version():
    header = (ROOT / "libqstereo" / "include" / "qstereo" / "version.h").read_text()
    version = re.search(r'QS_VERSION "(.*)"', header)[1]
    parts = [re.search(rf"QS_VERSION_{part} (\d+)", header)[1] for part in ("MAJOR", "MINOR", "PATCH")]
    assert version == ".".join(parts)
    assert qstereo_bridge.__version__ == version
    assert version in subprocess.run([QSTEREO, "--version"], capture_output=True, text=True).stdout
    assert (ROOT / "NEWS").read_text().startswith(f"qstereo {version}")


def test_installed_library_builds_a_program(tmp_path):
    def make(target):
        subprocess.run(["make", "-s", target, f"DESTDIR={tmp_path}/root", "PREFIX=/usr", "NEED="], cwd=ROOT, check=True,
                       capture_output=True)
    make("install")
    prefix = tmp_path / "root" / "usr"
    (tmp_path / "main.c").write_text('#include <qstereo.h>\n#include <stdio.h>\nint main(void) { puts(qs_status_text(QS_OK)); }\n')
    (tmp_path / "main.cpp").write_text('#include <qstereo.h>\nint main() { return qs_status_text(QS_OK) == nullptr; }\n')
    flags = subprocess.run(["pkg-config", "--cflags", "--libs", "qstereo"], capture_output=True, text=True, check=True,
                           env={"PATH": "/usr/bin:/bin", "PKG_CONFIG_PATH": f"{prefix}/lib/pkgconfig",
                                "PKG_CONFIG_SYSROOT_DIR": f"{tmp_path}/root", "PKG_CONFIG_ALLOW_SYSTEM_CFLAGS": "1",
                                "PKG_CONFIG_ALLOW_SYSTEM_LIBS": "1"}).stdout.split()
    subprocess.run(["cc", "-std=c99", "main.c", *flags, "-o", "main"], cwd=tmp_path, check=True)
    done = subprocess.run([tmp_path / "main"], env={"LD_LIBRARY_PATH": f"{prefix}/lib"}, capture_output=True, text=True, check=True)
    assert done.stdout == "done\n"
    subprocess.run(["c++", "-Wall", "-Werror", "main.cpp", *flags, "-o", "main"], cwd=tmp_path, check=True)
    make("uninstall")
    assert [path for path in prefix.rglob("*") if not path.is_dir()] == []


def test_a_sample_pair_is_as_its_generator_makes_it():
    subprocess.run([ROOT / ".venv" / "bin" / "python", ROOT / "samples" / "rendered" / "generate.py", "--check"], check=True)


def test_words_that_the_readme_promises():
    readme = (ROOT / "README.md").read_text()
    for command in ("make run", "make check", "qstereo encode", "qstereo-bridge solve", "qstereo validate", "qstereo decode", "qstereo score"):
        assert command in readme
    for link in re.findall(r"\]\(([^)#:]+)\)", readme):
        assert (ROOT / link).exists(), link
