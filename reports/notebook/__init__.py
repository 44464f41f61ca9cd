"""Scenes, trajectories and comparisons as HTML for notebooks: a picture and the main numbers."""
