"""What the command does with D-Wave's services: send and wait, collect, many problems, the list of solvers, and the dry run."""

import concurrent.futures
import contextlib
import copy
import json
import os
import sys
import time

from . import jobs, models, registry, runner
from .failure import BAD_INPUT, NO, OK, USAGE, Failure, failing, io
from .hybrid import PUBLISHED
from .output import Output
from .services import WANTED, configured, connect, explain, explained


def solve(options, session=None, print_result=runner.show):
    """Solve one problem, wherever its solver runs, and write its samples."""
    if not registry.find(options.solver).kind:
        return runner.solve(options, print_result)
    problem = runner.read(options) if options.no_wait else None
    if problem and problem.linear.size:
        return solve_there(options, problem, session, runner.progress(options), print_result)

    def ask(options, problem, tell):
        answer, job = solve_there(options, problem, session, tell)
        return answer, jobs.keeping(job)
    return runner.solve(options, print_result, ask, problem)


def dry_run(options):
    """The command `solve --dry-run`: say what would be sent."""
    problem = runner.read(options)
    if problem.linear.size == 0:
        found = {"variables": 0, "quadratic_terms": 0, "upload_bytes": 0, "fits": True}
        said = "nothing is left to decide; nothing is ever sent"
    elif registry.find(options.solver).kind:
        found, said = plan(options, problem), None
    else:
        found = {"variables": problem.linear.size, "quadratic_terms": models.Terms(problem).count}
        said = "runs on this machine; nothing is ever sent"
    if options.json:
        text = json.dumps({"schema": 1, "solver": options.solver, "dry_run": True, **found})
    else:
        text = planned(options, found) if said is None else (
            f"{options.solver}: {found['variables']:,} variables, "
            f"{found['quadratic_terms']:,} quadratic terms\n{said}")
    runner.show(options, text)


def solve_there(options, problem, session, progress, print_result=runner.show):
    """Send the problem and wait: (Answer, Job). With --no-wait it is sent only, and the exit status is returned."""
    with contextlib.ExitStack() as stack:
        earlier = jobs.check_earlier(options)
        if earlier:
            stack.callback(earlier.leave)
        stack.enter_context(explained())
        kind = registry.find(options.solver).run(options.solver, problem, options)
        session = session or stack.enter_context(connect(options.solver, options.solver_name))
        answer, job = jobs.solve(kind, options, progress, session, earlier)
    if not options.no_wait:
        return answer, job
    with job:
        print_result(options, json.dumps({"schema": 1, "solver": options.solver, "job": job.path, "problem_id": job.problem_id})
                     if options.json else f"{options.solver}: sent as {job.problem_id}; `qstereo-bridge collect {job.path}` fetches the answer")
    return OK


def collect(options, print_result=runner.show):
    """The command `collect`."""
    job = jobs.Job.load(options.job)
    if job is None:
        raise Failure(BAD_INPUT, f"{options.job}: there is no such job file; it is removed when the samples are written")
    with job:
        options.solver, options.solver_name, options.label = job.solver, job.service_solver, job.user_label
        if options.solver not in WANTED:
            raise Failure(BAD_INPUT, f"{options.job}: {options.solver} is no solver that this program knows")
        options.problem = _problem_of(options, job)
        with io(options.output, "write"):
            output = Output(options.output, last=getattr(options, "out_dir", None) is None)
        with output:
            problem = runner.read(options)
            if options.digest.hex() != job.problem_digest:
                raise Failure(BAD_INPUT, f"{options.problem}: this is not the problem that was sent (its SHA-256 differs); "
                                         "name that with --problem")
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
        raise Failure(USAGE, f"{options.job}: the problem came from stdin; name its file with --problem")
    path = os.path.join(os.path.dirname(options.job), job.problem)
    if not os.path.exists(path):
        raise Failure(USAGE, f"{options.job}: the problem is no longer at {path}; name its file with --problem")
    return path


