"""What would be sent to a service and charged: told by a dry run, and held against --max-charge."""

from ..core import models
from ..core.failure import NO, Failure
from ..core.text import line
from ..ocean import hybrid
from ..ocean.services import NAMES, explained
from . import registry, runner


def plan(options, session, problem):
    """What would be sent for one problem, a dict: by the solver's own limits where there is a
    session, else by published ones."""
    solver = registry.find(options.solver)
    found = {"variables": problem.linear.size, "quadratic_terms": 0}
    if not problem.linear.size:
        return {**found, "upload_bytes": 0, "charge_seconds": 0, "fits": True}
    if not solver.paid:
        return {**found, "quadratic_terms": models.Terms(problem).count}
    with explained():
        kind = solver.run(problem, options)
        by = ([hybrid.PUBLISHED[options.solver]] if session is None else
              [session.properties, session.solver])
        return {"service_solver": session and session.solver.name, **kind.plan(*by)}


def charge_of(plans):
    """Seconds that all of the plans that fit may be charged; None where one does not say."""
    charges = [found.get("charge_seconds") for found in plans if found.get("fits") is not False]
    return None if None in charges else sum(charges)


def check(options, plans):
    """Raises Failure(NO) where what the plans may be charged is more than --max-charge."""
    charge = charge_of(plans)
    if charge is None:
        raise Failure(NO, "the solver does not say what it will charge, so --max-charge cannot be "
                          "checked; nothing was sent")
    if charge > options.max_charge:
        raise Failure(NO, f"the charge may be {charge:,.3f} s, --max-charge allows "
                          f"{options.max_charge:,.3f} s; nothing was sent")


def told(options, found):
    """One plan for people, line by line."""
    yield (f"{NAMES.get(options.solver, options.solver)}: {found['variables']:,} variables, "
           f"{found['quadratic_terms']:,} quadratic terms")
    if "service_solver" not in found:
        yield ("runs on this machine; nothing is ever sent" if found["variables"] else
               "nothing is left to decide; nothing is ever sent")
        return
    whose = f"of {line(found['service_solver'])}" if found["service_solver"] else "as published"
    for key, limit in found["limits"].items():
        yield f"{found[key]:,} {line(key)} of {limit:,} that the service takes ({whose})"
    copies, known, least = found.get("copies", 1), found.get("embedded_qubits"), ""
    for chip, qubits in found.get("qubits", {}).items():
        yield f"{line(chip)}: {qubits:,} qubits ({whose})"
        least = f", {known:,} qubits in the embedding" if known else " at least, as embeddings add"
    if copies == "auto":
        yield f"as many copies as are found on the chip, {options.num_reads:,} samples of each"
    elif copies != 1:
        yield (f"{copies:,} copies: {options.num_reads * copies:,} samples from "
               f"{options.num_reads:,} reads")
    if not found["service_solver"]:
        yield "without an account the solver itself cannot be asked"
    yield f"upload {found['upload_bytes']:,} bytes{least}"
    if found["minimum_time_limit"]:
        yield f"least time limit {found['minimum_time_limit']:,.1f} s"
    if found.get("charge_seconds"):
        rate = found.get("charge_qpu_seconds")
        yield (f"estimated charge {'' if known or not least else 'at most '}"
               f"{found['charge_seconds']:,.3f} s"
               + (f", worth {rate:,.2f} s of QPU access" if rate else ""))
    fits = {True: "it fits", False: f"it does not fit: {found['reason']}",
            None: "whether it fits, the embedding will show"}[found["fits"]]
    yield f"{fits}; nothing was sent"


def show(options, what, plans):
    """The dry run of several problems, calls or frames: a line for each, and the bill. `plans` are
    dicts, whose first value names each."""
    charge, said = charge_of(plans), []
    for found in plans:
        (kind, name), cost = next(iter(found.items())), found.get("charge_seconds")
        said.append(f"{name}: " if kind == "problem" else f"{kind} {name}: ")
        said[-1] += (f"does not fit: {found['reason']}" if found.get("fits") is False else
                     "skipped, the samples are there" if found.get("skipped") else
                     f"{found['variables']:,} variables")
        if found.get("calls"):
            said[-1] += f" in at most {found['calls']:,} calls"
        if "mean_chain" in found:
            said[-1] += (f", {found['embedded_qubits']:,} qubits, chains of "
                         f"{found['mean_chain']:.2f} on average and {found['longest_chain']} at "
                         "most")
        if cost:
            said[-1] += f", estimated charge {cost:,.3f} s"
    bill = ("runs on this machine; nothing is charged" if not registry.find(options.solver).paid
            else "the charge cannot be told" if charge is None else
            f"estimated charge in all {charge:,.3f} s")
    runner.show(options, "\n".join([*said, f"{options.solver}: {len(plans):,} {what}; {bill}; "
                                           "nothing was sent"]),
                {"solver": options.solver, "dry_run": True, "charge_seconds": charge, what: plans})
