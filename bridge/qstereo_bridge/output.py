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
    """(name, stream) of a new file beside `path`, under a name that nobody can have put a link at.
    It is removed where the `with` fails, and is else to get its own name there."""
    name = f"{path}.{secrets.token_hex(8)}.tmp"
    stream = open(name, "xb+")
    try:
        yield name, stream
    except BaseException:
        # What is buffered fails once more where the disk is full.
        for step in (stream.close, lambda: os.remove(name)):
            with contextlib.suppress(OSError):
                step()
        raise


class Output:
    """The file `path` ("-": stdout), made ready before the solver's work, so that nothing forbids
    writing after it.

    A regular file is written under a short name in the same folder. keep() gives it its own;
    without it the end of the `with` removes it. All methods raise OSError.

    pending     the temporaries of all outputs
    kept        whether a signal comes too late: what was to be written is
    """

    pending, kept = set(), False

    def __init__(self, path, last=True):
        self.path, self.straight, self.last, self.temporary = path, path == "-", last, None
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
        self.temporary = os.path.join(folder, f".qstereo-{secrets.token_hex(8)}.tmp")
        self.stream = open(self.temporary, "xb")
        Output.pending.add(self.temporary)

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
        Output.pending.discard(self.temporary)
        self.temporary, Output.kept = None, self.last

    @staticmethod
    def abandon():
        """Remove all temporaries."""
        while Output.pending:
            with contextlib.suppress(OSError):
                os.remove(Output.pending.pop())

    def __enter__(self):
        return self

    def __exit__(self, *error):
        if self.temporary:
            self.stream.close()
            with contextlib.suppress(OSError):
                os.remove(self.temporary)
            Output.pending.discard(self.temporary)


def save(file, data):
    """Write bytes to a path, whole or not at all, or to a binary stream. Raises FileError."""
    if hasattr(file, "write"):
        file.write(data)
        return
    with io(file, "write"), Output(os.fspath(file), last=False) as output:
        output.write(data)
        output.keep()
