"""The console script. Signals are handled from here on, before anything large is imported."""

import os
import signal
import sys

from .output import Output


def _stop(number, frame):
    """End at once: an exception could be lost in an import, and a sampler's thread or a service would hold it up."""
    try:
        Output.abandon()
        if not Output.kept:
            os.write(2, (b"\r\033[K" if os.isatty(2) else b"") + b"qstereo-bridge: interrupted\n")
    finally:
        os._exit(0 if Output.kept else 128 + number)


def run():
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _stop)
    from .cli import main
    sys.exit(main())


if __name__ == "__main__":
    run()
