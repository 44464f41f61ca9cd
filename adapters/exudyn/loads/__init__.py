"""Loads on Exudyn's bodies as symbolic functions: gravity, effects, prescribed rotations."""
