"""encode: the QUBO that it writes has the energies of F, and all that can be wrong is said."""

import json
from fractions import Fraction

import numpy as np
import pytest
from cli_tools import (
    bits_of,
    chunks_of,
    energy,
    one_hot,
    random_pair,
    read_pnm,
    run,
    succeed,
    write_pgm,
    write_qsf,
)


def encode(pair, output, *options):
    return json.loads(succeed("encode", *pair.paths, "-o", output, "--json", *options).out)


SMOOTH = {
    "potts": lambda step: (step != 0) * 1,
    "linear": lambda step: np.minimum(np.abs(step), 2),
    "quadratic": lambda step: np.minimum(step * step, 5),
}


@pytest.mark.parametrize(
    "smoothness, truncation, encoding",
    [
        ("potts", None, "one-hot-sparse"),
        ("potts", None, "one-hot"),
        ("linear", "2", "one-hot"),
        ("quadratic", "5", "one-hot"),
    ],
)
@pytest.mark.parametrize("penalty", ["local", "paper", "3000.5"])
def test_energies_are_those_of_F(tmp_path, pair, smoothness, truncation, encoding, penalty):
    options = [
        "--smoothness",
        smoothness,
        "--encoding",
        encoding,
        "--lambda",
        "2.5",
        "--disparity",
        "1:4",
        "--penalty",
        penalty,
    ]
    facts = encode(
        pair, tmp_path / "p.qcf", *options, *(["--truncation", truncation] if truncation else [])
    )
    maps = np.random.default_rng(7).integers(1, 5, (4, 5, 8))
    energies = [energy(pair.left, pair.right, m, 2.5, SMOOTH[smoothness]) for m in maps]
    samples = write_qsf(
        tmp_path / "s.qsf",
        tmp_path / "p.qcf",
        [one_hot(m - 1, 4) for m in maps],
        np.multiply(energies, 2),
    )
    done = succeed("validate", tmp_path / "p.qcf", samples, "--json")
    assert json.loads(done.out)["best_energy"] == min(energies)
    assert (facts["encoding"], facts["smoothness"], facts["scale"], facts["lambda"]) == (
        encoding,
        smoothness,
        2,
        2.5,
    )
    assert facts["truncation"] == int(truncation or 0)


ENCODINGS = [
    ("one-hot", "potts"),
    ("one-hot", "quadratic"),
    ("one-hot-sparse", "potts"),
    ("one-hot-sparse", "linear"),
    ("domain-wall", "potts"),
    ("domain-wall", "linear"),
    ("multiway-cut", "potts"),
    ("st-cut", "linear"),
]
PLAIN = {**SMOOTH, "linear": np.abs, "quadratic": np.square}


@pytest.mark.parametrize("encoding, smoothness", ENCODINGS)
@pytest.mark.parametrize("truncate", [[], ["--truncate"]])
def test_every_encoding_has_the_energies_of_F(tmp_path, pair, encoding, smoothness, truncate):
    """Of the labellings of lowest cost, which no truncation touches, H of the file is F; and each
    decodes to itself.
    """
    facts = encode(
        pair,
        tmp_path / "p.qcf",
        "--encoding",
        encoding,
        "--smoothness",
        smoothness,
        "--lambda",
        "2.5",
        "--disparity",
        "1:4",
        *truncate,
    )
    theta = np.stack(
        [np.abs(pair.left[:, 4:] - pair.right[:, 4 - d : 12 - d]) for d in range(1, 5)]
    )
    maps = [theta.argmin(0) + 1, np.full((5, 8), 2)][: 1 if truncate else 2]
    energies = [energy(pair.left, pair.right, m, 2.5, PLAIN[smoothness]) for m in maps]
    bits = [bits_of(m - 1, 4, encoding) for m in maps]
    assert (
        facts["variables"] == len(bits[0])
        and facts["encoding"] == encoding
        and facts["smoothness"] == smoothness
    )
    assert (facts["sites"], facts["sites_open"], facts["truncated"]) == (40, 40, bool(truncate))
    samples = write_qsf(tmp_path / "s.qsf", tmp_path / "p.qcf", bits, np.multiply(energies, 2))
    done = succeed("validate", tmp_path / "p.qcf", samples, "--json")
    assert json.loads(done.out)["feasible"] == len(maps) and json.loads(done.out)[
        "best_energy"
    ] == min(energies)
    done = succeed(
        "decode", tmp_path / "p.qcf", samples, "-o", tmp_path / "m.pgm", "--scale", "2", "--json"
    )
    assert json.loads(done.out)["energy"] == min(energies)
    assert (
        read_pnm((tmp_path / "m.pgm").read_bytes())[0][:, 4:] // 2 == maps[int(np.argmin(energies))]
    ).all()


