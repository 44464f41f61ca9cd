"""Causes of changes, found by real runs in fresh environments; releases of engines."""
