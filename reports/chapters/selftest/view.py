"""View of a self-test, for the page and the terminal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.selftest.rows import CHECK_WORDS, CHECKS, LANDING, MatrixCell, cells
from reports.tables.faults.selftest import CAUGHT, FILES, MISSED, FaultOutcome, read_selftest
from reports.tables.measured import spread_rows
from reports.tables.outcome import Outcome
from reports.text.numerals import significant
from reports.text.record import is_complete, mapping

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

CONTROL = "control"


@dataclass(frozen=True)
class FaultRow:
    """One fault in all scenes."""

    name: str
    words: str
    stands_for: str
    group: str
    cells: tuple[MatrixCell, ...]

    @property
    def detected(self) -> int:
        """Number of scenes that detect the fault."""
        return sum(c.fate is FaultOutcome.KILLED for c in self.cells)

    @property
    def tried(self) -> int:
        """Number of scenes to which the fault applies."""
        return sum(c.fate is not FaultOutcome.NOTHING for c in self.cells)

    @property
    def survivors(self) -> tuple[MatrixCell, ...]:
        """Cells in which no check detects the fault."""
        return tuple(c for c in self.cells if c.fate in (FaultOutcome.SURVIVES, FaultOutcome.INVISIBLE))


@dataclass(frozen=True)
class CheckRow:
    """Faults detected by one check of one quantity."""

    quantity: str
    check: str
    faults: int
    """Number of faults detected in at least one scene"""
    alone: tuple[str, ...]
    """Faults that no other check detects in any scene"""


@dataclass(frozen=True)
class SmallestRow:
    """Smallest detected sizes of one fault in all scenes."""

    name: str
    unit: str
    natural: float
    sizes: tuple[str, ...]
    """As text, one for each scene; empty if the fault does not apply"""
    checks: tuple[str, ...]
    least: str
    """Over all scenes"""


@dataclass(frozen=True)
class SelftestView:
    """Contents of the page."""

    record: dict[str, Any]
    scenes: tuple[str, ...]
    rows: tuple[FaultRow, ...]
    checks: tuple[CheckRow, ...]
    smallest: tuple[SmallestRow, ...]

    @property
    def finished(self) -> bool:
        """Whether the self-test was finished."""
        return is_complete(self.record)

    @property
    def controls(self) -> tuple[FaultRow, ...]:
        """Rows of unmodified engines."""
        return tuple(r for r in self.rows if r.group == CONTROL)

    @property
    def faults(self) -> tuple[FaultRow, ...]:
        """Rows of faults."""
        return tuple(r for r in self.rows if r.group != CONTROL)

    @property
    def groups(self) -> dict[str, list[FaultRow]]:
        """Rows by group, controls first."""
        found: dict[str, list[FaultRow]] = {}
        for row in self.rows:
            found.setdefault(row.group, []).append(row)
        return found

    @property
    def outcomes(self) -> tuple[FaultOutcome, ...]:
        """Outcomes of a fault that no check detects, for the legend."""
        return tuple(o for o in FaultOutcome if o is not FaultOutcome.KILLED)

    @property
    def signs(self) -> tuple[tuple[str, str, str], ...]:
        """Sign, name and meaning of every check that detects a fault."""
        used = {c.check for c in self.checks}
        return tuple(
            (CHECKS[c], LANDING if c == Outcome.INCONSISTENT else str(c), words)
            for c, words in CHECK_WORDS.items()
            if str(c) in used
        )

    @property
    def survivors(self) -> tuple[tuple[FaultRow, MatrixCell], ...]:
        """Faults with the scenes that do not detect them, undetected faults first."""
        found = [(row, cell) for row in self.faults for cell in row.survivors]
        return tuple(sorted(found, key=lambda pair: pair[0].detected > 0))

    @property
    def undetected(self) -> tuple[FaultRow, ...]:
        """Faults that no scene detects and that are not proven invisible."""
        return tuple(r for r in self.faults if not r.detected and any(c.fate is FaultOutcome.SURVIVES for c in r.cells))

    @property
    def wrong(self) -> tuple[MatrixCell, ...]:
        """Cells of false alarms and of broken faults."""
        return tuple(c for r in self.rows for c in r.cells if c.fate in (FaultOutcome.FALSE_ALARM, FaultOutcome.BROKEN))

    @property
    def headline(self) -> str:
        """Result in one sentence."""
        detected = sum(r.detected > 0 for r in self.faults)
        tried = sum(r.tried > 0 for r in self.faults)
        invisible = [
            r.name for r in self.faults if not r.detected and any(c.fate is FaultOutcome.INVISIBLE for c in r.cells)
        ]
        said = f"{detected} of {tried} faults are detected"
        if invisible and not self.undetected:
            return f"{said}; the other, {', '.join(invisible)}, is proven invisible." if len(invisible) == 1 else (
                f"{said}; the others, {', '.join(invisible)}, are proven invisible."
            )  # fmt: skip
        if self.undetected:
            return f"{said}; undetected: {', '.join(r.name for r in self.undetected)}."
        return f"{said}."

    @property
    def sentences(self) -> tuple[str, ...]:
        """Sentences below the headline."""
        put_in = [c for r in self.faults for c in r.cells if c.fate is not FaultOutcome.NOTHING]
        dead = sum(c.fate is FaultOutcome.KILLED for c in put_in)
        clean = sum(c.fate is FaultOutcome.CLEAN for r in self.controls for c in r.cells)
        forms = sum(r.tried > 0 for r in self.controls)
        ran = sum(c.fate is not FaultOutcome.NOTHING for r in self.controls for c in r.cells)
        return (
            f"In {dead} of {len(put_in)} pairs of a fault and a scene to which it applies, a check detects the fault.",
            f"The unmodified engine, run {ran} times in {forms} form{'s' * (forms != 1)}, "
            + ("raises no false alarm." if clean == ran else f"fails a check in {ran - clean} runs: false alarms."),
        )


def view_selftest(folder: Path) -> SelftestView:
    """View of the study in a result folder."""
    tables = read_selftest(folder)
    found, faults = cells(tables.cells), mapping(tables.record.get("faults"))
    scenes = tuple(mapping(tables.record.get("scenes")))
    rows = tuple(fault_row(name, mapping(about), scenes, found) for name, about in faults.items())
    return SelftestView(
        tables.record,
        scenes,
        rows,
        check_rows(found, faults),
        smallest_rows(spread_rows(FILES, folder), scenes, faults),
    )


def fault_row(
    name: str, about: dict[str, Any], scenes: tuple[str, ...], found: dict[tuple[str, str], MatrixCell]
) -> FaultRow:
    """Row of one fault."""
    here = tuple(found[name, s] for s in scenes if (name, s) in found)
    return FaultRow(name, str(about["words"]), str(about["stands_for"]), str(about["group"]), here)


def check_rows(found: dict[tuple[str, str], MatrixCell], faults: dict[str, Any]) -> tuple[CheckRow, ...]:
    """Rows of all checks, those with the most faults first."""
    detecting: dict[str, set[tuple[str, str]]] = {}
    for (fault, _), cell in found.items():
        if mapping(faults[fault])["group"] != CONTROL:
            detecting.setdefault(fault, set()).update((k.quantity, k.check) for k in cell.detections)
    pairs = sorted({p for by in detecting.values() for p in by})
    rows = [
        CheckRow(
            *pair,
            sum(pair in by for by in detecting.values()),
            tuple(f for f, by in detecting.items() if by == {pair}),
        )
        for pair in pairs
    ]
    return tuple(sorted(rows, key=lambda r: (-r.faults, r.quantity)))


def smallest_rows(found: pd.DataFrame, scenes: tuple[str, ...], faults: dict[str, Any]) -> tuple[SmallestRow, ...]:
    """Smallest detected sizes of all faults of which they were looked for."""
    sizes: dict[str, dict[tuple[str, str], dict[str, Any]]] = {}
    for row in found[found["metric"].isin((CAUGHT, MISSED))].to_dict("records"):
        sizes.setdefault(row["fault"], {})[row["scene"], row["metric"]] = {str(k): v for k, v in row.items()}
    return tuple(smallest_row(name, own, scenes, mapping(faults[name])) for name, own in sizes.items())


def smallest_row(
    name: str, own: dict[tuple[str, str], dict[str, Any]], scenes: tuple[str, ...], about: dict[str, Any]
) -> SmallestRow:
    """Row of one fault."""
    caught = {s: row for (s, metric), row in own.items() if metric == CAUGHT}
    missed = {s: row["value"] for (s, metric), row in own.items() if metric == MISSED}
    sizes = tuple(size_text(caught.get(s, {}).get("value"), missed.get(s)) for s in scenes)
    checks = tuple(str(caught[s]["text"]).replace("_", " ") if s in caught else "" for s in scenes)
    least = significant(min(row["value"] for row in caught.values()), 2) if caught else "not detected"
    return SmallestRow(name, str(about["unit"]), float(about["natural"]), sizes, checks, least)


def size_text(caught: float | None, missed: float | None) -> str:
    """``1.2e-07``; ``> 1.0`` if the largest size tried is not detected; empty where none was tried."""
    if caught is None:
        return "" if missed is None else f"> {significant(missed, 2)}"
    return f"≤ {significant(caught, 2)}" if missed is None else significant(caught, 2)
