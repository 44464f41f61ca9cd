"""Solvers of SciPy and SUNDIALS on the reference's right-hand side, called with the options of a typical user.

Right-hand side: the compiled reference's, a C function. CVODE calls it by its address through its own C interface, with
no Python in a step; SciPy's solvers are Python themselves, and each evaluation is a call of the C function from Python.

Purpose: the cost and the errors of a general solver. They are no check of the physics, which is the reference's own.
Formulation and coordinates: the reference's, centre of mass and angles.
Integrators: DOP853 and Radau of SciPy's `solve_ivp`; Adams (with fixed-point iteration) and BDF (with
Newton's method) of CVODE, from the library that scikit-sundae brings along. All control their step. Each run restarts
at events known beforehand, and stops at the surface.
Accuracy parameter: `rtol`; the absolute tolerance is a thousandth of `rtol`, in SI units.

Supported: every effect but solar pressure with a shadow, whose edge a general solver steps over.

Traps: scikit-sundae's own interface takes Python functions of NumPy arrays only. No exception may cross CVODE: each is
kept, and raised afterwards. Where bars turn their faces (drag, solar pressure), SciPy's solvers stop and start again,
as DOP853's error estimate misses a jump in the slope of a force. CVODE's faces follow from each evaluated state in
Python. SciPy replaces an `rtol` below 100 eps, with a warning. Event functions are checked at the ends of steps only,
so a short contact with the surface may be missed.
"""
