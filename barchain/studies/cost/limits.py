"""Defaults of a cost study; a module of its own, as the command line's help must be quick."""

TIME_LIMIT_S = 2.0  # of one run: some ten thousand times what the fastest engine needs for 1e-10 rad
REPEATS = 7  # of short runs; with less the median's interval is the range
MINUTES = 8.0  # for the paper's scenes in all engines, so that start-up and report end inside 15