@pytest.mark.parametrize("encoding, smoothness", [*ENCODINGS, ("st-cut-arcs", "linear")])
def test_counts_are_those_of_the_formulas(tmp_path, pair, encoding, smoothness):
    facts = encode(
        pair,
        tmp_path / "p.qcf",
        "--encoding",
        encoding,
        "--smoothness",
        smoothness,
        "--disparity",
        "0:3",
    )
    n, m, k = 9, 5, 4
    sites, edges = n * m, 2 * n * m - n - m
    variables = {
        "domain-wall": sites * (k - 1),
        "multiway-cut": sites * k + k * k,
        "st-cut": sites * k + sites + 2,
        "st-cut-arcs": 7 * n * m * k + 9 * n * m - 2 * n * k - 2 * m * k - 2 * n - 2 * m + 2,
    }
    assert facts["variables"] == variables.get(encoding, sites * k)
    wall = (
        {"potts": 3 * k - 5, "linear": k - 1}[smoothness] * edges + (k - 2) * sites
        if encoding == "domain-wall"
        else 0
    )
    terms = {
        ("one-hot", "potts"): sites * k * (k - 1) // 2 + edges * k * (k - 1),
        ("one-hot-sparse", "potts"): sites * k * (k - 1) // 2 + edges * k,
        ("domain-wall", smoothness): wall,
        ("st-cut", "linear"): sites * (k + 2) + edges * (k + 1),
    }
    assert facts["quadratic_terms"] == terms.get((encoding, smoothness), facts["quadratic_terms"])


def test_penalties_of_encodings_without_one_hot_groups(tmp_path, pair):
    """kappa = largest shifted cost of an inner label + W + gap; the cuts have no such penalty."""
    facts = encode(
        pair,
        tmp_path / "p.qcf",
        "--encoding",
        "domain-wall",
        "--disparity",
        "0:3",
        "--lambda",
        "2.5",
        "--gap",
        "6",
    )
    theta = np.stack([np.abs(pair.left[:, 3:] - pair.right[:, 3 - d : 12 - d]) for d in range(4)])
    neighbours = np.full((5, 9), 4) - (
        np.add.outer(np.isin(range(5), [0, 4]) * 1, np.isin(range(9), [0, 8]) * 1)
    )
    kappa = theta[1:3].max(0) - theta.min(0) + 2.5 * neighbours + 3
    assert (facts["penalty_min"], facts["penalty_max"]) == (kappa.min(), kappa.max())
    assert facts["pair_penalty_min"] is None and facts["pair_penalty_max"] is None
    text = run("info", tmp_path / "p.qcf").out.decode()
    assert (
        f"penalty kappa    {kappa.min():g} to {kappa.max():g}" in text and "penalty b" not in text
    )
    cut = encode(
        pair,
        tmp_path / "p.qcf",
        "--encoding",
        "st-cut",
        "--smoothness",
        "linear",
        "--disparity",
        "0:3",
    )
    assert [
        cut[key] for key in ("penalty_min", "penalty_max", "pair_penalty_min", "pair_penalty_max")
    ] == [None] * 4
    two = encode(pair, tmp_path / "p.qcf", "--encoding", "domain-wall", "--disparity", "0:1")
    assert two["penalty_min"] is None


