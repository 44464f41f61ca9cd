"""Times of runs and of single evaluations, their statistics, and measured orders of convergence."""
