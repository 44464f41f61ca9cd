"""Method of measurement of a round-off study, in short paragraphs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from reports.chapters.roundoff.words import listed, spelled
from reports.text.record import mapping

if TYPE_CHECKING:
    from collections.abc import Iterator


def notes(record: dict[str, Any]) -> tuple[str, ...]:
    """Paragraphs on the measurement, the fits and the runs."""
    return (*evaluation_notes(record), *fit_notes(), *run_notes(record))


def evaluation_notes(record: dict[str, Any]) -> Iterator[str]:
    """Paragraphs on the exact values, the sources of error, and the ensemble."""
    digits, members = record.get("exact_digits"), record.get("members")
    exact = f"exact numbers ({digits} digits)" if digits else "exact numbers"
    yield (
        f"Each formulation is one code for any arithmetic. The exact values come from the absolute formula in {exact}, "
        "which are free of cancellation. For relative coordinates this is an independent formula."
    )
    yield (
        "Three errors are distinguished. Formula: the formula in its own arithmetic against the exact value of the "
        "same rounded numbers. Input: exact values of rounded against unrounded numbers; no formula avoids this error. "
        "Both: the sum, seen by a user and shown unless stated otherwise."
    )
    if members:
        yield (
            f"Each point is an ensemble of {members} members: the same state at a random longitude, its numbers "
            "perturbed by units in the last place of a double."
        )
    units = [f"{name} {spelled(float(u), 3)}" for name, u in mapping(record.get("unit_roundoff")).items()]
    if units:
        yield f"Unit round-off u: {listed(units)}."


def fit_notes() -> Iterator[str]:
    """Paragraph on the ranges of the fits."""
    yield (
        "Laws are fitted to medians. Errors above 0.1 leave no digit and are excluded. In absolute coordinates two "
        "more ranges are excluded: errors below ten times that of the relative formula in the same state, where "
        "round-off of the joint system contributes; and sizes with u/ε above 0.1, where positions no longer separate "
        "the ends of a bar. A fit needs three points."
    )


def run_notes(record: dict[str, Any]) -> Iterator[str]:
    """Paragraph on whole runs."""
    scene = f" {record['scene']}" if record.get("scene") else ""
    yield (
        f"Runs use the scene{scene} at several sizes. Their reference solution is an integration in long double with "
        "another method, at two steps; an error below ten times the difference of these two is drawn hollow. Second "
        "differences of positions use the step at which their truncation and round-off errors are equal."
    )
