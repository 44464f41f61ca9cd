"""Studies, one package each. Every study plans, runs, and writes tables; none imports another."""
