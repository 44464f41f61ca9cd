"""Faults of the random self-test, by what they spoil."""
