"""Engines behind one contract, `adapters.engine.Engine`: build a scene, simulate it, read a `Trajectory`.

Each engine has a package of its own. Its first page says how the chain is formulated, in which coordinates, with which
integrator, and what it does not support. An engine's package uses `common` and `bar_loads` and no other engine, with
two exceptions: `ode_solvers` steps the equations of `reference`, and `pinocchio` is stepped by a solver of
`ode_solvers`.
"""
