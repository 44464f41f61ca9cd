"""Solver settings, initial accelerations, equal steps, and runs divided where loads jump."""