def test_minimal_penalties_are_smaller_in_sparse(tmp_path, pair):
    """b = a + W / 2 + gap, rounded up, in integer units of 0.5: W is 5 to 10 of them."""
    facts = encode(
        pair,
        tmp_path / "p.qcf",
        "--disparity",
        "0:3",
        "--lambda",
        "1.5",
        "--penalty",
        "minimal",
        "--gap",
        "2",
    )
    assert (facts["penalty"], facts["gap"], facts["penalty_min"], facts["penalty_max"]) == (
        "minimal",
        2,
        1,
        1,
    )
    assert (facts["pair_penalty_min"], facts["pair_penalty_max"]) == (
        (2 + 3 + 2) / 2,
        (2 + 6 + 2) / 2,
    )


def test_truncation_reports_F(tmp_path, pair):
    """A labelling of the dearest labels: H is what the file says, F what is reported."""
    facts = encode(pair, tmp_path / "p.qcf", "--disparity", "0:3", "--lambda", "2", "--truncate")
    whole = encode(pair, tmp_path / "q.qcf", "--disparity", "0:3", "--lambda", "2")
    theta = np.stack([np.abs(pair.left[:, 3:] - pair.right[:, 3 - d : 12 - d]) for d in range(4)])
    dearest = theta.argmax(0)
    W = 2 * (
        np.full((5, 9), 4)
        - (np.add.outer(np.isin(range(5), [0, 4]) * 1, np.isin(range(9), [0, 8]) * 1))
    )
    F = energy(pair.left, pair.right, dearest, 2)
    H = F - np.maximum(theta.max(0) - theta.min(0) - W - 1, 0).sum()
    assert H < F and facts["linear_max"] < whole["linear_max"] and facts["linear_max"] <= 4 * 2 + 1
    samples = write_qsf(tmp_path / "s.qsf", tmp_path / "p.qcf", [one_hot(dearest, 4)], [H])
    seen = json.loads(run("validate", tmp_path / "p.qcf", samples, "--json").out)
    assert (seen["best_energy"], seen["lowest_energy"], seen["energies_agree"]) == (F, H, True)
    for repair in ([], ["--repair"]):
        facts = json.loads(
            run(
                "decode", tmp_path / "p.qcf", samples, "-o", tmp_path / "m.pgm", "--json", *repair
            ).out
        )
        assert (facts["energy"], facts["repaired"]) == (F, 0)
    lied = write_qsf(tmp_path / "lied.qsf", tmp_path / "p.qcf", [one_hot(dearest, 4)], [F])
    assert run("validate", tmp_path / "p.qcf", lied).status == 3
    assert "truncated" in run("info", tmp_path / "p.qcf").out.decode()
    assert "trnc" in chunks_of(tmp_path / "p.qcf") and "trnc" not in chunks_of(tmp_path / "q.qcf")


def test_the_best_sample_is_that_of_the_least_F(tmp_path, pair):
    """Truncation makes the H of two labellings almost equal: the lower H has the higher F."""
    encode(pair, tmp_path / "p.qcf", "--disparity", "0:3", "--lambda", "2", "--truncate")
    theta = np.stack([np.abs(pair.left[:, 3:] - pair.right[:, 3 - d : 12 - d]) for d in range(4)])
    W = 2 * (
        np.full((5, 9), 4)
        - (np.add.outer(np.isin(range(5), [0, 4]) * 1, np.isin(range(9), [0, 8]) * 1))
    )
    cut = np.maximum(theta - theta.min(0) - W - 1, 0)
    maps = np.random.default_rng(3).integers(0, 4, (60, 5, 9))
    F = np.array([energy(pair.left, pair.right, m, 2) for m in maps])
    H = F - np.array([np.take_along_axis(cut, m[None], 0).sum() for m in maps])
    assert F.argmin() != H.argmin()
    samples = write_qsf(tmp_path / "s.qsf", tmp_path / "p.qcf", [one_hot(m, 4) for m in maps], H)
    seen = json.loads(run("validate", tmp_path / "p.qcf", samples, "--json").out)
    assert (seen["best_sample"], seen["best_energy"], seen["lowest_energy"]) == (
        F.argmin(),
        F.min(),
        H.min(),
    )
    for repair in ([], ["--repair"]):
        facts = json.loads(
            run(
                "decode", tmp_path / "p.qcf", samples, "-o", tmp_path / "m.pgm", "--json", *repair
            ).out
        )
        assert (facts["sample"], facts["energy"]) == (F.argmin(), F.min())


