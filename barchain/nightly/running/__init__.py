"""A night from its plan to its folder."""
