"""decode: which sample becomes the map, and how maps are written."""

import json

import numpy as np
import pytest
from cli_tools import (
    energy,
    one_hot,
    random_pair,
    read_pfm,
    read_pnm,
    run,
    succeed,
    write_pgm,
    write_qsf,
)


def decode(solved, output, *options, samples=None):
    done = succeed(
        "decode", solved.problem, samples or solved.samples, "-o", output, "--json", *options
    )
    return json.loads(done.out)


def in_picture(disparities, scale=8):
    """The whole left picture as an integer map holds it."""
    held = np.zeros((5, 12), int)
    held[:, 4:] = disparities * scale
    return held


def test_the_best_feasible_sample(folder, solved):
    facts = decode(solved, folder / "m.pgm")
    assert facts == {
        "schema": 1,
        "sample": 2,
        "energy": solved.energies[1],
        "repaired": 0,
        "map": str(folder / "m.pgm"),
        "color_map": None,
    }
    values, maxval = read_pnm((folder / "m.pgm").read_bytes())
    assert maxval == 255
    assert (values == in_picture(solved.maps[1])).all()
    assert [path.name for path in folder.iterdir()] == ["m.pgm"]


def test_the_sample_asked_for(folder, solved):
    facts = decode(solved, folder / "m.pgm", "--sample", "1", "--scale", "3")
    assert (facts["sample"], facts["energy"]) == (1, solved.energies[0])
    assert (read_pnm((folder / "m.pgm").read_bytes())[0] == in_picture(solved.maps[0], 3)).all()


def test_the_human_line(folder, solved):
    done = run("decode", solved.problem, solved.samples, "-o", folder / "m.pgm")
    assert (
        done.out.decode()
        == f"{folder / 'm.pgm'}: sample 2 of 3, energy {solved.energies[1]:g}, 0 sites repaired\n"
    )


def test_16_bits_where_8_do_not_hold_it(folder, solved):
    decode(solved, folder / "m.pgm", "--scale", "100")
    values, maxval = read_pnm((folder / "m.pgm").read_bytes())
    assert maxval == 65535
    assert (values == in_picture(solved.maps[1], 100)).all()


def test_a_scale_too_large(folder, solved):
    done = run("decode", solved.problem, solved.samples, "-o", folder / "m.pgm", "--scale", "30000")
    assert (done.status, done.out) == (3, b"")
    assert "--scale 30000: 21845 is the largest" in done.err
    assert not list(folder.iterdir())
    decode(solved, folder / "m.pgm", "--scale", "21845")


def test_pfm(folder, solved):
    decode(solved, folder / "m.pfm", "--scale", "100")
    values = read_pfm((folder / "m.pfm").read_bytes())
    assert np.isposinf(values[:, :4]).all()
    assert (values[:, 4:] == solved.maps[1]).all()


def test_png(folder, solved, opencv):
    from PIL import Image

    for scale, mode in ((8, "L"), (100, "I;16")):
        decode(solved, folder / "m.PNG", "--scale", str(scale))
        picture = Image.open(folder / "m.PNG")
        assert picture.mode == mode
        assert (np.asarray(picture) == in_picture(solved.maps[1], scale)).all()


def test_png_without_opencv(folder, solved, pnm_only):
    done = run("decode", solved.problem, solved.samples, "-o", folder / "m.png", program=pnm_only)
    assert done.status == 2
    assert ".pgm and .pfm" in done.err and "OPENCV=1" in done.err
    assert not list(folder.iterdir())


def test_disparity_0_is_held_as_1(tmp_path):
    _, _, left, right = random_pair(tmp_path, 2, 1)
    succeed("encode", left, right, "-o", tmp_path / "p.qcf", "--disparity", "0:1", "--json")
    samples = write_qsf(tmp_path / "s.qsf", tmp_path / "p.qcf", [1, 0], [0])
    facts = json.loads(run("validate", tmp_path / "p.qcf", samples, "--json").out)
    samples = write_qsf(tmp_path / "s.qsf", tmp_path / "p.qcf", [1, 0], [facts["best_energy"]])
    succeed("decode", tmp_path / "p.qcf", samples, "-o", tmp_path / "m.pgm")
    assert read_pnm((tmp_path / "m.pgm").read_bytes())[0].tolist() == [[0, 1]]


def test_colours(folder, solved):
    facts = decode(solved, folder / "m.pgm", "--color")
    assert facts["color_map"] == str(folder / "m.color.ppm")
    colours, _ = read_pnm((folder / "m.color.ppm").read_bytes())
    assert (colours[:, :4] == 0).all()
    # One colour for each disparity, and not black.
    shown = {
        tuple(colour): set(solved.maps[1][(colours[:, 4:] == colour).all(axis=2)])
        for colour in np.unique(colours[:, 4:].reshape(-1, 3), axis=0)
    }
    assert len(shown) == len(np.unique(solved.maps[1])) and (0, 0, 0) not in shown
    assert all(len(disparities) == 1 for disparities in shown.values())


