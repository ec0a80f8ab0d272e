"""Ends of the command: their exit statuses, and one exception for all of them."""

import contextlib

OK, NO, USAGE, BAD_INPUT, IO, SERVICE = 0, 1, 2, 3, 4, 5


class Failure(Exception):
    """An end of the command: exit status and message."""

    def __init__(self, status, message):
        super().__init__(message)
        self.status = status


@contextlib.contextmanager
def io(name, what):
    """What the system refuses is a Failure that names the file."""
    try:
        yield
    except OSError as error:
        raise Failure(IO, f"{name}: cannot {what}: {error.strerror or error}") from None
