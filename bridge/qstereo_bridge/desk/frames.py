"""The command `frames`: many pairs of pictures on the workers of dask.distributed.

Each pair is three tasks: encode and reduce, solve, decode and score. What a task makes is in the
output folder, beside the key of what it was made from. So a second run goes on from there, and so
does a task whose worker has died. All workers see the same folders.
"""

import contextlib
import csv
import functools
import hashlib
import json
import os
import shlex
import tempfile
import time
from io import StringIO
from pathlib import Path

from ..core import command
from ..core.failure import BAD_INPUT, NO, OK, SERVICE, USAGE, Error, Failure, failing, io
from ..core.output import save
from ..core.problem import load_samples
from ..core.text import parse
from ..runs import bill, calls, registry, remote, runner

STEPS = "encode", "reduce", "solve", "decode", "score"
COLUMNS = ("name", "variables", "variables_left", "energy", "lower_bound", "gap", "proven_optimal",
           "rms", "bad_0_5", "bad_1_0", "seconds", "charge", "error")
# Seconds without any worker before frames are given up, and between two looks.
PATIENCE, PAUSE = 120, 0.1


def pairs(place):
    """The pairs of a folder or of a list: (name, left, right, truth or None), paths."""
    place, found = Path(place).absolute(), []
    with io(place, "read"):
        if place.is_dir():
            for left in sorted(place.glob("left_*.png")):
                name = left.stem.removeprefix("left_")
                truth = place / f"truth_{name}.png"
                found.append((name, left, place / f"right_{name}.png",
                              truth if truth.exists() else None))
        else:
            said = place.read_text(encoding="utf-8", errors="surrogateescape").splitlines()
            for number, line in enumerate(said, 1):
                words = _split(line, f"{place}: line {number}", comments=True)
                if len(words) not in (0, 2, 3):
                    raise Failure(BAD_INPUT, f"{place}: line {number} has {len(words)} words; a "
                                             "line is `left right` or `left right truth`")
                if words:
                    left, right, truth = [place.parent / word for word in words] + [None] * (
                        3 - len(words))
                    found.append((f"{number:04}", left, right, truth))
    if not found:
        raise Failure(BAD_INPUT, f"{place}: there is no pair; a folder holds left_NAME.png and "
                                 "right_NAME.png, a list `left right` on each line")
    return found


def _split(text, place, **options):
    try:
        return shlex.split(text, **options)
    except ValueError as error:
        raise Failure(BAD_INPUT, f"{place}: {error}") from None


def _key(*parts):
    """What a step is made from, in short. Of a Path its file counts."""
    found = hashlib.sha256()
    for part in parts:
        with io(part, "read"):
            data = part.read_bytes() if isinstance(part, Path) else json.dumps(part).encode()
        found.update(b"%d:" % len(data) + data)
    return found.hexdigest()


def _scale(words, step, option):
    """The grey levels of a pixel that the words of a step give, 8 where they give none. Raises
    Failure."""
    for word, after in zip(words[step], [*words[step][1:], ""]):
        name, equals, value = word.partition("=")
        if name == option:
            try:
                return float(value if equals else after)
            except ValueError:
                raise Failure(USAGE, f"--{step}: {option} needs a number") from None
    return 8


def _known(frame, name, key, ends):
    """(The facts of the frame's steps, from its .json; whether the step `name` is done: made from
    the same, and its files are there)."""
    try:
        state = dict(parse(Path(f"{frame['base']}.json").read_bytes()))
        done = dict(state.get(name, {})).get("key") == key
    except (FileNotFoundError, ValueError, TypeError):
        return {}, False
    return state, done and all(Path(frame["base"] + end).exists() for end in ends)


def _step(frame, name, key, ends, work):
    """The facts of a step that is done, else what work(folder) returns, `folder` being one that is
    removed."""
    state, done = _known(frame, name, key, ends)
    if done:
        return state[name]
    path = Path(f"{frame['base']}.json")
    if state.pop(name, None):
        # Samples without these facts are those of a run that was interrupted, and are kept.
        for end in [*ends, *(f"{end}.journal" for end in ends)]:
            Path(frame["base"] + end).unlink(missing_ok=True)
        save(path, json.dumps(state).encode())
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="qstereo-") as folder:
        facts = work(folder)
    state[name] = {"key": key, **facts, "seconds": round(time.monotonic() - began, 3)}
    save(path, json.dumps(state, indent=1).encode())
    return state[name]


def _task(work):
    """A task's errors as one of Python's own, which every worker can send."""
    @functools.wraps(work)
    def run(*arguments):
        try:
            with failing(None):
                return work(*arguments)
        except Error as error:
            raise RuntimeError(str(error)) from None
    return run


