"""Compiled effects, one module each, named as the reference names them; only those of a chain are imported."""
