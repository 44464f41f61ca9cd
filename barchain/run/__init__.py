"""Runs of engines in worker processes, with limits of time, and verdicts in such processes."""
