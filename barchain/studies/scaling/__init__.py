"""Scaling study: cost of an evaluation, of an orbit and of the model against the number of bars."""
