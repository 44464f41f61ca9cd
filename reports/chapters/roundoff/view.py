"""View of a round-off study."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.roundoff.charts import evaluation_panels, further_panels
from reports.chapters.roundoff.engine_charts import engine_panels, library_panels
from reports.chapters.roundoff.longitudes import SIGNIFICANT, longitude_rows
from reports.chapters.roundoff.rows import (
    best_law_rows,
    digit_columns,
    digit_rows,
    engine_rows,
    growth_rows,
    law_rows,
    stops,
    time_rows,
)  # fmt: skip
from reports.chapters.roundoff.run_charts import best_panels, growth_panels, run_panels
from reports.chapters.roundoff.series import DOUBLE, SINGLE, RoundoffData
from reports.chapters.roundoff.words import length, spelled
from reports.tables.roundoff import read_roundoff
from reports.text.record import is_complete, mapping, rows

if TYPE_CHECKING:
    from pathlib import Path

    from reports.chapters.roundoff.longitudes import LongitudeRow
    from reports.chapters.roundoff.rows import DigitRow, LawRow
    from reports.plotting.panels import Panel

FIRST, FURTHER = ("attitude", "reaction"), ("gap", "com")


@dataclass(frozen=True)
class Section:
    """Charts of one kind: open ones and folded ones."""

    title: str
    text: str
    panels: tuple[Panel, ...]
    folded: tuple[Panel, ...]
    summary: str


@dataclass(frozen=True)
class RoundoffView:
    """Contents of the chapter."""

    record: dict[str, Any]
    sizes: tuple[str, ...]
    """Lengths of the shortest and the longest bar; empty where they are not known"""
    digit_columns: tuple[str, ...]
    digits: tuple[DigitRow, ...]
    sections: tuple[Section, ...]
    laws: tuple[LawRow, ...]
    further_laws: tuple[LawRow, ...]
    best_laws: tuple[LawRow, ...]
    growths: tuple[LawRow, ...]
    engines: tuple[LawRow, ...]
    stops: tuple[tuple[str, str, str, str], ...]
    longitudes: tuple[LongitudeRow, ...]
    times: tuple[tuple[str, ...], ...]

    @property
    def finished(self) -> bool:
        """Whether the study was finished."""
        return is_complete(self.record)

    @property
    def fitted(self) -> int:
        """Number of exponents fitted to errors of one evaluation."""
        return sum(r.fit.exponent is not None for r in (*self.laws, *self.further_laws))

    @property
    def off(self) -> int:
        """Number of fitted exponents that disagree with the expected value."""
        return sum(r.fit.off for r in (*self.laws, *self.further_laws))

    @property
    def by_longitude(self) -> list[tuple[int, int, float]]:
        """Of errors of formulas, then of input: tests that differ, all tests, and those expected by chance."""
        found = [[r for r in self.longitudes if r.of_input is of_input] for of_input in (False, True)]
        return [(sum(r.differs for r in own), len(own), SIGNIFICANT * len(own)) for own in found]

    @property
    def units(self) -> list[tuple[str, str]]:
        """Unit round-off of each arithmetic."""
        return [(name, spelled(float(u), 3)) for name, u in mapping(self.record.get("unit_roundoff")).items()]

    @property
    def failed(self) -> list[dict[str, Any]]:
        """Failed tasks: table, task and reason."""
        parts = mapping(self.record.get("parts")).values()
        return [task for made in (*parts, *(() if parts else (self.record,))) for task in rows(made.get("failed"))]

    @property
    def made(self) -> list[dict[str, Any]]:
        """Provenance of the parts, once for those that were run together."""
        parts = list(mapping(self.record.get("parts")).values()) or [self.record]
        return [made for k, made in enumerate(parts) if made.get("created") and made not in parts[:k]]


def view_roundoff(folder: Path) -> RoundoffView:
    """View of the study in a result folder."""
    study = RoundoffData(read_roundoff(folder))
    laws, further = law_rows(study)
    return RoundoffView(
        study.tables.record,
        sizes_of(study),
        tuple(words for words, _ in digit_columns(study)),
        digit_rows(study),
        tuple(s for s in sections(study) if s.panels or s.folded),
        laws,
        further,
        best_law_rows(study),
        growth_rows(study),
        engine_rows(study),
        stops(study),
        longitude_rows(study),
        time_rows(study),
    )


def sizes_of(study: RoundoffData) -> tuple[str, ...]:
    """Lengths of the shortest and the longest measured bar; empty where they are not known."""
    ratios = study.tables.evaluation.ratio
    if not len(ratios) or study.metres is None:
        return ()
    return tuple(length(float(end) * study.metres) for end in (ratios.min(), ratios.max()))


def sections(study: RoundoffData) -> tuple[Section, ...]:
    """Sections of charts."""
    return (
        Section("One evaluation", "", evaluation_panels(study), further_panels(study), STATES),
        Section("One orbit", RUNS, run_panels(study, DOUBLE, FIRST),
                (*run_panels(study, DOUBLE, FURTHER), *run_panels(study, SINGLE, (*FIRST, *FURTHER))),
                "Joint gaps, the centre of mass, and single precision"),
        Section("Smallest error of an orbit, and its growth over many orbits", "",
                (*best_panels(study, FIRST), *growth_panels(study, FIRST)),
                (*best_panels(study, FURTHER), *growth_panels(study, FURTHER)), "Joint gaps and the centre of mass"),
        Section("Other engines", ENGINES, (*library_panels(study), *engine_panels(study, "reaction")),
                tuple(p for q in ("attitude", *FURTHER) for p in engine_panels(study, q)),
                "Attitude, joint gaps and the centre of mass"),
    )  # fmt: skip


STATES = "Other states, and single precision"
RUNS = (
    "“Minimal” coordinates are the centre of mass and the angles. “Relative” ones also hold positions of the bars "
    "relative to the centre of mass, “absolute” ones positions relative to the centre of the body."
)
ENGINES = (
    "First: one evaluation by libraries of joint trees. The root of the tree moves along the orbit (inertial), rests "
    "at the distance of the orbit (inertial places), or moves with the chain. Then: runs of a short part of an orbit, "
    "in the inertial frame and in a frame that moves with the chain."
)
