"""qb.Problem and qb.decode beside the command: the same bytes on random problems, and the labels of
every encoding, reduced or not.
"""

import io
import itertools
import subprocess
import tempfile
import warnings
from pathlib import Path

import numpy as np
import pytest
import qstereo_bridge as qb
from dimod import ExactSolver
from dwave.samplers import TreeDecompositionSolver
from hypothesis import given, settings
from hypothesis import strategies as st
from library import QSTEREO_PNM


@pytest.fixture(autouse=True, scope="module")
def command_of_this_tree():
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("QSTEREO", str(QSTEREO_PNM))
        yield


def qstereo(folder, *words):
    done = subprocess.run([QSTEREO_PNM, *map(str, words)], cwd=folder, capture_output=True,
                          text=True)
    assert done.returncode == 0, done.stderr


def pairwise_of(random, sizes, labels, kind, given, words):
    """Adds one of the ways to say what neighbours cost; `sizes` are those of the edges."""
    way = random.choice(["potts", "linear", "quadratic", "matrix", "tables"])
    if way == "tables":
        tables = [random.integers(0, 9, (*size, labels, labels)).astype(kind) for size in sizes]
        given["tables"] = tables if len(sizes) == 2 else tables[0]
        words += ["--tables", "tables0.npy,tables1.npy" if len(sizes) == 2 else "tables.npy"]
    elif way == "matrix":
        given["pairwise"] = random.integers(0, 9, (labels, labels)).astype(kind)
        words += ["--pairwise", "pairwise.npy"]
    else:
        given["pairwise"] = str(way)
        words += ["--smoothness", way]
        if way != "potts" and random.random() < 0.5:
            given["truncation"] = 2
            words += ["--truncation", "2"]


def arrays_of(random, shape, labels, kind):
    """Keyword arguments of Problem for a grid, and the words of the command for the same."""
    height, width = shape
    ends = {"right": (height, width - 1), "down": (height - 1, width)}
    given, words = {}, []
    pairwise_of(random, list(ends.values()), labels, kind, given, words)
    if random.random() < 0.5 and not floats(given):
        given |= {key: random.integers(0, 9, size).astype(kind) for key, size in ends.items()}
        words += ["--weights", "right.npy,down.npy"]
    if random.random() < 0.5:
        given["mask"] = random.random(shape) < 0.8
        given["mask"][0, 0] = True
        words += ["--mask", "mask.npy"]
    return given, words


def graph_of(random, sites, labels, kind):
    edges = np.array([(a, b) for b in range(sites) for a in range(b) if random.random() < 0.5],
                     int).reshape(-1, 2)
    given, words = {"edges": edges}, ["--edges", "edges.npy"]
    pairwise_of(random, [(len(edges),)], labels, kind, given, words)
    if random.random() < 0.5 and not floats(given):
        given["weights"] = random.integers(0, 9, len(edges)).astype(kind)
        words += ["--weights", "weights.npy"]
    return given, words


def floats(given):
    """Whether V or the tables are floats, which go without weights and with a whole lambda."""
    held = given.get("tables", given.get("pairwise"))
    arrays = held if isinstance(held, list) else [held]
    return any(isinstance(array, np.ndarray) and array.dtype.kind == "f" for array in arrays)


def save(folder, arrays):
    for key, value in arrays.items():
        if isinstance(value, list):
            for i, array in enumerate(value):
                np.save(folder / f"{key}{i}.npy", array)
        elif isinstance(value, np.ndarray):
            np.save(folder / f"{key}.npy", value)


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 2**32 - 1), st.booleans(), st.sampled_from(["i4", "u1", "f4", "f8", "i8"]),
       st.sampled_from(["i4", "u2", "i8", "f8"]))
def test_the_bytes_are_the_command_s(seed, is_grid, kind, pairwise_kind):
    """On random problems with all arguments: V by a name or an array, truncation, tables, weights,
    edges, mask, forbidden labels, lambda, scale, penalty, encoding."""
    random = np.random.default_rng(seed)
    *shape, labels = random.integers(1, 4, 3)
    shape = shape if is_grid else [shape[0] * shape[1]]
    costs = random.integers(0, 50, (*shape, labels)).astype(kind)
    if kind[0] == "f":
        costs = (costs / 4).astype(kind)
        costs[..., 1:][random.random((*shape, labels - 1)) < 0.2] = np.inf
    given, words = (arrays_of if is_grid else graph_of)(
        random, shape if is_grid else shape[0], labels, pairwise_kind)
    encoding = str(random.choice(["one-hot", "domain-wall"]))
    options = {"lam": 3 if floats(given) else 2.5, "scale": int(random.choice([1, 2, 12])),
               "penalty": str(random.choice(["minimal", "local"])), "encoding": encoding}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        save(folder, {"costs": costs, **given})
        qstereo(folder, "encode", "--problem", "label", "costs.npy", *words, "--lambda",
                options["lam"], "--scale", options["scale"], "--penalty", options["penalty"],
                "--encoding", encoding, "-o", "p.qcf")
        expected = (folder / "p.qcf").read_bytes()
        p = qb.Problem(costs, **given, **options)
        p.save(folder / "again.qcf")
        assert (folder / "again.qcf").read_bytes() == expected
        again = qb.load(folder / "p.qcf")
        stream = io.BytesIO()
        again.save(stream)
        assert stream.getvalue() == expected and again.digest == p.digest
    assert len(p) == p.linear.size


