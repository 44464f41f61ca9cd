"""The gate before a merge: two builds of an engine, measured in turns in one job, and judged by the rules of nights."""
