"""Pictures: every format and depth of the same grey gives the same problem, in both builds."""

import io
import struct

import numpy as np
import pytest
from cli_tools import run, succeed, tiff, write_pgm
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


def pam(samples, kind):
    depth = samples.size // GREY.size
    head = f"P7\n# a comment\nWIDTH 8\nHEIGHT 4\nDEPTH {depth}\nMAXVAL 255\n"
    head += f"TUPLTYPE {kind}\nENDHDR\n"
    return head.encode() + samples.tobytes()


PNM_GREY = {
    "P2": ascii_pnm("P2", GREY),
    "P2 of 16 bits": ascii_pnm("P2", GREY.astype(int) * 257, 65535),
    "P5 of 16 bits": binary_pnm("P5", GREY.astype(int) * 257, 65535, ">u2"),
    "P3 of grey": ascii_pnm("P3", np.dstack([GREY] * 3)),
    "PAM": pam(GREY, "GRAYSCALE"),
    "PAM with alpha": pam(alpha(GREY), "GRAYSCALE_ALPHA"),
}
PNM_RGB = {
    "P3": ascii_pnm("P3", RGB),
    "P6": binary_pnm("P6", RGB, 255, "u1"),
    "P6 of 16 bits": binary_pnm("P6", RGB.astype(int) * 257, 65535, ">u2"),
    "PAM": pam(RGB, "RGB"),
    "PAM with alpha": pam(alpha(RGB), "RGB_ALPHA"),
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
        == b"qstereo 0.2.0 (file format 1, pictures: PNM only)\n"
    )


LINE_ENDS = {
    "CR LF": b"P5\r\n8 4\r\n255\r\n%s",
    "CR": b"P5\r8 4\r255\r%s",
    "blank": b"P5 8 4 255 %s",
    "comment that touches maxval": b"P5\n8 4\n255# a comment\n%s",
    "comment and CR LF": b"P5\r\n# one\r\n8 4\r\n255# another\r\n%s",
    "LF behind": b"P5\n8 4\n255\n%s\n",
    "CR LF behind": b"P5\r\n8 4\r\n255\r\n%s\r\n",
}


@pytest.mark.parametrize("first", [b"\n", b"\r", b" ", b"#", b"\x08"])
@pytest.mark.parametrize("last", [b"\n", b" ", b"#", b"\x08"])
@pytest.mark.parametrize("name", LINE_ENDS)
def test_line_ends_of_a_binary_header(tmp_path, name, first, last):
    """Samples that look like blanks or comments are samples. A lone CR before a sample of 10 reads
    as CR LF only where the file is longer by that byte.
    """
    samples = first + GREY.tobytes()[1:-1] + last
    (tmp_path / "picture").write_bytes(LINE_ENDS[name].replace(b"%s", samples))
    expected = write_pgm(tmp_path / "plain.pgm", np.frombuffer(samples, "u1").reshape(4, 8))
    assert problem(tmp_path / "picture") == problem(expected)


@pytest.mark.parametrize("kind", ["P5", "P6"])
def test_line_ends_of_other_headers(tmp_path, kind):
    data = PNM_GREY["P5 of 16 bits"] if kind == "P5" else PNM_RGB["P6"]
    start = len(data) - GREY.size * (2 if kind == "P5" else 3)
    head, pixels = data[:start], data[start:]
    pixels = b"\n" + pixels[1:-1] + b" "
    (tmp_path / "lf").write_bytes(head + pixels)
    (tmp_path / "crlf").write_bytes(head.replace(b"\n", b"\r\n") + pixels)
    assert problem(tmp_path / "crlf") == problem(tmp_path / "lf")


@pytest.mark.parametrize("kind", ["P1", "P4"])
def test_bitmaps(tmp_path, kind):
    """1 is black. A binary row begins a byte."""
    black = RANDOM.integers(0, 2, (4, 9))
    text = "\n".join("".join(map(str, row)) for row in black).encode()
    data = {"P1": text, "P4": np.packbits(black, axis=1).tobytes()}[kind]
    (tmp_path / "picture").write_bytes(kind.encode() + b"\n# a comment\n9 4\n" + data)
    expected = write_pgm(tmp_path / "expected.pgm", (1 - black) * 255)
    assert problem(tmp_path / "picture") == problem(expected)


