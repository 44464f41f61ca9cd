"""Scenes of the physics, each examined by itself: a failure in one leaves the others."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.conform.physics import ask_about_scenes, in_parts, reason_against, stage_checks
from barchain.conform.scenes import STAGES
from barchain.conform.target import examined

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.conform.checks import Check
    from barchain.runs.job import Role, RunResult

EVERY = tuple(scene for scenes in STAGES.values() for scene in scenes)
"""Names of all scenes"""


class ScenesAlone:
    """Checks of an engine in scenes, in any order; runs are made together when the first check is asked for."""

    def __init__(self, given: str) -> None:
        """Take an engine by its name or as ``module:Class``.

        Raises
        ------
        UnknownEngineError
            If no engine has the name.
        """
        self.engine = examined(given)
        self.made: dict[str, dict[Role, RunResult]] | None = None

    def check(self, name: str, wanted: Sequence[str] = EVERY) -> Check:
        """Check of a scene; `wanted` are all that will be asked for."""
        if self.made is None:
            ask_about_scenes(self.engine)
            able = [one for one in dict.fromkeys((*wanted, name)) if reason_against(self.engine, one) is None]
            self.made = in_parts(self.engine, able)
        return next(stage_checks(self.engine, (name,), self.made))
