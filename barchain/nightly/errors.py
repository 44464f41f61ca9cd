"""Errors of nights, each with a message of one line; nothing heavy is imported."""

from __future__ import annotations

import importlib.util


class HistoryError(ValueError):
    """Raised for a history that can't be read or written; the message is one line."""


def need_extra(*more: str) -> None:
    """Check that the packages of the extra are installed.

    Raises
    ------
    HistoryError
        If one is missing; the message says how to get it.
    """
    for module in ("fsspec", *more):
        if importlib.util.find_spec(module) is None:
            raise HistoryError(f"the history needs {module}, which is not installed; try: pip install '.[nightly]'")


class PinnedEnvironmentError(HistoryError):
    """Raised for an environment, or sources, that can't be made; the message is one line."""
