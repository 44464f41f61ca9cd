"""Nights that are kept: levels, acceptances, and the judgement of a night from those before it."""
