"""Tests of the gate before a merge."""
