"""Compiled effects, one module each, named as in the reference; imported only for chains with the effect."""
