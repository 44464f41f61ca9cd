"""Migrations, one module each, numbered in their order."""
