"""match: encode, solve and decode in one go, held against the three commands."""

import json
import signal

import numpy as np
import pytest
from PIL import Image
from cli_tools import (
    LONG,
    SOLVERS,
    random_pair,
    read_pfm,
    read_pnm,
    run,
    signal_at_output,
    started,
    succeed,
    write_pgm,
)

KEYS = {
    "schema",
    "solver",
    "energy",
    "lower_bound",
    "gap",
    "proven_optimal",
    "iterations",
    "seconds",
    "converged",
    "sample",
    "repaired",
    "map",
    "color_map",
}
SETTINGS = {
    "preset",
    "cost",
    "contrast",
    "border",
    "smoothness",
    "truncation",
    "lambda",
    "disparity_step",
    "after",
}


def match(paths, output, *options):
    return json.loads(succeed("match", *paths, "-o", output, "--json", *options).out)


@pytest.fixture
def truth(tmp_path, pair):
    """A true map of the pair, in steps of 1/16 pixel."""
    values = np.random.default_rng(5).integers(0, 80, pair.left.shape)
    return write_pgm(tmp_path / "truth.pgm", values)


PROBLEMS = [
    ["--disparity", "1:4", "--lambda", "2.5"],
    ["--smoothness", "linear", "--truncation", "3", "--disparity", "0:5"],
    ["--roi", "5,1,6,3", "--disparity", "2:3", "--cost", "ad"],
]


@pytest.mark.parametrize("options", PROBLEMS)
@pytest.mark.parametrize("solver", SOLVERS)
def test_the_same_as_the_three_commands(tmp_path, folder, pair, options, solver):
    search = ["--solver", solver, "--seed", "3", "--iterations", "20"]
    problem, samples = tmp_path / "p.qcf", tmp_path / "s.qsf"
    succeed("encode", *pair.paths, "-o", problem, *options)
    solved = json.loads(run("solve", problem, "-o", samples, "--json", *search).out)
    decoded = json.loads(
        run(
            "decode",
            problem,
            samples,
            "-o",
            tmp_path / "m.pgm",
            "--json",
            "--scale",
            "5",
            "--color",
        ).out
    )
    facts = match(pair.paths, folder / "m.pgm", *options, *search, "--scale", "5", "--color")
    for name in ("m.pgm", "m.color.ppm"):
        assert (folder / name).read_bytes() == (tmp_path / name).read_bytes()
    assert set(facts) == KEYS | SETTINGS
    for of in (solved, decoded, facts):
        for key in ("seconds", "map", "color_map", *SETTINGS):
            of.pop(key, None)
    assert facts == solved | decoded
    assert sorted(path.name for path in folder.iterdir()) == ["m.color.ppm", "m.pgm"]


def test_the_errors_are_those_of_score(folder, pair, truth):
    for scale in ("8", "5"):
        scored = match(
            pair.paths,
            folder / "m.pgm",
            "--disparity",
            "0:5",
            "--truth",
            truth,
            "--truth-scale",
            "16",
            "--scale",
            scale,
        )
        alone = json.loads(
            run(
                "score", folder / "m.pgm", truth, "--scale", scale, "--truth-scale", "16", "--json"
            ).out
        )
        assert set(scored) == KEYS | SETTINGS | set(alone)
        assert alone == pytest.approx({key: scored[key] for key in alone}, rel=1e-12)


def test_the_default_is_best(folder, pair):
    facts = match(pair.paths, folder / "m.pgm", "--disparity", "0:5")
    assert (facts["solver"], facts["map"], facts["color_map"]) == (
        "best",
        str(folder / "m.pgm"),
        None,
    )


def test_pfm_and_png(folder, pair, opencv):
    from PIL import Image

    options = ["--disparity", "0:5", "--solver", "icm"]
    match(pair.paths, folder / "m.pfm", *options)
    match(pair.paths, folder / "m.png", *options)
    match(pair.paths, folder / "m.pgm", *options)
    values, _ = read_pnm((folder / "m.pgm").read_bytes())
    assert (np.asarray(Image.open(folder / "m.png")) == values).all()
    floats = read_pfm((folder / "m.pfm").read_bytes())
    assert (floats[:, 5:] == np.where(values == 1, 0, values)[:, 5:] / 8).all()


def test_png_without_opencv(folder, pair, pnm_only):
    done = run("match", *pair.paths, "-o", folder / "m.png", program=pnm_only)
    assert (done.status, "OPENCV=1" in done.err) == (2, True)
    done = run("match", *pair.paths, "-o", folder / "m.pgm", "--disparity", "0:3", program=pnm_only)
    assert done.status == 0
    assert [path.name for path in folder.iterdir()] == ["m.pgm"]


