"""Errors of nights, each with a message of one line; nothing heavy is imported."""

from __future__ import annotations

import importlib.util

EXTRA = "pip install '.[nightly]'"
NEEDED = ("fsspec",)


class HistoryError(ValueError):
    """Raised for a history that can't be read or written; the message is one line."""


class MissingExtraError(HistoryError):
    """Raised where a package of the extra is missing."""


class UnknownNightError(HistoryError):
    """Raised for a night that the history does not hold."""


class UnknownFigureError(HistoryError):
    """Raised for a figure that the history does not hold."""


def need_extra(*more: str) -> None:
    """Check that the packages of the extra are installed.

    Raises
    ------
    MissingExtraError
        If one is missing; the message says how to get it.
    """
    for module in (*NEEDED, *more):
        if importlib.util.find_spec(module) is None:
            raise MissingExtraError(f"the history needs {module}, which is not installed; try: {EXTRA}")


class PinnedEnvironmentError(HistoryError):
    """Raised for an environment, or sources, that can't be made; the message is one line."""
