"""Costs, half pixels, weights by contrast and presets of the command beside plain numpy."""

import json

import numpy as np
import pytest
from cli_tools import random_pair, read_pfm, read_pnm, run, succeed, write_pgm


def half_samples(picture):
    """The samples half a pixel to the left of the pixels."""
    before = np.concatenate([picture[:, :1], picture[:, :-1]], axis=1)
    return (before + picture + 1) // 2


def census(picture, width, height):
    """The bits of each pixel, one plane a neighbour."""
    down, across = height // 2, width // 2
    padded = np.pad(picture, ((down, down), (across, across)), mode="edge")
    rows, columns = picture.shape
    planes = [padded[y : y + rows, x : x + columns] < picture
              for y in range(height) for x in range(width) if (y, x) != (down, across)]
    return np.stack(planes)


def ranges(picture):
    padded = np.pad(picture, ((0, 0), (1, 1)), mode="edge")
    three = np.stack([2 * picture, picture + padded[:, :-2], picture + padded[:, 2:]])
    return three.min(axis=0), three.max(axis=0)


def outside(picture, low, high):
    return np.maximum(0, np.maximum(2 * picture - high, low - 2 * picture))


def shifted(values, by):
    """values[..., x - by], the first one before it."""
    columns = np.maximum(np.arange(values.shape[-1]) - by, 0)
    return values[..., columns]


def term(name, left, right, by, window):
    """The cost of each pixel for the sample `by` columns to the left in `right`."""
    moved = shifted(right, by)
    if name == "ad":
        return np.abs(left - moved)
    if name == "sd":
        return (left - moved) ** 2
    if name == "census":
        return (census(left, *window) != shifted(census(right, *window), by)).sum(axis=0)
    low, high = (shifted(end, by) for end in ranges(right))
    return np.minimum(outside(left, low, high), outside(moved, *ranges(left)))


def costs_of(left, right, terms, labels, parts, keep):
    """theta[y, x, label]; each term is (weight, name, window, truncation or None)."""
    planes = []
    for label in range(labels):
        from_ = half_samples(right) if label % parts else right
        by = label // parts
        plane = 0
        for weight, name, window, truncation in terms:
            cost = term(name, left, from_, by, window)
            plane = plane + weight * (cost if truncation is None else np.minimum(cost, truncation))
        if keep:
            beyond = np.arange(left.shape[1]) * parts < label
            plane = np.where(beyond, terms[0][0] * terms[0][3], plane)
        planes.append(plane)
    return np.stack(planes, axis=-1)


def energy_of(theta, labels, left, lam, smooth, contrast):
    """F of the labels of the right-most columns."""
    height, width = labels.shape
    first = left.shape[1] - width
    shown = left[:, first:]
    data = np.take_along_axis(theta[:, first:], labels[..., None], axis=-1).sum()
    edges = 0
    for axis in (0, 1):
        below, times = contrast or (0, 1)
        weight = np.where(np.abs(np.diff(shown, axis=axis)) < below, times * lam, lam)
        edges += (weight * smooth(np.abs(np.diff(labels, axis=axis)))).sum()
    return data + edges


CASES = [
    ("ad", [(1, "ad", None, None)]),
    ("sd:900", [(1, "sd", None, 900)]),
    ("bt:40+2*census:7x7", [(1, "bt", None, 40), (2, "census", (7, 7), None)]),
    ("3*census:3x5:7", [(3, "census", (3, 5), 7)]),
    ("2*ad:30+bt", [(2, "ad", None, 30), (1, "bt", None, None)]),
]


