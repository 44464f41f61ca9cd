"""Chapter on ensembles."""
