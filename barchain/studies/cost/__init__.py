"""Work-precision study: time of each engine against its error from the certified solution."""
