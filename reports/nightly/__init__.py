"""Page and summary of a night."""
