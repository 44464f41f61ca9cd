"""Diagnosis of engine mistakes: known mistakes that explain a wrong trajectory, found by trial."""
