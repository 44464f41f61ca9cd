"""Integration: SciPy's solvers step by step, events, stiffness, coordinate sets."""
