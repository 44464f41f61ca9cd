"""Errors of the history, which no library has to be there for."""

from __future__ import annotations


class HistoryError(ValueError):
    """Raised for a store that can't be used, or a night that is not in it; the message is one line."""


class FigureError(ValueError):
    """Raised for a figure that its kind does not allow; the message is one line."""
