"""Colours of engines: those of one family share a colour where many are drawn together."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from reports.plotting.palette import SERIES, Pen, engine_pen

if TYPE_CHECKING:
    from collections.abc import Sequence

Flags = NDArray[np.bool_]
OTHERS = "others"
SHARED = "Engines of one family share a colour here; the charts by family tell them apart."
MARKER_SIZE, CROSS_SIZE = 5.6, 6.0


def families(engines: Sequence[str]) -> dict[str, str]:
    """Family of each engine: the first word of its name, or ``others`` for single ones."""
    first = {e: first_word(e) for e in engines}
    words = list(first.values())
    return {e: word if words.count(word) > 1 else OTHERS for e, word in first.items()}


def group_of(engines: Sequence[str]) -> dict[str, str]:
    """Group of each engine that shares a pen: itself if there are enough pens, else the first word of its name."""
    names = list(dict.fromkeys(engines))
    return {e: e if len(names) <= len(SERIES) else first_word(e) for e in names}


def first_word(engine: str) -> str:
    """Family of an engine by its name."""
    return engine.partition("-")[0]


def family_pens(engines: Sequence[str]) -> dict[str, Pen]:
    """One pen for each group of engines."""
    words = list(dict.fromkeys(group_of(engines).values()))
    places = [0, *range(2, len(SERIES)), 1]  # the second neutral comes last
    count = len(places)
    return {word: engine_pen(places[k % count] + k // count * count) for k, word in enumerate(words)}
