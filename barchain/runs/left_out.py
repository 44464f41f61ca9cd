"""Why an engine is left out of a scene, in every study; engines and points that a study of times skips."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from barchain.runs.asking import declarations_of, engine_fault
from reports.results.outcome import Outcome
from reports.results.rows import NOT_RUN, NotRun, was_run

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping

    from adapters.registry import Registration
    from scenarios import Scene


@dataclass(frozen=True)
class LeftOut:
    """An engine that is skipped on a scene, with the reason."""

    scene: str
    engine: str
    outcome: Outcome
    reason: str


NOT_TRIED = frozenset({Outcome.UNSUPPORTED, Outcome.MISSING, NOT_RUN, *NotRun})
"""Outcomes of points that were not run; the reason is declared, or the limits that the study was given"""


def failures(points: Iterable[Mapping[str, Any]], named: Collection[str] = ()) -> tuple[str, ...]:
    """Failures of a study of times, one line each.

    Parameters
    ----------
    points : iterable of mapping
        Points measured and left out, with ``engine``, ``outcome``, ``reason`` and, of several scenes, ``scene``.
    named : collection of str
        Engines that were asked for by name.

    Returns
    -------
    tuple of str
        Each engine that fails in a scene and passes at none of its points there; each named engine that passes nowhere;
        a study without any passed point. A point that fails beside passed ones is a measured limit of its engine.
    """
    by_engine: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for point in points:
        by_engine.setdefault((str(point.get("scene", "")), str(point["engine"])), []).append(point)
    ran = {engine for (_, engine), own in by_engine.items() if passed(own)}
    lines = []
    for (scene, engine), own in by_engine.items():
        tried = [p for p in own if p["outcome"] not in NOT_TRIED]
        if not passed(own) and (tried or (engine in named and engine not in ran)):
            first = (tried or own)[0]
            lines.append(f"{scene} {engine}: {first['outcome']}: {first.get('reason', '')}".strip())
    return tuple(lines) if lines or ran else ("nothing was measured",)


def said(point: Mapping[str, Any]) -> str:
    """Outcome of a point; of one that was not run with the reason."""
    outcome = str(point["outcome"])
    return outcome if was_run(outcome) else f"{NOT_RUN}: {point['reason']}"


def passed(points: Iterable[Mapping[str, Any]]) -> bool:
    """Whether one of some points passed."""
    return any(p["outcome"] == Outcome.PASS for p in points)


def cannot(scene: Scene, engine: str, registration: Registration) -> LeftOut | None:
    """Reason why an engine is skipped on a scene, or None if it runs."""
    if registration.missing:
        return LeftOut(scene.name, engine, Outcome.MISSING, registration.missing)
    try:
        unsupported = declarations_of(registration).unsupported(scene)
    except Exception as error:
        return LeftOut(scene.name, engine, Outcome.FAILED, engine_fault(error))
    return None if unsupported is None else LeftOut(scene.name, engine, Outcome.UNSUPPORTED, unsupported)
