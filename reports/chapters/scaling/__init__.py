"""Chapter on the number of bars."""
