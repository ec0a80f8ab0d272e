"""What the command does with D-Wave's services: send and wait, collect, many problems, the list of
solvers, and the dry run."""

import concurrent.futures
import contextlib
import copy
import json
import os
import sys
import time

from . import hybrid, jobs, models, registry, runner
from .container import FormatError
from .failure import BAD_INPUT, NO, OK, USAGE, Failure, failing, io
from .output import Output
from .qsf import read_qsf
from .services import (NAMES, WANTED, client, configuration, configured, connect, explain,
                       explained)
from .text import line, lines


def solve(options, session=None, print_result=runner.show):
    """Solve one problem, wherever its solver runs, and write its samples."""
    if not registry.find(options.solver).kind:
        return runner.solve(options, print_result)
    problem = runner.read(options) if options.no_wait else None
    if problem and problem.linear.size:
        _, job = _send(options, problem, session, runner.progress(options))
        with job:
            return print_result(options, json.dumps(
                {"schema": 1, "solver": options.solver, "job": job.path,
                 "problem_id": job.problem_id}) if options.json else
                f"{options.solver}: sent as {line(job.problem_id)}; `qstereo-bridge collect "
                f"{job.path}` fetches the answer")

    def ask(options, problem, tell):
        answer, job = _send(options, problem, session, tell)
        return answer, jobs.keeping(job)
    return runner.solve(options, print_result, ask, problem)


def _send(options, problem, session, progress):
    """Send the problem and, without --no-wait, wait for its answer: (Answer or None, Job)."""
    with contextlib.ExitStack() as stack:
        earlier = jobs.check_earlier(options)
        if earlier:
            stack.callback(earlier.leave)
        stack.enter_context(explained())
        if session is None:
            # An account that there is not is told of before anything large is imported or built.
            configuration()
        kind = registry.find(options.solver).run(options.solver, problem, options)
        session = session or stack.enter_context(connect(options.solver, options.solver_name))
        if options.max_charge is not None and options.out_dir is None:
            _check_charge(options, [kind.plan(session.properties, session.solver)])
        return jobs.solve(kind, options, progress, session, earlier)


def _check_charge(options, plans):
    """Raises Failure(NO) where what the plans may be charged is more than --max-charge."""
    charges = [found.get("charge_seconds") for found in plans if found["fits"] is not False]
    if None in charges:
        raise Failure(NO, "the solver does not say what it will charge, so --max-charge cannot be "
                          "kept to; nothing was sent")
    if sum(charges) > options.max_charge:
        raise Failure(NO, f"the charge may be {sum(charges):,.3f} s, --max-charge allows "
                          f"{options.max_charge:,.3f} s; nothing was sent")


def collect(options, print_result=runner.show):
    """The command `collect`."""
    job = jobs.Job.load(options.job)
    if job is None:
        raise Failure(BAD_INPUT, f"{options.job}: there is no such job file; it is removed when "
                                 "the samples are written")
    with job:
        options.solver, options.solver_name = job.solver, job.service_solver
        options.label = job.user_label
        if options.solver not in WANTED:
            raise Failure(BAD_INPUT, f"{options.job}: {line(options.solver)} is no solver that "
                                     "this program knows")
        options.problem = _problem_of(options, job)
        with io(options.output, "write"):
            output = Output(options.output, last=getattr(options, "out_dir", None) is None)
        with output:
            problem = runner.read(options)
            if options.digest.hex() != job.problem_digest:
                raise Failure(BAD_INPUT, f"{options.problem}: this is not the problem that was "
                                         "sent (its SHA-256 differs); name that with --problem")
            began, progress = time.monotonic(), runner.progress(options)
            try:
                answer = _collected(options, problem, job, progress)
            finally:
                progress(None)
            with jobs.keeping(job):
                runner.deliver(options, problem, answer, output, began, print_result)
    return OK


def _problem_of(options, job):
    if options.problem:
        return options.problem
    if job.problem is None:
        raise Failure(USAGE, f"{options.job}: the problem came from stdin; name its file with "
                             "--problem")
    path = os.path.join(os.path.dirname(options.job), job.problem)
    if not os.path.exists(path):
        raise Failure(USAGE, f"{options.job}: the problem is no longer at {path}; name its file "
                             "with --problem")
    return path


