"""An effect budget from start to table: what the command line and notebooks call."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from barchain.record.environment import provenance
from barchain.record.facts import scene_words
from barchain.solutions.reference import PARTED_RAD
from barchain.studies.effects.budget import EffectsBudget
from barchain.studies.effects.plan import make_plan
from barchain.studies.effects.sensitivity import LOOSER
from barchain.studies.effects.store import EffectsStore
from reports.tables.effects import FOLDER

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from barchain.studies.effects.plan import EffectsPlan
    from scenarios import Scene

__all__ = ["make_plan", "measure"]


def measure(
    plan: EffectsPlan,
    out: Path,
    *,
    command: str = "",
    progress: Callable[[str, str, str], None] | None = None,
    notes: Callable[[str], None] | None = None,
) -> None:
    """Measure what each effect of a scene is worth, and write the table into ``out/effects``.

    Parameters
    ----------
    plan : Plan
        From :func:`make_plan`.
    out : Path
        Result folder; a comparison that is there already is left alone.
    command : str
        What was typed, for the record.
    progress : callable, optional
        Told (scene, run, outcome) after each step.
    notes : callable, optional
        Told what goes on besides, in words.
    """
    store = EffectsStore(out / FOLDER, new_record(plan, command))
    EffectsBudget(plan, store, progress or (lambda *_: None), notes or (lambda _: None)).run()


def new_record(plan: EffectsPlan, command: str) -> dict[str, Any]:
    """record.json before the first run."""
    return provenance(command) | {
        "scene": scene_words(plan.scene) | facts(plan.scene),
        "rtol": plan.rtol,
        "looser": LOOSER,
        "parted_rad": PARTED_RAD,
        "matters": plan.matters,
    }


def facts(scene: Scene) -> dict[str, Any]:
    """What the rule of the advice counts in."""
    return {
        "name": scene.name,
        "gravity": str(scene.effects.gravity),
        "bound": scene.bound,
        "period_s": scene.period_s,
        "radius0_m": scene.radius0_m,
    }