@pytest.mark.parametrize(
    "text, value",
    [
        ("0", 0),
        ("20", 20),
        ("12.5", 12.5),
        ("1e-1", 0.1),
        ("2.5e1", 25),
        (".5", 0.5),
        ("+7", 7),
        ("1.", 1),
        ("20.000000000000000000000000000000", 20),
        ("0e-99", 0),
        ("2147483647", 2147483647),
        ("0.000001", 1e-6),
        ("0.0000019073486328125", 2.0**-19),
        ("4095.0000019073486328125", 4095 + 2.0**-19),
    ],
)
def test_lambda_is_exact(tmp_path, text, value):
    """The scale is the denominator of lambda in lowest terms."""
    _, _, left, right = random_pair(tmp_path, 3, 1)
    done = succeed(
        "encode",
        left,
        right,
        "-o",
        tmp_path / "p.qcf",
        "--lambda",
        text,
        "--disparity",
        "0:1",
        "--json",
    )
    facts = json.loads(done.out)
    assert facts["scale"] == Fraction(text).denominator
    assert facts["lambda"] == value
    assert Fraction(done.out.decode().split('"lambda": ')[1].split(",")[0]) == Fraction(text)


def test_defaults(tmp_path):
    _, _, left, right = random_pair(tmp_path, 18, 2)
    done = run("encode", left, right, "-o", tmp_path / "p.qcf", "--json")
    facts = json.loads(done.out)
    assert {
        key: facts[key]
        for key in (
            "disparity_min",
            "disparity_max",
            "lambda",
            "smoothness",
            "encoding",
            "penalty",
            "gap",
        )
    } == {
        "disparity_min": 0,
        "disparity_max": 15,
        "lambda": 20,
        "smoothness": "potts",
        "encoding": "one-hot-sparse",
        "penalty": "local",
        "gap": 1,
    }
    assert (facts["width"], facts["height"], facts["x"], facts["y"]) == (3, 2, 15, 0)
    spelled = run(
        "encode",
        left,
        right,
        "-o",
        tmp_path / "q.qcf",
        "--cost",
        "ad",
        "--disparity",
        "0:15",
        "--lambda=20",
        "--smoothness=potts",
        "--encoding",
        "one-hot-sparse",
        "--penalty",
        "local",
        "--gap",
        "1",
    )
    assert spelled.status == 0
    assert (tmp_path / "q.qcf").read_bytes() == (tmp_path / "p.qcf").read_bytes()


def test_roi_takes_that_window(tmp_path, pair):
    facts = encode(pair, tmp_path / "p.qcf", "--roi", "2,1,7,3", "--disparity", "0:3")
    # Columns 2 is left of disparity 3.
    assert [
        facts[key] for key in ("x", "y", "width", "height", "picture_width", "picture_height")
    ] == [3, 1, 6, 3, 12, 5]
    assert facts["variables"] == 6 * 3 * 4


def test_penalty_and_gap(tmp_path, pair):
    given = encode(
        pair, tmp_path / "p.qcf", "--disparity", "0:3", "--penalty", "0.5", "--lambda", "0.5"
    )
    assert (
        given["penalty_min"],
        given["penalty_max"],
        given["pair_penalty_max"],
        given["penalty"],
    ) == (0.5, 0.5, 1, "given")
    wide = encode(pair, tmp_path / "p.qcf", "--disparity", "0:3", "--gap", "6")
    assert (wide["penalty_min"], wide["pair_penalty_max"], wide["gap"]) == (6, 6 + 80 + 6, 6)


