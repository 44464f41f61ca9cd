"""Whether engines stay numerically stable where scenes are hard: three settings each, a closed set of outcomes."""
