"""The command `inspect`: D-Wave's inspector on the samples of its annealer."""

from . import embedding, problem
from .failure import BAD_INPUT, IO, USAGE, Failure, failing, io


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
    if options.problem is None:
        raise Failure(USAGE, "the inspector needs the problem; name it with --problem P.qcf")
    whole = problem.load(options.problem, options.memory_limit)
    chains = dict(enumerate(samples.info.get("chains", [])))
    if options.embedding:
        with failing(options.embedding), io(options.embedding, "read"):
            chains = embedding.read(options.embedding).chains
    if len(chains) != len(whole):
        raise Failure(USAGE, f"{options.samples} does not tell the chains of the {len(whole):,} "
                      "variables; give --embedding E.json")
    dwave.inspector.show(
        whole.to_bqm(), samples.sampleset(whole),
        DWaveSampler(solver=samples.info.get("service_solver")), embedding_context={
            "embedding": chains, "chain_strength": samples.info.get("chain_strength")})
