"""The command `verify`."""

from dataclasses import asdict

from .. import verify as proof
from ..core.failure import NO, OK
from ..runs import runner


def verify(options):
    """The command `verify`."""
    found = proof.verify(options.problem, options.other, options.certificate, options.memory_limit)
    facts = {**asdict(found), "proven_optimal": found.valid and found.energy == found.lower_bound}
    scale = facts.pop("scale")
    for key in ("energy", "lower_bound"):
        facts[key] = runner.real(facts[key], scale)
    text = (f"valid: energy {facts['energy']}, lower bound {facts['lower_bound']}, "
            f"{found.stages} stage{'s' * (found.stages != 1)}")
    runner.show(options, text if found.valid else f"not valid: {found.why}", facts)
    return OK if found.valid else NO
