"""The ensemble study: many perturbed copies of a scene, and quantiles of attitude and reactions over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from barchain.runs.executors import DaskCluster
from barchain.runs.facts import scene_facts
from barchain.studies.ensemble.bins import DIGITS, PILOT_RUNS
from barchain.studies.ensemble.execution import EnsembleSummary, run_ensemble
from barchain.studies.ensemble.kept_parts import KEY, StoredParts, plan_key
from barchain.studies.ensemble.plan import make_plan
from reports.tables.ensemble import FILES

if TYPE_CHECKING:
    from barchain.record.study_store import StudyStore
    from barchain.studies.ensemble.plan import EnsembleOptions, EnsemblePlan
    from barchain.studies.study import Reporter
    from reports.tables.files import StudyFiles


@dataclass(frozen=True)
class EnsembleStudy:
    """The ensemble study."""

    files: ClassVar[StudyFiles] = FILES

    def plan(self, options: EnsembleOptions) -> EnsemblePlan:
        """Scene and variations, checked.

        Raises
        ------
        SceneError, VariationError, ClusterError
            For options that can't be met.
        """
        return make_plan(options)

    def record(self, plan: EnsemblePlan) -> dict[str, Any]:
        """Scene, distributions and settings; outcomes and times are added at the end."""
        return {
            "scene": {"name": plan.scene.name} | scene_facts(plan.scene),
            "vary": [v.text for v in plan.variations],
            "runs": plan.runs,
            "rtol": plan.rtol,
            "seed": plan.seed,
            "estimated": None if plan.exact else {"relative_error": 2.0**-DIGITS, "pilot_runs": PILOT_RUNS},
            "dask": isinstance(plan.executor, DaskCluster),
            KEY: plan_key(plan),
        }

    def run(self, plan: EnsemblePlan, store: StudyStore, reporter: Reporter) -> EnsembleSummary:
        """Draw, run and reduce the copies.

        Raises
        ------
        ClusterLostError
            If the plan's cluster fails; parts so far are in the folder.
        """
        kept = StoredParts(plan, store)
        with reporter.counted("runs", plan.runs) as done:
            result = run_ensemble(plan, kept, done)
        store.write("quantiles", result.quantiles)
        store.write_text("runs", kept.run_text())
        store.record["outcomes"] = dict(result.tally.outcomes.most_common())
        store.record["evaluations"] = result.tally.evaluations
        store.record["phases_s"] = result.seconds
        kept.remove()
        return result
