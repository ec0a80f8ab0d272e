"""Errors of the presets of match beside OpenCV's StereoSGBM, and how well `--confidence` sorts
them. Figures `stereo`.

    python tests/bench/bench_stereo.py --data DIR [--figures DIR]

DIR holds the seven scenes and scenes.json, which has each scene's truth_scale and disparity_max.
Errors are in percent of all pixels with a known truth whose matches lie inside the right picture
for every disparity (x at least disparity_max); holes of the other methods are filled as match
fills its own. The area under the sparsification curve is the mean, over all shares of the pixels
that are kept, surest first, of the percentage that is off by more than 1; 0 is best.
"""

import json
import tempfile
from pathlib import Path

import cv2
import numpy as np
from PIL import Image
from scenes import Figures, arguments, measured_call

PAPER_ITERATIONS = 50  # of the solver of the preset paper, which else may run for minutes
METHODS = {
    "paper": ["--preset", "paper", "--iterations", PAPER_ITERATIONS],
    "accurate": ["--preset", "accurate"],
    "accurate, Potts": ["--preset", "accurate", "--smoothness", "potts"],
    "fast": ["--preset", "fast"],
}


def read_pfm(path):
    _, size, _, pixels = path.read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    return np.frombuffer(pixels, "<f4").reshape(height, width)[::-1]


def truth_of(folder, facts):
    """The true map, NaN where it is not counted."""
    held = np.asarray(Image.open(folder / "truth.png")).astype(float)
    truth = np.where(held == 0, np.nan, held / facts["truth_scale"])
    truth[:, :facts["disparity_max"]] = np.nan
    return truth


def errors(found, truth):
    """{threshold: percent of the truth's pixels that are off by more}."""
    known = np.isfinite(truth)
    off = np.where(np.isfinite(found), np.abs(found - truth), np.inf)[known]
    return {"bad_1": 100 * float((off > 1).mean()), "bad_half": 100 * float((off > .5).mean())}


def filled(disparities):
    """Values below 0 become the smaller one of the nearest values of their row."""
    valid = disparities >= 0
    place = np.arange(disparities.shape[1])
    before = np.maximum.accumulate(np.where(valid, place, -1), axis=1)
    after = np.minimum.accumulate(np.where(valid, place, place.size)[:, ::-1], axis=1)[:, ::-1]
    at = [np.where(side, np.take_along_axis(disparities, np.clip(index, 0, place.size - 1), 1),
                   np.inf)
          for side, index in ((before >= 0, before), (after < place.size, after))]
    return np.where(valid, disparities, np.minimum(*at))


def labels_of_sgbm(facts):
    return 16 * -(-(facts["disparity_max"] + 1) // 16)


def padded(matcher, left, right, facts):
    """The map of a matcher, which gives no values in its first columns: the pictures get as many
    more on the left, so that it has a value at every pixel of the real ones.
    """
    more = labels_of_sgbm(facts)
    wide = [cv2.copyMakeBorder(picture, 0, 0, more, 0, cv2.BORDER_REPLICATE)
            for picture in (left, right)]
    return matcher.compute(*wide)[:, more:] / 16


def sgbm(left, right, facts):
    matcher = cv2.StereoSGBM_create(0, labels_of_sgbm(facts), 5, 200, 800, uniquenessRatio=5,
                                    speckleWindowSize=50, speckleRange=2)
    return padded(matcher, *greys(left, right), facts)


def matcher_of_hh(facts, p1, p2):
    return cv2.StereoSGBM_create(0, labels_of_sgbm(facts), 3, p1, p2, preFilterCap=0,
                                 uniquenessRatio=5, mode=cv2.STEREO_SGBM_MODE_HH)


def greys(left, right):
    return [cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY) for picture in (left, right)]


def hh(left, right, facts):
    return padded(matcher_of_hh(facts, 72, 288), *greys(left, right), facts)


def hh_wls(left, right, facts):
    left, right = greys(left, right)
    matcher = matcher_of_hh(facts, 36, 144)
    other = cv2.ximgproc.createRightMatcher(matcher)
    smooth = cv2.ximgproc.createDisparityWLSFilter(matcher)
    smooth.setLambda(8000)
    smooth.setSigmaColor(1.5)
    found = matcher.compute(left, right)
    return smooth.filter(found, left, disparity_map_right=other.compute(right, left)) / 16


