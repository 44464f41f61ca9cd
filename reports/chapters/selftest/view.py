"""The kill matrix: from a self-test's tables to what the templates and the terminal show."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.selftest.rows import CHECK_WORDS, CHECKS, LANDING, MatrixCell, cells
from reports.tables.outcome import Outcome
from reports.tables.selftest import FaultOutcome, read_selftest
from reports.text.numerals import number, significant
from reports.text.record import mapping

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
    def killed(self) -> int:
        """In how many scenes it is killed."""
        return sum(c.fate is FaultOutcome.KILLED for c in self.cells)

    @property
    def tried(self) -> int:
        """In how many scenes it is put in."""
        return sum(c.fate is not FaultOutcome.NOTHING for c in self.cells)

    @property
    def survivors(self) -> tuple[MatrixCell, ...]:
        """Cells in which nothing kills it."""
        return tuple(c for c in self.cells if c.fate in (FaultOutcome.SURVIVES, FaultOutcome.INVISIBLE))


@dataclass(frozen=True)
class CheckRow:
    """What one check of one quantity is worth."""

    quantity: str
    check: str
    faults: int
    """Faults that it kills in some scene"""
    alone: tuple[str, ...]
    """Faults that nothing else kills in any scene"""


@dataclass(frozen=True)
class SmallestRow:
    """Smallest sizes of one fault in all scenes."""

    name: str
    unit: str
    natural: float
    sizes: tuple[str, ...]
    """As text, one for each scene; empty where there is nothing to spoil"""
    checks: tuple[str, ...]
    least: str
    """Over all scenes"""


@dataclass(frozen=True)
class SelftestView:
    """All that is shown."""

    record: dict[str, Any]
    scenes: tuple[str, ...]
    rows: tuple[FaultRow, ...]
    checks: tuple[CheckRow, ...]
    smallest: tuple[SmallestRow, ...]

    @property
    def finished(self) -> bool:
        """Whether it came to its end."""
        return bool(self.record.get("finished"))

    @property
    def controls(self) -> tuple[FaultRow, ...]:
        """Sound engines."""
        return tuple(r for r in self.rows if r.group == CONTROL)

    @property
    def faults(self) -> tuple[FaultRow, ...]:
        """Faults."""
        return tuple(r for r in self.rows if r.group != CONTROL)

    @property
    def groups(self) -> dict[str, list[FaultRow]]:
        """Rows by group, controls first."""
        found: dict[str, list[FaultRow]] = {}
        for row in self.rows:
            found.setdefault(row.group, []).append(row)
        return found

    @property
    def signs(self) -> tuple[tuple[str, str, str], ...]:
        """Sign, name and meaning of every check that kills something."""
        used = {c.check for c in self.checks}
        return tuple(
            (CHECKS[c], LANDING if c == Outcome.INCONSISTENT else str(c), words)
            for c, words in CHECK_WORDS.items()
            if str(c) in used
        )

    @property
    def survivors(self) -> tuple[tuple[FaultRow, MatrixCell], ...]:
        """Faults and the scenes in which nothing kills them, those killed nowhere first."""
        found = [(row, cell) for row in self.faults for cell in row.survivors]
        return tuple(sorted(found, key=lambda pair: pair[0].killed > 0))

    @property
    def unkilled(self) -> tuple[FaultRow, ...]:
        """Faults put in, killed nowhere and not proven invisible."""
        return tuple(r for r in self.faults if not r.killed and any(c.fate is FaultOutcome.SURVIVES for c in r.cells))

    @property
    def wrong(self) -> tuple[MatrixCell, ...]:
        """False alarms and faults that are not put in as they are meant."""
        return tuple(c for r in self.rows for c in r.cells if c.fate in (FaultOutcome.FALSE_ALARM, FaultOutcome.BROKEN))

    @property
    def headline(self) -> str:
        """The result in a sentence."""
        killed = sum(r.killed > 0 for r in self.faults)
        tried = sum(r.tried > 0 for r in self.faults)
        invisible = [
            r.name for r in self.faults if not r.killed and any(c.fate is FaultOutcome.INVISIBLE for c in r.cells)
        ]
        said = f"{killed} of {tried} seeded faults are caught"
        if invisible and not self.unkilled:
            return f"{said}; the other, {', '.join(invisible)}, is proven invisible." if len(invisible) == 1 else (
                f"{said}; the others, {', '.join(invisible)}, are proven invisible."
            )  # fmt: skip
        if self.unkilled:
            return f"{said}; killed by nothing: {', '.join(r.name for r in self.unkilled)}."
        return f"{said}."

    @property
    def sentences(self) -> tuple[str, ...]:
        """What stands below it."""
        put_in = [c for r in self.faults for c in r.cells if c.fate is not FaultOutcome.NOTHING]
        dead = sum(c.fate is FaultOutcome.KILLED for c in put_in)
        clean = sum(c.fate is FaultOutcome.CLEAN for r in self.controls for c in r.cells)
        forms = sum(r.tried > 0 for r in self.controls)
        ran = sum(c.fate is not FaultOutcome.NOTHING for r in self.controls for c in r.cells)
        return (
            f"Of {len(put_in)} pairs of a fault and a scene in which it can show, a check kills {dead}.",
            f"The sound engine, run {ran} times in {forms} form{'s' * (forms != 1)}, is refused by "
            + ("nothing." if clean == ran else f"a check in {ran - clean}: a false alarm."),
        )


def view_selftest(folder: Path) -> SelftestView:
    """View of the study in a result folder."""
    tables = read_selftest(folder)
    found, faults = cells(tables.cells), mapping(tables.record.get("faults"))
    scenes = tuple(mapping(tables.record.get("scenes")))
    rows = tuple(fault_row(name, mapping(about), scenes, found) for name, about in faults.items())
    return SelftestView(
        tables.record, scenes, rows, check_rows(found, faults), smallest_rows(tables.smallest, scenes, faults)
    )


def fault_row(
    name: str, about: dict[str, Any], scenes: tuple[str, ...], found: dict[tuple[str, str], MatrixCell]
) -> FaultRow:
    """Row of one fault."""
    here = tuple(found[name, s] for s in scenes if (name, s) in found)
    return FaultRow(name, str(about["words"]), str(about["stands_for"]), str(about["group"]), here)


def check_rows(found: dict[tuple[str, str], MatrixCell], faults: dict[str, Any]) -> tuple[CheckRow, ...]:
    """How many faults each check kills, and which no other does."""
    killers: dict[str, set[tuple[str, str]]] = {}
    for (fault, _), cell in found.items():
        if mapping(faults[fault])["group"] != CONTROL:
            killers.setdefault(fault, set()).update((k.quantity, k.check) for k in cell.kills)
    pairs = sorted({p for by in killers.values() for p in by})
    rows = [
        CheckRow(
            *pair,
            sum(pair in by for by in killers.values()),
            tuple(f for f, by in killers.items() if by == {pair}),
        )
        for pair in pairs
    ]
    return tuple(sorted(rows, key=lambda r: (-r.faults, r.quantity)))


def smallest_rows(table: pd.DataFrame, scenes: tuple[str, ...], faults: dict[str, Any]) -> tuple[SmallestRow, ...]:
    """Smallest sizes by fault."""
    found: dict[str, dict[str, dict[str, Any]]] = {}
    for row in table.to_dict("records"):
        found.setdefault(row["fault"], {})[row["scene"]] = {str(k): v for k, v in row.items()}
    return tuple(smallest_row(name, by, scenes, mapping(faults[name])) for name, by in found.items())


def smallest_row(
    name: str, by: dict[str, dict[str, Any]], scenes: tuple[str, ...], about: dict[str, Any]
) -> SmallestRow:
    """Row of one fault."""
    caught = [v for row in by.values() if (v := known(row["caught"])) is not None]
    sizes = tuple(size_text(by[s]) if s in by else "" for s in scenes)
    checks = tuple(by[s]["quantity"].replace("_", " ") if s in by else "" for s in scenes)
    least = significant(min(caught), 2) if caught else "not caught"
    return SmallestRow(name, str(about["unit"]), float(about["natural"]), sizes, checks, least)


def size_text(row: dict[str, Any]) -> str:
    """``1.2e-07``; ``> 1.0`` where the largest that was tried is missed."""
    caught, missed = known(row["caught"]), known(row["missed"])
    if caught is None:
        return f"> {significant(missed, 2)}"
    return f"≤ {significant(caught, 2)}" if missed is None else significant(caught, 2)


def known(value: object) -> float | None:
    """Number in a table, None for an empty cell."""
    found = number(value)
    return None if found is None or math.isnan(found) else found
