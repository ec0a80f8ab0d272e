"""What the command does with D-Wave's services: send and wait, collect, many problems, the list of
solvers, and the dry run."""

import concurrent.futures
import contextlib
import copy
import json
import os
import sys

from . import hybrid, jobs, models, registry, runner
from .container import FormatError
from .failure import BAD_INPUT, NO, OK, USAGE, Failure, failing, io
from .qsf import read_qsf
from .services import (NAMES, WANTED, client, configuration, configured, connect, explain,
                       explained)
from .text import line, lines


def solve(options, session=None, print_result=runner.show):
    """Solve one problem, wherever its solver runs, and write its samples; with --no-wait, send it.
    """
    if options.windows:
        from . import calls

        return calls.solve(options)

    def ask(options, problem, progress):
        answer, job = send(options, problem, session, progress)
        if answer is None:
            with job:
                print_result(options, json.dumps(
                    {"schema": 1, "solver": options.solver, "job": job.path,
                     "problem_id": job.problem_id}) if options.json else
                    f"{options.solver}: sent as {line(job.problem_id)}; {job.command} fetches the "
                    "answer")
        return answer, jobs.keeping(job)
    ways = [ask] if registry.find(options.solver).kind else []
    return runner.solve(options, print_result, *ways)


def send(options, problem, session, progress):
    """Send the problem and, without --no-wait, wait for its answer: (Answer or None, Job)."""
    with contextlib.ExitStack() as stack:
        earlier = jobs.check_earlier(options)
        stack.push(lambda kind, *error: kind and earlier and earlier.leave())
        stack.enter_context(explained())
        if session is None:
            # An account that there is not is told of before anything large is imported or built.
            configuration()
        kind = registry.find(options.solver).run(options.solver, problem, options)
        session = session or stack.enter_context(connect(options.solver, options.solver_name))
        if options.max_charge is not None and options.out_dir is None:
            check_charge(options, [kind.plan(session.properties, session.solver)])
        return jobs.solve(kind, options, progress, session, earlier)


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


def collect(options, print_result=runner.show):
    """The command `collect`."""
    job = jobs.Job.load(options.job)
    if job is None:
        raise Failure(BAD_INPUT, f"{options.job}: there is no such job file; it is removed when "
                                 "the samples are written")
    with job:
        options.solver, options.label = job.solver, job.user_label
        if options.solver not in WANTED:
            raise Failure(BAD_INPUT, f"{options.job}: {line(options.solver)} is not a solver that "
                                     "this program knows")
        options.problem = options.problem or _problem_of(job)

        def ask(options, problem, progress):
            if options.digest.hex() != job.problem_digest:
                raise Failure(BAD_INPUT, f"{options.problem}: this is not the problem that was "
                                         "sent (its SHA-256 differs); name that with --problem")
            return collected(options, problem, job, progress), jobs.keeping(job)
        return runner.solve(options, print_result, ask)


def _problem_of(job):
    if job.problem is None:
        raise Failure(USAGE, f"{job.path}: the problem came from stdin; name its file with "
                             "--problem")
    path = os.path.join(os.path.dirname(job.path), job.problem)
    if not os.path.exists(path):
        raise Failure(USAGE, f"{job.path}: the problem is no longer at {path}; name its file with "
                             "--problem")
    return path


def collected(options, problem, job, progress):
    """The Answer to a problem that may have been sent. Raises Failure(NO) where it was not, or
    there is none yet."""
    if not jobs.was_sent(job):
        raise Failure(NO, f"{job.path}: nothing was sent and nothing is charged; `qstereo-bridge "
                          "solve` sends it")
    with connect(job.solver, job.service_solver, reading=True) as session:
        job.session = session
        future = jobs.wait(session, job, progress, once=options.no_wait)
        if future is None:
            raise Failure(NO, f"{job.path}: there is no answer yet")
        kind = registry.find(job.solver).run(job.solver, problem, options)
        return jobs.decoded(kind, future, job)


