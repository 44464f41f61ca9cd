"""Everything that runs in another process: runs of engines, questions to engines of other packages, verdicts, programs.

A call is a function of a module with its arguments, a limit of time and a pool of processes that it may share; its
answer is bytes, or the reason why there is none (:mod:`barchain.runs.call`). A worker answers calls one after the
other, each in a process that it forks (:mod:`barchain.runs.worker`): a crash or a hang costs its call. Who starts
workers is all that differs between this machine (:mod:`barchain.runs.pool`), a Dask cluster
(:mod:`barchain.runs.cluster`) and single questions (:mod:`barchain.runs.asking`). A case asks for calls and goes on
with their results (:mod:`barchain.runs.cases`); runs and verdicts are its tasks (:mod:`barchain.runs.tasks`). Programs
such as Git and other Pythons run to their end in :mod:`barchain.runs.processes`.
"""
