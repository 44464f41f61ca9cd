"""Mistakes in the equations of motion, found in the balance of momenta of an engine's own states."""
