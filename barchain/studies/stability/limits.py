"""Numbers that the command line shows without loading the study."""

TIME_LIMIT_S = 60.0  # of one run: some thirty times what a run of the default set takes
