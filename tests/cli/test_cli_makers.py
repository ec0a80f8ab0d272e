"""restore, segment, flow, register, detect, and what they write: beside numpy's own energies."""

import json
import math

import numpy as np
import pytest
from cli_tools import read_pnm, run, write_pgm


def facts_of(*arguments, **options):
    done = run(*arguments, "--json", **options)
    assert done.status == 0, done.err
    return json.loads(done.out)


def write_ppm(path, rgb):
    header = f"P6\n{rgb.shape[1]} {rgb.shape[0]}\n255\n".encode()
    path.write_bytes(header + rgb.astype("u1").tobytes())
    return path


def write_flo(path, field):
    height, width = field.shape[:2]
    head = b"PIEH" + np.array([width, height], "<i4").tobytes()
    path.write_bytes(head + field.astype("<f4").tobytes())
    return path


def read_flo(path):
    data = path.read_bytes()
    width, height = np.frombuffer(data, "<i4", 2, 4)
    assert data[:4] == b"PIEH" and len(data) == 12 + 8 * width * height
    return np.frombuffer(data, "<f4", offset=12).reshape(height, width, 2)


def write_boxes(path, rows, names="picture,x,y,width,height,score"):
    path.write_text("\n".join([names, *(",".join(map(str, row)) for row in rows)]) + "\n")
    return path


# ---- restore ----


def disc(size=24):
    y, x = np.mgrid[:size, :size]
    return np.where((x - size / 2) ** 2 + (y - size / 2) ** 2 < size**2 / 9, 208, 48)


@pytest.fixture
def noisy(tmp_path):
    random = np.random.default_rng(4)
    grey = np.clip(disc() + random.normal(0, 12, disc().shape), 0, 255).round().astype(int)
    return grey, write_pgm(tmp_path / "noisy.pgm", grey)


@pytest.mark.parametrize("cost, power", [("absolute", 1), ("squared", 2)])
@pytest.mark.parametrize("smoothness", ["potts", "linear", "quadratic"])
def test_restore_finds_the_energy_that_it_says(noisy, tmp_path, cost, power, smoothness):
    grey, path = noisy
    hole = (np.random.default_rng(5).random(grey.shape) < 0.2) * 255
    mask = write_pgm(tmp_path / "hole.pgm", hole)
    out = tmp_path / "clean.pgm"
    facts = facts_of(
        *["restore", path, "-o", out, "--cost", cost, "--smoothness", smoothness],
        *["--lambda", "12.5", "--step", "16", "--hole", mask, "--time-limit", "5"],
    )
    clean, maxval = read_pnm(out.read_bytes())
    assert maxval == 255 and set(np.unique(clean)) <= set(range(0, 256, 16))
    label = clean // 16
    steps = [abs(np.diff(label, axis=axis)) for axis in (0, 1)]
    v = {"potts": lambda t: (t > 0) * 1, "linear": lambda t: t, "quadratic": lambda t: t**2}
    smooth = sum(v[smoothness](step).sum() for step in steps)
    data = ((abs(grey - clean) ** power) * (hole == 0)).sum()
    assert facts["energy"] == data + 12.5 * smooth
    assert facts["output"] == str(out)
    assert facts["lower_bound"] <= facts["energy"]


def test_restoring_brings_the_picture_nearer(noisy, tmp_path):
    grey, path = noisy
    truth = write_pgm(tmp_path / "truth.pgm", disc())
    hole = np.zeros_like(grey)
    hole[3:6, 3:9] = 1
    mask = write_pgm(tmp_path / "hole.pgm", hole)
    out = tmp_path / "clean.pgm"
    before = facts_of("score", path, truth, "--as", "picture")
    facts = facts_of(
        *["restore", path, "-o", out, "--lambda", "1", "--truncation", "600", "--truth", truth],
        *["--hole", mask, "--time-limit", "5"],
    )
    assert facts["psnr"] > before["psnr"] + 4 and facts["ssim"] > before["ssim"]
    clean, _ = read_pnm(out.read_bytes())
    error = ((clean - disc())[hole == 1].astype(float) ** 2).mean()
    assert facts["hole_pixels"] == 18
    assert facts["hole_psnr"] == pytest.approx(10 * math.log10(255**2 / error))


