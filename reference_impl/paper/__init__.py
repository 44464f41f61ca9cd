"""The formulation as the paper prints it, and its misprints."""
