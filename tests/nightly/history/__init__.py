"""Tests of the history of nights."""
