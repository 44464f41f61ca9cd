"""Chapter on the round-off."""
