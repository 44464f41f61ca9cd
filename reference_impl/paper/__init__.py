"""Formulation as printed in the paper, and its misprints."""
