"""Module that misbehaves when it is imported."""

raise KeyboardInterrupt
