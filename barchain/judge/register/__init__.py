"""The register of tolerances, and the tables of the documents that are made of it."""
