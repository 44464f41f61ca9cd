"""Faults of the random self-test, by the part of the engine that they change."""
