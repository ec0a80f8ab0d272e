"""label and encode --problem label: arrays of numpy as problems, beside energies by numpy."""

import itertools
import json

import numpy as np
import pytest
from cli_tools import run, write_pgm

POTTS = "potts"


def save(path, array):
    np.save(path, array)
    return path


def smoothness(kind, labels, truncation=None):
    a, b = np.indices((labels, labels))
    apart = abs(a - b)
    table = {"potts": (apart > 0) * 1, "linear": apart, "quadratic": apart**2}[kind]
    return table if truncation is None else np.minimum(table, truncation)


def grid_edges(height, width, mask=None):
    """Cells of both ends, and where the edge's weight and table are: (direction, row, column)."""
    seen = np.ones((height, width), bool) if mask is None else mask != 0
    right = [((y, x), (y, x + 1), (0, y, x)) for y in range(height) for x in range(width - 1)]
    down = [((y, x), (y + 1, x), (1, y, x)) for y in range(height - 1) for x in range(width)]
    return [(p, q, place) for p, q, place in right + down if seen[p] and seen[q]]


def best(sites, edges, labels):
    """The least energy: sites are cost rows, edges (p, q, table)."""
    energies = []
    for x in itertools.product(range(labels), repeat=len(sites)):
        energy = sum(costs[d] for costs, d in zip(sites, x, strict=True))
        energies.append(energy + sum(t[x[p], x[q]] for p, q, t in edges))
    return min(energies)


def grid_best(costs, table_of, mask=None):
    height, width, labels = costs.shape
    cells = [c for c in np.ndindex(height, width) if mask is None or mask[c]]
    number = {c: i for i, c in enumerate(cells)}
    edges = [(number[p], number[q], table_of(at)) for p, q, at in grid_edges(height, width, mask)]
    return best([costs[c] for c in cells], edges, labels)


def label(tmp_path, *arguments, status=0):
    (tmp_path / "out.npy").unlink(missing_ok=True)
    done = run("label", *arguments, "-o", tmp_path / "out.npy", "--json")
    assert done.status == status, done.err
    if status != 0:
        assert not (tmp_path / "out.npy").exists()
        return done.err
    return json.loads(done.out), np.load(tmp_path / "out.npy")


