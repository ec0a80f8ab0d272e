"""What all tests share."""

import signal

# A shell ignores these signals for what it starts in the background, and so would every command
# that a test starts. The tests send them and expect what a user at a terminal sees.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGQUIT, signal.SIG_DFL)
signal.signal(signal.SIGHUP, signal.SIG_DFL)
