"""Error of an environment that can't be made."""

from __future__ import annotations

from barchain.nightly.history.faults import HistoryError


class PinnedEnvironmentError(HistoryError):
    """Raised for an environment, or sources, that can't be made; the message is one line."""