@pytest.mark.parametrize("kind", ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"])
def test_every_type_of_costs(tmp_path, kind):
    random = np.random.default_rng(1)
    costs = random.integers(0, 90, (3, 3, 2)).astype(kind)
    if kind[0] != "u":
        costs -= np.array(20, kind)
    facts, found = label(tmp_path, save(tmp_path / "c.npy", costs), "--lambda", "7")
    expected = grid_best(costs.astype(np.int64), lambda at: 7 * smoothness(POTTS, 2))
    assert facts["energy"] == expected
    assert found.dtype == np.int32 and found.shape == (3, 3)


@pytest.mark.parametrize("seed", range(12))
def test_grids(tmp_path, seed):
    """Weights, a mask, a table for all and a table for each edge, on random grids."""
    random = np.random.default_rng(seed)
    height, width, labels = random.integers(1, 4, 3)
    costs = random.integers(-9, 30, (height, width, labels))
    weights = [
        random.integers(0, 9, (height, width - 1)),
        random.integers(0, 9, (height - 1, width)),
    ]
    tables = [random.integers(0, 12, (*w.shape, labels, labels)) for w in weights]
    arguments = [save(tmp_path / "c.npy", costs), "--lambda", "1.5"]
    paths = [save(tmp_path / f"{n}.npy", w) for n, w in zip("rd", weights, strict=True)]
    table_paths = [save(tmp_path / f"t{n}.npy", t) for n, t in zip("rd", tables, strict=True)]
    mask = None
    if seed % 2:
        mask = random.integers(0, 3, (height, width)) > 0
        mask[0, 0] = True
        arguments += ["--mask", save(tmp_path / "m.npy", mask)]
    if seed % 4 < 2:
        arguments += ["--weights", f"{paths[0]},{paths[1]}"]
    else:
        weights = [np.ones_like(w) for w in weights]
    if seed % 3 == 0:
        arguments += ["--tables", f"{table_paths[0]},{table_paths[1]}"]
    elif seed % 3 == 1:
        one = random.integers(0, 9, (labels, labels))
        tables = [np.broadcast_to(one, t.shape) for t in tables]
        arguments += ["--pairwise", save(tmp_path / "v.npy", one)]
    else:
        one = smoothness("quadratic", labels, 3)
        tables = [np.broadcast_to(one, t.shape) for t in tables]
        arguments += ["--smoothness", "quadratic", "--truncation", "3"]

    def table_of(at):
        return 1.5 * weights[at[0]][at[1:]] * tables[at[0]][at[1:]]

    facts, found = label(tmp_path, *arguments)
    assert facts["energy"] == grid_best(costs, table_of, mask)
    assert ((found == -1) == (False if mask is None else ~mask)).all()
    # The file is the same problem.
    problem = tmp_path / "p.qcf"
    done = run("encode", "--problem", "label", *arguments, "-o", problem)
    assert done.status == 0, done.err
    done = run("solve", problem, "-o", tmp_path / "s.qsf", "--json")
    assert json.loads(done.out)["energy"] == facts["energy"]


@pytest.mark.parametrize("tables", [False, True])
def test_graphs(tmp_path, tables):
    random = np.random.default_rng(5)
    sites, labels = 6, 3
    costs = random.integers(0, 20, (sites, labels))
    pairs = np.array([(p, q) for p in range(sites) for q in range(p + 1, sites)])
    pairs = pairs[random.permutation(len(pairs))[:9]]
    weights = random.integers(0, 6, len(pairs))
    each = random.integers(0, 7, (len(pairs), labels, labels))
    arguments = [save(tmp_path / "c.npy", costs), "--edges", save(tmp_path / "e.npy", pairs)]
    if tables:
        arguments += ["--tables", save(tmp_path / "t.npy", each)]
    else:
        arguments += ["--weights", save(tmp_path / "w.npy", weights), "--smoothness", "linear"]
        each = weights[:, None, None] * smoothness("linear", labels)
    facts, found = label(tmp_path, *arguments)
    assert facts["energy"] == best(
        list(costs), [(p, q, t) for (p, q), t in zip(pairs, each, strict=True)], labels
    )
    assert found.shape == (sites,)


@pytest.mark.parametrize("seed", range(6))
def test_cuts_solve_submodular_tables_of_two_labels(tmp_path, seed):
    """On a grid and on a graph; a table that is not submodular is refused."""
    random = np.random.default_rng(seed)
    costs = random.integers(0, 9, (3, 3, 2) if seed % 2 else (9, 2))
    sizes = [(3, 2), (2, 3)] if seed % 2 else [(12,)]
    tables = [random.integers(0, 12, (*size, 2, 2)) for size in sizes]
    for t in tables:
        most = t[..., 0, 1] + t[..., 1, 0]
        t[..., 1, 1] = np.minimum(t[..., 1, 1], most)
        t[..., 0, 0] = np.minimum(t[..., 0, 0], most - t[..., 1, 1])
    if seed % 2:
        pairs = {place: (p, q) for p, q, place in grid_edges(3, 3)}
        edges = [(3 * p[0] + p[1], 3 * q[0] + q[1], tables[at[0]][at[1:]])
                 for at, (p, q) in pairs.items()]
        arguments = []
    else:
        pairs = random.permutation([(a, b) for b in range(9) for a in range(b)])[:12]
        edges = [(a, b, t) for (a, b), t in zip(pairs, tables[0], strict=True)]
        arguments = ["--edges", save(tmp_path / "e.npy", pairs)]
    save(tmp_path / "c.npy", costs)
    names = [str(save(tmp_path / f"t{i}.npy", t)) for i, t in enumerate(tables)]
    arguments = ["--solver", "cut", "--tables", ",".join(names), *arguments]
    facts, _ = label(tmp_path, tmp_path / "c.npy", *arguments)
    assert facts["proven_optimal"]
    assert facts["energy"] == best(costs.reshape(9, 2), edges, 2)
    tables[0][..., 0, 0] += 25
    save(tmp_path / "t0.npy", tables[0])
    error = label(tmp_path, tmp_path / "c.npy", *arguments, status=2)
    assert "--solver cut cannot solve" in error and "(tables, 2 labels)" in error


def test_infinite_costs_forbid_labels(tmp_path):
    random = np.random.default_rng(6)
    costs = random.integers(0, 40, (3, 3, 3)).astype(np.float32) / 4
    costs[random.random(costs.shape) < 0.4] = np.inf
    costs[..., 0] = np.where(np.isinf(costs).all(-1), 3, costs[..., 0])
    path = save(tmp_path / "c.npy", costs)
    facts, found = label(tmp_path, path, "--scale", "4", "--lambda", "2.5")
    expected = grid_best(costs.astype(np.float64), lambda at: 2.5 * smoothness(POTTS, 3))
    assert facts["energy"] == expected
    assert np.isfinite(np.take_along_axis(costs, found[..., None], -1)).all()
    problem = tmp_path / "p.qcf"
    done = run("encode", "--problem", "label", path, "--scale", "4", "--lambda", "2.5", "--json",
               "-o", problem)
    assert done.status == 0, done.err
    assert json.loads(done.out)["variables"] < costs.size
    assert json.loads(run("solve", problem, "-o", tmp_path / "s.qsf", "--json").out)[
        "energy"
    ] == expected


@pytest.mark.parametrize("kind", ["u2", "u4", "i8", "u8", "f4", "f8"])
def test_the_largest_numbers(tmp_path, kind):
    """Numbers near the end of what fits, and the next one, with a scale."""
    most = min(2**31 - 1, np.iinfo(kind).max if kind[0] in "iu" else 2**31 - 512) // 4 * 4
    costs = np.zeros((1, 40, 2), kind)
    costs[0, 33, :] = most // 4
    path = save(tmp_path / "c.npy", costs)
    assert label(tmp_path, path, "--scale", "4")[0]["energy"] == most // 4
    if kind != "u2":
        costs[0, 33, :] = 2**31 // 4
        error = label(tmp_path, save(path, costs), "--scale", "4", status=3)
        assert "[0, 33, 0]" in error


@pytest.mark.parametrize("kind", ["f4", "f8"])
def test_floats_are_rounded_to_the_scale(tmp_path, kind):
    costs = np.array([[[0.26, 0.0], [0.0, 0.74]]], kind)
    path = save(tmp_path / "c.npy", costs)
    assert label(tmp_path, path, "--scale", "2", "--lambda", "0.3")[0]["energy"] == 0.3
    assert label(tmp_path, path, "--scale", "1", "--lambda", "0.3")[0]["energy"] == 0
    table = save(tmp_path / "v.npy", np.array([[0, 0.5], [0.25, 0]], np.float32))
    facts, _ = label(tmp_path, path, "--scale", "4", "--pairwise", table, "--lambda", "2")
    assert facts["energy"] == 0.25


LOSSES = [
    ({"c": [[[0, 0.25], [0.9, 0]]]}, [], ["c.npy", "whole numbers, by up to 0.25 (at [0, 0, 1])"]),
    ({"c": [[[0, 0.25], [0.9, 0]]], "m": [[0, 1]]}, ["--mask", "m.npy"], ["0.1 (at [0, 1, 0])"]),
    ({"c": [[[0, np.inf], [2.5, 0]]]}, [], ["by up to 0.5 (at [0, 1, 0])"]),
    ({"c": [[[0, 1], [1, 0]]], "v": [[0, 0.375], [1, 0]]}, ["--pairwise", "v.npy"],
     ["v.npy", "0.375 (at [0, 1])"]),
    ({"c": [[[0, 1], [1, 0]]], "r": [[0.25]], "d": np.zeros((0, 2))},
     ["--weights", "r.npy,d.npy", "--lambda", "2.5"],
     ["r.npy", "lambda times its floats is rounded to 1/2, by up to 0.125 (at [0, 0])"]),
    ({"c": [[[0, 1], [1, 0]]], "r": [[[[0, 0.2], [1, 0]]]], "d": np.zeros((0, 2, 2, 2))},
     ["--tables", "r.npy,d.npy"], ["r.npy", "0.2 (at [0, 0, 0, 1])"]),
    ({"c": [[0, 1], [1, 0]], "e": [[0, 1]], "w": [0.3]},
     ["--edges", "e.npy", "--weights", "w.npy"], ["w.npy", "0.3 (at [0])"]),
    ({"c": [[0, 1], [1, 0]], "e": [[0, 1]], "t": [[[0, 0.4], [1, 0]]]},
     ["--edges", "e.npy", "--tables", "t.npy"], ["t.npy", "0.4 (at [0, 0, 1])"]),
]  # fmt: skip


@pytest.mark.parametrize("kind", ["f4", "f8"])
@pytest.mark.parametrize(("arrays", "arguments", "words"), LOSSES)
def test_what_rounding_loses_is_said(tmp_path, monkeypatch, kind, arrays, arguments, words):
    """Unless a scale was chosen."""
    monkeypatch.chdir(tmp_path)
    for name, array in arrays.items():
        np.save(f"{name}.npy", np.asarray(array, int if name in "em" else kind))
    done = run("label", "c.npy", "-o", "l.npy", *arguments)
    assert done.status == 0 and done.err.count(": warning: ") == 1
    for word in [*words, "--scale 1000"]:
        assert word in done.err
    for scale in ("1", "1000"):
        assert run("label", "c.npy", "-o", "l.npy", *arguments, "--scale", scale).err == ""


def test_whole_floats_lose_nothing(tmp_path):
    path = save(tmp_path / "c.npy", np.float32([[[0, 3], [2**20, np.inf]]]))
    assert run("label", path, "-o", tmp_path / "l.npy").err == ""


def test_truth(tmp_path):
    costs = save(tmp_path / "c.npy", np.array([[[0, 5], [5, 0], [0, 9]]]))
    truth = save(tmp_path / "t.npy", np.array([[1, 1, 0]]))
    facts, _ = label(tmp_path, costs, "--truth", truth, "--lambda", "2")
    assert (facts["sites"], facts["wrong"], facts["truth_energy"]) == (3, 1, 7)
    wrong = save(tmp_path / "t.npy", np.array([[2, 1, 0]]))
    assert label(tmp_path, costs, "--truth", wrong)[0]["truth_energy"] is None
    wrong = save(tmp_path / "t.npy", np.arange(3))
    assert "a label for each cell" in label(tmp_path, costs, "--truth", wrong, status=3)


def test_masks_are_pictures_too(tmp_path):
    costs = save(tmp_path / "c.npy", np.zeros((2, 2, 2), np.uint8))
    mask = write_pgm(tmp_path / "m.pgm", np.array([[0, 255], [255, 255]]))
    assert label(tmp_path, costs, "--mask", mask)[1].tolist() == [[-1, 0], [0, 0]]


GRID = np.zeros((2, 3, 2), np.float32)
EDGES = np.array([[0, 1]])


def changed(array, index, value):
    array = array.copy()
    array[index] = value
    return array


ERRORS = [
    ({"c": changed(GRID, (1, 2, 0), np.nan)}, [], ["c.npy", "[1, 2, 0]", "nan"]),
    ({"c": changed(GRID, (0, 1, 1), -np.inf)}, [], ["[0, 1, 1]", "-inf: inf forbids a label"]),
    ({"c": changed(GRID, (0, 1), np.inf)}, [], ["[0, 1]", "inf", "no label"]),
    ({"c": changed(GRID, (0, 1, 1), 3e9)}, [], ["[0, 1, 1]", "3e+09", "divide the array"]),
    ({"c": GRID.astype("i8") + 2**31}, [], ["[0, 0, 0]", "2147483648"]),
    ({"c": GRID.astype(">i4")}, [], [">i4", "astype"]),
    ({"c": GRID.astype("f2")}, [], ["<f2", "astype"]),
    ({"c": changed(GRID.astype("f8"), (1, 2, 0), 1e40)}, [],
     ["[1, 2, 0]", "1e+40", "divide the array"]),
    ({"c": GRID.astype("i8") - 2**40}, [], ["[0, 0, 0]", "-1099511627776"]),
    ({"c": GRID.astype("u8") - np.uint64(5)}, [], ["[0, 0, 0]", "18446744073709551611"]),
    ({"c": np.asfortranarray(GRID)}, [], ["Fortran", "ascontiguousarray"]),
    ({"c": GRID[0]}, [], ["3 x 2", "H x W x K"]),
    ({"c": GRID[:0]}, [], ["0 x 3 x 2"]),
    ({"c": GRID, "r": np.zeros((2, 3), int), "d": np.zeros((1, 3), int)},
     ["--weights", "r.npy,d.npy"], ["r.npy", "2 x 3", "2 x 2"]),
    ({"c": GRID, "r": np.full((2, 2), -4), "d": np.zeros((1, 3), int)},
     ["--weights", "r.npy,d.npy"], ["r.npy", "[0, 0]", "-4", "weight"]),
    ({"c": GRID, "r": np.full((2, 2), np.inf, "f4"), "d": np.zeros((1, 3), int)},
     ["--weights", "r.npy,d.npy"], ["r.npy", "[0, 0]", "inf"]),
    ({"c": GRID, "r": np.full((2, 2, 2, 2), -1), "d": np.zeros((1, 3, 2, 2), int)},
     ["--tables", "r.npy,d.npy"], ["r.npy", "[0, 0, 0, 0]", "-1"]),
    ({"c": GRID, "v": np.zeros((3, 3), int)}, ["--pairwise", "v.npy"], ["v.npy", "3 x 3", "2 x 2"]),
    ({"c": GRID, "v": np.zeros((2, 2), "f4")}, ["--pairwise", "v.npy", "--lambda", "1.5"],
     ["v.npy", "--lambda"]),
    ({"c": GRID[0], "e": EDGES + 2}, ["--edges", "e.npy"], ["e.npy", "[0, 0]", "2 and 3"]),
    ({"c": GRID[0], "e": EDGES[:, ::-1].copy()}, ["--edges", "e.npy"],
     ["1 and 0", "lower number first"]),
    ({"c": GRID[0], "e": EDGES * 0}, ["--edges", "e.npy"], ["[0, 0]", "0 with itself"]),
    ({"c": GRID[0], "e": EDGES, "w": np.zeros(2, int)}, ["--edges", "e.npy", "--weights", "w.npy"],
     ["w.npy"]),
    ({"c": GRID, "m": np.zeros((2, 3), int)}, ["--mask", "m.npy"], ["m.npy", "no site"]),
    ({"c": GRID[0], "e": np.zeros((0, 2))}, ["--edges", "e.npy"], ["e.npy", "holds floats"]),
    ({"c": GRID[0], "e": np.array([[0, 2**40]])}, ["--edges", "e.npy"],
     ["[0, 1]", "1099511627776", "the number of a site"]),
    ({"c": GRID, "m": np.ones((2, 3))}, ["--mask", "m.npy"], ["m.npy", "holds floats"]),
    ({"c": GRID, "r": np.full((2, 2), -0.25), "d": np.zeros((1, 3), int)},
     ["--weights", "r.npy,d.npy"], ["r.npy", "[0, 0]", "-0.25", "a weight cannot be below 0"]),
    ({"c": np.full((1, 1, 2), 2**30)}, ["--lambda", "0.25"], ["--lambda with fewer decimals"]),
    ({"c": np.full((1, 1, 2), 2**30)}, ["--scale", "4"], ["choose a smaller --scale"]),
    ({"c": GRID, "m": np.ones((3, 3), int)}, ["--mask", "m.npy"], ["m.npy", "3 rows"]),
]  # fmt: skip


@pytest.mark.parametrize(("arrays", "arguments", "words"), ERRORS)
def test_errors_name_array_index_and_mend(tmp_path, monkeypatch, arrays, arguments, words):
    monkeypatch.chdir(tmp_path)
    for name, array in arrays.items():
        np.save(f"{name}.npy", array)
    error = label(tmp_path, "c.npy", *arguments, status=3)
    assert error.count("\n") == 1
    for word in words:
        assert word in error


def test_damaged_files(tmp_path):
    good = save(tmp_path / "c.npy", np.zeros((2, 2, 2), np.uint8)).read_bytes()
    path = tmp_path / "c.npy"
    for data, word in [
        (good[:-1], "cut short"),
        (good + b"0", "cut short"),
        (good[:60], "not a .npy"),
        (b"", "not a .npy"),
        (good.replace(b"'shape': (2, 2, 2)", b"'shape': [2, 2, 2]"), "header"),
        (good.replace(b"'|u1'", b"[('')]"[:5]), "records"),
    ]:
        path.write_bytes(data)
        assert word in label(tmp_path, path, status=3)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["--pairwise", "v.npy", "--smoothness", "linear"], "give one"),
        (["--truncation", "3"], "--smoothness"),
        (["--edges", "e.npy", "--mask", "m.npy"], "--mask"),
        (["--weights", "r.npy"], "RIGHT.npy,DOWN.npy"),
        (["--edges", "e.npy", "--weights", "r.npy,d.npy"], "with --edges it is one array"),
        (["--edges", "e.npy", "--tables", "r.npy,d.npy"], "with --edges it is one array"),
        (["--scale", "0"], "--scale"),
        (["--scale", "999983", "--lambda", "1e-6"], "rounder"),
    ],
)
def test_usage(tmp_path, monkeypatch, arguments, word):
    monkeypatch.chdir(tmp_path)
    save(tmp_path / "e.npy", np.array([[0, 1]]))
    costs = np.zeros((2, 2) if "e.npy" in arguments else (2, 2, 2), "u1")
    assert word in label(tmp_path, save(tmp_path / "c.npy", costs), *arguments, status=2)


def test_the_name_of_the_output_is_that_of_an_array(tmp_path):
    costs = save(tmp_path / "c.npy", np.zeros((2, 2, 2), np.uint8))
    done = run("label", costs, "-o", tmp_path / "out.png")
    assert done.status == 2 and "ends in .npy" in done.err
    assert not (tmp_path / "out.png").exists()
