"""Checks of one engine's runs: each takes residuals, or an error model and a run, and returns findings."""
