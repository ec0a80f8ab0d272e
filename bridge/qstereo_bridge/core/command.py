"""What the command `qstereo` does for Python: a problem made of arrays, and the labels of samples.

Arrays go to the command as .npy files in a folder that is removed, so that nothing here knows how
labels become bits.
"""

import os
import re
import shutil
import subprocess
import tempfile
import warnings
from pathlib import Path

import numpy as np

from .failure import BAD_INPUT, IO, USAGE, Failure, InputError, io


def call(folder, *words):
    """Run qstereo in `folder`: what it prints. What it refuses is an InputError or Failure with its
    sentence."""
    found = shutil.which(os.environ.get("QSTEREO") or "qstereo")
    if not found:
        raise Failure(IO, "the command qstereo is needed and was not found: put it on the PATH, or "
                          "its path into the environment variable QSTEREO")
    with io(found, "run"):
        done = subprocess.run([os.path.abspath(found), *words], cwd=folder, capture_output=True,
                              stdin=subprocess.DEVNULL, text=True, errors="replace")
    if done.returncode == 0:
        for line in re.findall(r"^qstereo [a-z]+: (.*)$", done.stderr, re.MULTILINE):
            warnings.warn(line.replace("warning: ", "", 1), stacklevel=4)
        return done.stdout
    said = re.sub(r"^qstereo [a-z]+: | \(help: [^)]*\)$", "", done.stderr.strip())
    if done.returncode in (USAGE, BAD_INPUT):
        raise InputError(said)
    if done.returncode < 0:
        raise Failure(IO, f"{found} was ended by signal {-done.returncode}")
    raise Failure(done.returncode, said)


def _text(value):
    """A number as the command reads it, without an exponent."""
    return (np.format_float_positional(value, trim="-") if isinstance(value, (float, np.floating))
            else str(value))


def _named(given, edges):
    """The arrays of each option, with the names that their files get.

    given       the arguments right, down, weights, tables, mask and pairwise, where they are arrays
    """
    if (edges is None) == ("weights" in given) and given.keys() & {"weights", "right", "down"}:
        raise InputError("right and down are the weights of a grid, weights those of edges")
    found = {f"--{key}": {key: given[key]} for key in ("mask", "pairwise") if key in given}
    if edges is not None:
        found["--edges"] = {"edges": edges}
        return found | {f"--{key}": {key: given[key]} for key in ("weights", "tables")
                        if key in given}
    if given.keys() & {"right", "down"}:
        found["--weights"] = {key: given.get(key) for key in ("right", "down")}
    if "tables" in given:
        if len(given["tables"]) != 2:
            raise InputError("tables of a grid are two arrays, of the edges to the right and down")
        found["--tables"] = dict(zip(("tables-right", "tables-down"), given["tables"], strict=True))
    return found


def encode(costs, pairwise, edges, arrays, options):
    """The bytes of the .qcf that `qstereo encode --problem label` makes; see problem.Problem."""
    arrays = {key: array for key, array in arrays.items() if array is not None}
    if isinstance(pairwise, str):
        options["smoothness"] = pairwise
    elif pairwise is not None:
        arrays["pairwise"] = pairwise
    words = [f"--{key}={_text(value)}" for key, value in options.items() if value is not None]
    with tempfile.TemporaryDirectory(prefix="qstereo-") as name:
        for option, group in {"": {"costs": costs}, **_named(arrays, edges)}.items():
            for key, array in group.items():
                array = np.asarray(array)
                if array.dtype.kind not in "biuf":
                    raise InputError(f"{key} is missing, or is no array of numbers")
                with io(f"{key}.npy", "write"):  # in the byte order that the command reads
                    np.save(f"{name}/{key}.npy", array.astype(array.dtype.newbyteorder("="), "C"))
            files = ",".join(f"{key}.npy" for key in group)
            words.append(f"{option}={files}" if option else files)
        call(name, "encode", "--problem=label", *words, "-o", "problem.qcf")
        return Path(name, "problem.qcf").read_bytes()


def decode(problem, samples, sample, repair):
    """The array of problem.decode."""
    with tempfile.TemporaryDirectory(prefix="qstereo-") as name:
        words = ["problem.qcf", "-o", "labels.npy", *["--repair"] * repair]
        problem.save(f"{name}/problem.qcf")
        if samples is not None:
            samples.save(f"{name}/samples.qsf")
            words.append("samples.qsf")
        call(name, "decode", *words, *([] if sample is None else [f"--sample={sample}"]))
        return np.load(f"{name}/labels.npy")
