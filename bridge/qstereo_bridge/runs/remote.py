"""What the command does with D-Wave's services: send and wait, collect, many problems, the list of
solvers, and the dry run."""

import contextlib
import copy
import os

from ..core.container import FormatError
from ..core.failure import BAD_INPUT, NO, OK, USAGE, Error, Failure, failing, io
from ..core.problem import load_samples
from ..core.text import line
from ..ocean import hybrid
from ..ocean.services import NAMES, WANTED, NoAccount, client, configuration, connect, explained
from . import bill, jobs, registry, runner


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
                bill.check(options, [kind.plan(session.properties, session.solver)])
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
            bill.check(options, _planned(tasks, session))
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
    found = planned(options)
    if options.out_dir is None:
        runner.show(options, "\n".join(bill.told(options, found[0])), {
            "solver": options.solver, "dry_run": True, **found[0]})
    else:
        bill.show(options, "problems", found)


def planned(options):
    """What would be sent for the problem, or for each of several: dicts."""
    with account(options) as session:
        return _planned(_tasks(options), session)


def _planned(tasks, session):
    """The plans of the tasks; what of them is done already is charged no more."""
    found = []
    for task in tasks:
        with failing(task.problem):
            several = {} if task.out_dir is None else {"problem": task.problem}
            found.append({**several, **(
                {"skipped": True, "charge_seconds": 0, "fits": True} if several and _is_there(task)
                else bill.plan(task, session, runner.read(task)))})
    return found
