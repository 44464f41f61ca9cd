"""Chapter of an ensemble: quantiles of perturbed runs over time."""
