"""Frames of reference and their clock: the Kepler orbit, and the way back to inertial axes."""
