"""Scaling study: what an evaluation, an orbit and the model itself cost as the chain gets more bars."""
