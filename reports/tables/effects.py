"""The stored tables of an effect budget, from which alone its page is rendered.

A folder ``effects`` inside a result folder holds

``effects.csv``
    one row for each effect, columns :data:`COLUMNS`, SI units; an empty cell is what there is not, or was not measured;
``record.json``
    the scene, the rule of the advice, and what ran where.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

SIZES = ("between", "torque", "common")
"""Of an effect's push: differences between bars over the tide's, torque over 3 n² J, what is common over g"""
QUANTITIES = ("com", "attitude", "reaction")
COLUMNS = (
    "effect", "title", "kind", "on", "said", "reason", "caveat", "engine",
    *(f"{name}_{when}" for when in ("start", "largest") for name in SIZES),
    "com_m", "com_noise_m", "attitude_rad", "attitude_noise_rad", "reaction_N", "reaction_noise_N",
    "compared_s", "ended",
    "time_ratio", "time_ratio_low", "time_ratio_high", "rounds",
    "evaluation_ratio", "evaluation_ratio_low", "evaluation_ratio_high", "evaluations_ratio",
    "seconds", "evaluation_s", "evaluations",
)  # fmt: skip
WORDS = ("effect", "title", "kind", "said", "reason", "caveat", "engine", "ended")
FILES = StudyFiles("effects", {"effects": COLUMNS}, WORDS)
UNITS = {"com": "m", "attitude": "rad", "reaction": "N"}


class EffectKind(StrEnum):
    """Class of an effect: a model of gravity, a natural effect, or part of the design."""

    GRAVITY = "gravity"
    """Another model of gravity, instead of the scene's"""
    NATURE = "nature"
    """There whether one calls for it or not"""
    DESIGN = "design"
    """Chosen by whoever builds and flies the chain"""


@dataclass(frozen=True)
class EffectsTables:
    """An effect budget's folder, read."""

    effects: pd.DataFrame
    record: dict[str, Any]


def read_effects(folder: Path) -> EffectsTables:
    """Read the effect budget in a result folder.

    Raises
    ------
    FileNotFoundError
        If a table is missing.
    """
    return EffectsTables(FILES.read(folder, "effects"), FILES.read_record(folder))
