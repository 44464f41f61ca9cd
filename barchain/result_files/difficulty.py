"""Difficulty of a case: a grade, and the numbers that it follows from."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from barchain.metrics.quantities import rate_scale
from reports.results.comparison import LINEAR_GROWTH

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.result_files.tube import Tube
    from barchain.solutions.reference import ReferenceSolution


SMOOTH, JUMPS, SENSITIVE, CHAOTIC = "1 smooth", "2 jumps", "3 sensitive", "4 chaotic"
GRADES = {
    SMOOTH: "a requested error of 1e-6 in each step keeps the motion predictable to the end, and nothing jumps",
    JUMPS: "the same, and forces or laws jump, or bars turn their other face to wind or Sun",
    SENSITIVE: "a request between 1e-6 and 1e-12 is needed",
    CHAOTIC: "not even 1e-12 keeps the motion predictable to the end",
}
"""Grades by what the end of a case demands"""


def difficulty(solution: ReferenceSolution, tubes: Sequence[Tube]) -> dict[str, Any]:
    """Grade of a case and the numbers that it follows from, ready for JSON.

    Parameters
    ----------
    solution : ReferenceSolution
    tubes : sequence of Tube
        From the coarsest request to the finest.
    """
    scene, end_s = solution.scene, float(solution.trajectory.t_s[-1])
    needed = next((each.rtol for each in tubes if each.until_s >= end_s), None)
    jumps, effects = sum(0.0 < t < end_s for t in scene.effects.breaks_s), scene.effects
    faces = bool(effects.on_faces)
    grade = CHAOTIC if needed is None else SENSITIVE
    if needed == tubes[0].rtol:
        grade = JUMPS if jumps or faces else SMOOTH
    return {
        "grade": grade,
        "needed_rtol": needed,
        "digits_lost": round(math.log10(min(float(solution.amplification[-1]), LINEAR_GROWTH)), 1),
        "jumps": jumps,
        "faces": faces,
        "fastest_radians": round(rate_scale(scene, solution.trajectory) * end_s),
    }