def test_human_lines(folder, pair, truth):
    options = ["--disparity", "0:5", "--solver", "icm"]
    lines = (
        run("match", *pair.paths, "-o", folder / "m.pgm", *options, "--truth", truth, "--color")
        .out.decode()
        .splitlines()
    )
    energy = match(pair.paths, folder / "m.pgm", *options)["energy"]
    assert (
        lines[0]
        == f"{folder / 'm.pgm'}, {folder / 'm.color.ppm'}: energy {energy} by icm; icm has "
        "no lower bound"
    )
    assert [line.split()[0] for line in lines[2:]] == ["pixels", "rms", "bad-0.5", "bad-1.0"]


def test_standard_streams(folder, pair):
    options = ["--disparity", "0:5", "--solver", "icm"]
    match(pair.paths, folder / "m.pgm", *options)
    done = run("match", "-", pair.paths[1], "-o", "-", *options, input=pair.paths[0].read_bytes())
    assert (done.status, done.out) == (0, (folder / "m.pgm").read_bytes())


def test_it_names_every_file_that_it_wrote(folder, pair):
    names = [folder / name for name in ("m.pgm", "m.color.ppm", "sure.pgm", "seen.pgm", "t.csv")]
    done = run("match", *pair.paths, "-o", names[0], "--disparity", "0:3", "--color",
               "--confidence", names[2], "--mask", names[3], "--trace", names[4])
    assert done.status == 0 and sorted(folder.iterdir()) == sorted(names)
    assert done.out.decode().startswith(", ".join(map(str, names)) + ": energy ")


def test_a_pair_that_does_not_fit(tmp_path, folder, pair):
    done = run("match", *pair.paths, "-o", folder / "m.pgm")
    assert (done.status, "disparity 15 needs one at 15 or further right" in done.err) == (3, True)
    small = write_pgm(tmp_path / "small.pgm", np.zeros((3, 3), int))
    done = run("match", pair.paths[0], small, "-o", folder / "m.pgm", "--disparity", "0:3")
    assert (done.status, "both pictures need the same size" in done.err) == (3, True)
    assert not list(folder.iterdir())


def test_a_truth_that_does_not_fit(tmp_path, folder, pair):
    small = write_pgm(tmp_path / "small.pgm", np.zeros((3, 3), int))
    done = run("match", *pair.paths, "-o", folder / "m.pgm", "--disparity", "0:3", "--truth", small)
    assert (done.status, done.out) == (3, b"")
    assert f"{small}: is 3 x 3 pixels, but the left picture is 12 x 5" in done.err
    assert (
        run(
            "match",
            *pair.paths,
            "-o",
            folder / "m.pgm",
            "--disparity",
            "0:3",
            "--truth",
            tmp_path / "none.pgm",
        ).status
        == 4
    )
    assert not list(folder.iterdir())


def test_a_truth_that_says_nothing(tmp_path, folder, pair):
    blank = write_pgm(tmp_path / "blank.pgm", np.zeros((5, 12), int))
    facts = match(pair.paths, folder / "m.pgm", "--disparity", "0:3", "--truth", blank)
    assert [facts[key] for key in ("pixels", "rms", "bad_0_5", "bad_1_0")] == [0, None, None, None]


@pytest.mark.parametrize("solver", ["trws", "bp", "swap", "expansion", "cut", "best"])
def test_costs_beyond_32_bits(folder, tmp_path, solver):
    left = np.array([[0, 10, 10], [0, 10, 10]], np.uint8)
    right = np.array([[15, 10, 15], [15, 10, 15]], np.uint8)
    paths = tmp_path / "left.pgm", tmp_path / "right.pgm"
    for path, grey in zip(paths, (left, right)):
        Image.fromarray(grey).save(path)
    options = ["--disparity", "0:1", "--lambda", "700.000001", "--solver", solver]
    done = run("match", *paths, "-o", folder / "m.pgm", *options, "--json")
    assert done.status == 0
    assert json.loads(done.out)["energy"] == 10


def test_memory_limit(folder, tmp_path):
    _, _, *paths = random_pair(tmp_path, 400, 300)
    done = run("match", *paths, "-o", folder / "m.pgm", "--memory-limit", "2", "--solver", "icm")
    assert (done.status, f"{paths[0]}: needs more than the memory limit of 2 MiB" in done.err) == (
        4,
        True,
    )
    assert not list(folder.iterdir())


def test_a_pairwise_cost_that_cut_does_not_take(folder, pair):
    options = ["--disparity", "0:3", "--solver", "cut"]
    done = run("match", *pair.paths, "-o", folder / "m.pgm", *options)
    assert done.status == 2
    assert "--solver cut cannot solve the problem of" in done.err
    assert "(potts, 4 labels): it needs linear or quadratic smoothness without" in done.err
    assert "take any problem: icm, anneal, swap, expansion, bp, trws, best" in done.err
    assert not list(folder.iterdir())


