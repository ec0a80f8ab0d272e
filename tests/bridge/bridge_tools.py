"""How the tests start the command."""

import sys

COMMAND = [sys.executable, "-m", "qstereo_bridge"]
