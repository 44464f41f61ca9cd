"""Compiled relative formulation: the reference's equations and stepper in C, called through ctypes.

A run of paper/fig05 is 300 to 550 times faster than with NumPy. docs/explanation/kernel.md is its page.
"""