def _collected(options, problem, job, progress):
    """The Answer to a problem that may have been sent. Raises Failure(NO) where it was not, or
    there is none yet."""
    nothing = (f"{job.path}: nothing was sent and nothing is charged; `qstereo-bridge solve` sends "
               "it")
    if job.state == jobs.UPLOADING:
        raise Failure(NO, nothing)
    with connect(job.solver, job.service_solver, reading=True) as session:
        job.session = session
        if job.state == jobs.SENDING and not jobs.find(session, job):
            raise Failure(NO, nothing)
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
    tasks, failed, results, count = _tasks(options), [], [], 0
    with contextlib.ExitStack() as stack:
        session = None
        if registry.find(options.solver).kind:
            session = stack.enter_context(connect(options.solver, options.solver_name))
        if options.max_charge is not None:
            _check_charge(options, _plans(tasks, session))
        pool = stack.enter_context(concurrent.futures.ThreadPoolExecutor(options.jobs or 1))
        under_way = [pool.submit(_one_of_many, task, session) for task in tasks]
        for future in concurrent.futures.as_completed(under_way):
            task, said, failure = future.result()
            count += 1
            if failure:
                failed.append(task.problem)
                print(lines(f"qstereo-bridge solve: [{count}/{len(tasks)}] {failure}"),
                      file=sys.stderr, flush=True)
            elif options.json:
                results.append({"problem": task.problem, "samples_file": task.output, **said})
            else:
                runner.show(options, f"[{count}/{len(tasks)}] {task.problem}: {said}")
    if options.json:
        runner.show(options, json.dumps({"schema": 1, "solver": options.solver,
                                         "problems": results, "failed": failed}))
    if failed:
        print(lines(f"qstereo-bridge solve: {len(failed)} of {len(tasks)} failed: "
                    + ", ".join(failed)), file=sys.stderr)
    return NO if failed else OK


def _tasks(options):
    """The options of each of several problems."""
    tasks, seen = [], {}
    for path in options.problems:
        task = copy.copy(options)
        task.problem, task.label = path, options.label
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
    """(task, what it gave, None) or (task, None, why it failed)."""
    try:
        with failing(task.problem):
            if _is_there(task):
                return task, ({"skipped": True} if task.json else
                              "skipped, the samples are there"), None
            said = []
            _solve_or_collect(task, session, lambda options, text: said.append(text))
            return task, json.loads(said[0]) if task.json else said[0].splitlines()[0], None
    except Failure as failure:
        return task, None, str(failure)
    except Exception as error:
        # Whatever it is, the others go on.
        return task, None, f"{task.problem}: {explain(error)}"


def _solve_or_collect(task, session, print_result):
    """What an earlier run sent and did not wait for is collected."""
    job = jobs.path_of(task.output, b"")
    earlier = None
    if registry.find(task.solver).kind and not task.resubmit and os.path.exists(job):
        earlier = jobs.Job.load(job)
    if earlier is None or not _was_sent(earlier, task.digest):
        return solve(task, session, print_result)
    if task.no_wait:
        said = {"skipped": True, "solver": earlier.solver, "job": job,
                "problem_id": earlier.problem_id}
        return print_result(task, json.dumps(said) if task.json else
                            f"skipped, it was sent to {earlier.solver} as {earlier.problem_id}")
    collecting = copy.copy(task)
    collecting.job, collecting.no_wait = job, False
    return collect(collecting, print_result)


def _was_sent(earlier, digest):
    """Whether the service has the problem of this digest under a job; it is asked where the job
    does not know."""
    with earlier:
        if earlier.problem_digest != digest.hex() or earlier.state != jobs.SENDING:
            return earlier.problem_digest == digest.hex() and earlier.state == jobs.SENT
        with connect(earlier.solver, earlier.service_solver, reading=True) as session:
            return jobs.find(session, earlier)


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
    found = []
    with explained(), contextlib.closing(client()) as account:
        for online in (True, False):
            found += map(_described, account.get_solvers(order_by=None, online=online))
    found.sort(key=lambda one: (one["kind"], one["name"]))
    if options.json:
        runner.show(options, json.dumps({"schema": 1, "solvers": found}))
        return OK
    for one in found:
        limits = ", ".join(f"{value:,} {name}" if isinstance(value, int) else f"{name} {value}"
                           for name, value in one["limits"].items())
        load = "" if one["load"] is None else f", load {one['load']:.0%}"
        kind = NAMES.get(one["kind"], one["kind"])
        state = "online" if one["online"] else "OFFLINE"
        runner.show(options, f"{line(one['name']):<40} {kind:<18} {state}{load}\n"
                             f"    {line(limits)}")
    return OK


def _described(solver):
    properties, kinds = solver.properties, {"hybrid-" + kind.problem_type: kind for kind in (
        hybrid.Bqm, hybrid.Cqm, hybrid.Nl)}
    if solver.qpu:
        topology, kind = properties.get("topology", {}), "qpu"
        shape = [topology.get("type"), *topology.get("shape", [])]
        limits = {"qubits": len(properties["qubits"]), "couplers": len(properties["couplers"]),
                  "topology": ":".join(map(str, shape[:2])),
                  "reads at most": properties.get("num_reads_range", [1, None])[1],
                  "fast anneal": "yes" if "fast_anneal" in solver.parameters else "no"}
    else:
        kind = next((name for name, one in kinds.items()
                     if one.problem_type in solver.supported_problem_types), "other")
        limits = {what: properties[limit] for what, limit in getattr(
            kinds.get(kind), "limits", {}).items() if limit in properties}
    return {"name": solver.name, "kind": kind, "online": solver.online, "load": solver.avg_load,
            "limits": limits}


