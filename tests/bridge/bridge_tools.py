"""How the tests start the command."""

import os
import sys

COMMAND = [sys.executable, "-m", "qstereo_bridge"]


def forked(arguments, environment, folder, streams):
    """The command as a process has it; `streams` are the files for stdin, stdout and stderr."""
    for number, path in enumerate(streams):
        os.dup2(os.open(path, os.O_RDWR), number)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    sys.argv = ["qstereo-bridge", *arguments]
    from qstereo_bridge.__main__ import run
    run()
