"""Numbers, units, formulas and Markdown as text."""
