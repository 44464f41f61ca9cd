"""Reasons why no independent engine ran a scene, and the evidence that remains."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.tables.outcome import Outcome
from reports.text.numerals import number
from reports.text.record import mapping
from reports.text.words import joined

if TYPE_CHECKING:
    from reports.chapters.crossval.summary import Summary
    from reports.text.record import SceneRecord

ONLY_OWN = "Of the selected engines only those built on barchain\N{RIGHT SINGLE QUOTATION MARK}s equations support"
LACKING = f"{ONLY_OWN} the effects."
STOPPED = "Instants of this scene, not its effects, prevent independent engines from running it."
UNABLE = f"{ONLY_OWN} this scene."
MOST_TIMES = 4  # named of many
ONE_DERIVATION = "The agreeing runs share one derivation of the equations"


def coverage_words(summary: Summary, scene: SceneRecord) -> tuple[str, str] | None:
    """Headline, empty where an independent engine ran, and details; None where there are no details."""
    outside = [c for c in summary.of_scene(scene.name) if summary.external(c.engine)]
    known = mapping(scene.data.get("external_coverage"))
    instants = mapping(known.get("instants"))
    lack = mapping(known.get("lack"))
    if not outside or any(c.outcome is not Outcome.UNSUPPORTED for c in outside):
        return ("", instant_words(instants)) if instants else None
    lacking = bool(known) and all(c.engine in lack for c in outside)
    headline = STOPPED if instants else LACKING if lacking else UNABLE
    said = [
        instant_words(instants),
        not_asked_words(known.get("not_requested")),
        not_installed_words(known.get("not_installed")),
        not_loaded_words(mapping(known.get("not_loaded"))),
        solution_words(known),
    ]
    return headline, " ".join(s for s in said if s)


def instant_words(instants: dict[str, object]) -> str:
    """Engines stopped by instants between their steps, and a run that avoids this; empty without any."""
    engines, at = instants.get("engines"), instants.get("at_s")
    if not isinstance(engines, list) or not isinstance(at, list):
        return ""
    one, run = len(engines) == 1, mapping(instants.get("run"))
    times = ", ".join(f"{t:g}" for t in at[:MOST_TIMES]) + ("" if len(at) <= MOST_TIMES else ", ...")
    duration, samples = number(run.get("duration_s")), number(run.get("samples"))
    does = "supports the effects and takes" if one else "support the effects and take"
    said = (
        f"{joined(engines)} {does} equal steps. A load is discontinuous at t = {times} s, which is neither a sample "
        "nor the middle between two samples."
    )
    if duration is None or samples is None:
        return f"{said} Move these instants, or use more samples."
    return f"{said} With duration_s = {duration!r} and samples = {samples:.0f} in [run] each instant is."


def not_asked_words(names: object) -> str:
    """Independent engines that support the scene and were not selected."""
    if not isinstance(names, list) or not names:
        return ""
    verbs = ("supports", "was") if len(names) == 1 else ("support", "were")
    return f"{joined(names)} {verbs[0]} the scene and {verbs[1]} not selected."


def not_installed_words(names: object) -> str:
    """Independent engines that support the scene and whose libraries are not installed."""
    if not isinstance(names, list) or not names:
        return ""
    verbs = ("supports", "is") if len(names) == 1 else ("support", "are")
    return f"{joined(names)} {verbs[0]} the scene and {verbs[1]} not installed (barchain engines --missing)."


def not_loaded_words(messages: dict[str, object]) -> str:
    """Independent engines whose adapters do not load, with their messages; empty without any."""
    return " ".join(f"The adapter of {name} does not load ({said})." for name, said in messages.items())


def solution_words(known: dict[str, object]) -> str:
    """Evidence from runs that share one derivation."""
    solution = str(known.get("solution") or "")
    if not solution:
        return f"{ONE_DERIVATION}."
    return (
        f"{ONE_DERIVATION}. An independent derivation, computed with heyoka, is stored as a certified solution of "
        f"these physics ({solution})."
    )
