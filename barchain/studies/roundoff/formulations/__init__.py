"""Formulations of the reactions, and the exact states in which their round-off is measured."""
