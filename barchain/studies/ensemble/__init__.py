"""Ensembles: many perturbed copies of a scene, run by the compiled reference, and their quantiles over time."""
