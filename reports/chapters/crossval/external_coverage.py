"""Why a scene was run in no engine of somebody else's, and what its agreement is then worth."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.tables.outcome import Outcome
from reports.text.numerals import number
from reports.text.record import mapping
from reports.text.words import joined

if TYPE_CHECKING:
    from reports.chapters.crossval.summary import Summary
    from reports.text.record import SceneRecord

LACKING = "No engine asked but our own carries this scene\N{RIGHT SINGLE QUOTATION MARK}s effects."
STOPPED = "This scene\N{RIGHT SINGLE QUOTATION MARK}s instants, not its effects, keep other engines from it."
UNABLE = "No engine asked but our own can do this scene."
MOST_TIMES = 4  # named of many
ONE_DERIVATION = "What agrees here is one derivation in several forms"


def carrier_words(summary: Summary, scene: SceneRecord) -> tuple[str, str] | None:
    """Headline, empty where an engine of somebody else's was run, and what follows it; None where nothing does."""
    outside = [c for c in summary.of_scene(scene.name) if summary.external(c.engine)]
    known = mapping(scene.data.get("external_coverage"))
    instants = mapping(known.get("instants"))
    lack = mapping(known.get("lack"))
    if not outside or any(c.outcome is not Outcome.UNSUPPORTED for c in outside):
        return ("", instant_words(instants)) if instants else None
    lacking = bool(known) and all(c.engine in lack for c in outside)
    headline = STOPPED if instants else LACKING if lacking else UNABLE
    said = [instant_words(instants), not_asked_words(known.get("not_requested")), solution_words(known)]
    return headline, " ".join(s for s in said if s)


def instant_words(instants: dict[str, object]) -> str:
    """Who was stopped by what, and which run would let them go on; empty where that is not so."""
    engines, at = instants.get("engines"), instants.get("at_s")
    if not isinstance(engines, list) or not isinstance(at, list):
        return ""
    one, run = len(engines) == 1, mapping(instants.get("run"))
    times = ", ".join(f"{t:g}" for t in at[:MOST_TIMES]) + ("" if len(at) <= MOST_TIMES else ", ...")
    duration, samples = number(run.get("duration_s")), number(run.get("samples"))
    does = "carries the effects and takes" if one else "carry the effects and take"
    said = (
        f"{joined(engines)} {does} equal steps; something jumps at t = {times} s, which is neither a sample nor midway "
        "between two"
    )
    if duration is None or samples is None:
        return f"{said}: move these instants, or take more samples."
    return f"{said}: with duration_s = {duration!r} and samples = {samples:.0f} in [run] each is."


def not_asked_words(names: object) -> str:
    """Who else could have been asked."""
    if not isinstance(names, list) or not names:
        return ""
    return f"{joined(names)} can do it and {'was' if len(names) == 1 else 'were'} not asked."


def solution_words(known: dict[str, object]) -> str:
    """What the agreement of our own forms is worth."""
    solution = str(known.get("solution") or "")
    if not solution:
        return f"{ONE_DERIVATION}."
    return (
        f"{ONE_DERIVATION}; an independent one, heyoka\N{RIGHT SINGLE QUOTATION MARK}s, is committed as the truth of "
        f"these physics ({solution}), and barchain\N{RIGHT SINGLE QUOTATION MARK}s tests hold the reference to it."
    )
