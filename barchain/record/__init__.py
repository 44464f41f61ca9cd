"""What is recorded with results: environment, sources, scenes in words."""
