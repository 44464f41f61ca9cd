"""Commands that list scenes and engines, run them, compare them and render reports."""
