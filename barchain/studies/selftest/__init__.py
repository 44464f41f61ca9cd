"""Whether the harness catches wrong physics: faults put in on purpose, and which check kills each."""