@pytest.mark.parametrize("step", ["1", "0.5"])
@pytest.mark.parametrize("text, terms", CASES)
def test_energies_are_those_of_numpy(tmp_path, text, terms, step):
    left, right, *paths = random_pair(tmp_path, 30, 11, seed=len(text))
    parts = 2 if step == "0.5" else 1
    lam = 2 if text.startswith("3*census") else 25
    keep = terms[0][3] is not None
    labels = 4 * parts + 1
    options = ["--disparity", f"0:4:{step}", "--cost", text, "--lambda", lam, "--contrast", "60,3",
               "--smoothness", "linear", "--truncation", 2,
               "--border", "keep" if keep else "leave-out"]
    made = tmp_path / "m.pfm"
    facts = json.loads(succeed("match", *paths, "-o", made, *options, "--json").out)
    values = read_pfm(made.read_bytes())[:, 0 if keep else 4:]
    found = np.rint(values * parts).astype(int)
    assert np.array_equal(found / parts, values)
    theta = costs_of(left, right, terms, labels, parts, keep)
    expected = energy_of(theta, found, left, lam, lambda off: np.minimum(off, 2), (60, 3))
    assert facts["energy"] == expected
    assert len(np.unique(found)) > 2
    # The file has the same problem: its optimum is that of the pictures.
    problem, samples, again = (tmp_path / name for name in ("p.qcf", "s.qsf", "d.pfm"))
    succeed("encode", *paths, "-o", problem, *options)
    succeed("solve", problem, "-o", samples)
    decoded = json.loads(succeed("decode", problem, samples, "-o", again, "--json").out)
    read = read_pfm(again.read_bytes())[:, 0 if keep else 4:]
    assert decoded["energy"] == facts["energy"] == energy_of(
        theta, np.rint(read * parts).astype(int), left, lam, lambda off: np.minimum(off, 2),
        (60, 3))
    described = json.loads(succeed("info", problem, "--json").out)
    assert (described["disparity_max"], described["labels"]) == (4, labels)


def moving(folder):
    """A square that stands 3 pixels nearer than its background, of grey noise."""
    random = np.random.default_rng(5)
    right = random.integers(0, 256, (24, 60))
    left = np.roll(right, 2, axis=1)
    patch = random.integers(0, 256, (12, 16))
    left[6:18, 30:46], right[6:18, 25:41] = patch, patch
    truth = np.full(left.shape, 2)
    truth[6:18, 30:46] = 5
    paths = [write_pgm(folder / f"{name}.pgm", picture)
             for name, picture in (("left", left), ("right", right))]
    return truth, paths


@pytest.mark.parametrize("preset, most, step, after, iterations", [
    ("accurate", 8, .5, "check,fill", 8), ("accurate", 32, .5, "check,fill", 8),
    ("fast", 8, .5, "check,fill", 5), ("fast", 32, 1, "halves,check,fill", 1)])
def test_what_a_preset_takes_follows_the_range(tmp_path, preset, most, step, after, iterations):
    paths = random_pair(tmp_path, 40, 6)[2:]
    facts = json.loads(succeed("match", *paths, "-o", tmp_path / "m.pfm", "--disparity",
                               f"0:{most}", "--preset", preset, "--json").out)
    assert (facts["disparity_step"], facts["after"]) == (step, after)
    assert facts["iterations"] == iterations


@pytest.mark.parametrize("preset, step, after", [("accurate", ":0.5", "check,fill"),
                                                 ("fast", ":0.5", "check,fill"),
                                                 ("fast", ":1", "halves,check,fill")])
def test_presets_find_a_square(tmp_path, preset, step, after):
    truth, paths = moving(tmp_path)
    made, mask, sure = (tmp_path / name for name in ("m.pfm", "mask.pgm", "sure.pgm"))
    facts = json.loads(succeed("match", *paths, "-o", made, "--disparity", f"0:8{step}", "--preset",
                               preset, "--after", after, "--mask", mask, "--confidence", sure,
                               "--json").out)
    assert (facts["preset"], facts["disparity_step"]) == (preset, float(step[1:]))
    found = read_pfm(made.read_bytes())
    assert np.isfinite(found).all()
    assert (np.abs(found - truth)[:, 8:] < 1).mean() > .97
    kept, most = read_pnm(mask.read_bytes())
    margin, _ = read_pnm(sure.read_bytes())
    assert most == 255 and set(np.unique(kept)) == {0, 255}
    assert np.array_equal(margin > 0, kept == 255)
    beside = (margin[:, 1:] > 0) & (margin[:, :-1] > 0)
    steps = np.abs(np.diff(margin.astype(int), axis=1))[beside]
    assert steps.max() <= 86  # means of nine, of which three differ, by 255 at most
    hidden = kept[6:18, 27:30]  # left of the square: the right picture does not show it
    assert (hidden == 0).mean() > .5
    assert (kept[:, 50:] == 255).mean() > .9


