"""Engines behind one contract, `adapters.engine.Engine`: build a scene, simulate it, read a `Trajectory`.

Each engine has a package of its own. The docstring of the package gives the formulation, the coordinates, the
integrator, the effects and their limits. An engine's package imports `common` and `bar_loads` and no other engine. One
exception holds: `ode_solvers` steps the equations of `reference`.
"""
