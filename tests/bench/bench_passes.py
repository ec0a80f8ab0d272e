"""CPU time of one iteration of TRW-S on 12.7 million pairs of a site and a label, with numbers of
32 bits and of 16: figures `passes`.

    python tests/bench/bench_passes.py [--figures DIR]
"""

import json
import subprocess

from scenes import Figures, arguments


def main():
    options = arguments(__doc__)
    with Figures(options.figures, "passes") as figures:
        done = subprocess.run([options.build / "bench_passes"], check=True, capture_output=True)
        figures["runs"] = json.loads(done.stdout)


if __name__ == "__main__":
    main()