def uniqueness(left, right, facts):
    """(StereoSGBM's map without rejection, of each pixel the largest ratio that it survives)."""
    whole, sure = None, np.full(left.shape[:2], -1)
    for ratio in range(0, 100, 3):
        matcher = cv2.StereoSGBM_create(0, labels_of_sgbm(facts), 5, 200, 800,
                                        uniquenessRatio=ratio)
        found = padded(matcher, *greys(left, right), facts)
        sure = np.where(found >= 0, ratio, sure)
        if ratio == 0:
            whole = found
    return whole, sure


def area(found, sure, truth):
    """The area under the sparsification curve; ties in a random order."""
    known = np.isfinite(truth)
    bad = ~(np.abs(found - truth)[known] <= 1)
    order = np.lexsort((np.random.default_rng(0).random(bad.size), -sure[known].astype(float)))
    return 100 * float((np.cumsum(bad[order]) / np.arange(1, bad.size + 1)).mean())


def ours(scene, facts, truth, qstereo, folder):
    pictures = [scene / "left.png", scene / "right.png"]
    made = folder / "m.pfm"
    runs = {}
    for name, options in METHODS.items():
        said, seconds, mib = measured_call(
            qstereo, "match", *pictures, "-o", made, "--disparity", f"0:{facts['disparity_max']}",
            *options)
        settings = {key: said[key] for key in ("cost", "contrast", "border", "smoothness",
                                               "truncation", "lambda", "disparity_step", "solver",
                                               "iterations", "after")}
        runs[name] = {**errors(read_pfm(made), truth), "seconds": seconds, "mib": mib,
                      "settings": settings}
    return runs


def theirs(left, right, facts, truth):
    return {name: errors(filled(method(left, right, facts)), truth)
            for name, method in (("SGBM", sgbm), ("SGBM, HH", hh), ("HH + WLS", hh_wls))}


def confidence(scene, facts, truth, qstereo, folder):
    """The areas of the raw maps of both, sorted by their own measure."""
    sure = folder / "c.png"
    measured_call(qstereo, "match", scene / "left.png", scene / "right.png", "-o",
                  folder / "m.pfm", "--disparity", f"0:{facts['disparity_max']}", "--preset",
                  "accurate", "--after", "check", "--confidence", sure)
    checked = np.asarray(Image.open(sure))
    measured_call(qstereo, "match", scene / "left.png", scene / "right.png", "-o",
                  folder / "m.pfm", "--disparity", f"0:{facts['disparity_max']}", "--preset",
                  "accurate", "--after", "none")
    raw = read_pfm(folder / "m.pfm")
    pictures = [cv2.imread(str(scene / f"{side}.png")) for side in ("left", "right")]
    their_raw, ratio = uniqueness(*pictures, facts)
    return {"margin": area(raw, checked, truth), "uniqueness": area(their_raw, ratio, truth),
            "bad_1": errors(raw, truth)["bad_1"], "sgbm_bad_1": errors(their_raw, truth)["bad_1"]}


def measure(scene, facts, qstereo, folder):
    truth = truth_of(scene, facts)
    pictures = [cv2.imread(str(scene / f"{side}.png")) for side in ("left", "right")]
    print(f"  {scene.name}", flush=True)
    return {"scene": scene.name,
            "methods": {**theirs(*pictures, facts, truth),
                        **ours(scene, facts, truth, qstereo, folder)},
            "confidence": confidence(scene, facts, truth, qstereo, folder)}


def main():
    options = arguments(__doc__)
    if not options.data:
        raise SystemExit("bench_stereo: --data names the folder of the scenes")
    scenes = json.loads((options.data / "scenes.json").read_text())
    command = "python tests/bench/bench_stereo.py"
    with (tempfile.TemporaryDirectory() as folder,
          Figures(options.figures, "stereo", command) as figures):
        figures["runs"] = [measure(options.data / name, facts, options.qstereo, Path(folder))
                           for name, facts in scenes.items()]


if __name__ == "__main__":
    main()
