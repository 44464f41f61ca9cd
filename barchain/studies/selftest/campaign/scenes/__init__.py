"""Random scenes: drawing, writing and simplifying them."""
