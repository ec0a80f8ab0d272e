"""The command `embed`: a minor embedding as a file, as figures, and as a picture."""

import json

from . import embedding, runner
from .failure import IO, NO, USAGE, Failure, io
from .output import Output

# By the encoding that a problem has: those with fewer couplers on a chip.
SPARSER = {2: None, 3: "one-hot-sparse"}


def embed(options):
    """Embed, draw, print. The embedding's file gets its name last."""
    picture, drawing = None, None
    if options.picture:
        from . import picture

        try:
            picture.require()
        except ImportError:
            raise Failure(IO, f"{options.picture}: a picture needs matplotlib; pip install 'qstereo-bridge[picture]'") from None
        with io(options.picture, "write"), Output(options.picture, last=False):
            pass
    with io(options.output, "write"):
        output = Output(options.output, last=not picture)
    with output:
        problem, progress = runner.read(options), runner.progress(options)
        if problem.linear.size == 0:
            raise Failure(NO, f"{options.problem}: nothing is left to decide, so there is nothing to embed")
        try:
            chip = embedding.Chip.named(options.topology)
        except ValueError as error:
            raise Failure(USAGE, str(error)) from None
        source = embedding.Source.of(problem, options.memory_limit)
        try:
            found = embedding.find(source, chip, options.seed, options.timeout, progress)
            embedding.keep(found, source, chip)
            if picture:
                progress("picture")
                drawing = picture.draw(source, chip, found)
        except embedding.NoEmbedding as error:
            raise Failure(NO, f"{options.problem}: {error}; {_advice(problem)}") from None
        finally:
            progress(None)
        with io(options.output, "write"):
            output.write(found.to_json().encode())
        runner.show(options, _summary(options, source, chip, found))
        with io(options.output, "write"):
            output.keep()
    if picture:
        with io(options.picture, "write"), Output(options.picture) as output:
            output.write(drawing)
            output.keep()


def _advice(problem):
    """What helps against a chip that is too small."""
    sparser = SPARSER.get(problem.encoding, "one-hot-sparse or domain-wall")
    return ("make it smaller with `qstereo reduce` or a smaller window (encode --roi)"
            + (f", or encode it with fewer couplers (--encoding {sparser})" if sparser else "")
            + "; another --seed or a longer --timeout may do as well")


def _summary(options, source, chip, found):
    figures = {"variables": source.variables, "couplers": int(source.rows.size), **found.figures(), "seconds": found.seconds,
               "chip_qubits": int(chip.qubits.size), "share": round(found.figures()["qubits"] / chip.qubits.size, 4)}
    if options.json:
        return json.dumps({"schema": 1, "topology": found.topology, "method": found.method, "seed": found.seed, **figures})
    lines = [f"{found.topology}: {figures['variables']:,} variables, {figures['couplers']:,} couplers on {figures['qubits']:,} qubits, "
             f"{100 * figures['share']:.1f} % of the chip; longest chain {figures['longest_chain']}, mean {figures['mean_chain']:.2f}; "
             f"{found.method}, {found.seconds:.1f} s"]
    return "\n".join(lines + [f"{name}: written" for name in (options.output, options.picture) if name])
