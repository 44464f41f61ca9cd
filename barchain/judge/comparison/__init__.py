"""Comparison of one engine with the judging solution of one scene, and its verdict."""
