"""Boundary around engines of other packages: none of their code runs in the process that compares.

Import, declarations, `unsupported`, `unsupported_motion`, `noise` and runs happen in a process of their own. A server
that has loaded barchain and no engine forks it. A supervisor stands between: it ends the engine at its limits of wall
time, memory and output, and then every process that the engine has started. The answer comes back as a file of text
and float64 arrays (:mod:`barchain.boundary.message`), which cannot run code. The comparing process checks it anew.

An installed plug-in still runs as the user who starts barchain: the boundary guards a comparison against accidents,
and is no sandbox against malice.
"""
