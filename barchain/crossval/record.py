"""Record of a comparison, record.json: scenes, engines, environment, misprints of the paper and tolerances."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from barchain.crossval.external_coverage import external_coverage
from barchain.crossval.methodology import limitations, misprints, tolerance_rows
from barchain.record.environment import provenance
from barchain.runs.facts import engine_facts, scene_facts

if TYPE_CHECKING:
    from barchain.crossval.plan import ComparisonPlan


def new_record(plan: ComparisonPlan, command: str) -> dict[str, Any]:
    """Contents of record.json before the first run."""
    return provenance(command) | {
        "engines": {name: engine_facts(r) for name, r in plan.engines.items()},
        "scenes": {
            scene.name: scene_facts(scene) | {"external_coverage": external_coverage(scene, plan.engines)}
            for scene in plan.scenes
        },
        "runs": [],
        "misprints": misprints(),
        "tolerances": tolerance_rows(),
        "limitations": limitations(),
    }
