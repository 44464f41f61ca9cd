"""Shared by engines: initial state, joint coordinates and forces, Kepler's orbit, equal steps, events, landing."""