def energy_of(costs, lam, table, labels):
    y, x = np.indices(labels.shape)
    return (costs[y, x, labels].sum() + lam * table[labels[:, :-1], labels[:, 1:]].sum()
            + lam * table[labels[:-1], labels[1:]].sum())


ENCODINGS = {"one-hot": "quadratic", "one-hot-sparse": "potts", "domain-wall": "linear",
             "multiway-cut": "potts", "st-cut": "linear", "st-cut-arcs": "linear"}


def least(costs, lam, table):
    """The optimum, by all labellings."""
    *shape, count = costs.shape
    labels = itertools.product(range(count), repeat=shape[0] * shape[1])
    return min(energy_of(costs, lam, table, np.reshape(one, shape)) for one in labels)


@pytest.mark.parametrize("encoding", ENCODINGS)
@settings(deadline=None, max_examples=5)
@given(st.integers(0, 2**32 - 1))
def test_labels_of_every_encoding(encoding, seed):
    random = np.random.default_rng(seed)
    costs, kind = random.integers(0, 20, (2, 2, 3)), ENCODINGS[encoding]
    a, b = np.indices((3, 3))
    table = {"quadratic": (a - b) ** 2, "potts": (a != b) * 1, "linear": abs(a - b)}[kind]
    p = qb.Problem(costs, kind, lam=4, encoding=encoding)
    samples = p.sample(TreeDecompositionSolver())
    labels = qb.decode(p, samples)
    assert labels.shape == (2, 2) and labels.dtype == np.int32
    assert energy_of(costs, 4, table, labels) == least(costs, 4, table)
    assert samples.records["energy"].min() == p.scale * least(costs, 4, table)


@settings(deadline=None, max_examples=10)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1, 6, 18]))
def test_labels_of_a_reduced_problem(seed, target):
    random = np.random.default_rng(seed)
    costs = random.integers(0, 9, (3, 4, 4))
    table = 1 - np.eye(4, dtype=int)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        qb.Problem(costs, lam=3).save(folder / "p.qcf")
        qstereo(folder, "reduce", "p.qcf", "-o", "core.qcf", "--target", target)
        qstereo(folder, "solve", "p.qcf", "-o", "s.qsf", "--solver", "best")
        core = qb.load(folder / "core.qcf")
        best = qb.load_samples(folder / "s.qsf").records["energy"].min()
    labels = qb.decode(core, core.sample(TreeDecompositionSolver()) if len(core) else None)
    assert energy_of(costs, 3, table, labels) == best


@pytest.mark.parametrize("labels", [255, 256])
def test_labels_have_one_byte_as_long_as_they_fit(labels, tmp_path):
    """Fixed ones and those of the labelling that a file carries, in both readers."""
    costs = np.full((6, 6, labels), 50)
    costs[..., [0, 1, -2, -1]] = np.random.default_rng(1).integers(0, 9, (6, 6, 4))
    costs[0, 0, -1] = -40
    np.save(tmp_path / "costs.npy", costs)
    qstereo(tmp_path, "encode", "--problem", "label", "costs.npy", "--lambda", 4, "-o", "p.qcf")
    qstereo(tmp_path, "reduce", "p.qcf", "-o", "core.qcf", "--iterations", 1)
    qstereo(tmp_path, "solve", "core.qcf", "-o", "s.qsf", "--solver", "best")
    core = qb.load(tmp_path / "core.qcf")
    assert core.known.size == len(core) > 0
    assert qb.decode(core, qb.load_samples(tmp_path / "s.qsf")).max() == labels - 1


