"""Altered readings of the right motion: one module for each kind."""