def dry_run(options):
    """The command `solve --dry-run`: what would be sent, and of several problems the bill."""
    several = options.out_dir is not None
    tasks = _tasks(options) if several else [options]
    there = registry.find(options.solver).kind and configured()
    with (connect(options.solver, options.solver_name) if there
          else contextlib.nullcontext()) as session:
        plans = _plans(tasks, session)
    told = {"schema": 1, "solver": options.solver, "dry_run": True}
    if not several:
        return runner.show(options, json.dumps({**told, **plans[0]}) if options.json else
                           planned(options, plans[0]))
    charges = [found.get("charge_seconds") for found in plans if found.get("fits") is not False]
    total = None if None in charges else sum(charges)
    if options.json:
        return runner.show(options, json.dumps({**told, "charge_seconds": total, "problems": [
            {"problem": task.problem, **found} for task, found in zip(tasks, plans)]}))
    bill = ("runs on this machine; nothing is charged" if not registry.find(options.solver).kind
            else "the charge cannot be told" if total is None else
            f"estimated charge in all {total:,.3f} s")
    for task, found in zip(tasks, plans):
        runner.show(options, f"{task.problem}: {_in_short(found)}")
    runner.show(options, f"{options.solver}: {len(tasks):,} problems; {bill}; nothing was sent")


def _in_short(found):
    charge = found.get("charge_seconds")
    return (f"does not fit: {found['reason']}" if found.get("fits") is False else
            "skipped, the samples are there" if found.get("skipped") else
            f"{found['variables']:,} variables"
            + ("" if charge is None else f", estimated charge {charge:,.3f} s"))


def _plans(tasks, session):
    """What would be sent for each problem: dicts. By the solver's own limits where there is a
    session, else by published ones."""
    plans = []
    for task in tasks:
        with failing(task.problem):
            if task.out_dir is not None and _is_there(task):
                plans.append({"skipped": True, "charge_seconds": 0, "fits": True})
            else:
                plans.append(plan(task, session))
    return plans


def plan(options, session):
    """What would be sent for one problem: a dict."""
    problem, solver = runner.read(options), registry.find(options.solver)
    n = problem.linear.size
    if n == 0:
        return {"variables": 0, "quadratic_terms": 0, "upload_bytes": 0, "charge_seconds": 0,
                "fits": True}
    if not solver.kind:
        return {"variables": n, "quadratic_terms": models.Terms(problem).count}
    with explained():
        kind = solver.run(options.solver, problem, options)
        if session is None:
            return {"service_solver": None, **kind.plan(hybrid.PUBLISHED.get(options.solver))}
        return {"service_solver": session.solver.name,
                **kind.plan(session.properties, session.solver)}


def planned(options, found):
    """One plan for people."""
    said = [f"{NAMES.get(options.solver, options.solver)}: {found['variables']:,} variables, "
            f"{found['quadratic_terms']:,} quadratic terms"]
    if found["variables"] == 0:
        return "\n".join([*said, "nothing is left to decide; nothing is ever sent"])
    if "service_solver" not in found:
        return "\n".join([*said, "runs on this machine; nothing is ever sent"])
    whose = (f"of {line(found['service_solver'])}" if found["service_solver"] else
             "as published; without an account the solver cannot be asked")
    said += (_planned_qpu if options.solver == "qpu" else _planned_hybrid)(options, found, whose)
    fits = {True: "it fits", False: f"it does not fit: {found['reason']}",
            None: "whether it fits, the embedding will show"}[found["fits"]]
    return "\n".join([*said, f"{fits}; nothing was sent"])


def _planned_qpu(options, found, whose):
    copies, known = found["copies"], found["embedded_qubits"]
    if copies == "auto":
        yield (f"as many copies as are found on the chip, {options.num_reads:,} samples of each")
    elif copies != 1:
        yield (f"{copies:,} copies: {options.num_reads * copies:,} samples from "
               f"{options.num_reads:,} reads")
    if "largest_degree" in found:
        yield (f"largest degree {found['largest_degree']}; linear terms {found['linear_min']} to "
               f"{found['linear_max']}, quadratic terms {found['quadratic_min']} to "
               f"{found['quadratic_max']}")
    size = f"{found['upload_bytes']:,} bytes"
    yield (f"upload {size}, {known:,} qubits in the embedding" if known else
           f"upload at least {size}, the embedding adds to them")
    for chip, qubits in found["qubits"].items():
        yield f"{line(chip)}: {qubits:,} qubits ({whose})"
    if found.get("charge_seconds"):
        yield (f"estimated charge {'' if known else 'at most '}{found['charge_seconds']:.3f} s of "
               "QPU access")


def _planned_hybrid(options, found, whose):
    yield (f"upload about {found['upload_bytes']:,} bytes; least time limit "
           f"{found['minimum_time_limit']:,.1f} s")
    for key, limit in found["limits"].items():
        yield f"{found[key]:,} {key} of {limit:,} that the service takes ({whose})"
    rate = found["charge_qpu_seconds"]
    yield (f"estimated charge {found['charge_seconds']:,.1f} s of the hybrid solver"
           + ("" if rate is None else f", worth {rate:,.2f} s of QPU access"))