def test_what_is_given_wins_over_the_preset(tmp_path):
    _, paths = moving(tmp_path)
    facts = json.loads(succeed(
        "match", *paths, "-o", tmp_path / "m.pfm", "--preset", "accurate", "--disparity", "0:8:1",
        "--after", "none", "--smoothness", "potts", "--cost", "ad:20", "--solver", "icm",
        "--json").out)
    given = {"disparity_step": 1, "after": "none", "smoothness": "potts", "truncation": None,
             "cost": "ad:20", "solver": "icm", "lambda": "20", "contrast": "10,3"}
    assert {key: facts[key] for key in given} == given
    assert np.array_equal(read_pfm((tmp_path / "m.pfm").read_bytes()) % 1, np.zeros((24, 60)))


@pytest.mark.parametrize("options, solver", [
    ([], "trws16"), (["--lambda", "12.5"], "trws"), (["--lambda", "330"], "trws16"),
    (["--lambda", "340"], "trws"), (["--smoothness", "quadratic", "--truncation", "4"], "trws"),
    (["--cost", "sd:300"], "trws"), (["--lambda", "340", "--smoothness", "potts"], "trws16")])
def test_larger_numbers_where_small_ones_do_not_suffice(tmp_path, options, solver):
    _, paths = moving(tmp_path)
    facts = json.loads(succeed("match", *paths, "-o", tmp_path / "m.pfm", "--preset", "accurate",
                               "--disparity", "0:8", *options, "--json").out)
    assert facts["solver"] == solver and facts["iterations"] <= 8


def test_wide_ranges_are_smoothed_less(tmp_path):
    _, paths = moving(tmp_path)
    for most, strength, truncation in (31, "14", "4"), (32, "3", "8"):
        facts = json.loads(succeed("match", *paths, "-o", tmp_path / "m.pfm", "--preset",
                                   "accurate", "--disparity", f"0:{most}", "--json").out)
        assert (facts["lambda"], facts["truncation"]) == (strength, truncation)


def test_refined_and_median_maps(tmp_path):
    truth, paths = moving(tmp_path)
    options = ["--preset", "fast", "--disparity", "0:8"]
    succeed("match", *paths, "-o", tmp_path / "m.pfm", *options, "--after",
            "refine,check,fill,median")
    found = read_pfm((tmp_path / "m.pfm").read_bytes())
    assert np.array_equal(found * 16, np.rint(found * 16))
    assert (found % 1 != 0).any()
    assert (np.abs(found - truth)[:, 8:] < 1).mean() > .95


@pytest.mark.parametrize("options, words", [
    (["--cost", "ad+"], "is not a sum"),
    (["--cost", "bt+ad+sd"], "is not a sum"),
    (["--cost", "census"], "is not a sum"),
    (["--cost", "census:8x3"], "window of census"),
    (["--cost", "256*ad"], "is not a sum"),
    (["--cost", "2*sd"], "above 65535"),
    (["--cost", "census:3x3+census:5x5"], "same window"),
    (["--border", "keep"], "needs a truncation"),
    (["--border", "all"], "keep and leave-out"),
    (["--contrast", "8"], "--contrast 8 is not"),
    (["--contrast", "0,3"], "--contrast 0,3 is not"),
    (["--disparity", "0:9:0.25"], "the step is 1 or 0.5"),
    (["--disparity", "0:9:2"], "the step is 1 or 0.5"),
    (["--preset", "best"], "there are paper, accurate and fast"),
    (["--after", "check"], "goes with --border keep"),
    (["--after", "fill,check"], "in this order"),
    (["--after", "fill,"], "in this order"),
])
def test_refusals(tmp_path, pair, options, words):
    done = run("match", *pair.paths, "-o", tmp_path / "m.pgm", *options)
    assert done.status == 2 and words in done.err
    assert not (tmp_path / "m.pgm").exists()


