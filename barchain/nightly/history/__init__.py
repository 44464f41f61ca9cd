"""History of nights: what was measured, where, with which parts, and what changed."""
