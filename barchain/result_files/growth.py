"""Errors of files that begin where no error of the scene does."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.judge.scales import scales
from barchain.metrics.quantities import TRACK, differences, sizes

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.trajectory import Array
    from barchain.result_files.samples import Samples


FEWEST_BEFORE = 8
"""Least samples before one at which a change is held against earlier ones; and the share of the file, its reciprocal"""
SMALLEST_CHANGE = 1e-9
"""Change between files, relative to a quantity's size, that earlier changes need not foretell"""
MOST_FASTER = 1e3
"""Largest ratio of a change to what earlier ones grow to: doubled times make that of a right method up to 16 times"""
MOST_MADE = 100.0
"""Error of several steps and of what amplifies beside the attitude, over that of one step of the request"""


def leaves_too_fast(main: Samples, rtol: float) -> str:
    """Where a file that agrees leaves the solution beyond its own predictability limit, as a sentence; empty if not.

    A file of low accuracy has an early limit. The solution is known until a later one. At any time before, a step may
    have made an error of the request at which the file agrees, which the scene amplifies.

    Parameters
    ----------
    main : Samples
    rtol : float
        The request; 0 of a file that agrees to its digits.
    """
    known = main.solution.trajectory.t_s <= main.solution.limit_s
    own = differences(main.trajectory, main.solution.trajectory)
    seen = {quantity: off[known[: len(off)]] for quantity, off in own.items() if quantity in main.judged}
    where = too_fast(main, seen, rtol)
    return f"the file leaves the solution {where}" if where else ""


def too_fast(main: Samples, own: Mapping[str, Array], rtol: float = 0.0) -> str:
    """Where an error begins that grows faster than the scene lets errors grow, in words; empty where none does.

    What a change between files is taken for, an error, grows with the amplification, and slowly besides. Garbage
    begins at once. Scenes in which forces jump are left out: an error may begin at a jump.

    Parameters
    ----------
    main : Samples
    own : mapping
        Difference of the file from its finer one, or from the solution, by quantity, (n,).
    rtol : float
        Error that a step in between may have made, relative to a quantity's scale.
    """
    effects, amplification = main.solution.scene.effects, main.solution.amplification
    if effects.breaks_s or effects.drag or effects.solar_pressure:
        return ""
    size, unit = sizes(main.solution.trajectory), scales(main.solution)
    for quantity, change in own.items():
        n = min(len(change), len(amplification))
        if quantity in TRACK or quantity not in size:
            continue
        least = SMALLEST_CHANGE * float(size[quantity].max()) + 2.0 * main.written[quantity]
        between = MOST_MADE * rtol * amplification * unit[quantity]
        for k in range(max(FEWEST_BEFORE, n // FEWEST_BEFORE), n):
            grown = float(change[: k // 2 + 1].max()) * amplification[k] / amplification[k // 2]
            if change[k] > max(MOST_FASTER * max(grown, float(least[k])), float(between[k])):
                when = main.trajectory.t_s[k]
                return f"at t = {when:.4g} s, in the {quantity}, far faster than errors grow in the scene"
    return ""