@pytest.mark.parametrize("preset", ["accurate", "fast"])
def test_a_window_alone_is_filled(tmp_path, preset):
    """Outside --roi there is no value, also where holes are filled along the rows."""
    left, right, *names = random_pair(tmp_path, 40, 24)
    succeed("match", *names, "-o", tmp_path / "m.pfm", "--disparity", "0:5", "--preset", preset,
            "--roi", "10,6,16,9")
    found = np.isfinite(read_pfm((tmp_path / "m.pfm").read_bytes()))
    assert found[6:15, 10:26].all() and found.sum() == 16 * 9


HALF = ["--preset", "fast", "--disparity", "0:8:1", "--after"]


def test_half_pixels_after_the_labels(tmp_path):
    """A scene that is shifted by five half pixels: whole labels miss it, and halves find it."""
    random = np.random.default_rng(4).random((40, 300))
    samples = sum(random[:, i:i + 240] for i in range(7))
    samples = 255 * (samples - samples.min()) / np.ptp(samples)
    left, right = samples[:, 20:220:2], samples[:, 25:225:2]
    paths = [write_pgm(tmp_path / f"{n}.pgm", p) for n, p in (("l", left), ("r", right))]

    def found(steps):
        succeed("match", *paths, "-o", tmp_path / "m.pfm", "--lambda", "2", *HALF, steps)
        return read_pfm((tmp_path / "m.pfm").read_bytes())[:, 8:]

    whole, halves = found("none"), found("halves")
    assert np.isin(whole, [2, 3]).mean() > .9 and (halves == 2.5).mean() > .5
    assert np.abs(halves - whole).max() <= .5


def test_fast_with_half_pixel_labels_has_no_halves_after(tmp_path):
    paths = random_pair(tmp_path, 40, 6)[2:]
    for step, after in ("", "halves,check,fill"), (":0.5", "check,fill"):
        done = succeed("match", *paths, "-o", tmp_path / "m.pfm", "--preset", "fast",
                       "--disparity", f"0:32{step}", "--json")
        assert json.loads(done.out)["after"] == after


@pytest.mark.parametrize("options, message", [
    (["--disparity", "0:8:0.5"], "--after halves goes with whole pixels"),
    (["--smoothness", "quadratic", "--truncation", "4"],
     "--after halves goes with --smoothness potts or linear"),
    (["--after", "halves,refine"], "choose one"),
    (["--after", "check,halves"], "in this order"),
])
def test_halves_that_cannot_be(tmp_path, options, message):
    paths = random_pair(tmp_path, 20, 6)[2:]
    done = run("match", *paths, "-o", tmp_path / "m.pfm", *HALF, "halves", *options)
    assert (done.status, done.out) == (2, b"") and message in done.err


@pytest.mark.parametrize("options", [["--cost", "ad:40"], ["--smoothness", "potts"],
                                     ["--lambda", "7.5"], ["--border", "leave-out"],
                                     ["--disparity", "-3:5:1"], ["--roi", "9,2,20,8"]])
def test_halves_with_other_settings(tmp_path, options):
    """The map has halves, none more than half a pixel from the map of whole pixels."""
    paths = random_pair(tmp_path, 40, 12)[2:]
    maps = []
    for steps in ("none", "halves"):
        succeed("match", *paths, "-o", tmp_path / "m.pfm", *HALF, steps, "--solver", "trws",
                "--iterations", 5, *options)
        maps.append(read_pfm((tmp_path / "m.pfm").read_bytes()))
    known = np.isfinite(maps[0])
    assert (known == np.isfinite(maps[1])).all() and (maps[1] != maps[0])[known].any()
    assert np.abs(maps[1] - maps[0])[known].max() <= .5
