"""Comparison of one engine with the reference solution of one scene, and its verdict."""
