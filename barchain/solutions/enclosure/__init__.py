"""Rigorous enclosures of a chain's motion: ball arithmetic (python-flint), and equations of their own derivation."""
