"""Parameter sweep: numbers of a scene on grids or drawn, and measures of each run."""
