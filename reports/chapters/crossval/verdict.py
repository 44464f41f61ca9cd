"""Verdict of a cross-validation in words, from the numbers of the metrics table alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from reports.tables.outcome import Outcome
from reports.text.numerals import significant
from reports.text.words import joined
from scenarios.plural import plural

if TYPE_CHECKING:
    from reports.chapters.crossval.summary import QuantityRow, RunCell, Summary
    from reports.text.record import SceneRecord

MOST_NAMED = 3  # scenes in the headline; the sentences below it name all


@dataclass(frozen=True)
class CrossvalVerdict:
    """Verdict at the top of a report."""

    good: bool
    headline: str
    sentences: tuple[str, ...]
    failures: tuple[RunCell, ...]


def summary_verdict(summary: Summary) -> CrossvalVerdict:
    """Verdict of a summary."""
    failed = tuple(c for c in summary.all if not c.outcome.ok)
    failures = (*summary.unsolved, *failed)
    holes, unchecked = [], []  # of an unfinished run, whose engines may not have run yet
    if summary.finished:
        holes = scenes_without_comparison(summary)
        unchecked = [s for s in scenes_without_external(summary) if s not in holes]
    gaps = [unsolved_words(summary), gap_words(holes, unchecked, len(summary.scenes)), idle_words(summary)]
    gaps = [words for words in gaps if words]
    good = not failures and not gaps and summary.finished and bool(summary.with_outcome(Outcome.PASS))
    sentences = [
        counts(summary, failed),
        worst(summary),
        *(f"{c.engine} was {c.reason}." for c in summary.idle),
        f"No engine was compared on {', '.join(holes)}." if holes else "",
        f"No independent engine passed on {named(unchecked, len(summary.scenes))}." if unchecked else "",
    ]
    return CrossvalVerdict(good, headline(summary, failed, gaps), tuple(s for s in sentences if s), failures)


def unsolved_words(summary: Summary) -> str:
    """Clause on scenes without a judging solution; empty without any."""
    found = [c.scene for c in summary.unsolved]
    return f"the judging solution of {listed(found)} could not be run" if found else ""


def idle_words(summary: Summary) -> str:
    """Clause on engines compared on no scene, though they should have been; empty without any."""
    found = [c.engine for c in summary.idle]
    return f"{joined(found)} {'was' if len(found) == 1 else 'were'} compared on no scene" if found else ""


def gap_words(holes: list[str], unchecked: list[str], of: int) -> str:
    """Clause on scenes compared in no engine, or else passed in no independent one; empty without any."""
    if holes:
        return f"{listed(holes)} {'was' if len(holes) == 1 else 'were'} compared in no engine"
    if len(unchecked) == of > 1:
        return f"none of the {of} scenes passed in an independent engine"
    return f"{listed(unchecked)} passed in no independent engine" if unchecked else ""


def listed(scenes: list[str]) -> str:
    """``scene a``, ``2 scenes (a, b)``, ``7 scenes (a, b, c and 4 more)``."""
    if len(scenes) == 1:
        return f"scene {scenes[0]}"
    more = len(scenes) - MOST_NAMED
    return f"{len(scenes)} scenes ({', '.join(scenes[:MOST_NAMED])}{f' and {more} more' if more > 0 else ''})"


def headline(summary: Summary, failed: tuple[RunCell, ...], gaps: list[str]) -> str:
    """Verdict in one line, from failed comparisons and from clauses on other gaps."""
    judged = [c for c in summary.all if c.outcome.judged]
    unsolved = unsolved_words(summary)
    if not judged:
        return f"{unsolved[0].upper()}{unsolved[1:]}." if unsolved else "Nothing was compared."
    so_far = "" if summary.finished else " so far"
    if failed:
        also = f", and {unsolved}" if unsolved else ""
        return f"{len(failed)} of {plural(len(judged), 'comparison')} failed{so_far}{also}."
    but = f", but {' and '.join(gaps)}" if gaps else ""
    if len(judged) == 1:
        return f"The one comparison passed{so_far}{but}."
    return f"All {plural(len(judged), 'comparison')} passed{so_far}{but}."


def counts(summary: Summary, failures: tuple[RunCell, ...]) -> str:
    """Numbers of pairs by outcome."""
    passed, left_out = summary.with_outcome(Outcome.PASS), summary.with_outcome(Outcome.UNSUPPORTED)
    reported = summary.with_outcome(Outcome.REPORTED)
    cells = len(summary.scenes) * len(summary.engines)
    parts = [
        f"{len(passed)} passed" + (independent_words(summary, passed) if summary.outside_known and passed else ""),
        f"{len(failures)} failed",
        f"{len(left_out)} {be(left_out)} unsupported",
    ]
    coarse = summary.with_outcome(Outcome.TOO_COARSE)
    parts += [f"{len(coarse)} too coarse to be judged"] if coarse else []
    parts += [f"{len(reported)} {be(reported)} reported without a criterion"] if reported else []
    not_run = cells - len(summary.all)
    parts += [f"{not_run} {'was' if not_run == 1 else 'were'} not run"] if not_run else []
    scenes, engines = plural(len(summary.scenes), "scene"), plural(len(summary.engines), "engine")
    return f"Of {scenes} times {engines} ({plural(cells, 'pair')}), {', '.join(parts[:-1])} and {parts[-1]}."


def independent_words(summary: Summary, passed: list[RunCell]) -> str:
    """Share of independent engines in the passes; those that share the judging solution's equations are told apart."""
    outside = [c for c in passed if summary.external(c.engine)]
    shared = sum(summary.shares_equations(c) for c in outside)
    also = f", {shared} of these on the judging solution's equations" if shared else ""
    return f" ({len(outside)} of them with independent engines{also})"


