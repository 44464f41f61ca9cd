"""Tests of runs of nights."""
