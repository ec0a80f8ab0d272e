"""The package's own errors, each with the exit status that the command gives for it."""

import contextlib

OK, NO, USAGE, BAD_INPUT, IO, SERVICE = 0, 1, 2, 3, 4, 5
# Which extra of the package brings a module; all others come with `dwave`.
EXTRAS = {"scipy": "exact", "matplotlib": "picture", "jinja2": "report",
          "dask": "dask", "distributed": "dask"}


class Error(Exception):
    """Whatever the package refuses: its message is for people, `status` is the exit status."""

    status = BAD_INPUT


class Failure(Error):
    """An end of the command: exit status and message."""

    def __init__(self, status, message):
        super().__init__(message)
        self.status = status


class FileError(Failure):
    """What the system refuses to read or write. The message names the file."""

    def __init__(self, message):
        super().__init__(IO, message)


class InputError(Error, ValueError):
    """An argument of the wrong shape, values or kind, or samples of another problem."""


class SolverError(Error):
    """The solver failed, refused the problem, or answered something that cannot be. `code` is the
    status of HTTP, where a service said one."""

    status = SERVICE

    def __init__(self, message, code=None):
        super().__init__(message)
        self.code = code


@contextlib.contextmanager
def io(name, what):
    """What the system refuses is a FileError that names the file."""
    try:
        yield
    except OSError as error:
        raise FileError(f"{name}: cannot {what}: {error.strerror or error}") from None


@contextlib.contextmanager
def failing(name):
    """Whatever goes wrong with the file `name` is a Failure that names it."""
    prefix = f"{name}: " if name else ""
    try:
        yield
    except MemoryError:
        raise Failure(IO, f"{prefix}this machine has not enough memory for it") from None
    except ImportError as error:
        module = (error.name or str(error)).split(".")[0]
        raise Failure(SERVICE, f"{prefix}{module} is not installed; in the project's "
                      f"folder: pip install './bridge[{EXTRAS.get(module, 'dwave')}]'") from None
    except Failure:
        raise
    except Error as error:
        raise Failure(error.status, f"{prefix}{error}") from None
