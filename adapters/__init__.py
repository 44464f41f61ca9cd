"""Engines behind one contract; each external engine is imported in its own adapter only."""