def _collected(options, problem, job, progress):
    """The Answer to a problem that may have been sent. Raises Failure(NO) where it was not, or there is none yet."""
    nothing = f"{job.path}: nothing was sent and nothing is charged; `qstereo-bridge solve` sends it"
    if job.state == jobs.UPLOADING:
        raise Failure(NO, nothing)
    with connect(job.solver, job.service_solver, reading=True) as session:
        job.session = session
        if job.state == jobs.SENDING and not jobs.find(session, job):
            raise Failure(NO, nothing)
        future = jobs.wait(session, job, progress, once=options.no_wait)
        if future is None:
            raise Failure(NO, f"{job.path}: there is no answer yet")
        return jobs.decoded(registry.SOLVERS[job.solver].run(job.solver, problem, options), future, job)


def solve_all(options):
    """The command `solve` with --out-dir: each problem to its own samples, whatever happens to the others."""
    with io(options.out_dir, "make"):
        os.makedirs(options.out_dir, exist_ok=True)
    tasks, seen = [_task(options, path) for path in options.problems], {}
    for task in tasks:
        if task.output in seen:
            raise Failure(USAGE, f"{task.problem} and {seen[task.output]} would both go to {task.output}; rename one")
        seen[task.output] = task.problem
    failed, results, count = [], [], 0
    with contextlib.ExitStack() as stack:
        session = None
        if registry.find(options.solver).kind:
            session = stack.enter_context(connect(options.solver, options.solver_name))
        pool = stack.enter_context(concurrent.futures.ThreadPoolExecutor(options.jobs or 1))
        for future in concurrent.futures.as_completed([pool.submit(_one_of_many, task, session) for task in tasks]):
            task, said, failure = future.result()
            count += 1
            if failure:
                failed.append(task.problem)
                print(f"qstereo-bridge solve: [{count}/{len(tasks)}] {failure}", file=sys.stderr, flush=True)
            elif options.json:
                results.append({"problem": task.problem, "samples_file": task.output, **said})
            else:
                runner.show(options, f"[{count}/{len(tasks)}] {task.problem}: {said}")
    if options.json:
        runner.show(options, json.dumps({"schema": 1, "solver": options.solver, "problems": results, "failed": failed}))
    if failed:
        print(f"qstereo-bridge solve: {len(failed)} of {len(tasks)} failed: {', '.join(failed)}", file=sys.stderr)
    return NO if failed else OK


def _task(options, path):
    task = copy.copy(options)
    task.problem, task.label = path, options.label
    task.output = os.path.join(options.out_dir, os.path.splitext(os.path.basename(path))[0] + ".qsf")
    registry.name_label(task)
    return task


def _one_of_many(task, session):
    """(task, what it gave, None) or (task, None, why it failed)."""
    try:
        with failing(task.problem):
            if _is_there(task):
                return task, {"skipped": True} if task.json else "skipped, the samples are there", None
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
    if not registry.find(task.solver).kind or task.resubmit or not os.path.exists(job):
        return solve(task, session, print_result)
    earlier = jobs.Job.load(job)
    if earlier is None or not _was_sent(earlier, task.digest):
        return solve(task, session, print_result)
    if task.no_wait:
        said = {"skipped": True, "solver": earlier.solver, "job": job, "problem_id": earlier.problem_id}
        return print_result(task, json.dumps(said) if task.json else f"skipped, it was sent to {earlier.solver} as {earlier.problem_id}")
    collecting = copy.copy(task)
    collecting.job, collecting.no_wait = job, False
    return collect(collecting, print_result)


def _was_sent(earlier, digest):
    """Whether the service has the problem of this digest under a job; it is asked where the job does not know."""
    with earlier:
        if earlier.problem_digest != digest.hex() or earlier.state != jobs.SENDING:
            return earlier.problem_digest == digest.hex() and earlier.state == jobs.SENT
        with connect(earlier.solver, earlier.service_solver, reading=True) as session:
            return jobs.find(session, earlier)


def _is_there(task):
    """Whether the samples file answers this very problem, whose digest is known then."""
    from .container import FormatError
    from .qsf import read_qsf
    runner.read(task)
    if not os.path.lexists(task.output):
        return False
    with contextlib.suppress(FormatError), io(task.output, "read"), open(task.output, "rb") as stream:
        return read_qsf(stream, task.memory_limit).digest == task.digest
    return False


