"""The relative formulation of the chain's motion, in NumPy, compiled, and in other precisions."""
