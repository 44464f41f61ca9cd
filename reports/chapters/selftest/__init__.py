"""Chapter of the self-test: kill matrix of inserted faults."""
