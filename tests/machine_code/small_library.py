"""Smallest library, as any process would meet it."""

from __future__ import annotations

from reference_impl.machine_code.functions import compiled
from reference_impl.machine_code.library import Library


def half(x: float) -> float:
    """Half of a number."""
    return 0.5 * x


def fresh() -> Library:
    """Return the library, not yet compiled in this process."""
    return Library("stored", (compiled(half),))
