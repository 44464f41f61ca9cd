"""Solvers of SciPy and SUNDIALS on the reference's right-hand side, driven as their users drive them.

They show what a general solver costs and how it errs. They are no check on the physics, which is the reference's own.
Integrators: RK45, DOP853, Radau and LSODA of SciPy; Adams and BDF of CVODE, by way of scikit-sundae.
Accuracy parameter: `rtol`. Not supported: solar pressure with a shadow, whose edge a plain solver steps over.
Trap: asked for a single instant, CVODE returns its own steps; the last of them is the instant.
"""
