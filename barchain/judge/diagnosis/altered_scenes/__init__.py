"""Altered scenes, which the reference simulates: one module for each part of a scene."""
