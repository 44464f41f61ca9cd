"""The allowed name that is nearest to a given one."""

from __future__ import annotations

import difflib
from typing import TYPE_CHECKING

from scenarios.size_limits import MOST_KEY

if TYPE_CHECKING:
    from collections.abc import Iterable

LIKE_ENOUGH = 0.6  # difflib's default: a less similar suggestion would be a guess


def nearest(given: str, allowed: Iterable[str]) -> str:
    """`` (did you mean X?)`` for the allowed name nearest to `given`; empty if none is near."""
    match = nearest_name(given, allowed)
    return f" (did you mean {match}?)" if match else ""


def nearest_scene(given: str, names: Iterable[str]) -> str | None:
    """Scene whose name without folder is nearest to `given`; among equals the scene with the nearest folder."""

    def base(name: str) -> str:
        return name.rpartition("/")[2]

    known = list(names)
    match = nearest_name(base(given), map(base, known))
    return None if match is None else nearest_of(given, [name for name in known if base(name) == match])


def nearest_name(given: str, allowed: Iterable[str]) -> str | None:
    """Allowed name nearest to `given`, the first of equals; None if no name is similar."""
    best = nearest_of(given, allowed)
    return best if best is not None and likeness(given, best) >= LIKE_ENOUGH else None


def nearest_of(given: str, allowed: Iterable[str]) -> str | None:
    """Allowed name nearest to `given`, however far, the first of equals; None if there is none."""
    return max(sorted(allowed), key=lambda name: likeness(given, name), default=None)


def likeness(a: str, b: str) -> float:
    """Similarity of two names, 0 to 1, ignoring case; no name is like one beyond all lengths."""
    if max(len(a), len(b)) > MOST_KEY:
        return 0.0
    return difflib.SequenceMatcher(None, a.lower(), b.lower()).ratio()