def test_what_a_label_stands_for_does_not_matter(tmp_path):
    """Of a reduced stereo problem, decided wholly, too; graphs give N labels, masked cells -1."""
    for name, shift in (("left", 0), ("right", 2)):
        row = np.roll(np.arange(20, dtype=np.uint8) * 12, -shift)
        (tmp_path / f"{name}.pgm").write_bytes(b"P5\n20 1\n255\n" + row.tobytes())
    qstereo(tmp_path, "encode", "left.pgm", "right.pgm", "-o", "p.qcf", "--disparity", "1:3",
            "--reduce")
    p = qb.load(tmp_path / "p.qcf")
    assert len(p) == 0
    labels = qb.decode(p)
    assert labels.shape == (1, 17) and (labels == 1).all()
    graph = qb.Problem([[0, 3], [3, 0], [0, 3]], edges=[[0, 1]])
    assert qb.decode(graph, graph.sample(ExactSolver())).tolist() == [0, 1, 0]
    grid = qb.Problem([[[0, 3], [3, 0]]], mask=[[0, 1]])
    assert qb.decode(grid, grid.sample(ExactSolver()), sample=0, repair=True).shape == (1, 2)
    assert qb.decode(grid, grid.sample(ExactSolver())).tolist() == [[-1, 1]]


WRONG = [
    (dict(costs=[[[0.0, np.nan]]]), "costs.npy: [0, 0, 1] is nan"),
    (dict(costs=np.zeros((2, 2))), "H x W x K"),
    (dict(costs=[["a"]]), "no array of numbers"),
    (dict(costs=np.zeros((1, 2, 2)), pairwise="sharp"), "--smoothness sharp is unknown"),
    (dict(costs=np.zeros((1, 2, 2)), lam=-1), "--lambda"),
    (dict(costs=np.zeros((1, 2, 2)), right=[[1]]), "down is missing"),
    (dict(costs=np.zeros((1, 2, 2)), weights=[1]), "right and down"),
    (dict(costs=np.zeros((2, 2)), edges=[[0, 1]], right=[1]), "weights those of edges"),
    (dict(costs=np.zeros((1, 2, 2)), tables=[1, 2, 3]), "two arrays"),
    (dict(costs=np.zeros((1, 2, 2)), encoding="tern"), "--encoding tern"),
]


@pytest.mark.parametrize(("arguments", "words"), WRONG)
def test_the_command_s_sentences(arguments, words):
    with pytest.raises(qb.InputError) as caught:
        qb.Problem(**arguments)
    said = str(caught.value)
    assert words in said and "help:" not in said and not said.startswith("qstereo")


@pytest.mark.parametrize("kind", [">i4", ">u2", ">f8", "?"])
def test_any_order_of_bytes_and_axes(kind):
    costs = np.random.default_rng(3).integers(0, 9, (3, 4, 2)).astype(kind)
    expected = qb.Problem(costs.astype("i4"), "linear", lam=2).digest
    for same in (costs, np.asfortranarray(costs), costs[::-1].copy()[::-1], costs.tolist()):
        assert qb.Problem(same, "linear", lam=2).digest == expected


def test_floats_that_lose_something_are_warned_of():
    costs = np.array([[[0.26, 0.5], [0.0, 0.74]]])
    said = r"costs.npy: its floats are rounded .* up to 0.5 "
    with pytest.warns(UserWarning, match=said) as seen:
        p = qb.Problem(costs)
    assert p.scale == 1 and seen[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert qb.Problem(costs, scale=100).scale == 100
        qb.Problem(costs, scale=1)
        qb.Problem(costs.round())


def test_answers_that_are_no(tmp_path):
    p = qb.Problem([[[0, 3], [3, 0]]])
    samples = p.sample(ExactSolver())
    samples.bits[:] = 1
    samples.records["energy"][:] = p.energies(samples.bits)
    with pytest.raises(qb.Error, match="none of the 16 samples is feasible") as caught:
        qb.decode(p, samples)
    assert caught.value.status == 1
    assert qb.decode(p, samples, repair=True).shape == (1, 2)
    with pytest.raises(qb.InputError, match="S.qsf is missing"):
        qb.decode(p)
    with pytest.raises(qb.InputError, match="samples 0 to 15"):
        qb.decode(p, samples, sample=16)


def test_a_missing_command(monkeypatch, tmp_path):
    monkeypatch.setenv("QSTEREO", str(tmp_path / "none"))
    with pytest.raises(qb.Error, match="PATH.*QSTEREO") as caught:
        qb.Problem([[[0, 1]]])
    assert caught.value.status == 4
    (tmp_path / "none").write_text("#!/bin/sh\nkill -9 $$\n")
    (tmp_path / "none").chmod(0o755)
    with pytest.raises(qb.Error, match="ended by signal 9"):
        qb.Problem([[[0, 1]]])
