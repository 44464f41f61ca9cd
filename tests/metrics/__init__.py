"""Tests of compared quantities."""
