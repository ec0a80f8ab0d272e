"""Pictures: every format and depth of the same grey gives the same problem, in both builds."""

import io

import numpy as np
import pytest
from cli_tools import run, succeed, write_pgm
from PIL import Image


def problem(picture, **options):
    """The .qcf of a picture beside itself."""
    done = succeed(
        "encode", picture, picture, "-o", "-", "--disparity", "0:3", "--roi", "3,0,5,3", **options
    )
    return done.out


def luma(rgb):
    return (rgb.astype(int) @ [299, 587, 114] + 500) // 1000


RANDOM = np.random.default_rng(11)
GREY = RANDOM.integers(0, 256, (4, 8)).astype("u1")
RGB = RANDOM.integers(0, 256, (4, 8, 3)).astype("u1")


@pytest.fixture
def grey(tmp_path):
    return problem(write_pgm(tmp_path / "grey.pgm", GREY))


@pytest.fixture
def colour(tmp_path):
    return problem(write_pgm(tmp_path / "luma.pgm", luma(RGB)))


def ascii_pnm(kind, samples, maxval=255):
    rows = "\n".join(" ".join(map(str, row)) for row in samples.reshape(4, -1))
    return f"{kind} # a comment\n8\n# and another\n4 {maxval}\n{rows}".encode()


def binary_pnm(kind, samples, maxval, dtype):
    return f"{kind}\n8 4\n{maxval}\n".encode() + samples.astype(dtype).tobytes()


def saved(array, kind, **options):
    file = io.BytesIO()
    Image.fromarray(array).save(file, kind, **options)
    return file.getvalue()


def alpha(samples):
    return np.dstack([samples, RANDOM.integers(0, 256, (4, 8, 1)).astype(samples.dtype)])


PNM_GREY = {
    "P2": ascii_pnm("P2", GREY),
    "P2 of 16 bits": ascii_pnm("P2", GREY.astype(int) * 257, 65535),
    "P5 of 16 bits": binary_pnm("P5", GREY.astype(int) * 257, 65535, ">u2"),
    "P3 of grey": ascii_pnm("P3", np.dstack([GREY] * 3)),
}
PNM_RGB = {
    "P3": ascii_pnm("P3", RGB),
    "P6": binary_pnm("P6", RGB, 255, "u1"),
    "P6 of 16 bits": binary_pnm("P6", RGB.astype(int) * 257, 65535, ">u2"),
}
OTHER_GREY = {
    "PNG": saved(GREY, "PNG"),
    "PNG of 16 bits": saved(GREY.astype("u2") * 257, "PNG"),
    "TIFF": saved(GREY, "TIFF"),
    "TIFF of 16 bits": saved(GREY.astype("u2") * 257, "TIFF"),
    "PNG with alpha": saved(alpha(GREY), "PNG"),
    "BMP": saved(GREY, "BMP"),
}
OTHER_RGB = {
    "PNG": saved(RGB, "PNG"),
    "PNG with alpha": saved(alpha(RGB), "PNG"),
    "TIFF": saved(RGB, "TIFF"),
    "PNG of a palette": saved(RGB, "PNG"),
}


@pytest.mark.parametrize("name", PNM_GREY)
def test_grey_pnm(tmp_path, grey, name):
    (tmp_path / "picture").write_bytes(PNM_GREY[name])
    assert problem(tmp_path / "picture") == grey


@pytest.mark.parametrize("name", PNM_RGB)
def test_colour_pnm(tmp_path, colour, name):
    (tmp_path / "picture").write_bytes(PNM_RGB[name])
    assert problem(tmp_path / "picture") == colour


@pytest.mark.parametrize("name", OTHER_GREY)
def test_grey_of_the_library(tmp_path, grey, opencv, name):
    (tmp_path / "picture").write_bytes(OTHER_GREY[name])
    assert problem(tmp_path / "picture") == grey


