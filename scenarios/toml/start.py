"""Rule for initial places of bars that contradict the angles and the joints.

The angles and the joints define the place of every bar. A file may also give the bars' centres, e.g. as another program
wrote them. The largest joint gap of these places, relative to the shorter bar, then decides:

====================  ==========================================================================
up to 1e-9            rounding of written numbers: taken as closed, without a note
above, up to 1e-6     projected: closed by the angles, with a note in the description
above                 rejected: angles and places are of two different chains
====================  ==========================================================================
"""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenarios.toml.scene_tables import ChainTable

ROUNDED = 1e-9  # of the shorter bar: rounding of a place to nine digits
PROJECTED = 1e-6  # of the shorter bar: joint gaps of a loose solver


def start_faults(chain: ChainTable) -> Iterator[str]:
    """Faults of centres in other axes, or that leave a joint open; one line each."""
    if chain.centre_m is None:
        return
    if chain.angle_from != "chain":
        yield 'chain.centre_m: needs angle_from = "chain": places and angles in the same axes'
    elif len(chain.centre_m) != chain.bars:
        yield f"chain.centre_m: {len(chain.centre_m)} places given, allowed: one for each of {chain.bars}"
    else:
        joint, share = widest(chain)
        if share > PROJECTED:
            yield (
                f"chain.centre_m: joint {joint} is {share:.3g} of its shorter bar open at the start, "
                f"allowed: up to {ROUNDED:g}, taken as closed, or up to {PROJECTED:g}, closed by the angles"
            )


def start_note(chain: ChainTable) -> str:
    """Note on a start whose joints were closed by the angles; empty if they were closed as given."""
    if chain.centre_m is None:
        return ""
    joint, share = widest(chain)
    if share <= ROUNDED:
        return ""
    return f"Joint {joint} was given {share:.2g} of its shorter bar open; the angles decide the places."


def widest(chain: ChainTable) -> tuple[int, float]:
    """Joint (from 1) with the largest gap over its shorter bar, and that share; (0, 0.0) without joints."""
    assert chain.centre_m is not None
    places = [complex(*place) for place in chain.centre_m]
    _, length, _, share = chain.material()
    bars = [size * complex(math.cos(a), math.sin(a)) for size, a in zip(length, chain.angles_rad, strict=True)]
    lefts = [place - part * bar for place, part, bar in zip(places, share, bars, strict=True)]
    pairs = itertools.pairwise(zip(lefts, bars, length, strict=True))
    gaps = [abs(other - (left + bar)) / min(a, b) for (left, bar, a), (other, _, b) in pairs]
    return max(((i + 1, gap) for i, gap in enumerate(gaps)), key=lambda found: found[1], default=(0, 0.0))
