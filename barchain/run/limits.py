"""Default limits of a run; a module of its own, as the command line's help must be quick."""

TIME_LIMIT_S = 120.0  # the slowest run of the core suite takes a tenth of it on two cores
SOLUTION_PATIENCE = 5.0
"""Limit of a run for the reference solution, relative to an engine's run: a scene without it judges no engine"""
