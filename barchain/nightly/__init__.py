"""Nightly regression: a plan, the history of nights, what changed, whose change it was, and how that is told."""
