"""Writing a file whole or not at all."""

import contextlib
import os
import secrets
import stat

from .failure import io


def sync_folder(path):
    """Have the names in the folder of `path` on the disk, where the system can."""
    with contextlib.suppress(OSError):
        folder = os.open(os.path.dirname(path) or ".", os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


@contextlib.contextmanager
def temporary(path):
    """(name, stream) of a new file in the folder of `path`, under a short name that nobody can have
    put a link at. When the `with` ends, or a signal ends all, it has got its own name or goes."""
    name = os.path.join(os.path.dirname(path), f".qstereo-{secrets.token_hex(8)}.tmp")
    stream = open(name, "xb")
    Output.pending.add(name)
    try:
        yield name, stream
    except BaseException:
        # What is buffered fails once more where the disk is full.
        with contextlib.suppress(OSError):
            stream.close()
        raise
    finally:
        with contextlib.suppress(OSError):
            os.remove(name)
        Output.pending.discard(name)


class Output:
    """The file `path` ("-": stdout), made ready before the solver's work, so that nothing forbids
    writing after it. keep() gives it its own name, as one step; without it the end of the `with`
    removes it. All methods raise OSError.

    pending     the temporaries of all outputs
    kept        whether a signal comes too late: what was to be written is
    """

    pending, kept = set(), False

    def __init__(self, path, last=True):
        self.path, self.straight, self.last = path, path == "-", last
        self.end = contextlib.ExitStack()
        if self.straight:
            return
        # stat and not os.path.exists, which passes over names that are too long.
        with contextlib.suppress(FileNotFoundError):
            mode = os.stat(path or ".").st_mode
            if stat.S_ISDIR(mode):
                raise IsADirectoryError("it is a folder; name a file")
            self.straight = not stat.S_ISREG(mode)
            if not os.access(path, os.W_OK):
                raise PermissionError("no permission")
        if self.straight:
            return
        # A link is followed: the file it leads to is replaced, not the link.
        self.path = os.path.realpath(path)
        folder = os.path.dirname(self.path)
        if not os.path.isdir(folder):
            raise FileNotFoundError(f"there is no folder {folder}; make it first")
        self.temporary, self.stream = self.end.enter_context(temporary(self.path))
        self.end.callback(self.stream.close)

    def write(self, data):
        if self.straight:
            path = self.path
            with open(1 if path == "-" else path, "wb", closefd=path != "-") as stream:
                stream.write(data)
            return
        with self.stream as stream:
            stream.write(data)
            # A job is forgotten once its answer is on the disk.
            stream.flush()
            os.fsync(stream.fileno())

    def keep(self):
        if not self.straight:
            os.replace(self.temporary, self.path)
            sync_folder(self.path)
        Output.kept = self.last

    @staticmethod
    def abandon():
        """Remove all temporaries."""
        while Output.pending:
            with contextlib.suppress(OSError):
                os.remove(Output.pending.pop())

    def __enter__(self):
        return self

    def __exit__(self, *error):
        return self.end.__exit__(*error)


def save(file, data):
    """Write bytes to a path, whole or not at all, or to a binary stream. Raises FileError."""
    if hasattr(file, "write"):
        file.write(data)
        return
    with io(file, "write"), Output(os.fspath(file), last=False) as output:
        output.write(data)
        output.keep()