def solvers(options):
    """The command `solvers`."""
    found = []
    with explained():
        from dwave.cloud import Client
        client = Client.from_config(client="base", defaults={})
        with contextlib.closing(client):
            for online in (True, False):
                found += map(_described, client.get_solvers(order_by=None, online=online))
    found.sort(key=lambda one: (one["kind"], one["name"]))
    if options.json:
        runner.show(options, json.dumps({"schema": 1, "solvers": found}))
        return OK
    for one in found:
        limits = ", ".join(f"{value:,} {name}" if isinstance(value, int) else f"{name} {value}" for name, value in one["limits"].items())
        load = "" if one["load"] is None else f", load {one['load']:.0%}"
        runner.show(options, f"{one['name']:<44} {one['kind']:<11} {'online' if one['online'] else 'OFFLINE'}{load}\n    {limits}")
    return OK


def _described(solver):
    properties = solver.properties
    if solver.qpu:
        topology = properties.get("topology", {})
        limits = {"qubits": len(properties["qubits"]), "couplers": len(properties["couplers"]),
                  "topology": ":".join(map(str, [topology.get("type"), *topology.get("shape", [])][:2])),
                  "reads at most": properties.get("num_reads_range", [1, None])[1],
                  "fast anneal": "yes" if "fast_anneal" in solver.parameters else "no"}
        kind = "qpu"
    else:
        from .hybrid import Bqm, Cqm, Nl
        kinds = {"hybrid-" + kind.problem_type: kind for kind in (Bqm, Cqm, Nl)}
        kind = next((name for name, one in kinds.items() if one.problem_type in solver.supported_problem_types), "other")
        limits = {what: properties[limit] for what, limit in (kinds[kind].limits if kind in kinds else {}).items() if limit in properties}
    return {"name": solver.name, "kind": kind, "online": solver.online, "load": solver.avg_load, "limits": limits}


def plan(options, problem):
    """What would be sent: a dict. By the solver's own limits where there is an account to ask, else by published ones."""
    with explained():
        kind = registry.find(options.solver).run(options.solver, problem, options)
    if not configured():
        return {"service_solver": None, **kind.plan(PUBLISHED.get(options.solver))}
    with connect(options.solver, options.solver_name) as session:
        return {"service_solver": session.solver.name, **kind.plan(session.properties, session.solver)}


def planned(options, found):
    """plan() for people."""
    whose = "of " + found["service_solver"] if found["service_solver"] else "as published; without an account the solver cannot be asked"
    lines = [f"{options.solver}: {found['variables']:,} variables, {found['quadratic_terms']:,} quadratic terms"]
    if options.solver == "qpu":
        if found["copies"] != 1:
            lines.append(f"as many copies as are found on the chip, {options.num_reads:,} samples of each" if found["copies"] == "auto" else
                         f"{found['copies']:,} copies: {options.num_reads * found['copies']:,} samples from {options.num_reads:,} reads")
        if "largest_degree" in found:
            lines.append(f"largest degree {found['largest_degree']}; linear terms {found['linear_min']} to {found['linear_max']}, "
                         f"quadratic terms {found['quadratic_min']} to {found['quadratic_max']}")
        known = found["embedded_qubits"]
        lines.append(f"upload {found['upload_bytes']:,} bytes, {known:,} qubits in the embedding" if known else
                     f"upload at least {found['upload_bytes']:,} bytes, the embedding adds to them")
        lines += [f"{chip}: {qubits:,} qubits ({whose})" for chip, qubits in found["qubits"].items()]
        if found.get("charge_seconds"):
            lines.append(f"estimated charge {'' if known else 'at most '}{found['charge_seconds']:.3f} s of QPU access")
    else:
        lines.append(f"upload about {found['upload_bytes']:,} bytes; least time limit {found['minimum_time_limit']:,.1f} s")
        lines += [f"{found[key]:,} {key} of {limit:,} that the service takes ({whose})" for key, limit in found["limits"].items()]
        rate = found["charge_qpu_seconds"]
        lines.append(f"estimated charge {found['charge_seconds']:,.1f} s of the hybrid solver"
                     + (f", worth {rate:,.2f} s of QPU access" if rate is not None else ""))
    fits = {True: "it fits", False: f"it does not fit: {found['reason']}", None: "whether it fits, the embedding will show"}[found["fits"]]
    return "\n".join([*lines, f"{fits}; nothing was sent"])
