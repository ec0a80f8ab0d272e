"""The command `embed`: a minor embedding as a file, as figures, and as a picture."""

import json

import networkx as nx

from . import embedding, picture, runner
from .failure import IO, NO, USAGE, Failure, io
from .output import Output

# By the encoding that a problem has: those with fewer couplers on a chip.
SPARSER = {2: None, 3: "one-hot-sparse"}


def embed(options):
    """Embed, draw, print. The embedding's file gets its name before the picture."""
    drawing = None
    if options.picture:
        try:
            picture.require()
        except ImportError:
            raise Failure(IO, f"{options.picture}: a picture needs matplotlib; "
                              "pip install 'qstereo-bridge[picture]'") from None
        with io(options.picture, "write"), Output(options.picture, last=False):
            pass
    with runner.output_of(options, last=not options.picture) as deliver:
        problem, progress = runner.read(options), runner.progress(options)
        if problem.linear.size == 0:
            raise Failure(NO, f"{options.problem}: nothing is left to decide, so there is nothing "
                              "to embed")
        try:
            chip = embedding.Chip.named(options.topology)
        except ValueError as error:
            raise Failure(USAGE, str(error)) from None
        source = embedding.Source.of(problem, options.memory_limit)
        try:
            found = embedding.find(source, chip, options.seed, options.timeout, progress)
            embedding.keep(found, source, chip)
            if options.picture:
                progress("picture")
                drawing = picture.draw(source, chip, found)
        except embedding.NoEmbedding as error:
            raise Failure(NO, f"{options.problem}: {error}; {_advice(problem, source, error)}"
                          ) from None
        finally:
            progress(None)
        deliver(found.to_json().encode(), _summary(options, source, chip, found))
    if options.picture:
        with io(options.picture, "write"), Output(options.picture) as output:
            output.write(drawing)
            output.keep()


def _advice(problem, source, error):
    """What helps against a chip that is too small, or against a search that was too short."""
    parts = nx.number_connected_components(source.graph)
    sparser = SPARSER.get(problem.encoding, "one-hot-sparse or domain-wall")
    advice = ["" if parts == 1 else f"solve its {parts:,} parts, which share no coupling, each by "
              "itself (Problem.parts in Python)",
              "make it smaller with `qstereo reduce` or a smaller window (encode --roi)",
              sparser and f"encode it with fewer couplers (--encoding {sparser})",
              "" if isinstance(error, embedding.Hopeless) else
              "search with another --seed or a longer --timeout"]
    return ", or ".join(filter(None, advice))


def _summary(options, source, chip, found):
    figures, total = found.figures(), int(chip.qubits.size)
    share, couplers = figures["qubits"] / total, int(source.rows.size)
    if options.json:
        return json.dumps({
            "schema": 1, "topology": found.topology, "method": found.method, "seed": found.seed,
            "variables": source.variables, "couplers": couplers, **figures,
            "seconds": found.seconds, "chip_qubits": total, "share": round(share, 4)})
    return "\n".join([
        f"{found.topology}: {source.variables:,} variables, {couplers:,} couplers on "
        f"{figures['qubits']:,} qubits, {share:.1%} of the chip; longest chain "
        f"{figures['longest_chain']}, mean {figures['mean_chain']:.2f}; {found.method}, "
        f"{found.seconds:.1f} s",
        *(f"{name}: written" for name in (options.output, options.picture) if name)])
