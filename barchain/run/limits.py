"""Default limit of a run; a module of its own, as the command line's help must be quick."""

TIME_LIMIT_S = 120.0  # the slowest run of the core suite takes a tenth of it on two cores