@_task
def reduced(frame):
    """Encode and reduce: the facts of the step."""
    words = frame["words"]

    def work(folder):
        command.call(folder, "encode", str(frame["left"]), str(frame["right"]), "-o", "p.qcf",
                     *words["encode"])
        said = json.loads(command.call(folder, "reduce", "p.qcf", "-o", "core.qcf", "--json",
                                       *words["reduce"]))
        save(frame["base"] + ".qcf", Path(folder, "core.qcf").read_bytes())
        return {"variables": said["variables_before"], "variables_left": said["variables_after"],
                "lower_bound": said["lower_bound"]}
    key = _key(frame["left"], frame["right"], words["encode"], words["reduce"])
    return _step(frame, "reduce", key, (".qcf",), work)


def solving(options, base, words):
    """The options of `solve` for a frame. Raises click.UsageError, Failure."""
    given = options.options_of("solve", [f"{base}.qcf", "-o", f"{base}.qsf", "--quiet", *words])
    for option, wrong, why in (
            ("-o", given.output != f"{base}.qsf", "each frame's samples have a name"),
            ("--no-wait", given.no_wait, "each frame's samples are decoded"),
            ("--dry-run", given.dry_run, "give it to frames: it is for all frames"),
            ("--max-charge", given.max_charge, "give it to frames: it is for all frames")):
        if wrong:
            raise Failure(USAGE, f"--solve does not take {option}; {why}")
    given.said = []
    return given


@_task
def planned(frame, before):
    """What solving the frame would send, at most: the frame as the bill has it."""
    given = frame["solve"]
    given.dry_run = frame["dry_run"]
    _, done = _known(frame, "solve", _key(before["key"], frame["words"]["solve"]), (".qsf",))
    plans = [] if done else calls.planned(given) if given.windows else remote.planned(given)
    unfit = [{key: found[key] for key in ("fits", "reason")} for found in plans
             if found.get("fits") is False]
    return {"frame": frame["name"], "variables": before["variables_left"], "calls": len(plans),
            "charge_seconds": bill.charge_of(plans), "skipped": done, **dict(*unfit[:1])}


@_task
def solved(frame, before):
    """Solve what is left: the facts of the step. What was sent already is collected."""
    given = frame["solve"]

    def work(folder):
        if given.windows:
            calls.solve(given)
        else:
            remote.solve_one(given)
        info = load_samples(given.output).info
        charges = [call["charge_seconds"] for call in info.get("calls", [])]
        bounds = [bound for bound in (before["lower_bound"], info.get("lower_bound"))
                  if bound is not None]
        return {"lower_bound": max(bounds, default=None),
                "charge": sum(charges) if charges else calls.charged(info)}
    return _step(frame, "solve", _key(before["key"], frame["words"]["solve"]), (".qsf",), work)


@_task
def finished(frame, before, solving):
    """Decode and score: the frame as the summary has it."""
    words, truth, base = frame["words"], frame["truth"], frame["base"]

    def work(folder):
        said = json.loads(command.call(folder, "decode", f"{base}.qcf", f"{base}.qsf", "-o",
                                       "map.png", "--json", *words["decode"]))
        facts = {"energy": said["energy"]}
        if truth:
            said = json.loads(command.call(folder, "score", "map.png", str(truth), "--json",
                                           f"--scale={frame['scale']:g}", *words["score"]))
            facts |= {key: said[key] for key in ("rms", "bad_0_5", "bad_1_0")}
        for made in Path(folder).glob("map*.png"):
            save(base + made.name.removeprefix("map"), made.read_bytes())
        return facts
    key = _key(solving["key"], words["decode"], words["score"], *([truth] if truth else []))
    facts, bound = _step(frame, "decode", key, (".png",), work), solving["lower_bound"]
    result = {"solver": frame["solver"], "map": f"{Path(base).name}.png", **facts,
              "gap": None if bound is None else facts["energy"] - bound,
              "proven_optimal": facts["energy"] == bound, "charge": solving["charge"],
              "seconds": round(sum(one["seconds"] for one in (before, solving, facts)), 3)}
    del result["key"]
    near = {side: frame[side] and os.path.relpath(frame[side], Path(base).parent)
            for side in ("left", "right", "truth")}
    return {"name": frame["name"], **near,
            **{key: frame[key] for key in ("scale", "truth_scale")},
            **{key: before[key] for key in ("variables", "variables_left")},
            "lower_bound": bound, "results": [result]}


def _manned(client, paid):
    """Whether there is a worker, for paid calls one that takes them."""
    # scheduler_info() may name none: the client's own question in between asks for none.
    with contextlib.suppress(OSError):
        workers = client.sync(client.scheduler.identity, n_workers=-1)["workers"].values()
        return any(not paid or worker.get("resources", {}).get("qpu") for worker in workers)
    # The scheduler is gone.
    return False


@contextlib.contextmanager
def _client(options, paid):
    """The Client of the scheduler, or of a cluster of this machine."""
    from dask.distributed import Client, LocalCluster
    with contextlib.ExitStack() as stack:
        if options.scheduler is None:
            place = stack.enter_context(LocalCluster(
                n_workers=options.workers, threads_per_worker=1, resources={"qpu": 1},
                dashboard_address="127.0.0.1:0"))
        else:
            place = options.scheduler
        try:
            client = stack.enter_context(Client(place))
        except (OSError, ValueError) as error:
            raise Failure(SERVICE, f"{place}: cannot reach this scheduler: {error}") from None
        if paid and not _manned(client, paid):
            raise Failure(SERVICE, f"{place}: no worker has the resource qpu, which paid calls "
                                   "need; start one with `dask worker ... --resources qpu=1`")
        yield client


