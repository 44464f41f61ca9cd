"""Places of calls: in processes of this machine, or beside the workers of a Dask cluster.

A call is a function of a module with its arguments, a limit of time and a pool of processes that it may share. Its
answer is bytes, or the reason why there is none. :mod:`barchain.execution.executors` has both places behind one
interface. The same :class:`barchain.execution.processes.ProcessSlot` runs a call in both: a crash or a hang costs that
call.
"""
