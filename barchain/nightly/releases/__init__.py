"""Study of the releases of an engine: accuracy, times, sizes against the release, with today's barchain."""
