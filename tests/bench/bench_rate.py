"""Frames a second of match on a rendered sequence at VGA with 64 disparities, its errors, and
OpenCV's StereoSGBM on the same frames in the same run. Figures `rate`.

    python tests/bench/bench_rate.py [--figures DIR] [--frames DIR]

The frames are those of samples/camera/generate.py, four times as large, and between two of its
frames there are four more. They are rectified once, before anything is measured. The time of match
is that of the whole command on all frames, files read and written; the time of StereoSGBM is that
of its calls alone. Beside the frames a second, which depend on what else the machine does, there
are the seconds of CPU for a frame. Errors are in percent of all pixels with x at least 63 that are
off by more than 1, or a half, over all frames.

--frames  keeps the rendered frames there, and takes them from there the next time
"""

import importlib.util
import resource
import subprocess
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np
from bench_stereo import errors, filled, read_pfm
from scenes import ROOT, Figures, arguments

TIMES, FRAMES, BETWEEN, MOST = 4, 8, 5, 63
METHODS = {
    "fast": ["--preset", "fast"],
    "fast, two threads": ["--preset", "fast", "--threads", "2"],
    "fast, whole pixels": ["--preset", "fast", "--after", "check,fill"],
    "fast, left picture alone": ["--preset", "fast", "--after", "halves"],
}


def enlarged():
    """The generator of the sample, for larger pictures and a ball that rolls more slowly."""
    path = ROOT / "samples" / "camera" / "generate.py"
    spec = importlib.util.spec_from_file_location("generate", path)
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    scale = np.diag([TIMES, TIMES, 1])
    made.WIDTH, made.HEIGHT, made.FOCAL = (TIMES * n for n in (made.WIDTH, made.HEIGHT, made.FOCAL))
    made.CENTRE = tuple(TIMES * (c + .5) - .5 for c in made.CENTRE)
    made.CAMERAS = [(scale @ matrix, bend, angles) for matrix, bend, angles in made.CAMERAS]
    made.BASELINE /= 2  # the nearest surface is within the range of disparities
    scene = made.scene
    made.scene = lambda frame: scene(frame / BETWEEN)
    return made


def render(qstereo, folder):
    """Writes left_N.pgm and right_N.pgm, rectified, and truth_N.npy."""
    made = enlarged()
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "stereo.yml").write_text(made.storage(made.calibration()))
    for frame in range(FRAMES):
        pair = [folder / f"{side}_{frame}.pgm" for side in ("left", "right")]
        raw = [folder / f"raw_{side}.pgm" for side in ("left", "right")]
        for side, path in enumerate(raw):
            cv2.imwrite(str(path), made.photograph(frame, side))
        subprocess.run([qstereo, "rectify", *raw, "--calibration", folder / "stereo.yml", "-o",
                        *pair], check=True, capture_output=True)
        np.save(folder / f"truth_{frame}.npy", made.disparities(frame))
        print(f"  frame {frame} is rendered", flush=True)


def truths(folder):
    for frame in range(FRAMES):
        truth = np.load(folder / f"truth_{frame}.npy")
        truth[:, :MOST] = np.nan
        yield truth


def cpu_seconds(who):
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


def timed(who, work):
    """(what the work returns, its seconds, its seconds of CPU)."""
    begin, used = time.perf_counter(), cpu_seconds(who)
    done = work()
    return done, time.perf_counter() - begin, cpu_seconds(who) - used


def measured(maps, folder, seconds, cpu):
    wrong = [errors(found, truth) for found, truth in zip(maps, truths(folder))]
    return {**{key: float(np.mean([of[key] for of in wrong])) for key in ("bad_1", "bad_half")},
            "frames_a_second": FRAMES / seconds, "cpu_seconds_a_frame": cpu / FRAMES}


def ours(qstereo, folder, options):
    with tempfile.TemporaryDirectory() as out:
        line = [qstereo, "match", folder / "left_%d.pgm", folder / "right_%d.pgm", "-o",
                f"{out}/d_%d.pfm", "--disparity", f"0:{MOST}", *options]
        _, *times = timed(resource.RUSAGE_CHILDREN,
                          lambda: subprocess.run(line, check=True, capture_output=True))
        maps = [read_pfm(Path(out) / f"d_{frame}.pfm") for frame in range(FRAMES)]
    return measured(maps, folder, *times)


def sgbm(folder):
    matcher = cv2.StereoSGBM_create(0, MOST + 1, 5, 200, 800, uniquenessRatio=5,
                                    speckleWindowSize=50, speckleRange=2)
    pairs = [[cv2.imread(str(folder / f"{side}_{frame}.pgm"), 0) for side in ("left", "right")]
             for frame in range(FRAMES)]
    cv2.setNumThreads(1)
    maps, *times = timed(resource.RUSAGE_SELF,
                         lambda: [matcher.compute(*pair) / 16 for pair in pairs])
    return measured(map(filled, maps), folder, *times)


def main():
    options = arguments(__doc__, frames="folder that keeps the rendered frames")
    with (tempfile.TemporaryDirectory() as made,
          Figures(options.figures, "rate", "python tests/bench/bench_rate.py") as figures):
        folder = Path(options.frames or made)
        if not (folder / f"truth_{FRAMES - 1}.npy").exists():
            render(options.qstereo, folder)
        figures["methods"] = {"SGBM": sgbm(folder),
                              **{name: ours(options.qstereo, folder, words)
                                 for name, words in METHODS.items()}}
        for name, of in figures["methods"].items():
            print(f"  {name}: {of['frames_a_second']:.1f} frames a second, "
                  f"{of['bad_1']:.2f} % off by more than 1")


if __name__ == "__main__":
    main()
