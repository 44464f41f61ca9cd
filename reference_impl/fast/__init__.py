"""Compiled relative formulation: the reference's equations and stepper, some hundred times faster than NumPy."""
