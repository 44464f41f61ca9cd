"""Run of a night: jobs one after the other inside a budget, kept after each, resumed after an interruption."""