def test_colours_as_png(folder, solved, opencv):
    from PIL import Image

    decode(solved, folder / "m.pgm", "--color")
    facts = decode(solved, folder / "m.png", "--color")
    assert facts["color_map"] == str(folder / "m.color.png")
    assert (
        np.asarray(Image.open(folder / "m.color.png"))
        == read_pnm((folder / "m.color.ppm").read_bytes())[0]
    ).all()


def test_both_maps_or_none(folder, solved):
    (folder / "m.color.ppm").mkdir()
    (folder / "m.pgm").write_text("as it was")
    done = run("decode", solved.problem, solved.samples, "-o", folder / "m.pgm", "--color")
    assert done.status == 4
    assert (folder / "m.pgm").read_text() == "as it was"
    assert sorted(path.name for path in folder.iterdir()) == ["m.color.ppm", "m.pgm"]


def test_no_feasible_sample(tmp_path, folder, solved):
    samples = write_qsf(
        tmp_path / "n.qsf", solved.problem, solved.broken, [2 * solved.broken_energy]
    )
    for options in ([], ["--sample", "0"]):
        done = run("decode", solved.problem, samples, "-o", folder / "m.pgm", *options)
        assert (done.status, done.out) == (1, b"")
        assert "feasible" in done.err and "--repair" in done.err
    assert not list(folder.iterdir())


def test_no_sample_at_all(tmp_path, folder, solved):
    samples = write_qsf(tmp_path / "n.qsf", solved.problem, np.zeros((0, 160)), [])
    done = run("decode", solved.problem, samples, "-o", folder / "m.pgm", "--repair")
    assert (done.status, "holds no sample" in done.err) == (1, True)


def test_repair(tmp_path, folder, solved):
    """The one empty site gets the label that is cheapest beside its neighbours."""
    samples = write_qsf(
        tmp_path / "n.qsf",
        solved.problem,
        [solved.bits[0], solved.broken],
        [2 * solved.energies[0], 2 * solved.broken_energy],
    )
    candidates = []
    for label in range(1, 5):
        repaired = solved.maps[1].copy()
        repaired[0, 0] = label
        candidates.append((energy(solved.pair.left, solved.pair.right, repaired, 2.5), repaired))
    best, expected = min(candidates, key=lambda pair: pair[0])
    facts = decode(solved, folder / "m.pgm", "--repair", "--sample", "1", samples=samples)
    assert (facts["sample"], facts["repaired"], facts["energy"]) == (1, 1, best)
    assert (read_pnm((folder / "m.pgm").read_bytes())[0] == in_picture(expected)).all()
    facts = decode(solved, folder / "m.pgm", "--repair", samples=samples)
    assert facts["energy"] == min(best, solved.energies[0])


def test_repair_takes_the_best_wherever_it_stands(tmp_path, folder, solved):
    for order in ([0, 1], [1, 0]):
        samples = write_qsf(
            tmp_path / "n.qsf",
            solved.problem,
            [solved.bits[i] for i in order],
            [2 * solved.energies[i] for i in order],
        )
        facts = decode(solved, folder / "m.pgm", "--repair", samples=samples)
        assert (facts["sample"], facts["repaired"], facts["energy"]) == (
            order.index(1),
            0,
            solved.energies[1],
        )
        assert (read_pnm((folder / "m.pgm").read_bytes())[0] == in_picture(solved.maps[1])).all()


def test_memory_limit(tmp_path, folder):
    """The map is of the whole picture, however small the window is."""
    grey = write_pgm(tmp_path / "g.pgm", np.zeros((700, 700), int))
    succeed(
        "encode", grey, grey, "-o", tmp_path / "p.qcf", "--disparity", "0:0", "--roi", "0,0,2,1"
    )
    samples = write_qsf(tmp_path / "s.qsf", tmp_path / "p.qcf", [1, 1], [0])
    done = run("decode", tmp_path / "p.qcf", samples, "-o", folder / "m.pgm", "--memory-limit", "1")
    assert (done.status, "raise --memory-limit" in done.err) == (4, True)
    assert not list(folder.iterdir())
    succeed("decode", tmp_path / "p.qcf", samples, "-o", folder / "m.pgm", "--memory-limit", "2")


def test_a_wrong_energy(tmp_path, folder, solved):
    samples = write_qsf(
        tmp_path / "w.qsf",
        solved.problem,
        solved.bits,
        [2 * solved.energies[0] + 1, 2 * solved.energies[1]],
    )
    done = run("decode", solved.problem, samples, "-o", folder / "m.pgm")
    assert done.status == 3
    assert "sample 0 states the energy" in done.err
    assert not list(folder.iterdir())


