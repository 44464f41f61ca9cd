"""The stored tables of a stability study, from which alone its page is rendered.

A folder ``stability`` inside a result folder holds

``outcomes.csv``
    a row for each scene and engine, columns :data:`OUTCOMES`;
``evidence.csv``
    a row for each of their runs, columns :data:`EVIDENCE`;
``laws.csv``
    how drifts and differences grow with time in long scenes, columns :data:`LAWS`;
``long.csv``
    these drifts and differences over time, columns :data:`SERIES`;
``plain.csv``
    SciPy's solvers at their own default tolerances, columns :data:`PLAIN`;
``run.json``
    what ran where, and the scenes in words;
``trajectories/<scene>/<engine>[.coarse|.finer].parquet``
    one row per sample; ``solution.parquet`` is the reference solution.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import pandas as pd

from reports.tables.files import StudyFiles

if TYPE_CHECKING:
    from pathlib import Path

OUTCOMES = (
    "scene", "engine", "stability", "slow", "reason",
    "quantity", "exponent", "low", "high", "at_end", "expected", "change",
)  # fmt: skip
"""`slow`: it hangs on the machine's speed; the law ``at_end (t/T)^exponent`` of a drift; `expected` and `change` are
empty where nothing is recorded, and where nothing changed"""
EVIDENCE = (
    "scene", "engine", "level", "setting", "run", "reason", "attitude_rad",
    "normalised_error", "normalised_error_of", "bound_used", "bound_of", "limit_s",
    "gap_m", "energy", "angular_momentum", "energy_exponent", "kinetic_ratio", "growth_excess",
    "steps", "mean_step_s", "simulate_s",
)  # fmt: skip
"""`attitude_rad`: largest difference from the reference solution until the predictability limit; `gap_m`, `energy`,
`angular_momentum`: largest drift of the run; `kinetic_ratio`: largest relative kinetic energy over its maximum;
`growth_excess`: growth of an error over the scene's own error amplification"""
LAWS = ("scene", "engine", "level", "setting", "quantity", "exponent", "low", "high", "at_end")
SERIES = ("scene", "engine", "level", "quantity", "t_s", "value")
PLAIN = ("scene", "engine", "run", "reason", "attitude_rad", "judged", "seconds")
WORDS = (
    "scene", "engine", "stability", "reason", "quantity", "expected", "change", "level", "setting", "run",
    "normalised_error_of", "bound_of", "judged",
)  # fmt: skip
TABLES = {"outcomes": OUTCOMES, "evidence": EVIDENCE, "laws": LAWS, "long": SERIES, "plain": PLAIN}
FILES = StudyFiles("stability", TABLES, WORDS, frozenset(TABLES), "run.json")


class Stability(StrEnum):
    """Outcome of an engine in a scene."""

    STABLE = "stable"
    DRIFTING = "drifting"
    INACCURATE = "inaccurate"
    UNSTABLE = "unstable"
    FAILED = "failed"
    REJECTED = "rejected"
    UNSUPPORTED = "unsupported"

    @property
    def advice(self) -> str:
        """Meaning in one sentence."""
        return ADVICE[self]


ADVICE = {
    Stability.STABLE: "Every quantity agrees with the reference solution at the default and at the finer "
    "setting, and every invariant stays within its drift bound.",
    Stability.DRIFTING: "Every quantity agrees point by point, but an invariant exceeds its drift bound.",
    Stability.INACCURATE: "Finite, and wrong: the error of a quantity exceeds the error estimates or the "
    "expected-error bound.",
    Stability.UNSTABLE: "Finite, and blown up: kinetic energy above its maximum, an error that grows faster than the "
    "scene's error amplification, or an error that grows with a finer setting.",
    Stability.FAILED: "An exception, a crash, a time-out, not a number, or another end than the reference solution's.",
    Stability.REJECTED: "The engine rejects the scene with a reason before its first step.",
    Stability.UNSUPPORTED: "The engine does not support an effect of the scene exactly; the pair is skipped.",
}


@dataclass(frozen=True)
class StabilityTables:
    """A stability study's folder, read."""

    folder: Path
    outcomes: pd.DataFrame
    evidence: pd.DataFrame
    laws: pd.DataFrame
    long: pd.DataFrame
    plain: pd.DataFrame
    record: dict[str, Any]

    def trajectory(self, scene: str, name: str) -> pd.DataFrame | None:
        """Samples of one run, or None if it left none."""
        path = self.folder / "trajectories" / scene / f"{name}.parquet"
        return pd.read_parquet(path) if path.is_file() else None


def read_stability(folder: Path) -> StabilityTables:
    """Read the stability study in a result folder.

    Raises
    ------
    FileNotFoundError
        If a table is missing.
    """
    return StabilityTables(FILES.folder(folder), **FILES.read_all(folder), record=FILES.read_record(folder))