def solve_all(options):
    """The command `solve` with --out-dir: each problem to its own samples, whatever happens to the
    others."""
    with io(options.out_dir, "make"):
        os.makedirs(options.out_dir, exist_ok=True)
    tasks, failed, results = _tasks(options), [], []

    def tell(count, text):
        print(lines(f"qstereo-bridge solve: {count}{text}"), file=sys.stderr, flush=True)
    with contextlib.ExitStack() as stack:
        session = None
        if registry.find(options.solver).kind:
            session = stack.enter_context(connect(options.solver, options.solver_name))
        if options.max_charge is not None:
            check_charge(options, _plans(tasks, session))
        pool = stack.enter_context(concurrent.futures.ThreadPoolExecutor(options.jobs or 1))
        under_way = {pool.submit(_one_of_many, task, session): task for task in tasks}
        for number, future in enumerate(concurrent.futures.as_completed(under_way), 1):
            task, (said, failure), count = under_way[future], future.result(), f"{len(tasks)}] "
            if failure:
                failed.append(task.problem)
                tell(f"[{number}/{count}", failure)
            elif options.json:
                results.append({"problem": task.problem, "samples_file": task.output,
                                **json.loads(said)})
            else:
                runner.show(options, f"[{number}/{count}{task.problem}: {said.splitlines()[0]}")
    if options.json:
        runner.show(options, json.dumps({"schema": 1, "solver": options.solver,
                                         "problems": results, "failed": failed}))
    if failed:
        tell("", f"{len(failed)} of {len(tasks)} failed: {', '.join(failed)}")
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


def _one_of_many(task, session):
    """(what it printed, None) or (None, why it failed). What an earlier run sent and did not wait
    for is collected."""
    said = []
    try:
        with failing(task.problem):
            path = jobs.path_of(task.output, b"")
            if _is_there(task):
                said.append(json.dumps({"skipped": True}) if task.json else
                            "skipped, the samples are there")
            elif sent := sent_before(task, path):
                said.append(json.dumps({"skipped": True, "solver": sent.solver, "job": path,
                                        "problem_id": sent.problem_id}) if task.json else
                            f"skipped, it was sent to {sent.solver} as {sent.problem_id}")
                if not task.no_wait:
                    collecting = copy.copy(task)
                    collecting.job = path
                    collect(collecting, lambda options, text: said.append(text))
            else:
                solve(task, session, lambda options, text: said.append(text))
        return said[-1], None
    except Failure as failure:
        return None, str(failure)
    except Exception as error:
        # Whatever it is, the others go on.
        return None, f"{task.problem}: {explain(error)}"


def sent_before(task, path):
    """The Job of this very problem that an earlier run sent, let go of; None where there is none.
    """
    if not registry.find(task.solver).kind or task.resubmit or not os.path.exists(path):
        return None
    with jobs.Job.load(path) or contextlib.nullcontext() as earlier:
        same = earlier and earlier.problem_digest == task.digest.hex()
        return earlier if same and jobs.was_sent(earlier) else None


def _is_there(task):
    """Whether the samples file answers this very problem, whose digest is known then."""
    runner.read(task)
    if not os.path.lexists(task.output):
        return False
    with (contextlib.suppress(FormatError), io(task.output, "read"),
          open(task.output, "rb") as stream):
        return read_qsf(stream, task.memory_limit).digest == task.digest
    return False


def solvers(options):
    """The command `solvers`."""
    with explained(), contextlib.closing(client()) as account:
        found = sorted((_described(solver) for online in (True, False)
                        for solver in account.get_solvers(order_by=None, online=online)),
                       key=lambda one: (one["kind"], one["name"]))
    if options.json:
        return runner.show(options, json.dumps({"schema": 1, "solvers": found}))
    for one in found:
        limits = ", ".join(f"{value:,} {name}" if isinstance(value, int) else f"{name} {value}"
                           for name, value in one["limits"].items())
        load = "" if one["load"] is None else f", load {one['load']:.0%}"
        state = "online" if one["online"] else "OFFLINE"
        runner.show(options, f"{line(one['name']):<40} {NAMES.get(one['kind'], one['kind']):<18} "
                             f"{state}{load}\n    {line(limits)}")


def _described(solver):
    properties, kind, limits = solver.properties, "other", {}
    if solver.qpu:
        topology, kind = properties.get("topology", {}), "qpu"
        shape = [topology.get("type"), *topology.get("shape", [])]
        limits = {"qubits": len(properties["qubits"]), "topology": ":".join(map(str, shape[:2])),
                  "fast anneal": "yes" if "fast_anneal" in solver.parameters else "no"}
    for one in (hybrid.Bqm, hybrid.Cqm, hybrid.Nl):
        if not solver.qpu and one.problem_type in solver.supported_problem_types:
            kind = "hybrid-" + one.problem_type
            limits = {what: properties[limit] for what, limit in one.limits.items()
                      if limit in properties}
    return {"name": solver.name, "kind": kind, "online": solver.online, "load": solver.avg_load,
            "limits": limits}


