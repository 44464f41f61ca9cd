"""Chapter on the cost of accuracy."""
