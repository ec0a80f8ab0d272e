"""`best` beside each of the library's other solvers, on families of random problems: the energies
after the same time. Figures `families`.

    python tests/bench/bench_families.py [--figures DIR] [--only NAME] [--limits 2,10]

Each problem is drawn from a fixed seed. A solver that cannot take a problem is left out. `best`
should nowhere be clearly above any other one.
"""

import subprocess
import tempfile
from pathlib import Path

import numpy as np
from scenes import Figures, arguments, call

SOLVERS = ("icm", "anneal", "expansion", "swap", "bp", "trws", "best")
LIMITS = "2,10"
SIDE = 40


def grid(random, side, labels, most=100):
    return random.integers(0, most, (side, side, labels))


def edges_of(random, sites, degree):
    """Each two sites are joined with the same chance, so that `degree` is the usual number."""
    first, second = np.triu_indices(sites, 1)
    chosen = random.random(len(first)) < degree / (sites - 1)
    return np.stack((first[chosen], second[chosen]), axis=1)


def right_and_down(random, side, shape=(), most=100, least=0):
    return {"right": random.integers(least, most, (side, side - 1, *shape)),
            "down": random.integers(least, most, (side - 1, side, *shape))}


def edge_tables(random):
    """A random table for each edge."""
    return {"costs": grid(random, SIDE, 6), "tables": right_and_down(random, SIDE, (6, 6))}


def signed_potts(random):
    """Potts costs whose weights are positive or negative: tables, shifted so that none is below
    0."""
    tables = {}
    for name, weights in right_and_down(random, SIDE, most=51, least=-50).items():
        same = np.where(weights < 0, -weights, 0)[..., None, None] * np.eye(4, dtype=np.int64)
        other = np.where(weights > 0, weights, 0)[..., None, None] * (1 - np.eye(4, dtype=np.int64))
        tables[name] = same + other
    return {"costs": grid(random, SIDE, 4, 60), "tables": tables}


def spin_glass(random):
    """Two labels, no fields to speak of, couplings of both signs."""
    tables = {}
    for name, weights in right_and_down(random, SIDE, most=101, least=-100).items():
        same = np.array([[1, 0], [0, 1]])
        tables[name] = np.where(weights[..., None, None] < 0, same, 1 - same) * np.abs(
            weights[..., None, None])
    return {"costs": grid(random, SIDE, 2, 2), "tables": tables}


def steps(random, side, labels):
    """Costs of a scene of rectangles, seen through noise."""
    truth = np.zeros((side, side), np.int64)
    for _ in range(30):
        (y, x), (height, width) = random.integers(0, side, 2), random.integers(4, side // 2, 2)
        truth[y:y + height, x:x + width] = random.integers(0, labels)
    noisy = truth + random.normal(0, labels / 6, truth.shape)
    return np.abs(noisy[..., None] - np.arange(labels)) * 20


def linear(random):
    return {"costs": steps(random, 120, 24).astype(np.int64), "smoothness": "linear",
            "truncation": 3, "lambda": 25}


def quadratic(random):
    return {"costs": (steps(random, 120, 24) ** 2 / 40).astype(np.int64),
            "smoothness": "quadratic", "truncation": 9, "lambda": 40}


def segmentation(random):
    """Potts costs of five classes, weights that fall where colours differ."""
    return {"costs": steps(random, 200, 5).astype(np.int64), "lambda": 1,
            "weights": right_and_down(random, 200, most=40, least=5)}


def sparse(random):
    """A graph of four edges a site, a table for each."""
    edges = edges_of(random, 800, 4)
    return {"costs": random.integers(0, 100, (800, 5)), "edges": edges,
            "tables": random.integers(0, 100, (len(edges), 5, 5))}


def dense(random):
    """Nearly a half of all pairs are edges."""
    edges = edges_of(random, 60, 25)
    return {"costs": random.integers(0, 100, (60, 5)), "edges": edges,
            "tables": random.integers(0, 30, (len(edges), 5, 5))}


def dense_potts(random):
    edges = edges_of(random, 300, 30)
    return {"costs": random.integers(0, 100, (300, 6)), "edges": edges, "lambda": 1,
            "weights": random.integers(1, 8, len(edges))}


FAMILIES = (edge_tables, signed_potts, spin_glass, linear, quadratic, segmentation, sparse, dense,
            dense_potts)


def words_of(problem, folder):
    """Writes the arrays of a problem. Returns the arguments of `label`."""
    def save(name, array):
        path = Path(folder, f"{name}.npy")
        np.save(path, array)
        return str(path)

    words = [save("costs", problem["costs"])]
    for name in ("edges", "weights", "tables"):
        of = problem.get(name)
        if isinstance(of, dict):
            words += [f"--{name}", ",".join(save(name + key, of[key]) for key in ("right", "down"))]
        elif of is not None:
            words += [f"--{name}", save(name, of)]
    for name in ("smoothness", "truncation", "lambda"):
        if name in problem:
            words += [f"--{name}", problem[name]]
    return words


def run(qstereo, words, solver, limit, folder):
    try:
        found = call(qstereo, "label", *words, "-o", Path(folder, "x.npy"), "--solver", solver,
                     "--time-limit", limit)
    except subprocess.CalledProcessError:
        return None
    return {"energy": found["energy"], "lower_bound": found["lower_bound"],
            "seconds": found["seconds"]}


def family(make, limits, qstereo, folder):
    words = words_of(make(np.random.default_rng(1)), folder)
    rows = []
    for limit in limits:
        runs = {solver: run(qstereo, words, solver, limit, folder) for solver in SOLVERS}
        runs = {solver: found for solver, found in runs.items() if found}
        others = min(found["energy"] for solver, found in runs.items() if solver != "best")
        above = 100 * (runs["best"]["energy"] - others) / others
        print(f"{make.__name__:14}{limit:4} s  best {above:+.3f} %", *(
            f"{solver} {found['energy']}" for solver, found in runs.items()), flush=True)
        rows.append({"limit": limit, "runs": runs, "best_above_percent": above})
    return {"family": make.__name__, "limits": rows}


def main():
    options = arguments(__doc__, only="one family alone", limits=f"seconds (default {LIMITS})")
    limits = [float(limit) for limit in (options.limits or LIMITS).split(",")]
    chosen = [make for make in FAMILIES if options.only in (None, make.__name__)]
    with tempfile.TemporaryDirectory() as folder, Figures(
            options.figures, "families", "python tests/bench/bench_families.py") as figures:
        figures["families"] = [family(make, limits, options.qstereo, folder) for make in chosen]


if __name__ == "__main__":
    main()