# ---- segment ----


@pytest.fixture
def photo(tmp_path):
    """A red disc on green, with noise, a stroke on both, and the truth."""
    random = np.random.default_rng(6)
    inside = disc() > 100
    colour = np.where(inside[..., None], [180, 60, 60], [70, 150, 60])
    rgb = np.clip(colour + random.normal(0, 10, colour.shape), 0, 255).round().astype(int)
    strokes = np.zeros(inside.shape, int)
    strokes[1, 2:20] = 1
    strokes[12, 10:14] = 2
    return (
        write_ppm(tmp_path / "photo.ppm", rgb),
        write_pgm(tmp_path / "strokes.pgm", strokes),
        write_pgm(tmp_path / "truth.pgm", 1 + inside),
        strokes,
    )


def test_segment_finds_the_disc_and_keeps_strokes(photo, tmp_path):
    path, strokes, truth, marked = photo
    out = tmp_path / "mask.pgm"
    facts = facts_of("segment", path, strokes, "-o", out, "--truth", truth)
    mask, _ = read_pnm(out.read_bytes())
    assert facts["proven_optimal"] and facts["iou"] > 0.9 and facts["error_rate"] < 0.05
    assert [row["class"] for row in facts["classes"]] == [1, 2]
    assert (mask[marked > 0] == marked[marked > 0]).all()


def test_strokes_are_kept_against_all_evidence(photo, tmp_path):
    path, strokes, _, marked = photo
    wrong = marked.copy()
    wrong[20, 20] = 2
    strokes = write_pgm(tmp_path / "wrong.pgm", wrong)
    out = tmp_path / "mask.pgm"
    facts_of("segment", path, strokes, "-o", out, "--lambda", "500")
    mask, _ = read_pnm(out.read_bytes())
    assert mask[20, 20] == 2 and (mask == 2).sum() >= 5


def test_rounds_fit_the_colours_again(photo, tmp_path):
    """A box around the disc, and the outside of it as the only stroke."""
    path, _, truth, _ = photo
    outside = np.ones((24, 24), int)
    outside[3:21, 3:21] = 0
    strokes = write_pgm(tmp_path / "outside.pgm", outside)
    out = tmp_path / "mask.pgm"
    arguments = ["segment", path, strokes, "-o", out, "--truth", truth, "--lambda", "3"]
    one = facts_of(*arguments)
    three = facts_of(*arguments, "--rounds", "3")
    assert three["iou"] > 0.9 and three["iou"] >= one["iou"]
    assert three["energy"] != one["energy"]


@pytest.mark.parametrize("kind", ["i8", "f4"])
def test_costs_that_are_given(photo, tmp_path, kind):
    """Without smoothness each pixel takes its cheapest class, but for the strokes."""
    path, strokes, _, marked = photo
    costs = np.random.default_rng(11).integers(-90, 90, (24, 24, 3)).astype(kind)
    np.save(tmp_path / "c.npy", costs)
    out = tmp_path / "mask.pgm"
    options = ["--costs", tmp_path / "c.npy", "--lambda", "0", "-o", out]
    facts = facts_of("segment", path, *options)
    mask, _ = read_pnm(out.read_bytes())
    assert (mask == costs.argmin(axis=2) + 1).all()
    assert facts["energy"] == costs.min(axis=2).sum()
    facts_of("segment", path, strokes, *options)
    mask, _ = read_pnm(out.read_bytes())
    assert (mask == np.where(marked > 0, marked, costs.argmin(axis=2) + 1)).all()
    np.save(tmp_path / "c.npy", costs[1:])
    done = run("segment", path, *options)
    assert done.status == 3 and "24 x 24 x classes is needed" in done.err


