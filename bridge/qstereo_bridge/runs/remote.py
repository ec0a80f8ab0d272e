"""What the command does with D-Wave's services: send and wait, collect, many problems, the list of
solvers, and the dry run."""

import contextlib
import copy
import os

from ..core import models
from ..core.container import FormatError
from ..core.failure import BAD_INPUT, NO, OK, USAGE, Error, Failure, failing, io
from ..core.problem import load_samples
from ..core.text import line
from ..ocean import hybrid
from ..ocean.services import NAMES, WANTED, NoAccount, client, configuration, connect, explained
from . import jobs, registry, runner


def solve(options, session=None, again=False):
    """Solve one problem, wherever its solver runs, and write its samples; with --no-wait, send it.
    """
    runner.solve(options, lambda problem, tell: answered(options, problem, tell, session, again))


@contextlib.contextmanager
def answered(options, problem, progress, session=None, again=False):
    """The Answer to a problem, in a `with` in which it is written; None with --no-wait.

    session     the service's, where it is open already
    again       fetch what an earlier run has sent; else that is refused, with Failure(NO)
    """
    solver = registry.find(options.solver)
    if not solver.paid:
        yield solver.run(problem, options, progress)
        return
    path = jobs.path_of(options.output, problem.digest)
    with (jobs.Job.load(path, options.resubmit) as job, explained(),
          contextlib.ExitStack() as stack):
        before = _at_service(options, problem, job)
        if before and not again:
            raise Failure(NO, f"{path}: this problem was sent {job.time} and is not sent again; "
                              f"{job.command} fetches the answer (--resubmit sends and charges it "
                              "once more)")
        if not before:
            session = session or stack.enter_context(connect(options.solver, options.solver_name))
            kind = solver.run(problem, options)
            if options.max_charge is not None and options.out_dir is None:
                check_charge(options, [kind.plan(session.properties, session.solver)])
            jobs.send(job, kind, options, session, progress)
        if options.no_wait:
            runner.show(options, *_sent(job, before))
            yield None
            return
        yield (_collected(options, problem, job, progress) if before else
               jobs.fetch(session, job, kind, progress))
        job.remove()


def _at_service(options, problem, job):
    """Whether the service has the problem by an earlier job. Raises Failure(NO) where that is of
    another problem."""
    if job.state == jobs.UPLOADING or options.resubmit:
        return False
    if job.problem_digest == problem.digest.hex():
        return jobs.was_sent(job)
    if options.windows:
        # A call of another run, whose journal was removed.
        return False
    raise Failure(NO, f"{job.path}: the answer to another problem ({job.problem}) is still to be "
                      f"collected under this name; {job.command}, or give another -o, or "
                      "--resubmit to forget it")


def _sent(job, before):
    """(text, facts) of a job whose answer is not waited for."""
    said = f"{job.solver}: sent as {line(job.problem_id)}; {job.command} fetches the answer"
    facts = {"solver": job.solver, "job": job.path, "problem_id": job.problem_id}
    return (f"skipped, it was sent to {job.solver} as {line(job.problem_id)}",
            {"skipped": True, **facts}) if before else (said, facts)


def charge_of(plans):
    """Seconds that all of the plans that fit may be charged; None where one does not say."""
    charges = [found.get("charge_seconds") for found in plans if found.get("fits") is not False]
    return None if None in charges else sum(charges)


def check_charge(options, plans):
    """Raises Failure(NO) where what the plans may be charged is more than --max-charge."""
    charge = charge_of(plans)
    if charge is None:
        raise Failure(NO, "the solver does not say what it will charge, so --max-charge cannot be "
                          "checked; nothing was sent")
    if charge > options.max_charge:
        raise Failure(NO, f"the charge may be {charge:,.3f} s, --max-charge allows "
                          f"{options.max_charge:,.3f} s; nothing was sent")


def collect(options):
    """The command `collect`. Raises Failure(NO) where nothing was sent, or there is no answer yet.
    """
    with jobs.Job.load(options.job) as job:
        if not job.stream:
            raise Failure(BAD_INPUT, f"{options.job}: there is no such job file; it is removed "
                                     "when the samples are written")
        if job.facts.get("window"):
            raise Failure(BAD_INPUT, f"{options.job}: this is one of the calls of `solve "
                                     "--windows`; run that command again, it goes on")
        options.problem = options.problem or _problem_of(job)

        @contextlib.contextmanager
        def ask(problem, progress):
            if problem.digest.hex() != job.problem_digest:
                raise Failure(BAD_INPUT, f"{options.problem}: this is not the problem that was "
                                         "sent (its SHA-256 differs); name that with --problem")
            if not jobs.was_sent(job):
                raise Failure(NO, f"{job.path}: nothing was sent and nothing is charged; "
                                  "`qstereo-bridge solve` sends it")
            yield _collected(options, problem, job, progress)
            job.remove()
        runner.solve(options, ask)


def _collected(options, problem, job, progress):
    """The Answer to a problem that an earlier run has sent."""
    options.solver, options.label = job.solver, job.user_label
    if options.solver not in WANTED:
        raise Failure(BAD_INPUT, f"{job.path}: {line(options.solver)} is not a solver that this "
                                 "program knows")
    with connect(job.solver, job.service_solver, reading=True) as session:
        kind = registry.find(job.solver).run(problem, options)
        return jobs.fetch(session, job, kind, progress, once=options.no_wait)


