import multiprocessing
import os
import subprocess
import sys
from multiprocessing import forkserver
from pathlib import Path

import pytest
from qstereo_bridge.desk import cli

sys.path.insert(0, str(Path(__file__).parent))

from bridge_tools import COMMAND, forked  # noqa: E402
from problems import grid, pack_qcf  # noqa: E402
from service import TOKEN, Service  # noqa: E402, F401


@pytest.fixture
def problem_file(tmp_path):
    """A .qcf of 2 x 2 sites and 3 labels."""
    path = tmp_path / "tiny.qcf"
    path.write_bytes(pack_qcf(grid(2, 2, 3)))
    return path


@pytest.fixture
def environment(tmp_path):
    """The environment of a user without any D-Wave configuration."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith("DWAVE_")}
    return {**kept, "HOME": str(tmp_path), "DWAVE_CONFIG_FILE": "/dev/null",
            "DWAVE_CACHE_ENABLED": "false"}


@pytest.fixture(scope="session")
def processes():
    """Processes that have the modules already: to import them takes longer than most commands."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["qstereo_bridge.desk.frames", "dwave.cloud.client",
                                    "dwave.cloud.api.resources", "dwave.optimization",
                                    "dwave.samplers", "dimod", "distributed"])
    # Those of dask come from it, too: whoever starts it says what it has.
    forkserver.ensure_running()
    return context


@pytest.fixture
def command(environment, processes, tmp_path_factory):
    """Runs qstereo-bridge in a process of its own; in a new interpreter where `options` for it are
    given."""
    def run(*arguments, input=b"", cwd=".", **options):
        arguments = [word if isinstance(word, bytes) else str(word) for word in arguments]
        if options:
            options = {"env": environment, "capture_output": True, "timeout": 600, "cwd": cwd,
                       **options}
            if options.get("stdin") is None:
                options["input"] = input
            found = subprocess.run([*COMMAND, *arguments], **options)
        else:
            streams = [tmp_path_factory.mktemp("streams") / name for name in ("stdin", "stdout",
                "stderr")]
            for path in streams:
                path.write_bytes(input if path.name == "stdin" else b"")
            process = processes.Process(target=forked, args=(list(map(os.fsdecode, arguments)),
                                                             environment, str(cwd), streams),
                                        daemon=True)
            process.start()
            process.join(600)
            found = subprocess.CompletedProcess(arguments, process.exitcode, *(path.read_bytes()
                for path in streams[1:]))
        assert TOKEN.encode() not in (found.stdout or b"") + (found.stderr or b"")
        return found
    return run


@pytest.fixture
def main(capsys):
    """Runs the command in this process: (exit status, stdout, stderr)."""
    def run(*arguments):
        status = cli.main(list(map(str, arguments)))
        out, err = capsys.readouterr()
        assert TOKEN not in out + err
        return status, out, err
    return run


@pytest.fixture(autouse=True)
def no_token_in_any_file(tmp_path):
    yield
    for path in tmp_path.rglob("*"):
        assert (not path.is_file() or path.name == "dwave.conf"
                or TOKEN.encode() not in path.read_bytes())


@pytest.fixture
def service(environment, monkeypatch):
    """A service on the loopback interface, where `main` and `command` look for D-Wave's."""
    with Service() as service:
        environment.update(service.environment)
        for name, value in service.environment.items():
            monkeypatch.setenv(name, value)
        yield service


@pytest.fixture(scope="session", autouse=True)
def no_account(tmp_path_factory):
    """No test asks a real service."""
    with pytest.MonkeyPatch.context() as patch:
        for name in [name for name in os.environ if name.startswith("DWAVE_")]:
            patch.delenv(name)
        patch.setenv("DWAVE_CONFIG_FILE", "/dev/null")
        patch.setenv("DWAVE_CACHE_ENABLED", "false")
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield
