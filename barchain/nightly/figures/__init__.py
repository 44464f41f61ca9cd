"""Figures of nights: what a night measured, what it depends on, and the rules of change."""
