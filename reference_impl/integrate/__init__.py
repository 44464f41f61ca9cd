"""Stepping: SciPy's solvers walked step by step, events, stiff modes, coordinate sets."""
