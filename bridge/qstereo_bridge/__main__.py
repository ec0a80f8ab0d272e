"""The console script. Signals are handled from here on, before anything large is imported."""

import contextlib
import os
import signal
import sys
import threading

from .core.output import Output


def _stop(number, frame):
    """End at once: an exception could be lost in an import, and a sampler's thread or a service
    would hold it up.

    What is at a service is told of, and after Ctrl-C cancelled if it has not begun; a second signal
    does not wait for that.
    """
    try:
        signal.signal(number, lambda number, frame: os._exit(128 + number))
        Output.abandon()
        embedding = sys.modules.get(f"{__package__}.ocean.embedding")
        for child in list(getattr(embedding, "searching", ())):
            child.kill()
        if not Output.kept:
            clear = "\r\033[K" if os.isatty(2) else ""
            jobs = sys.modules.get(f"{__package__}.runs.jobs")
            told = getattr(jobs, "interrupted", lambda cancel: [])(number == signal.SIGINT)
            lines = [f"qstereo-bridge: interrupted{said}\n"
                     for said in [f"; {line}" for line in told] or [""]]
            os.write(2, (clear + "".join(lines)).encode(errors="backslashreplace"))
    finally:
        os._exit(0 if Output.kept else 128 + number)


def run():
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _stop)
    from .desk.cli import main
    status = main()
    if threading.active_count() > 1:
        # What is no longer waited for, as HiGHS at a time limit, aborts in an orderly end.
        for stream in filter(None, (sys.stdout, sys.stderr)):
            with contextlib.suppress(OSError):
                stream.flush()
        os._exit(status)
    sys.exit(status)


if __name__ == "__main__":
    run()
