"""The commands `export` and `inspect`: a problem, and samples of it, for other tools."""

import io as memory
import os

import numpy as np

from ..core import models, problem
from ..core.failure import BAD_INPUT, IO, USAGE, Failure, failing, io
from ..runs import runner


def bqm(found):
    """dimod's own binary file: BinaryQuadraticModel.from_file() reads it back equal."""
    with models.to_bqm(found).to_file() as file:
        return file.read()


def coo(found):
    """A line `i j value` for each term, `i i value` for each variable. The format knows no offset:
    a comment tells it."""
    linear, quadratic, offset = models.expand(found)
    every = np.arange(linear.size)
    return (f"# vartype=BINARY\n# offset {offset}\n# {found.scale} units are 1\n"
            + _lines(every, every, linear) + _lines(*quadratic)).encode()


def qubo(found):
    """The format of qbsolv: c lines are comments, p says how many nodes and couplers follow."""
    linear, quadratic, offset = models.expand(found)
    used = np.flatnonzero(linear)
    return (f"c offset {offset}\nc {found.scale} units are 1\n"
            f"p qubo 0 {linear.size} {used.size} {quadratic[0].size}\n"
            + _lines(used, used, linear[used]) + _lines(*quadratic)).encode()


def lp(found):
    """An LP file of variables x0, x1, .. with a constraint for each one-hot group, no penalties:
    dimod.lp.load() and integer programmers' tools read it."""
    import dimod.lp

    cqm, text = models.to_cqm(found), memory.StringIO()
    cqm.relabel_variables({v: f"x{v}" for v in cqm.variables})
    cqm.relabel_constraints({g: f"group{g}" for g in cqm.constraints})
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
        found = runner.read(options)
        data = FORMATS[end](found)
        deliver(data, f"{found.linear.size:,} variables\n{options.output}: written",
                {"variables": found.linear.size, "bytes": len(data)})


def inspect(options):
    """Open dwave-inspector with the samples in `options.samples`, where it is installed."""
    try:
        import dwave.inspector
        from dwave.system import DWaveSampler
    except ImportError as error:
        raise Failure(IO, f"{error.name} is not installed; `dwave install inspector` installs "
                      "D-Wave's inspector") from None
    samples = problem.load_samples(options.samples, options.memory_limit)
    if samples.solver != "qpu":
        raise Failure(BAD_INPUT, f"{options.samples}: samples of {samples.solver}; the inspector "
                      "shows those of the solver qpu")
    whole, chains = problem.load(options.problem, options.memory_limit), samples.info.get("chains")
    if options.embedding:
        from ..ocean import embedding

        with failing(options.embedding), io(options.embedding, "read"):
            chains = list(embedding.read(options.embedding).chains.values())
    if chains is None or len(chains) != len(whole):
        raise Failure(USAGE, f"{options.samples} does not tell the chains of the {len(whole):,} "
                      "variables; give --embedding E.json")
    # The inspector reads the embedding from the samples' info, and warnings of another form.
    found = samples.sampleset(whole)
    found.info.pop("warnings", None)
    found.info["embedding_context"] = {"embedding": dict(enumerate(chains)),
                                       "chain_strength": samples.info.get("chain_strength")}
    dwave.inspector.show(whole.to_bqm(), found,
                         DWaveSampler(solver=samples.info.get("service_solver")))
