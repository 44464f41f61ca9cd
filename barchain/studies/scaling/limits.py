"""Defaults of a scaling study; a module of its own, as the command line's help must be quick."""

BARS = (2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 20_000, 50_000, 100_000)
TIME_LIMIT_S = 10.0  # of one simulation
MINUTES = 25.0
REPEATS = 5  # of short runs and of evaluations
