"""One run of a solver: read, solve, check, write; jobs that are paid for once; many calls."""
