"""What run.json says: scenes, engines, environment, and what is known of the paper and of the tolerances."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from barchain.crossval.external_coverage import carriers
from barchain.crossval.methodology import limitations, misprints, tolerances
from barchain.record.environment import provenance
from barchain.record.facts import engine_facts, scene_facts

if TYPE_CHECKING:
    from barchain.crossval.suite import Plan


def new_record(plan: Plan, command: str) -> dict[str, Any]:
    """run.json before the first run."""
    return provenance(command) | {
        "engines": {name: engine_facts(r) for name, r in plan.engines.items()},
        "scenes": {
            scene.name: scene_facts(scene) | {"carriers": carriers(scene, plan.engines)} for scene in plan.scenes
        },
        "runs": [],
        "misprints": misprints(),
        "tolerances": tolerances(),
        "limitations": limitations(),
    }
