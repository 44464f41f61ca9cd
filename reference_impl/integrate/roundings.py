"""Round-off errors of absolute coordinates, as the step control and the declared noise count them."""

ROUNDINGS = 4.0
"""Round-off errors of an absolute coordinate in one step"""