# ---- flow and register ----


def texture(size, seed):
    random = np.random.default_rng(seed)
    small = random.random((size // 4 + 3, size // 4 + 3)) * 255
    y, x = np.mgrid[:size, :size] / 4
    i, j, u, v = y.astype(int), x.astype(int), y % 1, x % 1
    return (
        (small[i, j] * (1 - v) + small[i, j + 1] * v) * (1 - u)
        + (small[i + 1, j] * (1 - v) + small[i + 1, j + 1] * v) * u
    ).round().astype(int)


@pytest.fixture
def moved(tmp_path):
    """A texture, and the same one moved by (2, -1): first(x) = second(x + d)."""
    whole = texture(48, 7)
    first = write_pgm(tmp_path / "first.pgm", whole[8:40, 8:40])
    second = write_pgm(tmp_path / "second.pgm", whole[9:41, 6:38])
    field = np.full((32, 32, 2), [2.0, -1.0])
    return first, second, write_flo(tmp_path / "truth.flo", field)


def test_flow_of_a_moved_texture(moved, tmp_path):
    first, second, truth = moved
    out, colour = tmp_path / "flow.flo", tmp_path / "flow.ppm"
    facts = facts_of(
        *["flow", first, second, "-o", out, "--radius", "3", "--truth", truth, "--color", colour]
    )
    field = read_flo(out)
    assert field.shape == (32, 32, 2)
    assert (field[4:28, 4:28] == [2, -1]).all()
    assert facts["aepe"] < 0.1
    ends = np.hypot(*(field - [2, -1]).transpose(2, 0, 1)).mean()
    assert facts["aepe"] == pytest.approx(ends, abs=1e-6)
    assert read_pnm(colour.read_bytes())[0].shape == (32, 32, 3)


def test_flow_has_the_energy_that_it_says(moved, tmp_path):
    """With a step of one and a window of one pixel the energy is quickly computed."""
    first, second, _ = moved
    out = tmp_path / "flow.flo"
    facts = facts_of(
        *["flow", first, second, "-o", out, "--radius", "2,1", "--step", "1", "--window", "1"],
        *["--lambda", "7.5", "--truncation", "2", "--time-limit", "3"],
    )
    d = read_flo(out).astype(int)
    a, b = (read_pnm(path.read_bytes())[0] for path in (first, second))
    y, x = np.mgrid[:32, :32]
    there = b[np.clip(y + d[..., 1], 0, 31), np.clip(x + d[..., 0], 0, 31)]
    smooth = sum(
        np.minimum(abs(np.diff(d, axis=axis)).sum(axis=2), 2).sum() for axis in (0, 1)
    )
    assert facts["energy"] == abs(a - there).sum() + 7.5 * smooth


def test_register_bends_a_picture_over_another(moved, tmp_path):
    fixed, moving, truth = moved
    out, warped = tmp_path / "field.flo", tmp_path / "warped.pgm"
    facts = facts_of(
        *["register", fixed, moving, "-o", out, "--warped", warped, "--truth", truth],
        *["--step", "8", "--window", "9", "--radius", "3", "--fraction", "1"],
    )
    assert facts["tre_before"] == pytest.approx(math.hypot(2, 1))
    assert facts["tre"] < 0.4 and facts["mse"] < facts["mse_before"] / 10
    a, b = (read_pnm(path.read_bytes())[0].astype(float) for path in (fixed, warped))
    assert facts["mse"] == pytest.approx(((a - b) ** 2).mean())


def test_fields_are_kept_by_kittis_format(moved, tmp_path, opencv):
    first, second, truth = moved
    png, flo = tmp_path / "flow.png", tmp_path / "flow.flo"
    for out in (png, flo):
        facts_of("flow", first, second, "-o", out, "--radius", "3")
    assert facts_of("score", png, flo, "--as", "flow")["aepe"] == 0
    assert facts_of("score", png, truth, "--as", "flow")["aepe"] < 0.1


# ---- detect ----


def iou(a, b):
    if a[0] != b[0]:
        return 0
    width = min(a[1] + a[3], b[1] + b[3]) - max(a[1], b[1])
    height = min(a[2] + a[4], b[2] + b[4]) - max(a[2], b[2])
    shared = max(0, width) * max(0, height)
    return shared / (a[3] * a[4] + b[3] * b[4] - shared)


def boxes_energy(rows, kept):
    """In hundredths."""
    energy = -sum(round(100 * row[5]) for row, keep in zip(rows, kept, strict=True) if keep)
    for i, a in enumerate(rows):
        for j in range(i):
            if kept[i] and kept[j] and iou(a, rows[j]) > 0.1:
                energy += round(400 * iou(a, rows[j]))
    return energy


@pytest.fixture
def boxes(tmp_path):
    random = np.random.default_rng(8)
    rows = [
        ["ab"[i % 2], *map(int, random.integers(0, 30, 2)), *map(int, random.integers(10, 30, 2)),
         round(float(random.normal(0.6, 0.7)), 3)]
        for i in range(14)
    ]
    return rows, write_boxes(tmp_path / "boxes.csv", rows)


def test_boxes_of_spreadsheets(boxes, tmp_path):
    """With a mark of UTF-8, quotes, spaces and their ends of lines the boxes are the same, and
    their lines are kept as they are."""
    _, path = boxes
    out, expected = tmp_path / "kept.csv", tmp_path / "expected.csv"
    facts = facts_of("detect", path, "-o", expected)
    lines = path.read_text().splitlines()
    quoted = ['"' + '","'.join(line.split(",")) + '"' for line in lines]
    spaced = [line.replace(",", ", ") for line in lines]
    for changed in (quoted, spaced, lines):
        path.write_bytes("\ufeff".encode() + "\r\n".join(changed).encode())
        again = facts_of("detect", path, "-o", out)
        assert again["energy"] == facts["energy"] and again["kept"] == facts["kept"]
        kept = [changed[lines.index(line)] for line in expected.read_text().splitlines()]
        assert out.read_text().splitlines() == kept


def test_detect_finds_the_optimum(boxes, tmp_path):
    rows, path = boxes
    out = tmp_path / "kept.csv"
    facts = facts_of("detect", path, "-o", out)
    lines = path.read_text().splitlines()
    kept_lines = out.read_text().splitlines()
    assert kept_lines[0] == lines[0] and facts["kept"] == len(kept_lines) - 1
    kept = [line in kept_lines[1:] for line in lines[1:]]
    least = min(boxes_energy(rows, [bits >> i & 1 for i in range(14)]) for bits in range(2**14))
    assert boxes_energy(rows, kept) == least
    assert facts["energy"] == least / 100 and facts["proven_optimal"]


def test_score_of_boxes(tmp_path):
    """Right, a second one on the same truth, wrong, right: by falling score."""
    truth = write_boxes(
        tmp_path / "truth.csv",
        [["p", 0, 0, 10, 10], ["p", 50, 0, 10, 10], ["q", 0, 0, 10, 10]],
        "picture,x,y,width,height",
    )
    found = write_boxes(
        tmp_path / "found.csv",
        [["p", 50, 1, 10, 10, 0.1], ["p", 0, 0, 10, 9, 0.9], ["p", 1, 0, 10, 10, 0.8],
         ["q", 8, 0, 10, 10, 0.7]],
    )
    facts = facts_of("score", found, truth, "--as", "boxes")
    assert (facts["boxes"], facts["truths"], facts["right"]) == (4, 3, 2)
    assert facts["precision"] == 0.5
    assert facts["recall"] == pytest.approx(2 / 3)
    # Precision 1 at the first true box, 2/4 at the second, of three.
    assert facts["ap"] == pytest.approx((1 + 0.5) / 3)


# ---- score ----


def test_score_of_labels(tmp_path):
    a = np.array([[0, 1, 1, 2], [0, 1, 2, 2]])
    b = np.array([[0, 1, 2, 2], [0, 0, 2, 3]])
    first, second = write_pgm(tmp_path / "a.pgm", a), write_pgm(tmp_path / "b.pgm", b)
    np.save(tmp_path / "b.npy", b.astype("i8"))
    classes = {0: 2 / 3, 1: 1 / 3, 2: 2 / 4, 3: 0}
    for other in (second, tmp_path / "b.npy"):
        facts = facts_of("score", first, other, "--as", "labels")
        assert facts["error_rate"] == 3 / 8
        assert {row["class"]: row["iou"] for row in facts["classes"]} == pytest.approx(classes)
        assert facts["iou"] == pytest.approx(sum(classes.values()) / 4)
    np.save(tmp_path / "none.npy", np.where(a == b, a, -1))
    assert facts_of("score", first, tmp_path / "none.npy", "--as", "labels")["iou"] == 1


def slow_ssim(a, b):
    i = np.arange(11) - 5
    window = np.exp(-(i[:, None] ** 2 + i**2) / 4.5)
    window /= window.sum()
    values = []
    for y in range(a.shape[0] - 10):
        for x in range(a.shape[1] - 10):
            p, q = a[y : y + 11, x : x + 11], b[y : y + 11, x : x + 11]
            mp, mq = (window * p).sum(), (window * q).sum()
            vp, vq = (window * (p - mp) ** 2).sum(), (window * (q - mq) ** 2).sum()
            cov = (window * (p - mp) * (q - mq)).sum()
            c1, c2 = 2.55**2, 7.65**2
            values.append(
                (2 * mp * mq + c1) * (2 * cov + c2) / ((mp**2 + mq**2 + c1) * (vp + vq + c2))
            )
    return np.mean(values)


def test_score_of_pictures(tmp_path):
    random = np.random.default_rng(9)
    a = random.integers(0, 256, (14, 17))
    b = np.clip(a + random.integers(-40, 40, a.shape), 0, 255)
    first, second = write_pgm(tmp_path / "a.pgm", a), write_pgm(tmp_path / "b.pgm", b)
    facts = facts_of("score", first, second, "--as", "picture")
    mse = ((a - b) ** 2).mean()
    assert facts["mse"] == pytest.approx(mse)
    assert facts["psnr"] == pytest.approx(10 * math.log10(255**2 / mse))
    assert facts["ssim"] == pytest.approx(slow_ssim(a, b))
    same = facts_of("score", first, first, "--as", "picture")
    assert same["psnr"] is None and same["ssim"] == pytest.approx(1)
    small = write_pgm(tmp_path / "small.pgm", a[:10])
    assert facts_of("score", small, small, "--as", "picture")["ssim"] is None


def test_score_of_flow(tmp_path):
    random = np.random.default_rng(10)
    a, b = (random.normal(0, 5, (6, 7, 2)).astype("f4") for _ in range(2))
    b[0, 0] = 1e10
    facts = facts_of(
        "score", write_flo(tmp_path / "a.flo", a), write_flo(tmp_path / "b.flo", b), "--as", "flow"
    )
    np.save(tmp_path / "b.npy", np.where(b > 1e9, np.nan, b).astype("f4"))
    assert facts_of("score", tmp_path / "a.flo", tmp_path / "b.npy", "--as", "flow") == facts
    p, q = a.reshape(-1, 2)[1:].astype(float), b.reshape(-1, 2)[1:].astype(float)
    dot = (p * q).sum(1) + 1
    angle = np.degrees(np.arccos(dot / np.sqrt(((p**2).sum(1) + 1) * ((q**2).sum(1) + 1))))
    assert facts["pixels"] == 41
    assert facts["aepe"] == pytest.approx(np.hypot(*(p - q).T).mean())
    assert facts["aae"] == pytest.approx(angle.mean())


# ---- files between ----


@pytest.fixture
def inputs(noisy, photo, moved, boxes):
    """{problem: (its inputs, its options, its label file, what info calls the labels)}"""
    small = ["--radius", "2", "--step", "8"]
    return {
        "restore": ([noisy[1]], ["--step", "32", "--smoothness", "potts"], "o.pgm", "grey"),
        "segment": (photo[:2], [], "o.pgm", "class"),
        "flow": (moved[:2], small, "o.flo", "displacement"),
        "register": (moved[:2], [*small, "--fraction", "1"], "o.flo", "displacement"),
        "detect": ([boxes[1]], [], "o.csv", "keep"),
    }


@pytest.mark.parametrize("problem", ["restore", "segment", "flow", "register", "detect"])
@pytest.mark.parametrize("way", [[], ["--reduce"]])
def test_by_files_it_is_the_same_answer(inputs, tmp_path, problem, way):
    names, options, out, meaning = inputs[problem]
    direct, decoded = tmp_path / ("direct" + out[1:]), tmp_path / out
    file, samples = tmp_path / "p.qcf", tmp_path / "s.qsf"
    whole = facts_of(problem, *names, "-o", direct, *options, "--time-limit", "5")
    encoded = facts_of("encode", "--problem", problem, *names, "-o", file, *options, *way)
    assert (encoded["meaning"], encoded["disparity_min"]) == (meaning, None)
    solved = facts_of("solve", file, "-o", samples, "--time-limit", "5")
    assert solved["energy"] == whole["energy"]
    facts = facts_of("decode", file, samples, "-o", decoded)
    assert facts["energy"] == whole["energy"] and facts["output"] == str(decoded)
    if problem == "detect":
        kept = [line.split(",")[1] for line in decoded.read_text().splitlines()[1:]]
        lines = names[0].read_text().splitlines()[1:]
        chosen = [line for line, keep in zip(lines, kept, strict=True) if keep == "1"]
        assert direct.read_text().splitlines()[1:] == chosen
    else:
        assert decoded.read_bytes() == direct.read_bytes()
    assert run("compare", file, "--samples", samples, "--maps", tmp_path / "maps").status == 0
    assert len(list((tmp_path / "maps").iterdir())) > 1
    refused = run("decode", file, samples, "-o", decoded, "--color")
    assert refused.status == 2 and "--color goes with maps of disparities" in refused.err


@pytest.mark.parametrize("problem, endings", [
    ("restore", "greys: choose a name that ends in .png, .pgm or .npy"),
    ("segment", "classes: choose a name that ends in .png, .pgm or .npy"),
    ("flow", "displacements: choose a name that ends in .flo, .png or .npy"),
    ("detect", "boxes to keep or drop: choose a name that ends in .csv or .npy"),
])
def test_decode_names_the_endings_of_its_labels(inputs, tmp_path, problem, endings):
    names, options, *_ = inputs[problem]
    file, samples, out = tmp_path / "p.qcf", tmp_path / "s.qsf", tmp_path / "o.tif"
    facts_of("encode", "--problem", problem, *names, "-o", file, *options)
    facts_of("solve", file, "-o", samples, "--solver", "icm")
    done = run("decode", file, samples, "-o", out)
    assert done.status == 2 and f"the labels of {file} are {endings}" in done.err
    facts_of("decode", file, samples, "-o", tmp_path / "o.npy")
    assert not out.exists() and (tmp_path / "o.npy").exists()


def test_boxes_the_whole_way_to_their_score(boxes, tmp_path):
    """The boxes that detect writes, those that decode writes, and its list of numbers: all of them
    are scored, and alike."""
    _, path = boxes
    truth = write_boxes(tmp_path / "truth.csv", [["a", 10, 10, 30, 40], ["b", 0, 0, 20, 20]],
                        "picture,x,y,width,height")
    kept, listed, lines = (tmp_path / f"{name}.csv" for name in ("kept", "listed", "lines"))
    file, samples = tmp_path / "p.qcf", tmp_path / "s.qsf"
    said = facts_of("detect", path, "-o", kept, "--truth", truth)
    facts_of("encode", "--problem", "detect", path, "-o", file)
    facts_of("solve", file, "-o", samples)
    facts_of("decode", file, samples, "-o", listed)
    facts_of("decode", file, samples, "-o", lines, "--boxes", path)
    assert lines.read_bytes() == kept.read_bytes()
    score = ["score", listed, truth, "--as", "boxes"]
    facts = facts_of(*score, "--boxes", path)
    assert facts == facts_of("score", kept, truth, "--as", "boxes")
    assert facts.items() <= said.items()
    for words, arguments, status in [
        ("give those with --boxes", score, 3),
        ("does not begin with the line box,keep",
         ["score", kept, truth, "--as", "boxes", "--boxes", path], 3),
        ("give the file that the problem was made of", [*score, "--boxes", kept], 3),
        ("--boxes goes with --as boxes", ["score", kept, kept, "--boxes", path], 2),
        ("made of", ["decode", file, samples, "-o", lines, "--boxes", truth], 3),
        ("--boxes goes with a problem of detect",
         ["decode", file, samples, "-o", "o.npy", "--boxes", path], 2),
    ]:
        done = run(*arguments)
        assert done.status == status, done.err
        assert words in done.err


@pytest.mark.parametrize("line", ["1,2", "2,1", "x,1", "1", "1,1,0", ""])
def test_lists_of_boxes_that_are_refused(boxes, tmp_path, line):
    path = tmp_path / "list.csv"
    path.write_text(f"box,keep\n{line}\n")
    done = run("score", path, boxes[1], "--as", "boxes", "--boxes", boxes[1])
    assert done.status == 3 and "line 2: " in done.err and "is not box 1 and 0 or 1" in done.err


# ---- what is refused ----


def test_restore_takes_grey_pictures_of_8_bits(noisy, tmp_path):
    """R = G = B is grey; colours and more bits, of NOISY or of the truth, are refused."""
    (grey, path), out = noisy, tmp_path / "o.pgm"
    options = ["-o", out, "--step", "32", "--smoothness", "potts"]
    facts_of("restore", path, *options)
    expected = out.read_bytes()
    size = f"{grey.shape[1]} {grey.shape[0]}"
    same, colour, deep = (tmp_path / name for name in ("same.ppm", "colour.ppm", "deep.pgm"))
    rgb = np.repeat(grey[..., None], 3, -1).astype(np.uint8)
    same.write_bytes(f"P6\n{size}\n255\n".encode() + rgb.tobytes())
    rgb[-1, -1, 2] ^= 1
    colour.write_bytes(f"P6\n{size}\n255\n".encode() + rgb.tobytes())
    write_pgm(deep, grey * 257, 65535)
    facts_of("restore", same, *options)
    assert out.read_bytes() == expected
    out.unlink()
    for arguments, words in [
        ([colour], f"{colour}: is a picture in colours: convert it to grey"),
        ([deep], f"{deep}: has 65535 greys above black: convert it to 8 bits"),
        ([path, "--truth", colour], f"{colour}: is a picture in colours"),
    ]:
        done = run("restore", *arguments, *options)
        assert done.status == 3 and words in done.err
        assert not out.exists()



def test_pictures_that_do_not_fit(noisy, photo, moved, tmp_path):
    other = write_pgm(tmp_path / "other.pgm", np.zeros((3, 4)))
    out = tmp_path / "o.pgm"
    for arguments in (
        ["restore", noisy[1], "--hole", other, "-o", out],
        ["restore", noisy[1], "--truth", other, "-o", out],
        ["segment", photo[0], other, "-o", out],
        ["segment", *photo[:2], "--truth", other, "-o", out],
        ["flow", moved[0], other, "-o", tmp_path / "o.flo"],
        ["score", other, noisy[1], "--as", "picture"],
        ["score", other, noisy[1], "--as", "labels"],
    ):
        done = run(*arguments)
        assert done.status == 3 and "both need the same size" in done.err
        assert done.out == b"" and not out.exists()


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["restore", "n", "-o", "o.jpg"], "ends in .png or .pgm"),
        (["restore", "n", "-o", "o.pgm", "--step", "0"], "--step 0 is not"),
        (["restore", "n", "-o", "o.pgm", "--cost", "cubic"], "absolute squared"),
        (["segment", "p", "s", "-o", "o.pgm", "--classes", "1"], "--classes 1 is not"),
        (["segment", "p", "s", "-o", "o.pgm", "--rounds", "0"], "--rounds 0 is not"),
        (["segment", "p", "s", "-o", "o.pgm", "--lambda", "3000000"], "too large"),
        (["flow", "a", "b", "-o", "o.pfm"], "ends in .flo or .png"),
        (["detect", "b", "-o", "o.png"], "ends in .csv"),
        (["flow", "a", "b", "-o", "o.flo", "--window", "4"], "is even"),
        (["flow", "a", "b", "-o", "o.flo", "--radius", "1,2,3"], "is not R or RX,RY"),
        (["flow", "a", "b", "-o", "o.flo", "--radius", "200"], "more than 65535 displacements"),
        (["flow", "a", "b", "-o", "o.flo", "--truncation", "0.5"], "a multiple of 1/N pixel"),
        (["flow", "a", "b", "-o", "o.flo", "--color", "c.jpg"], "ends in .png or .ppm"),
        (["encode", "--problem", "nonsense", "a", "b", "-o", "c"],
         "stereo label restore segment flow register detect"),
        (["score", "a", "b", "--as", "boxes", "--scale", "3"], "--scale goes with --as disparity"),
        (["score", "a", "b", "--as", "labels", "--hole", "m"], "--hole goes with --as picture"),
    ],
)
def test_usage_errors(arguments, words):
    done = run(*arguments)
    assert (done.status, done.out) == (2, b"")
    assert words in done.err and done.err.count("\n") == 1


