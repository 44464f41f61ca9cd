"""Module that misbehaves when it is imported."""

raise RuntimeError("at import")
