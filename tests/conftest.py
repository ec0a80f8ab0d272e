"""What all tests share."""

import signal

# A shell ignores some signals for what it starts in the background, and so would every command
# that a test starts. The tests send these signals and expect what a terminal's user would see.
for name in ("SIGINT", "SIGQUIT", "SIGHUP"):
    signal.signal(getattr(signal, name), signal.SIG_DFL)
signal.signal(signal.SIGINT, signal.default_int_handler)
