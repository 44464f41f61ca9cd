"""The verdict in words, made from the numbers of the table and from nothing else."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from reports.tables.outcome import Outcome
from reports.text.numerals import significant
from reports.text.words import joined

if TYPE_CHECKING:
    from reports.chapters.crossval.summary import QuantityRow, RunCell, Summary
    from reports.text.record import SceneRecord

MOST_NAMED = 3  # scenes in the headline; the sentences below it name all
ALLOWED = (Outcome.PASS, Outcome.REPORTED, Outcome.UNSUPPORTED)


@dataclass(frozen=True)
class CrossvalVerdict:
    """What stands at the top of a report."""

    good: bool
    headline: str
    sentences: tuple[str, ...]
    failures: tuple[RunCell, ...]


def judge(summary: Summary) -> CrossvalVerdict:
    """Put the summary into words."""
    failed = tuple(c for c in summary.all if not c.outcome.ok)
    failures = (*summary.unsolved, *failed)
    holes = scenes_without_comparison(summary)
    unchecked = [s for s in scenes_without_external(summary) if s not in holes]
    spoilt = [unsolved_words(summary), spoilt_words(holes, unchecked, len(summary.scenes)), idle_words(summary)]
    spoilt = [words for words in spoilt if words]
    good = not failures and not spoilt and summary.finished and bool(summary.with_outcome(Outcome.PASS))
    sentences = [
        counts(summary, failed),
        worst(summary),
        *(f"{c.engine} was {c.reason}." for c in summary.idle),
        f"No engine was compared on {', '.join(holes)}." if holes else "",
        f"No external engine passed on {named(unchecked, len(summary.scenes))}." if unchecked else "",
    ]
    return CrossvalVerdict(good, headline(summary, failed, spoilt), tuple(s for s in sentences if s), failures)


def unsolved_words(summary: Summary) -> str:
    """Which scenes have no reference solution; empty if all have one."""
    found = [c.scene for c in summary.unsolved]
    return f"the reference solution of {listed(found)} could not be run" if found else ""


def idle_words(summary: Summary) -> str:
    """Which engines were compared on no scene, though they should have been; empty if none."""
    found = [c.engine for c in summary.idle]
    return f"{joined(found)} {'was' if len(found) == 1 else 'were'} compared on no scene" if found else ""


def spoilt_words(holes: list[str], unchecked: list[str], of: int) -> str:
    """Which scenes were compared in no engine, or else passed in no external one; empty if none."""
    if holes:
        return f"{listed(holes)} {'was' if len(holes) == 1 else 'were'} compared in no engine"
    if len(unchecked) == of > 1:
        return f"none of the {of} scenes passed in an external engine"
    return f"{listed(unchecked)} passed in no external engine" if unchecked else ""


def listed(scenes: list[str]) -> str:
    """``scene a``, ``2 scenes (a, b)``, ``7 scenes (a, b, c and 4 more)``."""
    if len(scenes) == 1:
        return f"scene {scenes[0]}"
    more = len(scenes) - MOST_NAMED
    return f"{len(scenes)} scenes ({', '.join(scenes[:MOST_NAMED])}{f' and {more} more' if more > 0 else ''})"


def headline(summary: Summary, failed: tuple[RunCell, ...], spoilt: list[str]) -> str:
    """One line that can be read alone; `failed` are comparisons, `spoilt` what else is no success, in words."""
    judged = [c for c in summary.all if c.outcome not in (Outcome.REPORTED, Outcome.UNSUPPORTED)]
    unsolved = unsolved_words(summary)
    if not judged:
        return f"{unsolved[0].upper()}{unsolved[1:]}." if unsolved else "Nothing was compared."
    so_far = "" if summary.finished else " so far"
    if failed:
        also = f", and {unsolved}" if unsolved else ""
        return f"{len(failed)} of {count(len(judged), 'comparison')} failed{so_far}{also}."
    but = f", but {' and '.join(spoilt)}" if spoilt else ""
    if len(judged) == 1:
        return f"The one comparison passed{so_far}{but}."
    return f"All {count(len(judged), 'comparison')} passed{so_far}{but}."


def counts(summary: Summary, failures: tuple[RunCell, ...]) -> str:
    """How many runs there were, and how they ended."""
    passed, left_out = summary.with_outcome(Outcome.PASS), summary.with_outcome(Outcome.UNSUPPORTED)
    reported = summary.with_outcome(Outcome.REPORTED)
    cells = len(summary.scenes) * len(summary.engines)
    outside = sum(summary.external(c.engine) for c in passed)
    parts = [
        f"{len(passed)} passed"
        + (f" ({outside} of them with external engines)" if summary.outside_known and passed else ""),
        f"{len(failures)} failed",
        f"{len(left_out)} {be(left_out)} unsupported",
    ]
    parts += [f"{len(reported)} {be(reported)} reported without being judged"] if reported else []
    not_run = cells - len(summary.all)
    parts += [f"{not_run} {'was' if not_run == 1 else 'were'} not run"] if not_run else []
    scenes, engines = count(len(summary.scenes), "scene"), count(len(summary.engines), "engine")
    return f"Of {scenes} times {engines} ({count(cells, 'run')}), {', '.join(parts[:-1])} and {parts[-1]}."


def worst(summary: Summary) -> str:
    """Largest ratio of a difference to what is explained, among the comparisons that passed and in all."""
    rated = [(c, r) for c in summary.all if (r := c.worst_ratio)]
    if not rated:
        return ""
    cell, row = max(rated, key=lambda pair: pair[1].ratio or 0.0)
    if (row.ratio or 0.0) > 1.0:
        return f"The worst difference is {ratio_words(cell, row)}: more than 1 is not explained."
    return f"The largest difference is {ratio_words(cell, row)}."


def ratio_words(cell: RunCell, row: QuantityRow) -> str:
    """``0.83 of what the errors ... explain (attitude, exudyn on paper/fig05)``."""
    times = significant(row.ratio)
    return f"{times} times what the errors of both sides explain ({row.name}, {cell.engine} on {cell.scene})"


def solved(summary: Summary) -> list[SceneRecord]:
    """Scenes that have a reference solution to compare with."""
    without = {c.scene for c in summary.unsolved}
    return [s for s in summary.scenes if s.name not in without]


def scenes_without_comparison(summary: Summary) -> list[str]:
    """Scenes that no engine was compared on: a hole in the suite."""
    return [
        s.name
        for s in solved(summary)
        if summary.of_scene(s.name) and not any(c.outcome is not Outcome.UNSUPPORTED for c in summary.of_scene(s.name))
    ]


def scenes_without_external(summary: Summary) -> list[str]:
    """Scenes that passed in no engine of somebody else: they were only checked against ourselves.

    Where the record does not tell whose work the engines are, those of which the tables say so.
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
    """Why a run failed, from its rows: the reason stored, or the numbers."""
    if cell.reason:
        return cell.reason
    row = next((r for r in cell.rows if r.outcome is cell.outcome), None)
    if row is None:
        return cell.outcome.advice
    if cell.outcome is Outcome.INCONSISTENT and row.ratio is not None:
        return f"{row.name}: {significant(row.ratio)} times what is explained"
    if cell.outcome is Outcome.EXCEEDS_BOUND and row.bound is not None:
        return f"{row.name}: {significant(row.largest)} {row.unit}, allowed {significant(row.bound)} {row.unit}"
    return cell.outcome.advice


def count(n: int, noun: str) -> str:
    """``1 scene``, ``2 scenes``."""
    return f"{n} {noun}{'' if n == 1 else 's'}"


def be(cells: list[RunCell]) -> str:
    """``is`` or ``are``."""
    return "is" if len(cells) == 1 else "are"
