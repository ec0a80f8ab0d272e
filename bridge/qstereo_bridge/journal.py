"""The journal of a run of many calls: JSON, one line a call, each on the disk before the next call.

After any end of the process, kill -9 and a power cut among them, the lines that are whole say what
has been done. A line that was cut off is of a call whose answer its job file still leads to.
"""

import json
import os

from .failure import NO, Failure, io
from .jobs import lock


class Journal:
    """The journal in the file `path`, locked while it is open.

    head        dict: what the run is; a journal of another run is refused
    lines       list of dicts, one for each call that is done
    Raises Failure.
    """

    def __init__(self, path, head):
        self.path, self.lines = path, []
        with io(path, "write"):
            self.stream = open(path, "ab+")
            lock(self.stream, path)
            self.stream.seek(0)
            found, end = [], 0
            for line in self.stream.read().splitlines(keepends=True):
                try:
                    found.append(json.loads(line if line.endswith(b"\n") else b""))
                except ValueError:
                    break
                end += len(line)
            if found and found[0] != head:
                self.stream.close()
                raise Failure(NO, f"{path}: the journal of another run (its problem, --windows, "
                                  "--seed, --solver or --start differ); give another -o, or remove "
                                  "the journal to begin anew")
            self.stream.truncate(end)
        self.lines = found[1:]
        if not found:
            self._write(head)

    def _write(self, line):
        with io(self.path, "write"):
            self.stream.write(json.dumps(line).encode() + b"\n")
            self.stream.flush()
            os.fsync(self.stream.fileno())

    def append(self, line):
        """Add the line of a call, and have it on the disk."""
        self._write(line)
        self.lines.append(line)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.stream.close()
