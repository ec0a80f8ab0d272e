"""The command `export`: a problem as a file that other tools read."""

import io
import json
import os

import numpy as np

from . import models, runner
from .failure import USAGE, Failure


def bqm(problem, limit):
    """dimod's own binary file: BinaryQuadraticModel.from_file() reads it back equal."""
    with models.to_bqm(problem, limit).to_file() as file:
        return file.read()


def coo(problem, limit):
    """A line `i j value` for each term, `i i value` for each variable. The format knows no offset:
    a comment tells it."""
    linear, quadratic, offset = models.expand(problem, limit=limit)
    return (f"# vartype=BINARY\n# offset {offset}\n# {problem.scale} units are 1\n"
            + _lines(np.arange(linear.size), np.arange(linear.size), linear)
            + _lines(*quadratic)).encode()


def qubo(problem, limit):
    """The format of qbsolv: c lines are comments, p says how many nodes and couplers follow."""
    linear, quadratic, offset = models.expand(problem, limit=limit)
    used = np.flatnonzero(linear)
    return (f"c offset {offset}\nc {problem.scale} units are 1\n"
            f"p qubo 0 {linear.size} {used.size} {quadratic[0].size}\n"
            + _lines(used, used, linear[used]) + _lines(*quadratic)).encode()


def lp(problem, limit):
    """An LP file of variables x0, x1, .. with a constraint for each one-hot group, no penalties:
    dimod.lp.load() and integer programmers' tools read it."""
    import dimod.lp

    cqm = models.to_cqm(problem, limit)
    cqm.relabel_variables({v: f"x{v}" for v in cqm.variables})
    cqm.relabel_constraints({g: f"group{g}" for g in cqm.constraints})
    text = io.StringIO()
    dimod.lp.dump(cqm, text)
    return text.getvalue().encode()


def _lines(*columns):
    return "".join(map("%d %d %d\n".__mod__, zip(*(column.tolist() for column in columns))))


FORMATS = {".bqm": bqm, ".coo": coo, ".lp": lp, ".qubo": qubo}


def export(options):
    """Write `options.problem` to `options.output`, whose end names the format."""
    end = os.path.splitext(options.output)[1]
    if end not in FORMATS:
        raise Failure(USAGE, f"{options.output} ends in none of {', '.join(FORMATS)}; the end "
                      "names the format")
    with runner.output_of(options) as deliver:
        problem = runner.read(options)
        data = FORMATS[end](problem, options.memory_limit)
        found = {"schema": 1, "variables": problem.linear.size, "bytes": len(data)}
        deliver(data, json.dumps(found) if options.json else
                f"{found['variables']:,} variables\n{options.output}: written")
