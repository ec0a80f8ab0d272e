"""Writing a file whole or not at all."""

import os
import sys


def check_writable(path):
    """Raise OSError now where write() would fail after the solver's work: no such folder, no permission."""
    folder = os.path.dirname(os.path.realpath(path))
    if path == "-" or _is_device(path):
        return
    if os.path.isdir(path):
        raise IsADirectoryError("it is a folder; name a file")
    if not os.path.isdir(folder):
        raise FileNotFoundError(f"there is no folder {folder}; make it first")
    if not os.access(folder, os.W_OK) or (os.path.exists(path) and not os.access(path, os.W_OK)):
        raise PermissionError(f"no permission to write into {folder}")


def write(path, data):
    """Write `data` to `path` ("-": stdout). A regular file appears under its name only when it is whole. Raises OSError."""
    if path == "-":
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()
    elif _is_device(path):
        with open(path, "wb") as stream:
            stream.write(data)
    else:
        path = os.path.realpath(path)
        temporary = f"{path}.{os.getpid()}.tmp"
        try:
            with open(temporary, "xb") as stream:
                stream.write(data)
            os.replace(temporary, path)
        except BaseException:
            if os.path.exists(temporary):
                os.remove(temporary)
            raise


def _is_device(path):
    return os.path.exists(path) and not os.path.isfile(path) and not os.path.isdir(path)