def dry_run(options):
    """The command `solve --dry-run`: what would be sent, and of several problems the bill."""
    if options.windows:
        from . import calls

        return calls.dry_run(options)
    tasks, service = _tasks(options), bool(registry.find(options.solver).kind)
    with (connect(options.solver, options.solver_name) if service and configured()
          else contextlib.nullcontext()) as session:
        plans = _plans(tasks, session)
    told, charge = {"schema": 1, "solver": options.solver, "dry_run": True}, charge_of(plans)
    if options.out_dir is None:
        said, told = planned(options, plans[0]), {**told, **plans[0]}
    else:
        told.update(charge_seconds=charge, problems=[{"problem": task.problem, **found}
                                                     for task, found in zip(tasks, plans)])
        bill = ("runs on this machine; nothing is charged" if not service else
                "the charge cannot be told" if charge is None else
                f"estimated charge in all {charge:,.3f} s")
        said = [*(f"{task.problem}: " + (
            f"does not fit: {found['reason']}" if found.get("fits") is False else
            "skipped, the samples are there" if found.get("skipped") else
            f"{found['variables']:,} variables" + (
                f", estimated charge {found['charge_seconds']:,.3f} s"
                if found.get("charge_seconds") is not None else ""))
            for task, found in zip(tasks, plans)),
            f"{options.solver}: {len(tasks):,} problems; {bill}; nothing was sent"]
    runner.show(options, json.dumps(told) if options.json else "\n".join(said))


def _plans(tasks, session):
    """What would be sent for each problem: dicts. By the solver's own limits where there is a
    session, else by published ones."""
    plans = []
    for task in tasks:
        with failing(task.problem):
            plans.append({"skipped": True, "charge_seconds": 0, "fits": True}
                         if task.out_dir is not None and _is_there(task) else plan(task, session))
    return plans


def plan(options, session):
    """What would be sent for one problem: a dict."""
    problem, solver = runner.read(options), registry.find(options.solver)
    found = {"variables": problem.linear.size, "quadratic_terms": 0}
    if not problem.linear.size:
        return {**found, "upload_bytes": 0, "charge_seconds": 0, "fits": True}
    if not solver.kind:
        return {**found, "quadratic_terms": models.Terms(problem).count}
    with explained():
        kind = solver.run(options.solver, problem, options)
        by = ([hybrid.PUBLISHED.get(options.solver)] if session is None else
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
    whose = (f"of {line(found['service_solver'])}" if found["service_solver"] else
             "as published; without an account the solver cannot be asked")
    for key, limit in found["limits"].items():
        yield f"{found[key]:,} {line(key)} of {limit:,} that the service takes ({whose})"
    for chip, qubits in found.get("qubits", {}).items():
        yield f"{line(chip)}: {qubits:,} qubits ({whose})"
    copies, known = found.get("copies", 1), found.get("embedded_qubits")
    if copies == "auto":
        yield f"as many copies as are found on the chip, {options.num_reads:,} samples of each"
    elif copies != 1:
        yield (f"{copies:,} copies: {options.num_reads * copies:,} samples from "
               f"{options.num_reads:,} reads")
    yield (f"upload {found['upload_bytes']:,} bytes" + (
        f", {known:,} qubits in the embedding" if known else
        " at least, the embedding adds to them" if "qubits" in found else ""))
    if found["minimum_time_limit"]:
        yield f"least time limit {found['minimum_time_limit']:,.1f} s"
    if found.get("charge_seconds"):
        rate = found.get("charge_qpu_seconds")
        yield (f"estimated charge {'at most ' if known is None and 'qubits' in found else ''}"
               f"{found['charge_seconds']:,.3f} s" + (
                   f", worth {rate:,.2f} s of QPU access" if rate else ""))
    fits = {True: "it fits", False: f"it does not fit: {found['reason']}",
            None: "whether it fits, the embedding will show"}[found["fits"]]
    yield f"{fits}; nothing was sent"
