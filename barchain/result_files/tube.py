"""Tolerance tubes of a case: how far a right answer may be off at a requested error, and until when.

The width is the margin by which `barchain judge` passes a file of that request: the expected-error bound of its method
as the scene amplifies it, and twice the error bar of the solution. Beyond the predictability limit two right answers
may have any attitude; there only the track of the centre of mass has a tube.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.evidence import Evidence
from barchain.judge.written import Declared, WrittenErrors, WrittenResiduals
from barchain.runs.job import RunResult
from barchain.solutions.case_versions import values
from reports.results.outcome import Outcome
from scenarios.channels import COMPARED

if TYPE_CHECKING:
    import pandas as pd

    from adapters.trajectory import Array
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene


@dataclass(frozen=True)
class Tube:
    """Largest differences of right answers at one request; n samples."""

    rtol: float
    """Requested error of one step"""
    until_s: float
    """Predictability limit, s"""
    width: dict[str, Array]
    """(n,) for each quantity in its unit, of the largest difference over bars or joints; NaN where there is no tube"""

    @property
    def name(self) -> str:
        """Request as part of a file's name: ``1e-6``."""
        return f"{self.rtol:g}".replace("e-0", "e-")


def tube(solution: ReferenceSolution, rtol: float) -> Tube:
    """Tube of a case at a requested error.

    Parameters
    ----------
    solution : ReferenceSolution
        Judging solution of the scene, at the samples of the tube.
    rtol : float
    """
    declared = Declared(rtol=rtol)
    errors = WrittenErrors(declared.engine, declared.setting, solution, solution.trajectory)
    itself = RunResult(Outcome.PASS, trajectory=solution.trajectory)
    judged = frozenset(solution.error)
    run = WrittenResiduals(errors, Evidence(itself, itself), judged, whole=True, restarted=False)
    width = {
        name: np.where(run.inside(name) & np.isfinite(margin), margin, np.nan)
        for name, margin in run.margin.items()
        if name in judged
    }
    return Tube(rtol, run.limit_s, width)


def curves(solution: ReferenceSolution, of: Tube) -> dict[str, pd.DataFrame]:
    """Tables ``lower`` and ``upper`` with the columns of the values, rounded outwards; NaN where there is no tube.

    A vector's two columns have the width of its length each: a right answer lies inside both.
    """
    frame, quantity = values(solution), quantities(solution.scene)
    names = [name for name in map(str, frame) if name in quantity]
    width = np.stack([of.width[quantity[name]] for name in names], axis=1)
    found = {"lower": frame.copy(), "upper": frame.copy()}
    found["lower"][names] = np.nextafter(frame[names] - width, -np.inf)
    found["upper"][names] = np.nextafter(frame[names] + width, np.inf)
    return found


def quantities(scene: Scene) -> dict[str, str]:
    """Compared quantity of each column of a scene's table."""
    return {name + channel.ending: channel.name for channel in COMPARED for name in channel.names(scene)}
