import json
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from library import BRIDGE, QSTEREO  # noqa: E402


@pytest.fixture
def run(tmp_path):
    """Runs a command line in a folder of its own and returns its stdout; `qstereo` and
    `qstereo-bridge` are this tree's.
    """
    def call(command, *arguments, status=0):
        program = {"qstereo": QSTEREO, "qstereo-bridge": BRIDGE}[command]
        done = subprocess.run([str(program), *map(str, arguments)], cwd=tmp_path,
                              capture_output=True, text=True)
        assert done.returncode == status, done.stderr
        return json.loads(done.stdout) if "--json" in arguments else done.stdout
    return call