@pytest.mark.parametrize(
    "text, words",
    [
        ("", "has no column picture"),
        ("picture,x,y,width,height\n", "has no column score"),
        ("picture,x,y,width,height,score\n", "has no box"),
        ("picture,x,y,width,height,score\np,1,2,3,4,0.5\np,1,2,3\n", "box 2: its height"),
        ("picture,x,y,width,height,score\np,1,2,0,4,0.5\n", "box 1: its width"),
        ("picture,x,y,width,height,score\np,1,2,3,4,high\n", "box 1: its score"),
        ("picture,x,y,width,height,score\np,nan,2,3,4,1\n", "box 1: its x"),
    ],
)
def test_boxes_that_are_refused(tmp_path, text, words):
    path = tmp_path / "boxes.csv"
    path.write_text(text)
    done = run("detect", path, "-o", tmp_path / "kept.csv")
    assert done.status == 3 and words in done.err
    assert not (tmp_path / "kept.csv").exists()


def test_strokes_that_are_refused(photo, tmp_path):
    path, _, _, marked = photo
    empty = write_pgm(tmp_path / "empty.pgm", marked * 0)
    for strokes, options, words in (
        (empty, [], "has no stroke"),
        (photo[1], ["--classes", "2"], None),
        (write_pgm(tmp_path / "five.pgm", marked * 2), ["--classes", "3"], "a stroke of class 4"),
        (path, [], "is a picture in colours"),
    ):
        done = run("segment", path, strokes, "-o", tmp_path / "o.pgm", *options)
        assert done.status == (3 if words else 0)
        assert words is None or words in done.err


@pytest.mark.parametrize("change", [lambda d: d[:11], lambda d: d[:-1], lambda d: d + b"\0" * 8])
def test_flow_files_that_are_refused(moved, tmp_path, change):
    truth = moved[2]
    bad = tmp_path / "bad.flo"
    bad.write_bytes(change(truth.read_bytes()))
    done = run("score", bad, truth, "--as", "flow")
    assert done.status == 3 and "cut short" in done.err and done.out == b""