@pytest.mark.parametrize("kind", ["f4", "i2", "u2"])
def test_tiffs_of_other_numbers(tmp_path, opencv, kind):
    """Floats are greys from 0 to 255, whole numbers of 16 bits from 0 to 65535."""
    samples = GREY.astype(kind)
    if kind != "f4":
        samples = (GREY.astype(int) * (257 if kind == "u2" else 128)).astype(kind)
    (tmp_path / "p.tiff").write_bytes(tiff(samples))
    grey = GREY if kind == "f4" else (samples.astype(int) * 255 + 32767) // 65535
    assert problem(tmp_path / "p.tiff") == problem(write_pgm(tmp_path / "p.pgm", grey))


def test_numbers_that_are_no_greys(tmp_path, opencv):
    for values, words in (
        (GREY.astype("f4") / 255, "floats up to 1"),
        (GREY.astype("f4") * 2, "but a grey picture has 0 to 255"),
        (-GREY.astype("i2"), "but a grey picture has 0 to 65535"),
    ):
        (tmp_path / "p.tiff").write_bytes(tiff(values))
        line = ["encode", tmp_path / "p.tiff", tmp_path / "p.tiff", "-o", "-"]
        done = run(*line, "--disparity", "0:3")
        assert (done.status, words in done.err, done.out) == (3, True, b"")


@pytest.mark.parametrize("bits", [10, 12])
def test_bits(tmp_path, folder, bits):
    """10 or 12 bits in a file of 16 look black; --bits says where white is."""
    samples = RANDOM.integers(0, 2**bits, (4, 8))
    samples[0, 0] = 2**bits - 1
    deep = write_pgm(tmp_path / "deep.pgm", samples, 65535)
    plain = write_pgm(tmp_path / "plain.pgm", samples, 2**bits - 1)
    line = ["encode", deep, deep, "-o", folder / "p.qcf", "--disparity", "0:3"]
    done = run(*line)
    assert (done.status, f"add --bits {bits}" in done.err) == (0, True)
    done = run(*line, "--bits", bits)
    assert (done.status, done.err) == (0, "")
    made = (folder / "p.qcf").read_bytes()
    assert run("encode", plain, plain, "-o", folder / "q.qcf", "--disparity", "0:3").status == 0
    assert made == (folder / "q.qcf").read_bytes()
    done = run(*line, "--bits", bits - 1)
    assert (done.status, f"more than --bits {bits - 1} can hold" in done.err) == (3, True)
    done = run("encode", plain, plain, "-o", folder / "r.qcf", "--disparity", "0:3", "--bits", bits)
    assert (done.status, "leave out --bits" in done.err) == (3, True)


def tiled_tiff(grey):
    """A TIFF of 8 bits in tiles of 16 x 16; the sides are multiples of 16."""
    height, width = grey.shape
    tiles = [
        grey[y : y + 16, x : x + 16].astype("u1").tobytes()
        for y in range(0, height, 16)
        for x in range(0, width, 16)
    ]
    places = [8 + 256 * i for i in range(len(tiles))]
    lists = 8 + 256 * len(tiles)
    fields = [(256, 3, 1, width), (257, 3, 1, height), (258, 3, 1, 8), (259, 3, 1, 1)]
    fields += [(262, 3, 1, 1), (277, 3, 1, 1), (322, 3, 1, 16), (323, 3, 1, 16)]
    fields += [(324, 4, len(tiles), lists), (325, 4, len(tiles), lists + 4 * len(tiles))]
    return b"".join(
        [
            b"II*\0",
            struct.pack("<I", lists + 8 * len(tiles)),
            *tiles,
            struct.pack(f"<{2 * len(tiles)}I", *places, *[256] * len(tiles)),
            struct.pack("<H", len(fields)),
            *[struct.pack("<HHII", *field) for field in fields],
            bytes(4),
        ]
    )


def test_a_tiff_in_tiles_is_read_or_named(tmp_path, opencv):
    """OpenCV 4.6 reads no tiles of 16 x 16, later ones may."""
    grey = np.random.default_rng(3).integers(0, 256, (32, 48)).astype("u1")
    path, plain = tmp_path / "t.tiff", write_pgm(tmp_path / "p.pgm", grey)
    path.write_bytes(tiled_tiff(grey))
    assert np.array_equal(np.array(Image.open(path)), grey)
    done = run("encode", path, path, "-o", "-")
    if done.status == 0:
        assert done.out == succeed("encode", plain, plain, "-o", "-").out
    else:
        assert done.status == 3 and "is a TIFF in tiles" in done.err and "strips" in done.err
