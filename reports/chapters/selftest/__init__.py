"""Chapter of the self-test: kill matrix of seeded faults."""
