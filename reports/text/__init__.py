"""Numbers, units, formulas and Markdown in words."""