def test_human_lines_name_sites_and_file(tmp_path, pair):
    done = run("encode", *pair.paths, "-o", tmp_path / "p.qcf", "--disparity", "0:3")
    size = (tmp_path / "p.qcf").stat().st_size
    assert (
        f"{tmp_path / 'p.qcf'}: 45 sites x 4 labels = 180 variables, {size} bytes"
        in done.out.decode()
    )
    assert "3 columns" in done.out.decode()
    assert done.err == ""


def test_human_lines_of_other_encodings(tmp_path, pair):
    done = run(
        "encode",
        *pair.paths,
        "-o",
        tmp_path / "p.qcf",
        "--disparity",
        "0:3",
        "--encoding",
        "domain-wall",
    )
    size = (tmp_path / "p.qcf").stat().st_size
    assert (
        f"{tmp_path / 'p.qcf'}: 45 sites x 4 labels, 135 variables in domain-wall, {size} bytes"
        in done.out.decode()
    )
    assert "3 columns" in done.out.decode() and done.err == ""


@pytest.mark.parametrize("limit", [2, 8])
def test_memory_limit(folder, limit):
    """The whole problem takes 3 MiB as a file, and more once it is laid out; a stream takes next
    to nothing.
    """
    wide = write_pgm(folder.parent / "wide.pgm", np.zeros((400, 500), int))
    for options in (["--encoding", "domain-wall"], ["--reduce"], ["--truncate"]):
        done = run("encode", wide, wide, "-o", folder / "p.qcf", "--memory-limit", limit, *options)
        assert (done.status, f"needs more than the memory limit of {limit} MiB" in done.err) == (
            4,
            True,
        )
        assert not list(folder.iterdir())
    succeed("encode", wide, wide, "-o", folder / "p.qcf", "--memory-limit", "1")


def test_other_encodings_to_standard_output(tmp_path, pair):
    encode(pair, tmp_path / "p.qcf", "--disparity", "0:3", "--encoding", "domain-wall")
    for name in ("-", "/dev/stdout"):
        done = run(
            "encode", *pair.paths, "-o", name, "--disparity", "0:3", "--encoding", "domain-wall"
        )
        assert done.out == (tmp_path / "p.qcf").read_bytes()


def test_standard_output_and_input(tmp_path, pair):
    encode(pair, tmp_path / "p.qcf", "--disparity", "0:3")
    whole = (tmp_path / "p.qcf").read_bytes()
    for name in ("-", "/dev/stdout"):
        assert run("encode", *pair.paths, "-o", name, "--disparity", "0:3").out == whole
    done = run(
        "encode",
        "-",
        pair.paths[1],
        "-o",
        "-",
        "--disparity",
        "0:3",
        input=pair.paths[0].read_bytes(),
    )
    assert done.out == whole


def test_one_of_each(tmp_path, pair):
    problem = tmp_path / "p.qcf"
    done = run("encode", *pair.paths, "-o", problem, "--disparity", "1:1", "--roi", "0,0,2,1")
    assert done.out.decode().splitlines() == [
        f"{problem}: 1 site x 1 label = 1 variable, {problem.stat().st_size} bytes",
        f"1 column on the left is left out: a match would fall outside {pair.paths[1]}",
    ]


