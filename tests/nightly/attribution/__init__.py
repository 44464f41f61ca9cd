"""Tests of attribution, environments and releases."""
