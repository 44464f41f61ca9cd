"""View of a round-off study."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.roundoff.charts import evaluation_panels, further_panels
from reports.chapters.roundoff.engine_charts import engine_panels, library_panels
from reports.chapters.roundoff.longitudes import longitude_rows, longitudes_sentences
from reports.chapters.roundoff.notes import notes
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
from reports.chapters.roundoff.verdict import verdict
from reports.tables.roundoff import read_roundoff
from reports.text.record import is_complete, mapping, rows

if TYPE_CHECKING:
    from pathlib import Path

    from reports.chapters.roundoff.longitudes import LongitudeRow
    from reports.chapters.roundoff.rows import DigitRow, LawRow
    from reports.chapters.roundoff.verdict import RoundoffVerdict
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
    verdict: RoundoffVerdict
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
    def longitudes_sentences(self) -> tuple[str, ...]:
        """Sentences on the dependence on the longitude."""
        return longitudes_sentences(self.longitudes)

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

    @property
    def notes(self) -> tuple[str, ...]:
        """Paragraphs on the method of measurement."""
        return notes(self.record)


def view_roundoff(folder: Path) -> RoundoffView:
    """View of the study in a result folder."""
    study = RoundoffData(read_roundoff(folder))
    laws, further = law_rows(study)
    return RoundoffView(
        study.tables.record,
        verdict(study),
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
