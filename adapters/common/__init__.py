"""Shared by engines: initial state, Kepler's orbit, equal steps, step alignment, face reversal, joint coordinates."""
