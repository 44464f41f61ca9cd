"""Benchmarks of which a mistake would not be seen in their output."""
