"""Reference solutions (tight runs of the reference) and certified solutions (quadruple precision, with error bars)."""
