"""Pages of the gallery and of the engines, rendered from code, scenes and the record; no engine runs."""
