"""What each cost and each smoothness of stereo asks of a chip, on a window of the sample pair:
figures `costs`.

    python tests/bench/bench_costs.py [--figures DIR]
"""

import tempfile
from pathlib import Path

from scenes import LAMBDA, SAMPLES, Figures, arguments, call

ROI, DISPARITY = "60,40,50,50", "0:15"
SETTINGS = ["", "--cost bt", "--cost census:7x7", "--cost bt:40+2*census:7x7", "--contrast 8,3",
            f"--disparity {DISPARITY}:0.5", "--smoothness linear",
            "--smoothness linear --truncation 2", "--smoothness quadratic --truncation 4",
            "--preset accurate"]
ENCODINGS = ["one-hot", "domain-wall"]
COUNTED = ["quadratic_terms", "penalty_min", "penalty_max"]


def counted(setting, encoding, qstereo, problem):
    """Terms and penalties of the file that `encode` writes, and the unit of energy of a chip."""
    call(qstereo, "encode", SAMPLES / "left.png", SAMPLES / "right.png", "-o", problem, "--roi",
         ROI, "--encoding", encoding,
         *([] if "--disparity" in setting else ["--disparity", DISPARITY]),
         *([] if "--preset" in setting else ["--lambda", LAMBDA]), *setting.split())
    said = call(qstereo, "info", problem)
    form = next(of for of in call(qstereo, "info", "--complexity", problem)["encodings"]
                if (of["encoding"], of["penalty"], of["truncated"]) == (encoding, "local", False))
    return {**{key: said[key] for key in COUNTED}, "unit": form["unit"]}


def measure(qstereo):
    """The figures of all settings."""
    with tempfile.TemporaryDirectory() as folder:
        problem = Path(folder, "p.qcf")
        runs = [{"setting": setting, **{encoding: counted(setting, encoding, qstereo, problem)
                                        for encoding in ENCODINGS}} for setting in SETTINGS]
    return {"roi": ROI, "disparity": DISPARITY, "lambda": LAMBDA, "runs": runs}


def main():
    options = arguments(__doc__)
    with Figures(options.figures, "costs") as figures:
        figures.update(measure(options.qstereo))


if __name__ == "__main__":
    main()
