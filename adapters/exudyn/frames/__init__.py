"""Frames of reference and their clock: the Kepler orbit, and the transformation to inertial axes."""
