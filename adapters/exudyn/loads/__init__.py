"""Loads on Exudyn's bodies, as symbolic functions of Exudyn: gravity, effects, prescribed rotations."""
