"""Studies, one package each: every study plans, runs, and writes tables, and none imports another.

`timing` is no study: several measure their times with it.
"""
