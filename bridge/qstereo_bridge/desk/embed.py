"""The command `embed`: a minor embedding as a file, as figures, and as a picture."""

import io as memory

import networkx as nx

from ..core.failure import NO, USAGE, Failure, SolverError, io
from ..core.output import Output
from ..ocean import embedding
from ..runs import runner

# By the encoding that a problem has: those with fewer couplers on a chip.
SPARSER = {2: None, 3: "one-hot-sparse"}


def embed(options):
    """Embed, draw, print. The embedding's file gets its name before the picture."""
    if options.picture:
        # What is missing is told before the search.
        import matplotlib.figure  # noqa: F401
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
        source = embedding.Source.of(problem)
        try:
            found = embedding.find(source, chip, options.seed, options.timeout, progress)
            embedding.keep(found, source, chip)
            progress("picture")
            drawing = draw(source, chip, found) if options.picture else None
        except embedding.NoEmbedding as error:
            raise Failure(NO, f"{options.problem}: {error}; {_advice(problem, source, error)}"
                          ) from None
        finally:
            progress(None)
        deliver(found.to_json().encode(), *_summary(options, source, chip, found))
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
    """(text, facts) of an embedding."""
    figures, total = found.figures(), len(chip.graph)
    share, couplers = figures["qubits"] / total, source.graph.number_of_edges()
    return "\n".join([
        f"{found.topology}: {len(source.graph):,} variables, {couplers:,} couplers on "
        f"{figures['qubits']:,} qubits, {share:.1%} of the chip; longest chain "
        f"{figures['longest_chain']}, mean {figures['mean_chain']:.2f}; {found.method}, "
        f"{found.seconds:.1f} s",
        *(f"{name}: written" for name in (options.output, options.picture) if name)]), {
            "topology": found.topology, "method": found.method, "seed": found.seed,
            "variables": len(source.graph), "couplers": couplers, **figures,
            "seconds": found.seconds, "chip_qubits": total, "share": round(share, 4)}


def draw(source, chip, found):
    """The bytes of a PNG by dwave.graphs: the chip, each chain in a colour of its own. Raises
    SolverError for a chip that Ocean has no layout of."""
    import dwave.graphs
    from dwave.graphs.drawing.qubit_layout import draw_embedding
    from matplotlib.figure import Figure

    if chip.family is None:
        raise SolverError(f"{chip.name} is of a shape that cannot be drawn; embed without "
                          "--picture")
    figure, data = Figure(figsize=(10, 10), dpi=150, layout="constrained"), memory.BytesIO()
    layout, graph = (getattr(dwave.graphs, f"{chip.family}_{what}") for what in ("layout", "graph"))
    zoom, figures = min(12 / chip.size, 4), found.figures()
    axes = figure.subplots(subplot_kw={"aspect": "equal"})
    draw_embedding(chip.graph, layout(graph(chip.size)), found.chains, ax=axes,
                   embedded_graph=source.graph, node_size=12 * zoom, width=0.4 * zoom,
                   unused_color=(0.9, 0.9, 0.9, 1.0))
    axes.set_title(f"{chip.name}: {len(source.graph):,} variables on {figures['qubits']:,} of "
                   f"{len(chip.graph):,} qubits, longest chain {figures['longest_chain']}, mean "
                   f"{figures['mean_chain']:.2f}")
    figure.savefig(data, format="png")
    return data.getvalue()
