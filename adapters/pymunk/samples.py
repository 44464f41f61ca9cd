"""Types of the samples of pymunk's bars."""

Rows = list[tuple[float, float, float]]
"""For each bar x, y and angle, or their rates; SI units"""
StaggeredSample = tuple[Rows, Rows, Rows]
"""Each bar's position at a sample, its rates half a step before, and half a step after"""