def test_samples_of_another_problem(tmp_path, folder, pair, solved):
    succeed("encode", *pair.paths, "-o", tmp_path / "q.qcf", "--disparity", "1:4")
    done = run("decode", tmp_path / "q.qcf", solved.samples, "-o", folder / "m.pgm")
    assert (done.status, "samples of another problem" in done.err) == (3, True)
    assert not list(folder.iterdir())


@pytest.mark.parametrize(
    "options, words",
    [
        (["--sample", "3"], "holds samples 0 to 2"),
        (["--sample", "-1"], "--sample -1 is not a whole number"),
        (["--scale", "1"], "--scale 1 is not a whole number from 2"),
        (["--scale", "8.5"], "whole number"),
        (["-o", "m.jpg"], ".png, .pgm, .pfm or .npy"),
        (["-o", "map"], ".png, .pgm, .pfm or .npy"),
        (["-o", "-", "--color"], "--color needs"),
        (["-o", "-", "--json"], "cannot both go"),
    ],
)
def test_usage_errors(tmp_path, folder, solved, options, words):
    output = [] if "-o" in options else ["-o", folder / "m.pgm"]
    done = run("decode", solved.problem, solved.samples, *output, *options, cwd=folder)
    assert done.status == 2
    assert words in done.err
    assert not list(folder.iterdir())


@pytest.mark.parametrize("name, to", [("m.pgm", "-"), ("m.pfm", "pfm:-")])
def test_standard_output_is_a_pgm_or_pfm(folder, solved, name, to):
    decode(solved, folder / name)
    assert (
        run("decode", solved.problem, solved.samples, "-o", to).out == (folder / name).read_bytes()
    )


def test_a_window_inside_the_picture(tmp_path):
    left, right, left_path, right_path = random_pair(tmp_path, 12, 7)
    options = ["--roi", "5,2,4,3", "--disparity", "2:3"]
    succeed("encode", left_path, right_path, "-o", tmp_path / "p.qcf", *options)
    chosen = np.random.default_rng(3).integers(2, 4, (3, 4))
    exact = energy(left[2:5, :9], right[2:5, :9], chosen, 20)
    samples = write_qsf(tmp_path / "s.qsf", tmp_path / "p.qcf", one_hot(chosen - 2, 2), [exact])
    succeed("decode", tmp_path / "p.qcf", samples, "-o", tmp_path / "m.pgm")
    expected = np.zeros((7, 12), int)
    expected[2:5, 5:9] = 8 * chosen
    assert (read_pnm((tmp_path / "m.pgm").read_bytes())[0] == expected).all()


@pytest.mark.parametrize("palette", ["turbo", "viridis"])
def test_palettes_and_the_bar(tmp_path, palette):
    """The colours of a map of many disparities are those of matplotlib."""
    import matplotlib

    *_, left, right = random_pair(tmp_path, 64, 40)
    paths = left, right
    line = ["match", *paths, "-o", tmp_path / "m.pfm", "--disparity", "3:18", "--solver", "icm"]
    line += ["--color", "--palette", palette]
    succeed(*line)
    plain, _ = read_pnm((tmp_path / "m.color.ppm").read_bytes())
    succeed(*line, "--scale-bar")
    barred, _ = read_pnm((tmp_path / "m.color.ppm").read_bytes())
    values = read_pfm((tmp_path / "m.pfm").read_bytes())
    shown = np.isfinite(values)
    wanted = matplotlib.colormaps[palette]((values[shown] - 3) / 15)[:, :3] * 255
    assert shown.sum() == 40 * 46 and len(np.unique(values[shown])) == 16
    assert np.abs(plain[shown] - wanted).max() <= 4
    assert not plain[~shown].any()
    assert barred.shape == (40, 64 + 68, 3) and np.array_equal(barred[:, :64], plain)
    bar = barred[::-1, 64 + 6 : 64 + 18]
    assert (bar == bar[:, :1]).all()
    wanted = matplotlib.colormaps[palette](np.linspace(0, 1, 40))[:, :3] * 255
    assert np.abs(bar[:, 0] - wanted).max() <= 4
    white = (barred[:, 64 + 18 :] == 255).all(axis=2)
    ticks = white[:, :4].all(axis=1)
    assert ticks[0] and ticks[39] and ticks.sum() == 2  # 18 above, 3 below
    digits = ["".join(".#"[int(dot)] for dot in row[6:14:2]) for row in white[30:40:2]]
    assert digits == ["###.", "..#.", "###.", "..#.", "###."]  # the 3 of --disparity 3:18


def test_a_bar_goes_with_colours(folder, solved):
    done = run("decode", solved.problem, solved.samples, "-o", folder / "m.pgm", "--scale-bar")
    assert done.status == 2 and "--scale-bar goes with --color: add --color" in done.err
