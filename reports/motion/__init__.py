"""Runs over time as charts and animations, in files and in Matplotlib's figures."""
