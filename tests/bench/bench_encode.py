"""Speed of cost and encoding in memory beside memcpy of the same bytes: figures `encode`.

    python tests/bench/bench_encode.py [--figures DIR]
"""

from scenes import figures_of_program

if __name__ == "__main__":
    figures_of_program("encode", __doc__)
