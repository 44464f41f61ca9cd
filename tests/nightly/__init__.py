"""Tests of the nightly regression."""
