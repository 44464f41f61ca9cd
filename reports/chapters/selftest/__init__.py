"""Chapter on the self-test."""
