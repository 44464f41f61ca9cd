"""Single questions of a verdict: digits, the run's end, extrapolation, restarts beyond the predictability limit."""