def worst(summary: Summary) -> str:
    """Sentence on the largest normalised error of all comparisons."""
    rated = [(c, r) for c in summary.all if (r := c.worst_ratio)]
    if not rated:
        return ""
    cell, row = max(rated, key=lambda pair: pair[1].ratio or 0.0)
    if (row.ratio or 0.0) > 1.0:
        return f"{normalised_error_words(cell, row)}: a difference above 1 is unexplained."
    return f"{normalised_error_words(cell, row)}."


def normalised_error_words(cell: RunCell, row: QuantityRow) -> str:
    """``The largest normalised error is 0.83 (attitude, exudyn on paper/fig05)``."""
    return f"The largest normalised error is {significant(row.ratio)} ({row.name}, {cell.engine} on {cell.scene})"


def solved(summary: Summary) -> list[SceneRecord]:
    """Scenes with a judging solution."""
    without = {c.scene for c in summary.unsolved}
    return [s for s in summary.scenes if s.name not in without]


def scenes_without_comparison(summary: Summary) -> list[str]:
    """Scenes on which no engine was compared."""
    return [
        s.name
        for s in solved(summary)
        if summary.of_scene(s.name) and not any(c.outcome is not Outcome.UNSUPPORTED for c in summary.of_scene(s.name))
    ]


def scenes_without_external(summary: Summary) -> list[str]:
    """Scenes that passed in no independent engine.

    Where the record does not tell which engines are independent, the scenes of which the tables say so.
    """
    return [
        s.name
        for s in solved(summary)
        if summary.of_scene(s.name)
        and not any(c.outcome is Outcome.PASS and summary.external(c.engine) for c in summary.of_scene(s.name))
        and (summary.outside_known or any(not c.outcome.ok for c in summary.of_several(s.name)))
    ]


def named(scenes: list[str], of: int) -> str:
    """Names of some scenes; ``any scene`` for all of several."""
    return "any scene" if len(scenes) == of > 1 else ", ".join(scenes)


def failure_words(cell: RunCell) -> str:
    """Reason of a failed run from its rows: as stored, or the numbers."""
    if cell.reason:
        return cell.reason
    row = next((r for r in cell.rows if r.outcome is cell.outcome), None)
    if row is None:
        return cell.outcome.advice
    if cell.outcome is Outcome.INCONSISTENT and row.ratio is not None:
        return f"{row.name}: normalised error {significant(row.ratio)}"
    if cell.outcome is Outcome.EXCEEDS_BOUND and row.bound is not None:
        return f"{row.name}: {significant(row.largest)} {row.unit_words}, bound {significant(row.bound)}"
    return cell.outcome.advice


def be(cells: list[RunCell]) -> str:
    """``is`` or ``are``."""
    return "is" if len(cells) == 1 else "are"
