"""Chapter on the effects that are worth simulating."""
