import os
import subprocess
import sys
from pathlib import Path

import pytest
from qstereo_bridge import cli, qcf

sys.path.insert(0, str(Path(__file__).parent))

from bridge_tools import COMMAND  # noqa: E402
from problems import grid  # noqa: E402
from service import TOKEN, Service  # noqa: E402, F401


@pytest.fixture
def problem_file(tmp_path):
    """A .qcf of 2 x 2 sites and 3 labels."""
    path = tmp_path / "tiny.qcf"
    path.write_bytes(qcf.pack_qcf(grid(2, 2, 3)))
    return path


@pytest.fixture
def environment(tmp_path):
    """The environment of a user without any D-Wave configuration."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith("DWAVE_")}
    return {**kept, "HOME": str(tmp_path), "DWAVE_CONFIG_FILE": "/dev/null", "DWAVE_CACHE_ENABLED": "false"}


@pytest.fixture
def command(environment):
    """Runs qstereo-bridge in a process of its own."""
    def run(*arguments, **options):
        options = {"env": environment, "capture_output": True, "timeout": 60, **options}
        arguments = [word if isinstance(word, bytes) else str(word) for word in arguments]
        found = subprocess.run([*COMMAND, *arguments], **options)
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
        assert not path.is_file() or path.name == "dwave.conf" or TOKEN.encode() not in path.read_bytes()


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