USAGE = {
    "disparity reversed": (["--disparity", "5:2"], "empty"),
    "disparity not a range": (["--disparity", "5"], "MIN:MAX"),
    "disparity negative": (["--disparity", "-3:-2.5"], "MIN:MAX"),
    "disparity trailing": (["--disparity", "0:3x"], "MIN:MAX"),
    "too many labels": (["--disparity", "0:65535"], "65535 is the most"),
    "lambda negative": (["--lambda", "-1"], "negative"),
    "lambda nan": (["--lambda", "nan"], "not a decimal number"),
    "lambda inf": (["--lambda", "inf"], "not a decimal number"),
    "lambda garbage": (["--lambda", "1x"], "not a decimal number"),
    "lambda hexadecimal": (["--lambda", "0x10"], "not a decimal number"),
    "lambda empty exponent": (["--lambda", "1e"], "not a decimal number"),
    "lambda too fine": (["--lambda", "0.0000001"], "up to 1000000"),
    "lambda too long": (["--lambda", "0." + "3" * 90], "up to 1000000"),
    "lambda too large": (["--lambda", "2147483648"], "up to 2147483647"),
    "lambda far too large": (["--lambda", "1e99999999999"], "too large"),
    "lambda numerator": (["--lambda", "1073741824.5"], "too large"),
    "roi garbage": (["--roi", "1,2,3"], "X,Y,W,H"),
    "roi empty": (["--roi", "0,0,0,4"], "X,Y,W,H"),
    "roi negative": (["--roi", "-1,0,2,2"], "X,Y,W,H"),
    "cost": (["--cost", "ssd"], "with the names ad, sd, bt, or census:WxH"),
    "smoothness": (
        ["--smoothness", "pots"],
        "did you mean potts? It can be: potts linear quadratic",
    ),
    "smoothness table": (["--smoothness", "table"], "it can be: potts linear quadratic"),
    "encoding": (
        ["--encoding", "onehot"],
        "did you mean one-hot? It can be: one-hot one-hot-sparse domain-wall "
        "multiway-cut st-cut st-cut-arcs",
    ),
    "penalty": (
        ["--penalty", "loca"],
        "did you mean local? It can be: local minimal paper, or a number",
    ),
    "penalty zero": (["--penalty", "0"], "not above 0"),
    "penalty too fine": (["--penalty", "0.5"], "multiple above 0 of 1/1"),
    "penalty of another unit": (["--penalty", "0.5", "--lambda", "0.2"], "multiple above 0 of 1/5"),
    "penalty large": (["--penalty", "1e16"], "too large"),
    "gap": (["--gap", "0"], "--gap 0 is not a whole number from 1"),
    "gap of paper": (
        ["--gap", "6", "--penalty", "paper"],
        "--gap goes with --penalty local or minimal",
    ),
    "gap of an alpha": (
        ["--penalty", "3000", "--gap", "1"],
        "--gap goes with --penalty local or minimal",
    ),
    "truncation of potts": (["--truncation", "3"], "linear or quadratic"),
    "truncation": (["--truncation", "0", "--smoothness", "linear"], "whole number from 1"),
    "sparse quadratic": (
        ["--encoding", "one-hot-sparse", "--smoothness", "quadratic"],
        "--encoding one-hot-sparse cannot hold the smoothness (quadratic), but these can: one-hot, "
        "domain-wall",
    ),
    "multiway quadratic": (
        ["--encoding", "multiway-cut", "--smoothness", "quadratic", "--truncation", "4"],
        "cannot hold the smoothness (quadratic, truncated at 4), but these can: one-hot, "
        "domain-wall",
    ),
    "multiway linear": (
        ["--encoding", "multiway-cut", "--smoothness", "linear", "--truncation", "2"],
        "cannot hold the smoothness (linear, truncated at 2), but these can: one-hot, "
        "one-hot-sparse, domain-wall",
    ),
    "cut of potts": (
        ["--encoding", "st-cut"],
        "--encoding st-cut cannot hold the smoothness (potts), but these can: one-hot, "
        "one-hot-sparse, domain-wall, multiway-cut",
    ),
    "cut of truncated linear": (
        ["--encoding", "st-cut-arcs", "--smoothness", "linear", "--truncation", "14"],
        "st-cut-arcs cannot hold the smoothness (linear, truncated at 14)",
    ),
    "paper of a band": (
        ["--encoding", "one-hot-sparse", "--smoothness", "linear", "--penalty", "paper"],
        "--penalty paper goes with --encoding one-hot-sparse only for potts smoothness: "
        "choose local or minimal, or --encoding",
    ),
    "paper of a band, reduced": (
        [
            "--encoding",
            "one-hot-sparse",
            "--smoothness",
            "linear",
            "--penalty",
            "paper",
            "--reduce",
        ],
        "--encoding one-hot-sparse only for potts smoothness",
    ),
    "paper of a wall": (
        ["--encoding", "domain-wall", "--penalty", "paper"],
        "does not go with --encoding domain-wall: choose local or minimal",
    ),
    "alpha of a cut": (
        ["--encoding", "st-cut", "--smoothness", "linear", "--penalty", "30"],
        "does not go with --encoding st-cut: choose local or minimal",
    ),
    "target alone": (["--target", "9"], "--target goes with --reduce"),
    "time limit alone": (["--time-limit", "9"], "--time-limit goes with --reduce"),
    "target zero": (["--reduce", "--target", "0"], "--target 0 is not a whole number from 1"),
    "target of a cut": (
        ["--reduce", "--target", "9", "--encoding", "multiway-cut"],
        "--target does not go with --encoding multiway-cut, but with these: one-hot, ",
    ),
    "time limit": (["--reduce", "--time-limit", "0"], "--time-limit 0"),
    "memory": (["--memory-limit", "0"], "--memory-limit 0 is not a whole number from 1"),
    "unknown option": (
        ["--lamda", "3"],
        "unknown option --lamda: did you mean --lambda? (help: qstereo encode --help)\n",
    ),
}


