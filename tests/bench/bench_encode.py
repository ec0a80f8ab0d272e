"""Speed of cost and encoding in memory beside memcpy of the same bytes: figures `encode`.

    python tests/bench/bench_encode.py [--figures DIR]
"""

import json
import subprocess

from scenes import Figures, arguments


def main():
    options = arguments(__doc__)
    with Figures(options.figures, "encode") as figures:
        done = subprocess.run([options.build / "bench_encode"], check=True, capture_output=True)
        figures["runs"] = json.loads(done.stdout)


if __name__ == "__main__":
    main()
