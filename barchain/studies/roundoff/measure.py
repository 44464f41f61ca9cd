"""A round-off study from start to tables: what the command line and notebooks call."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from barchain.record.environment import package_version, provenance
from barchain.studies.roundoff.formulations.states import MEMBERS
from barchain.studies.roundoff.objects import objects
from barchain.studies.roundoff.plan import SCENE
from barchain.studies.roundoff.store import RoundoffStore
from barchain.studies.roundoff.study import RoundoffStudy
from reference_impl.precision.arithmetic import ARITHMETICS, EXACT_DIGITS, long_doubles
from reports.tables.roundoff import FOLDER

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from barchain.studies.roundoff.plan import RoundoffPlan


def measure(
    plan: RoundoffPlan,
    out: Path,
    *,
    command: str = "",
    workers: int | None = None,
    progress: Callable[[str, str, str], None] | None = None,
) -> None:
    """Measure what coordinates cost in digits, and write the tables into ``out/roundoff``.

    Parameters
    ----------
    plan : Plan
        From :func:`barchain.studies.roundoff.plan.make_plan`.
    out : Path
        Result folder; a comparison that is there already is left alone.
    command : str
        What was typed, for the record.
    workers : int, optional
        Processes side by side; all cores by default.
    progress : callable, optional
        Told (table, task, outcome) after each task.
    """
    store = RoundoffStore(out / FOLDER, new_record(plan, command), plan.parts)
    RoundoffStudy(plan, store, progress or (lambda *_: None), workers).run()


def new_record(plan: RoundoffPlan, command: str) -> dict[str, Any]:
    """record.json before the first task."""
    return provenance(command, {"gmpy2": package_version("gmpy2")}) | {
        "full": plan.full,
        "parts": list(plan.parts),
        "scene": SCENE,
        "members": MEMBERS,
        "exact_digits": EXACT_DIGITS,
        "unit_roundoff": {name: a.unit_roundoff for name, a in ARITHMETICS.items()},
        "long_doubles": long_doubles(),
        "objects": objects(),
        "failed": [],
    }
