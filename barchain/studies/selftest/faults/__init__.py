"""Faults of the kill matrix, by what they spoil, and the engine that carries them."""
