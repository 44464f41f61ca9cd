"""Verdicts that a plan requires and that no comparison gave: each lack is a failure of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.judge.verdict import no_verdict
from barchain.solutions.judging import shares_equations
from reports.tables.crossval import ALL_SCENES
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from barchain.crossval.plan import ComparisonPlan, SceneProgress
    from barchain.judge.verdict import Verdict

    Missing = tuple[str, str, Verdict]

ANY_INDEPENDENT = "(any independent engine)"
SEVERAL = 2
"""Scenes of which an engine must support at least one: its failure is then no accident of one scene"""


def required_verdicts(plan: ComparisonPlan, progress: Mapping[str, SceneProgress]) -> Iterator[Missing]:
    """Scene, engine and verdict of each lack; a name in parentheses stands for all scenes or any independent engine.

    Later lacks follow from verdicts on earlier ones, so that each verdict has to be stored before the next is taken.
    """
    yield from pairs_without_verdict(plan, progress)
    yield from scenes_without_independent_pass(plan, progress)
    yield from engines_without_scene(plan, progress)


def pairs_without_verdict(plan: ComparisonPlan, progress: Mapping[str, SceneProgress]) -> Iterator[Missing]:
    """Pairs that were planned and left without a verdict: a fault of barchain's own."""
    for name, own in progress.items():
        if not own.solution_failed:
            for engine in [e for e in plan.engines if e not in own.verdicts]:
                reason = "no verdict was given: a fault of barchain"
                yield name, engine, no_verdict(name, engine, None, Outcome.FAILED, reason)


def scenes_without_independent_pass(plan: ComparisonPlan, progress: Mapping[str, SceneProgress]) -> Iterator[Missing]:
    """Scenes that no engine with independent physics passes: they have not been cross-validated.

    An engine with the equations of the judging solution is not independent of the solution.
    """
    if not plan.need_external:
        return
    for name, own in progress.items():
        passed = [
            e for e, verdict in own.verdicts.items()
            if verdict.outcome is Outcome.PASS and plan.engines[e].external
            and not shares_equations(plan.engines[e], own.source)
        ]  # fmt: skip
        if not own.solution_failed and not passed:
            reason = "no engine with independent physics was compared and passed on this scene"
            yield name, ANY_INDEPENDENT, no_verdict(name, ANY_INDEPENDENT, None, Outcome.NOTHING_COMPARED, reason)


def engines_without_scene(plan: ComparisonPlan, progress: Mapping[str, SceneProgress]) -> Iterator[Missing]:
    """Engines compared on no scene, if they were requested by name or had several scenes to do."""
    scenes = [own for own in progress.values() if not own.solution_failed]
    if not plan.named and len(scenes) < SEVERAL:
        return
    for engine in plan.engines:
        verdicts = [own.verdicts[engine] for own in progress.values() if engine in own.verdicts]
        if verdicts and all(v.outcome in (Outcome.UNSUPPORTED, Outcome.TOO_COARSE) for v in verdicts):
            reasons = "; ".join(dict.fromkeys(row["reason"] for v in verdicts for row in v.rows))
            reason = f"compared on no scene: {reasons}"
            yield ALL_SCENES, engine, no_verdict(ALL_SCENES, engine, None, Outcome.NOTHING_COMPARED, reason)
