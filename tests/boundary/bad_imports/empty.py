"""Module that misbehaves when it is imported."""