@pytest.mark.parametrize("name", USAGE)
def test_usage_errors(folder, pair, name):
    options, words = USAGE[name]
    done = run("encode", *pair.paths, "-o", folder / "p.qcf", *options)
    assert done.status == 2
    assert words in done.err
    assert done.err.startswith("qstereo encode: ") and done.err.count("\n") == 1
    assert done.out == b"" and not list(folder.iterdir())


def test_missing_picture(folder, pair):
    done = run("encode", folder / "none.pgm", pair.paths[1], "-o", folder / "p.qcf")
    assert done.status == 4
    assert (
        done.err
        == f"qstereo encode: {folder / 'none.pgm'}: cannot be opened: No such file or directory\n"
    )
    done = run("encode", pair.paths[0], folder, "-o", folder / "p.qcf")
    assert (done.status, "Is a directory" in done.err) == (4, True)
    assert not list(folder.iterdir())


BAD_PICTURES = {
    "empty": b"",
    "text": b"hello, this is no picture\n",
    "cut png": b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0",
    "cut": b"P5\n4 4\n255\n123",
    "no samples": b"P5\n100000 100000\n255\n",
    "above maxval": b"P2\n2 1\n9\n3 10\n",
    "letters": b"P2\n2 1\n9\n3 x\n",
    "more": b"P2\n2 1\n9\n3 3 3\n",
    "more binary": b"P5\n2 1\n9\n\1\1\1",
    "above maxval, binary": b"P5\n2 1\n9\n\1\12",
    "above maxval, 16 bits": b"P5\n2 1\n999\n\1\1\377\1",
    "zero width": b"P5\n0 4\n255\n",
    "no maxval": b"P5\n2 2\n",
    "maxval 0": b"P5\n1 1\n0\n\0",
    "maxval 65536": b"P5\n1 1\n65536\n\0\0",
    "negative": b"P5\n-1 4\n255\n",
    "bitmap with letters": b"P1\n2 1\n0 x\n",
    "pam without depth": b"P7\nWIDTH 1\nHEIGHT 1\nMAXVAL 255\nENDHDR\n\0",
    "pam without an end": b"P7\nWIDTH 1\nHEIGHT 1\nDEPTH 1\nMAXVAL 255\n",
    "pam with 5 channels": b"P7\nWIDTH 1\nHEIGHT 1\nDEPTH 5\nMAXVAL 255\nENDHDR\n\0\0\0\0\0",
    "a row of blanks": b"P5\n4 1\n255\n\1\1\1\1    ",
    "a row like a line end": b"P5\n2 1\n255\n\1\1\r\n",
    "a row like a line feed": b"P5\n1 1\n255\n\1\n",
    "a comment behind": b"P5\n2 1\n255\n\1\1# no\n",
    "pfm": b"Pf\n1 1\n-1.0\n\0\0\0\0",
    "huge number": b"P5\n99999999999999999999 1\n255\n\0",
}


