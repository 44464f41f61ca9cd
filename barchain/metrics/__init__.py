"""Quantities that are compared, their scales, and what they are derived from."""
