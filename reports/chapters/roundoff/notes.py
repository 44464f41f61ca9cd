"""How a round-off study was measured, in short paragraphs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from reports.chapters.roundoff.words import listed, spelled
from reports.text.record import mapping

if TYPE_CHECKING:
    from collections.abc import Iterator


def notes(record: dict[str, Any]) -> tuple[str, ...]:
    """One paragraph for each thing that a reader must know to judge the numbers."""
    return (*evaluation_notes(record), *fit_notes(), *run_notes(record))


def evaluation_notes(record: dict[str, Any]) -> Iterator[str]:
    """The judge, the sources of error, the ensemble."""
    digits, members = record.get("exact_digits"), record.get("members")
    exact = f"exact numbers ({digits} digits)" if digits else "exact numbers"
    yield (
        f"Each formulation is one code for any arithmetic. Its judge is the absolute formula in {exact}, which feel no "
        "cancellation; for relative coordinates that is another formula besides."
    )
    yield (
        "Three errors are told apart. The formula’s: the same rounded numbers are given to the formula in its own "
        "arithmetic and to the judge. The input’s: the judge is given rounded and unrounded numbers; that is lost "
        "whatever the formula. And both together, which is what a user sees and what is shown unless said."
    )
    if members:
        yield (
            f"Each point is an ensemble of {members}: the same state turned by a random longitude, which no reaction "
            "knows of, and its numbers off by a unit in the last place of a double here and there."
        )
    units = [f"{name} {spelled(float(u), 3)}" for name, u in mapping(record.get("unit_roundoff")).items()]
    if units:
        yield f"Unit round-off u: {listed(units)}."


def fit_notes() -> Iterator[str]:
    """Ranges of the fits."""
    yield (
        "Laws are fitted to medians between two ends: errors above a tenth leave no digit and are left out, and, in "
        "absolute coordinates, so are errors below ten times what the relative formula leaves in the same state, where "
        "the joint system’s own round-off begins to tell, and sizes at which u over ε exceeds a tenth, where places no "
        "longer tell a bar’s ends apart. Fewer than three points make no line."
    )


def run_notes(record: dict[str, Any]) -> Iterator[str]:
    """Whole runs."""
    scene = f" {record['scene']}" if record.get("scene") else ""
    yield (
        f"Runs are of the scene{scene} at several sizes, judged by an integration in long double with a method that "
        "nothing else here uses, at two steps; an error below ten times what these two differ by is drawn hollow. "
        "Positions are read off differenced at the step at which truncation and round-off of a second difference are "
        "alike."
    )