@pytest.mark.parametrize("name", BAD_PICTURES)
def test_not_a_picture(folder, tmp_path, name):
    bad = tmp_path / "bad.picture"
    bad.write_bytes(BAD_PICTURES[name])
    done = run("encode", bad, bad, "-o", folder / "p.qcf", "--disparity", "0:0")
    assert done.status == 3
    assert done.err.startswith(f"qstereo encode: {bad}: ") and done.err.count("\n") == 1
    assert not list(folder.iterdir())


def test_pictures_of_other_sizes(folder, pair):
    other = write_pgm(folder.parent / "other.pgm", np.zeros((5, 11), int))
    done = run("encode", pair.paths[0], other, "-o", folder / "p.qcf", "--disparity", "0:3")
    assert done.status == 3
    assert f"{other}: is 11 x 5 pixels, but {pair.paths[0]} is 12 x 5" in done.err


@pytest.mark.parametrize(
    "options, words",
    [
        (["--disparity", "0:12"], "disparity 12 needs one at 12 or further right"),
        (["--roi", "0,0,3,3", "--disparity", "0:3"], "move --roi"),
        (["--roi", "10,0,3,3", "--disparity", "0:3"], "--roi 10,0,3,3 does not fit inside"),
        (["--roi", "0,3,12,3", "--disparity", "0:3"], "does not fit inside"),
        (["--roi", "4294967295,0,4294967295,1", "--disparity", "0:3"], "does not fit inside"),
    ],
)
def test_windows_that_do_not_fit(folder, pair, options, words):
    done = run("encode", *pair.paths, "-o", folder / "p.qcf", *options)
    assert done.status == 3
    assert words in done.err
    assert not list(folder.iterdir())


def test_smallest_window_that_fits(tmp_path, pair):
    facts = encode(pair, tmp_path / "p.qcf", "--disparity", "0:11")
    assert (facts["width"], facts["sites"]) == (1, 5)


def test_too_many_variables(folder):
    wide = write_pgm(folder.parent / "wide.pgm", np.zeros((1, 100000), int))
    done = run("encode", wide, wide, "-o", folder / "p.qcf", "--disparity", "0:65534")
    assert done.status == 3
    assert "more than 2147483647 variables" in done.err
    assert not list(folder.iterdir())


@pytest.mark.parametrize(
    "options",
    [
        ["--penalty", "4503599627370496"],
        ["--penalty", "4503599627370496", "--truncate"],
        ["--smoothness", "quadratic", "--disparity", "0:511", "--lambda", "2147483647", "--reduce"],
        ["--smoothness", "quadratic", "--disparity", "0:511", "--lambda", "2147483647"],
    ],
)
def test_overflow(folder, options):
    _, _, left, right = random_pair(folder.parent, 530, 3)
    (folder / "p.qcf").write_text("as it was")
    done = run("encode", left, right, "-o", folder / "p.qcf", *options)
    assert done.status == 3
    assert "overflow" in done.err and "--lambda" in done.err
    assert [path.name for path in folder.iterdir()] == ["p.qcf"]
    assert (folder / "p.qcf").read_text() == "as it was"


@pytest.mark.parametrize("smoothness, grows", [("quadratic", True), ("linear", False)])
def test_walls_of_many_labels_say_that_kappa_grows(tmp_path, pair, smoothness, grows):
    encode(pair, tmp_path / "p.qcf", "--encoding", "domain-wall", "--disparity", "0:4",
           "--smoothness", smoothness, "--truncation", "3")
    assert (b"kappa grows" in run("info", tmp_path / "p.qcf").out) == grows