def _summary(folder, problems, failed):
    """Writes summary.json and summary.csv."""
    said = {"schema": 1, "problems": problems, "failed": [
        {"name": name, "error": error} for name, error in failed.items()]}
    save(folder / "summary.json", json.dumps(said, indent=1).encode())
    table = StringIO()
    rows = csv.DictWriter(table, COLUMNS, extrasaction="ignore")
    rows.writeheader()
    rows.writerows([{**one, **one["results"][0]} for one in problems] + said["failed"])
    save(folder / "summary.csv", table.getvalue().encode("utf-8", "surrogateescape"))


def _ends(client, tasks, failed, tell, paid=False):
    """The results of the tasks {task: frame's name}, as they come. The errors of others are told,
    and put into `failed`, {name: error}; all that are left fail where there has been no worker for
    them for PATIENCE seconds."""
    from dask.distributed import as_completed

    def fail(task, error):
        failed[tasks[task]] = str(error)
        tell(f"{tasks[task]}: {error}")
    left, ends, seen = dict(tasks), as_completed(tasks), time.monotonic()
    while left:
        for task in ends.next_batch(block=False):
            del left[task]
            lost = task.cancelled() and "the scheduler is lost; give the same command again"
            if error := lost or task.exception():
                fail(task, error)
            else:
                yield task.result()
        if _manned(client, paid):
            seen = time.monotonic()
        elif time.monotonic() - seen >= PATIENCE:
            for task in left:
                fail(task, f"{'no worker with the resource qpu' if paid else 'no worker'} is left; "
                           "start one and give the same command again")
            return
        time.sleep(PAUSE)


def frames(options):
    """The command `frames`."""
    began, folder = time.monotonic(), Path(options.out_dir).absolute()
    words = {step: _split(getattr(options, step), f"--{step}") for step in STEPS}
    solver, found = solving(options, "frame", words["solve"]).solver, pairs(options.pairs)
    options.solver, paid = solver, registry.find(solver).paid
    if options.max_charge and not paid:
        raise Failure(USAGE, f"{solver} runs on your workers and charges nothing; leave "
                             "--max-charge out")

    scales = {"scale": _scale(words, "decode", "--scale"),
              "truth_scale": _scale(words, "score", "--truth-scale")}

    def tell(text):
        if not options.quiet:
            runner.say(options, text)
    with io(folder, "make"):
        folder.mkdir(parents=True, exist_ok=True)
    problems, failed, first, plans, tasks = [], {}, {}, {}, {}
    with _client(options, paid and not options.dry_run) as client:
        tell(f"dashboard at {client.dashboard_link}")
        for name, left, right, truth in found:
            base = str(folder / f"frame_{name}")
            frame = {"name": name, "left": left, "right": right, "truth": truth, "words": words,
                     "solver": solver, "base": base, "dry_run": options.dry_run, **scales,
                     "solve": solving(options, base, words["solve"])}
            # Pure tasks would be those of another run with this scheduler.
            first[name] = frame, client.submit(reduced, frame, pure=False)
            if options.dry_run or options.max_charge:
                plans[client.submit(planned, *first[name], pure=False)] = name
        costs = sorted(_ends(client, plans, failed, tell), key=lambda one: one["frame"])
        if options.dry_run:
            bill.show(options, "frames", costs)
            return NO if failed else OK
        if options.max_charge:
            bill.check(options, costs)
        for name in [name for name in first if name not in failed]:
            frame, before = first[name]
            second = client.submit(solved, frame, before, pure=False,
                                   resources={"qpu": 1} if paid else None)
            tasks[client.submit(finished, frame, before, second, pure=False)] = name
        for problem in _ends(client, tasks, failed, tell, paid):
            problems.append(problem)
            tell(f"[{len(problems) + len(failed)}/{len(found)}] {problem['name']}: "
                 f"{_told(problem)}")
    problems.sort(key=lambda problem: problem["name"])
    _summary(folder, problems, failed)
    text = f"{len(problems)} of {len(found)} frames, {time.monotonic() - began:.1f} s"
    text += f"; failed: {', '.join(sorted(failed))}" * bool(failed)
    runner.show(options, f"{text}\n{folder / 'summary.json'}: written", {
        "frames": len(found), "done": len(problems), "failed": sorted(failed),
        "seconds": round(time.monotonic() - began, 3)})
    return NO if failed else OK


def _told(problem):
    """A frame in one line."""
    result = problem["results"][0]
    proven = " (proven optimal)" * result["proven_optimal"]
    rms = f", rms {result['rms']:.2f}" if "rms" in result else ""
    return f"energy {result['energy']}{proven}{rms}, {result['seconds']:.1f} s"
