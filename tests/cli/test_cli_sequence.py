"""match on sequences, streams, pairs side by side and pictures of calibrated cameras: each map is
the one that match makes of the same rectified pair alone.
"""

import json
import os
import shutil
import signal
import subprocess

import numpy as np
import pytest
from camera_tools import SIZE, calibration, write_calib, write_storage
from cli_tools import (
    LONG,
    random_pair,
    read_pfm,
    run,
    signal_at_output,
    started,
    succeed,
    write_pgm,
)

OPTIONS = ["--disparity", "0:4", "--solver", "icm"]


@pytest.fixture
def work(tmp_path, monkeypatch):
    """A folder that the commands run in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def pictures(count, width=14, height=6, most=255, seed=3):
    """[(left, right)] of random pictures."""
    random = np.random.default_rng(seed)
    return [tuple(random.integers(0, most + 1, (2, height, width))) for _ in range(count)]


def alone(work, left, right, maxval=255, options=()):
    """The map of one pair."""
    paths = [write_pgm(work / f"alone{i}.pgm", p, maxval) for i, p in enumerate((left, right))]
    succeed("match", *paths, "-o", work / "alone.pfm", *OPTIONS, *options)
    return (work / "alone.pfm").read_bytes()


def write_numbered(work, pairs, first=0):
    for number, pair in enumerate(pairs, first):
        for side, picture in zip("lr", pair):
            write_pgm(work / f"{side}_{number:03}.pgm", picture)


def maps_in(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


@pytest.mark.parametrize("first", [0, 1, 998])
def test_files_with_numbers(work, first):
    pairs = pictures(3)
    write_numbered(work, pairs, first)
    done = succeed("match", "l_%03d.pgm", "r_%03d.pgm", "-o", "out/d_%d.pfm", *OPTIONS, "--json")
    facts = [json.loads(line) for line in done.out.splitlines()]
    numbers = list(range(first, first + 3))
    assert [of["frame"] for of in facts] == numbers
    assert [of["map"] for of in facts] == [f"out/d_{number}.pfm" for number in numbers]
    wanted = {f"d_{n}.pfm": alone(work, *pair) for n, pair in zip(numbers, pairs)}
    assert maps_in(work / "out") == wanted
    assert done.err == ""


def test_colours_and_lines_of_a_sequence(work):
    write_numbered(work, pictures(2))
    done = succeed("match", "l_%03d.pgm", "r_%03d.pgm", "-o", "d_%02d.pgm", "--color", *OPTIONS)
    assert [line.split(":")[0] for line in done.out.decode().splitlines()[::2]] == [
        "d_00.pgm, d_00.color.ppm", "d_01.pgm, d_01.color.ppm"]
    assert len(list(work.glob("d_0[01].*"))) == 4


def pnm_stream(pairs, maxval=255):
    kind = ">u2" if maxval > 255 else "u1"
    return b"".join(
        b"P5 # a comment\n%d\t%d\n%d\n" % (picture.shape[1], picture.shape[0], maxval)
        + picture.astype(kind).tobytes()
        for picture in pairs
    )


# Colour spaces, the bits of a sample, and the samples of colour of a frame of 28 x 7 pixels.
SPACES = [("", 8, 2 * 14 * 4), ("C420jpeg", 8, 2 * 14 * 4), ("C420mpeg2", 8, 2 * 14 * 4),
          ("C422", 8, 2 * 14 * 7), ("C411", 8, 2 * 7 * 7), ("C444", 8, 2 * 28 * 7),
          ("C444alpha", 8, 3 * 28 * 7), ("Cmono", 8, 0), ("C420p10", 10, 2 * 14 * 4),
          ("C422p12", 12, 2 * 14 * 7), ("Cmono16", 16, 0)]


def y4m_stream(frames, space, bits, colours):
    kind = "<u2" if bits > 8 else "u1"
    height, width = frames[0].shape
    other = bytes([77]) * (colours * (2 if bits > 8 else 1))
    head = f"YUV4MPEG2 W{width} H{height} F30000:1001 Ip A1:1 {space}".strip() + "\n"
    return head.encode() + b"".join(
        b"FRAME Ip\n" + frame.astype(kind).tobytes() + other for frame in frames
    )


@pytest.mark.parametrize("space, bits, colours", SPACES)
def test_y4m_side_by_side(work, space, bits, colours):
    most = 2**bits - 1
    pairs = pictures(3, height=7, most=most)
    stream = y4m_stream([np.hstack(pair) for pair in pairs], space, bits, colours)
    succeed("match", "--sbs", "-", "-o", "out/d_%02d.pfm", *OPTIONS, input=stream)
    wanted = {f"d_{n:02}.pfm": alone(work, *pair, most) for n, pair in enumerate(pairs, 1)}
    assert maps_in(work / "out") == wanted


@pytest.mark.parametrize("maxval", [255, 1000, 65535])
def test_two_streams_of_pictures(work, maxval):
    pairs = pictures(3, most=maxval)
    for side, name in enumerate(("left", "right")):
        (work / name).write_bytes(pnm_stream([pair[side] for pair in pairs], maxval))
    succeed("match", "left", "right", "-o", "out/d_%d.pfm", *OPTIONS)
    wanted = {f"d_{n}.pfm": alone(work, *pair, maxval) for n, pair in enumerate(pairs, 1)}
    assert maps_in(work / "out") == wanted


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_two_video_files(work):
    """As the page says it, with pipes that have names."""
    pairs = pictures(3)
    size, quiet, readers = "14x6", ["ffmpeg", "-v", "error", "-nostdin"], []
    for side, frames in zip("lr", zip(*pairs)):
        raw = np.array(frames, np.uint8).tobytes()
        subprocess.run([*quiet[:3], "-f", "rawvideo", "-pix_fmt", "gray", "-s", size, "-i", "-",
                        "-c:v", "ffv1", f"{side}.avi"], input=raw, check=True)
        os.mkfifo(f"{side}.y4m")
        readers.append(subprocess.Popen([*quiet, "-y", "-i", f"{side}.avi", "-pix_fmt", "gray",
                                         "-f", "yuv4mpegpipe", "-strict", "-1", f"{side}.y4m"]))
    succeed("match", "l.y4m", "r.y4m", "-o", "out/d_%d.pfm", *OPTIONS)
    assert [reader.wait() for reader in readers] == [0, 0]
    wanted = {f"d_{n}.pfm": alone(work, *pair) for n, pair in enumerate(pairs, 1)}
    assert maps_in(work / "out") == wanted


VIDEOS = [b"RIFF\0\0\0\0AVI LIST", b"\0\0\0\x20ftypisom", b"\x1a\x45\xdf\xa3\x01"]


@pytest.mark.parametrize("data", VIDEOS)
@pytest.mark.parametrize("to", ["d.pfm", "d_%d.pfm"])
def test_a_video_that_is_no_stream_says_what_makes_one(work, data, to):
    (work / "v.avi").write_bytes(data)
    done = run("match", "v.avi", "v.avi", "-o", to, *OPTIONS)
    assert done.status == 3 and "v.avi" in done.err and "ffmpeg" in done.err
    assert "yuv4mpegpipe" in done.err and done.err.count("\n") == 1


@pytest.mark.parametrize("inputs", [["video0", "video1"], ["--sbs", "video0"]])
@pytest.mark.parametrize("to", ["d.pfm", "d_%d.pfm"])
def test_a_device_that_is_not_there(work, inputs, to):
    done = run("match", *inputs, "-o", to, *OPTIONS)
    assert done.status == 4
    assert done.err == "qstereo match: video0: cannot be opened: No such file or directory\n"


def test_a_stream_of_colours_is_that_of_its_greys(work):
    frame = np.random.default_rng(1).integers(0, 256, (6, 20, 3))
    data = b"P6\n20 6\n255\n" + frame.astype("u1").tobytes()
    (work / "one.ppm").write_bytes(data)
    succeed("match", "--sbs", "one.ppm", "-o", "one.pfm", *OPTIONS)
    succeed("match", "--sbs", "-", "-o", "d_%d.pfm", *OPTIONS, input=data * 2)
    assert (work / "d_1.pfm").read_bytes() == (work / "d_2.pfm").read_bytes()
    assert (work / "d_1.pfm").read_bytes() == (work / "one.pfm").read_bytes()


@pytest.mark.parametrize("to, ending", [("-", "pgm"), ("pfm:-", "pfm")])
def test_maps_as_a_stream(work, to, ending):
    pairs = pictures(3)
    stream = pnm_stream([np.hstack(pair) for pair in pairs])
    done = succeed("match", "--sbs", "-", "-o", to, *OPTIONS, input=stream)
    succeed("match", "--sbs", "-", "-o", f"d_%d.{ending}", *OPTIONS, input=stream)
    files = b"".join((work / f"d_{n}.{ending}").read_bytes() for n in (1, 2, 3))
    assert done.out == files and len(files) > 3 * 84


def test_one_pair_side_by_side(work):
    left, right = pictures(1)[0]
    write_pgm(work / "both.pgm", np.hstack((left, right)))
    succeed("match", "--sbs", "both.pgm", "-o", "d.pfm", *OPTIONS)
    assert (work / "d.pfm").read_bytes() == alone(work, left, right)


FAILURES = [
    # What the second frame lacks, the exit status, and what is said.
    ("right", 3, "r_001.pgm: is missing, but l_001.pgm is there"),
    ("left", 3, "l_001.pgm: is missing, but r_001.pgm is there"),
    ("end", 3, "r_001.pgm: is a damaged PBM"),
    ("size", 3, "r_001.pgm: is 9 x 6 pixels, but l_001.pgm is 14 x 6"),
]


@pytest.mark.parametrize("lack, status, message", FAILURES)
def test_earlier_maps_stay_where_a_frame_fails(work, lack, status, message):
    pairs = pictures(3)
    write_numbered(work, pairs)
    path = work / ("l_001.pgm" if lack == "left" else "r_001.pgm")
    if lack == "end":
        path.write_bytes(path.read_bytes()[:-3])
    elif lack == "size":
        write_pgm(path, pairs[1][1][:, :9])
    else:
        path.unlink()
    done = run("match", "l_%03d.pgm", "r_%03d.pgm", "-o", "out/d_%d.pfm", *OPTIONS)
    assert done.status == status
    assert message in done.err
    assert maps_in(work / "out") == {"d_0.pfm": alone(work, *pairs[0])}


def test_a_stream_that_is_cut_short_names_its_frame(work):
    pairs = pictures(2)
    stream = y4m_stream([np.hstack(pair) for pair in pairs], "Cmono", 8, 0)
    done = run("match", "--sbs", "-", "-o", "out/d_%d.pfm", *OPTIONS, input=stream[:-1])
    assert done.status == 3
    assert "standard input, frame 2: ends before its last sample" in done.err
    assert maps_in(work / "out") == {"d_1.pfm": alone(work, *pairs[0])}


def test_a_first_frame_that_fails_leaves_nothing(work):
    write_numbered(work, pictures(2))
    (work / "l_000.pgm").write_bytes(b"P5\n4 4\n")
    done = run("match", "l_%03d.pgm", "r_%03d.pgm", "-o", "out/d_%d.pfm", *OPTIONS)
    assert done.status == 3 and not (work / "out").exists()


def test_numbers_that_are_left_out_are_said(work):
    write_numbered(work, pictures(2))
    write_numbered(work, pictures(1), 5)
    done = succeed("match", "l_%03d.pgm", "r_%03d.pgm", "-o", "d_%d.pfm", *OPTIONS)
    assert "ends at number 1: 2 is missing, but 5 is there" in done.err
    assert sorted(path.name for path in work.glob("d_*")) == ["d_0.pfm", "d_1.pfm"]


BAD_STREAMS = [
    (b"", "has no frame"),
    (b"GIF89a", "is no picture of a stream"),
    (b"Y", "header cannot be read"),
    (b"YUV4MPEG1 W20 H6\nFRAME\n", "header cannot be read"),
    (b"YUV4MPEG2 W20 H6 X" + bytes([88]) * 2000 + b"\nFRAME\n", "header cannot be read"),
    (b"YUV4MPEG2 W20 C420\nFRAME\n", "header cannot be read"),
    (b"YUV4MPEG2 W20 H6 C999\nFRAME\n", "header cannot be read"),
    (b"YUV4MPEG2 W20 H6 Cmono17\nFRAME\n", "header cannot be read"),
    (b"YUV4MPEG2 W99999999999999999999 H6\nFRAME\n", "header cannot be read"),
    (b"YUV4MPEG2 W20 H6 Cmono\nFRAMe\n" + bytes(120), "does not begin with FRAME"),
    (b"YUV4MPEG2 W20 H6 Cmono10\nFRAME\n" + bytes([255]) * 240, "above its largest value"),
    (b"YUV4MPEG2 W1000000 H1000000 Cmono\nFRAME\n", "needs more than the memory limit"),
    (b"P5 20 6 70000\n" + bytes(240), "has no header of a binary PGM"),
    (b"P2 20 6 255\n", "has no header of a binary PGM"),
    (b"P5 20", "has no header of a binary PGM"),
    (b"P5 21 6 255\n" + bytes(126), "is 21 pixels wide"),
]


@pytest.mark.parametrize("data, message", BAD_STREAMS)
def test_streams_that_cannot_be_read(work, data, message):
    done = run("match", "--sbs", "-", "-o", "out/d_%d.pfm", *OPTIONS, input=data)
    assert done.status == (4 if "memory" in message else 3)
    assert message in done.err and done.err.count("\n") == 1
    assert not (work / "out").exists()


USAGE = [
    (["l_%03d.pgm", "r_%03d.pgm", "-o", "d.pfm"], "give their name a number"),
    (["--sbs", "-", "-o", "d.pfm"], "give their name a number"),
    (["--sbs", "l_000.pgm", "r_000.pgm", "-o", "d.pfm"], "leave out r_000.pgm"),
    (["l_000.pgm", "-o", "d.pfm"], "the operand RIGHT is missing"),
    (["l_%03d.pgm", "r_%03d.pgm", "-o", "d_%d.pfm", "--truth", "l_000.pgm"], "goes with one pair"),
    (["l_000.pgm", "r_000.pgm", "-o", "pfm:-", "--json"], "cannot both go to standard output"),
]


@pytest.mark.parametrize("words, message", USAGE)
def test_wrong_usage(work, words, message):
    write_numbered(work, pictures(1))
    done = run("match", *words, *OPTIONS)
    assert done.status == 2 and message in done.err
    assert len(list(work.iterdir())) == 2


@pytest.mark.parametrize("words, message", [
    (["x_%d.pgm", "r_%03d.pgm"], "x_%d.pgm: no file has this name with a number in it"),
    (["l_%03d.pgm", "s_%03d.pgm"], "begins at number 4, but l_%03d.pgm at 0"),
    (["l_000.pgm", "r_%03d.pgm"], "has no frame 2"),
])
def test_inputs_that_do_not_agree(work, words, message):
    write_numbered(work, pictures(2))
    write_pgm(work / "s_004.pgm", np.zeros((6, 14)))
    done = run("match", *words, "-o", "d_%d.pfm", *OPTIONS)
    assert done.status in (3, 4)
    if message != "has no frame 2":
        assert message in done.err
    else:  # a file without a number is a stream, here of one frame, named from the other's number
        assert "l_000.pgm, frame 1: is missing, but r_001.pgm is there" in done.err


def test_a_map_is_no_input_of_its_sequence(work):
    write_numbered(work, pictures(2))
    before = maps_in(work)
    done = run("match", "l_%03d.pgm", "r_%03d.pgm", "-o", "l_%03d.pgm", *OPTIONS)
    assert done.status == 2 and "is an input of this command" in done.err
    assert maps_in(work) == before


@pytest.mark.parametrize("folder", ["l_000.pgm", "none/deeper", "/dev/null", "/proc"])
def test_a_folder_that_takes_no_maps(work, folder):
    """A file in its place, one whose own folder is not there, and one for no files."""
    write_numbered(work, pictures(2))
    before = maps_in(work)
    done = run("match", "l_%03d.pgm", "r_%03d.pgm", "-o", f"{folder}/d_%d.pgm", *OPTIONS)
    assert done.status == 4 and folder in done.err and done.err.count("\n") == 1
    assert done.out == b"" and maps_in(work) == before


@pytest.mark.parametrize("standard", [False, True])
def test_a_map_is_no_stream_that_it_is_made_from(work, standard):
    """Neither the stream by its name, nor behind standard input."""
    (work / "s_1.pgm").write_bytes(pnm_stream([np.hstack(pair) for pair in pictures(2)]))
    before = maps_in(work)
    with (work / "s_1.pgm").open("rb") as stream:
        done = run("match", "--sbs", "-" if standard else "s_1.pgm", "-o", "s_%d.pgm", *OPTIONS,
                   stdin=stream)
    assert done.status == 2 and "s_1.pgm: is an input of this command" in done.err
    assert maps_in(work) == before


def test_a_signal_between_frames_leaves_whole_maps(work):
    _, _, left, right = random_pair(work, 200, 150)
    for number in range(400):
        for path, side in ((left, "l"), (right, "r")):
            (work / f"{side}_{number:03}.pgm").symlink_to(path)
    (work / "out").mkdir()
    words = ["l_%03d.pgm", "r_%03d.pgm", "-o", "out/d_%03d.pgm", "--solver", "icm"]
    process = started("match", *words)
    signal_at_output(process, work / "out", 4, signal.SIGTERM)
    assert process.wait(LONG) == 128 + signal.SIGTERM
    process.communicate()
    made = maps_in(work / "out")
    assert 2 <= len(made) < 400 and len(set(made.values())) == 1


@pytest.mark.parametrize("kind", ["numbers", "stream"])
def test_calibrated_cameras(work, kind):
    path = write_storage(work / "stereo.yml", calibration())
    pairs = pictures(2, *SIZE)
    write_numbered(work, pairs)
    stream = pnm_stream([np.hstack(pair) for pair in pairs])
    words = ["l_%03d.pgm", "r_%03d.pgm"] if kind == "numbers" else ["--sbs", "-"]
    succeed("match", *words, "--calibration", path, "-o", "d_%d.pfm", *OPTIONS, input=stream)
    for number, pair in enumerate(pairs, kind == "stream"):
        paths = [write_pgm(work / f"p{side}.pgm", picture) for side, picture in enumerate(pair)]
        succeed("rectify", *paths, "--calibration", path, "-o", "a.pgm", "b.pgm")
        succeed("match", "a.pgm", "b.pgm", "-o", "alone.pfm", *OPTIONS)
        assert (work / f"d_{number}.pfm").read_bytes() == (work / "alone.pfm").read_bytes()


def test_middleburys_range_of_disparities(work):
    path = write_calib(work / "calib.txt", size=(14, 6), ndisp=5)
    pair = pictures(1)[0]
    paths = [write_pgm(work / f"{side}.pgm", picture) for side, picture in zip("lr", pair)]
    succeed("match", *paths, "--calibration", path, "-o", "d.pfm", "--solver", "icm")
    assert (work / "d.pfm").read_bytes() == alone(work, *pair)
    succeed("match", *paths, "--calibration", path, "-o", "d.pfm", "--solver", "icm",
            "--disparity", "0:2")
    assert np.isfinite(read_pfm((work / "d.pfm").read_bytes())).sum() == 12 * 6


@pytest.mark.parametrize("preset", ["accurate", "fast"])
def test_a_preset_knows_the_range_of_a_calibration(work, preset):
    path = write_calib(work / "calib.txt", size=(14, 6), ndisp=40)
    write_numbered(work, pictures(1))
    line = ["match", "l_000.pgm", "r_000.pgm", "--calibration", path, "--preset", preset, "--json"]
    known = json.loads(succeed(*line, "-o", "d.pfm").out)
    given = json.loads(succeed(*line, "-o", "e.pfm", "--disparity", "0:39").out)
    narrow = json.loads(succeed(*line, "-o", "f.pfm", "--disparity", "0:20").out)
    for key in "lambda", "truncation", "disparity_step", "after", "iterations":
        assert known[key] == given[key]
    assert known["lambda"] != narrow["lambda"]
    assert (work / "d.pfm").read_bytes() == (work / "e.pfm").read_bytes()


@pytest.mark.parametrize("option", ["--mask", "--confidence"])
def test_pictures_of_one_map_are_refused_for_a_sequence(work, option):
    write_numbered(work, pictures(1))
    done = run("match", "l_%03d.pgm", "r_%03d.pgm", "-o", "d_%d.pfm", *OPTIONS, option, "m.pgm")
    assert (done.status, done.out) == (2, b"")
    assert f"{option} goes with one pair, not with a sequence" in done.err
    assert not (work / "m.pgm").exists() and not (work / "d_0.pfm").exists()


def test_pictures_of_another_size_than_the_calibration(work):
    path = write_calib(work / "calib.txt")
    write_numbered(work, pictures(1))
    done = run("match", "l_000.pgm", "r_000.pgm", "--calibration", path, "-o", "d.pfm")
    assert done.status == 3 and "is 14 x 6 pixels, but" in done.err
