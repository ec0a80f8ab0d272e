"""CPU time of one iteration of TRW-S on 12.7 million pairs of a site and a label, with numbers of
32 bits and of 16: figures `passes`.

    python tests/bench/bench_passes.py [--figures DIR]
"""

from scenes import figures_of_program

if __name__ == "__main__":
    figures_of_program("passes", __doc__)
