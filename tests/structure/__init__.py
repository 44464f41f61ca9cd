"""Checks of the project's own layout: names, folders, imports of tests, paths and commands in the docs, words."""
