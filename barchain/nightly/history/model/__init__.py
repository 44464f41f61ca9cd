"""Data model of the history: nights, parts, figures, and what their names and digests are made of."""
