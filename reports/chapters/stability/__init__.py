"""Chapter on the stability."""