@pytest.mark.parametrize("name", OTHER_RGB)
def test_colour_of_the_library(tmp_path, colour, opencv, name):
    (tmp_path / "picture").write_bytes(OTHER_RGB[name])
    assert problem(tmp_path / "picture") == colour


@pytest.mark.parametrize("kind, maxval", [("P5", 1023), ("P5", 100), ("P2", 1023), ("P2", 1)])
def test_any_maxval(tmp_path, kind, maxval):
    samples = RANDOM.integers(0, maxval + 1, (4, 8))
    data = (
        ascii_pnm(kind, samples, maxval)
        if kind == "P2"
        else binary_pnm(kind, samples, maxval, ">u2" if maxval > 255 else "u1")
    )
    (tmp_path / "picture").write_bytes(data)
    expected = write_pgm(tmp_path / "expected.pgm", (samples * 255 + maxval // 2) // maxval)
    assert problem(tmp_path / "picture") == problem(expected)


@pytest.mark.parametrize("samples", [GREY, RGB])
def test_jpeg(tmp_path, opencv, samples):
    (tmp_path / "picture.jpg").write_bytes(saved(samples, "JPEG", quality=95, subsampling=0))
    decoded = np.asarray(Image.open(tmp_path / "picture.jpg"))
    expected = write_pgm(tmp_path / "expected.pgm", decoded if decoded.ndim == 2 else luma(decoded))
    assert problem(tmp_path / "picture.jpg") == problem(expected)


def test_orientation_is_not_applied(tmp_path, opencv):
    plain, turned = tmp_path / "plain.jpg", tmp_path / "turned.jpg"
    exif = Image.Exif()
    exif[0x0112] = 3
    plain.write_bytes(saved(GREY, "JPEG"))
    turned.write_bytes(saved(GREY, "JPEG", exif=exif))
    assert plain.read_bytes() != turned.read_bytes()
    assert problem(plain) == problem(turned)


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "TIFF"])
def test_cut_and_damaged(tmp_path, folder, opencv, kind):
    whole = saved(np.random.default_rng(2).integers(0, 256, (40, 60, 3)).astype("u1"), kind)
    for share in (0.1, 0.5, 0.98):
        (tmp_path / "cut").write_bytes(whole[: int(len(whole) * share)])
        done = run("encode", tmp_path / "cut", tmp_path / "cut", "-o", folder / "p.qcf")
        assert (done.status, done.err.count("\n")) == (3, 1)
        assert done.err.startswith(f"qstereo encode: {tmp_path / 'cut'}: is ")
    assert not list(folder.iterdir())


def test_floats_are_no_grey(tmp_path, opencv):
    (tmp_path / "f.tiff").write_bytes(saved(np.ones((4, 8), "f4"), "TIFF"))
    done = run("encode", tmp_path / "f.tiff", tmp_path / "f.tiff", "-o", "-", "--disparity", "0:3")
    assert (done.status, "8 or 16 bits" in done.err) == (3, True)


@pytest.mark.parametrize("name, data", [*PNM_GREY.items(), *PNM_RGB.items()])
def test_both_builds_make_the_same_bytes(tmp_path, pnm_only, name, data):
    (tmp_path / "picture").write_bytes(data)
    assert problem(tmp_path / "picture", program=pnm_only) == problem(tmp_path / "picture")


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "TIFF"])
def test_a_build_without_opencv_says_what_it_reads(tmp_path, folder, pnm_only, kind):
    (tmp_path / "picture").write_bytes(saved(GREY, kind))
    done = run(
        "encode",
        tmp_path / "picture",
        tmp_path / "picture",
        "-o",
        folder / "p.qcf",
        program=pnm_only,
    )
    assert done.status == 3
    assert f"is a {kind}: this build reads PGM and PPM" in done.err and "OPENCV=1" in done.err
    assert not list(folder.iterdir())


def test_versions_name_the_library(pnm_only):
    assert (
        run("--version", program=pnm_only).out
        == b"qstereo 0.1.0 (file format 1, pictures: PNM only)\n"
    )
