"""Checks of the project's own layout: names, folders, imports of tests, references in docstrings, words."""
