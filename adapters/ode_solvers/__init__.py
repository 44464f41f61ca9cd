"""Solvers of SciPy and SUNDIALS on the reference's right-hand side, called with the options of a typical user.

Purpose: the cost and the errors of a general solver. They are no check of the physics, which is the reference's own.
Formulation and coordinates: the reference's, centre of mass and angles.
Integrators: RK45, DOP853, Radau and LSODA of SciPy's `solve_ivp`; Adams and BDF of CVODE through scikit-sundae. All
control their step. Each run restarts at events known beforehand, and stops at the surface.
Accuracy parameter: `rtol`; the absolute tolerance is a thousandth of `rtol`, in SI units.

Supported: every effect but solar pressure with a shadow, whose edge a general solver steps over.

Traps: with a single output instant CVODE returns all its own steps, the last of them at the instant. SciPy replaces an
`rtol` below 100 eps, with a warning. Event functions are checked at the ends of steps only, so a short contact with the
surface may be missed.
"""
