"""Limits of time on a Dask cluster; a module of its own, as the command line's help must be quick."""

ANSWER_S = 10.0  # for a scheduler to connect
SILENT_S = 30.0  # for a scheduler to answer: it may import this code for several seconds
START_S = 120.0  # for workers to start a process beside them, which imports this code
WORKERS_S = 30.0  # without any worker; a batch system may need more
CLOSE_S = 5.0  # for the connection to be closed