def _problem_of(job):
    path = job.problem and os.path.join(os.path.dirname(job.path), job.problem)
    if not path or not os.path.exists(path):
        why = f"the problem is no longer at {path}" if path else "the problem came from stdin"
        raise Failure(USAGE, f"{job.path}: {why}; name its file with --problem")
    return path


def solve_all(options):
    """The command `solve` with --out-dir: each problem to its own samples, one after another,
    whatever happens to the others."""
    with io(options.out_dir, "make"):
        os.makedirs(options.out_dir, exist_ok=True)
    tasks, failed, results = _tasks(options), [], []
    with account(options) as session:
        if options.max_charge is not None:
            check_charge(options, _plans(tasks, session))
        for number, task in enumerate(tasks, 1):
            task.said, count = [], f"[{number}/{len(tasks)}] "
            try:
                with failing(task.problem), explained():
                    solve_one(task, session)
            except Error as error:
                failed.append(task.problem)
                runner.say(options, f"{count}{error}")
                continue
            text, facts = task.said[-1]
            results.append({"problem": task.problem, "samples_file": task.output, **facts})
            if not options.json:
                runner.show(options, f"{count}{task.problem}: {text.splitlines()[0]}", {})
    if options.json:
        runner.show(options, "", {"solver": options.solver, "problems": results, "failed": failed})
    if failed:
        runner.say(options, f"{len(failed)} of {len(tasks)} failed: {', '.join(failed)}")
    return NO if failed else OK


def _tasks(options):
    """The options of each problem, of one or of several."""
    if options.out_dir is None:
        return [options]
    tasks, seen = [], {}
    for path in options.problems:
        task = copy.copy(options)
        task.problem = path
        name = os.path.splitext(os.path.basename(path))[0] + ".qsf"
        task.output = os.path.join(options.out_dir, name)
        registry.name_label(task)
        if task.output in seen:
            raise Failure(USAGE, f"{path} and {seen[task.output]} would both go to {task.output}; "
                                 "rename one")
        seen[task.output] = path
        tasks.append(task)
    return tasks


def solve_one(task, session=None):
    """Skip what is done, collect what an earlier run sent and did not wait for, solve the rest."""
    if _is_there(task):
        runner.show(task, "skipped, the samples are there", {"skipped": True})
    else:
        solve(task, session, again=True)


def _is_there(task):
    """Whether the samples file answers this very problem."""
    if not os.path.lexists(task.output):
        return False
    problem = runner.read(task)
    with contextlib.suppress(FormatError):
        return load_samples(task.output, task.memory_limit).digest == problem.digest
    return False


def solvers(options):
    """The command `solvers`."""
    with explained(), contextlib.closing(client()) as account:
        found = sorted((_described(solver) for online in (True, False)
                        for solver in account.get_solvers(order_by=None, online=online)),
                       key=lambda one: (one["kind"], one["name"]))
    if options.json:
        return runner.show(options, "", {"solvers": found})
    for one in found:
        limits = ", ".join(f"{value} {name}" for name, value in one["limits"].items())
        state = f"online, load {one['load']}" if one["online"] else "OFFLINE"
        runner.show(options, f"{line(one['name']):<40} {NAMES.get(one['kind'], one['kind']):<18} "
                             f"{state}\n    {line(limits)}", {})


def _described(solver):
    properties, kind, limits = solver.properties, "other", {}
    if solver.qpu:
        shape = properties.get("topology", {"type": "", "shape": [""]})
        kind, limits = "qpu", {"qubits": len(properties["qubits"]),
                               "topology": f"{shape['type']}:{shape['shape'][0]}"}
    for one in () if solver.qpu else (hybrid.Bqm, hybrid.Cqm, hybrid.Nl):
        if one.problem_type in solver.supported_problem_types:
            kind = "hybrid-" + one.problem_type
            limits = {what: properties.get(limit) for what, limit in one.limits.items()}
    return {"name": solver.name, "kind": kind, "online": solver.online, "load": solver.avg_load,
            "limits": limits}


@contextlib.contextmanager
def account(options):
    """The Session of a service's solver; None for a solver of this machine, and in a dry run
    without an account."""
    with contextlib.ExitStack() as stack:
        session = None
        if registry.find(options.solver).paid:
            with contextlib.suppress(*[NoAccount] * options.dry_run), explained():
                configuration()
                session = stack.enter_context(connect(options.solver, options.solver_name))
        yield session


def dry_run(options):
    """The command `solve --dry-run`: what would be sent, and of several problems the bill."""
    tasks = _tasks(options)
    with account(options) as session:
        plans = _plans(tasks, session)
    if options.out_dir is None:
        runner.show(options, "\n".join(planned(options, plans[0])), {
            "solver": options.solver, "dry_run": True, **plans[0]})
    else:
        show_plans(options, "problems", [{"problem": task.problem, **found}
                                         for task, found in zip(tasks, plans)])


def show_plans(options, what, plans):
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


def plans(options):
    """What would be sent for one problem, as a list of dicts."""
    with account(options) as session:
        return _plans([options], session)


def _plans(tasks, session):
    """What would be sent for each problem: dicts. By the solver's own limits where there is a
    session, else by published ones."""
    plans = []
    for task in tasks:
        with failing(task.problem):
            plans.append({"skipped": True, "charge_seconds": 0, "fits": True}
                         if task.out_dir is not None and _is_there(task) else
                         plan(task, session, runner.read(task)))
    return plans


def plan(options, session, problem):
    """What would be sent for one problem: a dict."""
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


def planned(options, found):
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