@pytest.mark.parametrize(
    "options, words",
    [
        (["--solver", "beste"], "did you mean best?"),
        (["--encoding", "one-hot"], "unknown option --encoding"),
        (["--scale", "1"], "from 2"),
        (["--truth", "t.pgm", "--truth-scale", "0"], "from 1"),
        (["--truth-scale", "8"], "--truth-scale goes with --truth: add --truth"),
        (["--truth-no-value", "0"], "--truth-no-value goes with --truth: add --truth"),
        (["--palette", "viridis"], "--palette goes with --color: add --color"),
        (["--truncation", "2"], "potts has nothing to truncate"),
        (["--time-limit", "never"], "above 0"),
        (["-o", "m.jpg"], ".png, .pgm or .pfm"),
        (["-o", "-", "--json"], "cannot both go"),
        (["-o", "-", "--color"], "--color needs"),
        (["--lambda", "-1"], "negative"),
    ],
)
def test_usage_errors(folder, pair, options, words):
    done = run(
        "match", *pair.paths, *([] if "-o" in options else ["-o", folder / "m.pgm"]), *options
    )
    assert (done.status, done.out) == (2, b"")
    assert words in done.err
    assert not list(folder.iterdir())


def test_a_signal_while_solving(folder, tmp_path):
    _, _, *paths = random_pair(tmp_path, 400, 300)
    process = started(
        "match",
        *paths,
        "-o",
        folder / "m.pgm",
        "--color",
        "--solver",
        "anneal",
        "--iterations",
        10**9,
    )
    signal_at_output(process, folder, 2, signal.SIGINT)
    assert process.wait(LONG) == 130
    process.communicate()
    assert not list(folder.iterdir())


def test_costs_that_are_too_large(folder, tmp_path):
    *_, left, right = random_pair(tmp_path, 530, 60)
    large = ["--smoothness", "quadratic", "--disparity", "0:511", "--lambda", "2147483647"]
    done = run("match", left, right, "-o", folder / "m.pgm", *large)
    assert (done.status, done.out) == (3, b"")
    assert f"{left}: its costs overflow what the solvers can hold" in done.err
    assert "choose a smaller --lambda or --truncation" in done.err
    assert not list(folder.iterdir())


def moved(shift, height=40, width=90, seed=7):
    """A pair whose every pixel moves by `shift`, right of its left margin."""
    scene = np.random.default_rng(seed).integers(0, 256, (height, width + shift))
    return scene[:, :width], scene[:, shift:]


def hints(folder, left, right, *options):
    paths = [
        write_pgm(folder.parent / f"{name}.pgm", picture)
        for name, picture in (("l", left), ("r", right))
    ]
    done = run("match", *paths, "-o", folder / "m.pgm", "--solver", "icm", *options)
    assert done.status == 0, done.err
    return done.err


def test_a_range_that_is_too_small_is_suspected(folder):
    err = hints(folder, *moved(5), "--disparity", "0:5")
    assert "100 % of the pixels have the largest disparity, 5: raise the MAX" in err
    assert hints(folder, *moved(5), "--disparity", "0:9") == ""


def test_swapped_pictures_are_suspected(folder):
    left, right = moved(5)
    assert "are left and right swapped?" in hints(folder, right, left, "--disparity", "0:9")


def test_a_truth_beyond_the_range_is_suspected(folder, tmp_path):
    truth = write_pgm(tmp_path / "t.pgm", np.full((40, 90), 160))
    err = hints(folder, *moved(5), "--disparity", "0:9", "--truth", truth)
    assert "100 % of its disparities are above 9" in err and "wrong by more than 1" in err
    err = hints(folder, *moved(5), "--disparity", "0:9", "--truth", truth, "--truth-scale", "32")
    assert err == ""


@pytest.mark.parametrize("beyond, disparity", [(360, 20), (3600, 10)])
def test_little_truth_beyond_the_range_is_no_reason(folder, tmp_path, beyond, disparity):
    """A tenth of the pixels, or all of them by no more than a pixel."""
    truth = np.full((40, 90), 8 * 5)
    truth.flat[:beyond] = 8 * disparity
    path = write_pgm(tmp_path / "t.pgm", truth)
    err = hints(folder, *moved(5), "--disparity", "0:9", "--truth", path)
    assert "of its disparities" not in err


def test_what_overflows_by_decimals_asks_for_fewer(folder, tmp_path):
    """The same lambda, within a millionth, but in finer units."""
    *_, left, right = random_pair(tmp_path, 580, 40)
    line = ["match", left, right, "-o", folder / "m.pgm", "--disparity", "0:511"]
    line += ["--smoothness", "quadratic", "--solver", "icm", "--iterations", 1, "--lambda"]
    done = run(*line, "2000.000001")
    assert done.status == 3
    assert "give --lambda fewer decimals, or choose a smaller --lambda" in done.err
    assert not list(folder.iterdir())
    assert run(*line, "2000").status == 0
