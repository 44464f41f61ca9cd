"""Chapter of the self-test: matrix of faults and scenes, survivors, smallest detected sizes, faults by check."""

from __future__ import annotations

from collections import Counter
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from reports.page import paragraphs
from reports.results.outcome import Outcome
from reports.results.rows import records, spread
from reports.results.selftest import CAUGHT, FILES, KILLED, MISSED, FaultOutcome
from reports.text.numerals import significant
from reports.text.record import is_complete

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

CHECKS = {
    "normalised_error": ("≠", "normalised error above 1"),
    "bound": ("▲", "error above the expected-error bound"),
    "drift": ("≈", "drift of a conserved quantity above its bound"),
    "restarted": ("↻", "deviation from the reference restarted at the engine's own sample"),
    "own_state": ("↔", "reactions or torques that do not belong to the engine's own state"),
    "extrapolated": ("½", "error above that of the two runs' Richardson extrapolation"),
    "judged_share": ("○", "too small a share of the run can be judged"),
    Outcome.INCONSISTENT: ("≠", "instant of surface contact unexplained by both errors"),
    Outcome.INCOMPLETE: ("◐", "channel, sample, instant or reason of the end missing or wrong"),
    Outcome.NOT_FINITE: ("?", "NaN or infinity"),
    Outcome.JOINTS_IGNORED: ("¦", "open joints"),
    Outcome.NOTHING_COMPARED: ("○", "nothing of the run can be compared"),
    Outcome.TOO_COARSE: ("○", "too little of the run can be predicted at the setting"),
    Outcome.EXCEEDS_BOUND: ("▲", "error of the whole run above its bound"),
    Outcome.MALFORMED: ("#", "values with too few digits, or undeclared channels"),
    Outcome.MISSING: ("✗", "engine that does not import"),
    Outcome.FAILED: ("✗", "failure of the engine"),
    Outcome.TIMED_OUT: ("◷", "run ended at its time limit"),
}
"""Sign and meaning of each check that rejects a run"""
FATES = {
    FaultOutcome.KILLED: ("", "pass"),
    FaultOutcome.SURVIVES: ("survives", "fail"),
    FaultOutcome.INVISIBLE: ("invisible", "gone"),
    FaultOutcome.NOTHING: ("–", "aside"),
    FaultOutcome.CLEAN: ("✓ clean", "pass"),
    FaultOutcome.FALSE_ALARM: ("false alarm", "fail"),
    FaultOutcome.BROKEN: ("broken", "fail"),
}
"""Text of a cell, a check's name if a check detects the fault, and its colour class"""
WHOLE = "run"
UNDETECTED = (FaultOutcome.SURVIVES, FaultOutcome.INVISIBLE)


def view_selftest(folder: Path) -> SimpleNamespace:
    """Contents of the page and of the terminal, from the study in a result folder."""
    tables = FILES.contents(folder)
    about, scenes = tables.record.get("faults") or {}, list(tables.record.get("scenes") or {})
    cells = cells_of(tables.fates, tables.readings)
    rows = []
    for name, words in about.items():
        own = [cells[name, s] for s in scenes if (name, s) in cells]
        count = Counter(c["fate"] for c in own)
        counts = {"tried": len(own) - count[FaultOutcome.NOTHING], "detected": count[FaultOutcome.KILLED]}
        counts |= {str(fate): count[fate] for fate in (*UNDETECTED, FaultOutcome.CLEAN)}
        rows.append({"name": name, "cells": own} | words | counts)
    faults, controls = ([r for r in rows if (r["group"] == "control") is control] for control in (False, True))
    checks = checks_of(faults)
    used = {check for _, check, *_ in checks}
    headline, *sentences = paragraphs("selftest/result.txt.j2", faults=faults, controls=controls)
    return SimpleNamespace(
        record=tables.record,
        finished=is_complete(tables.record),
        headline=headline,
        sentences=sentences,
        scenes=scenes,
        rows=rows,
        groups={group: [r for r in rows if r["group"] == group] for group in dict.fromkeys(r["group"] for r in rows)},
        outcomes=[o for o in FaultOutcome if o is not FaultOutcome.KILLED],
        signs=[(sign, named(c), words) for c, (sign, words) in CHECKS.items() if str(c) in used],
        survivors=sorted(
            ((r, c) for r in faults for c in r["cells"] if c["fate"] in UNDETECTED),
            key=lambda pair: pair[0]["detected"] > 0,
        ),
        wrong=[c for r in rows for c in r["cells"] if c["fate"] in (FaultOutcome.FALSE_ALARM, FaultOutcome.BROKEN)],
        checks=checks,
        smallest=smallest(spread(FILES.rows(folder, tables.record)), scenes, about),
    )


def cells_of(fates: pd.DataFrame, readings: pd.DataFrame) -> dict[tuple[str, str], dict[str, Any]]:
    """Cells by fault and scene, in the table's order; of each the detections, rejections of the whole run first."""
    rejected = readings[readings["killed"] == KILLED].sort_values("ratio", ascending=False, kind="stable")
    found, by_cell = {}, dict[tuple[str, str], list[dict[str, Any]]]()
    for row in records(rejected):
        by_cell.setdefault((row["fault"], row["scene"]), []).append(row)
    for row in records(fates):
        killers = sorted(by_cell.get((row["fault"], row["scene"]), ()), key=lambda r: r["quantity"] != WHOLE)
        fate = FaultOutcome(row["fate"])
        text, kind = FATES[fate]
        if fate is FaultOutcome.KILLED:
            first = killers[0]
            word = quantity_of(first) or named(first["check"]).replace("_", " ")
            text = f"{CHECKS[first['check']][0]} {word}".strip()
        found[row["fault"], row["scene"]] = row | {
            "fate": fate,
            "text": text,
            "kind": kind,
            "further": len({r["quantity"] for r in killers}) - 1,
            "pairs": {(r["quantity"], r["check"]) for r in killers},
            "title": "; ".join(f"{quantity_of(r) or WHOLE}: {r['check']}{amount(r)}" for r in killers) or row["why"],
            "reason": row["why"],
        }
    return found


def quantity_of(row: dict[str, Any]) -> str:
    """Quantity whose check rejects the run; empty if the whole run is rejected."""
    return "" if row["quantity"] == WHOLE else str(row["quantity"]).replace("_", " ")


def named(check: str) -> str:
    """Name of a check."""
    return "landing" if check == Outcome.INCONSISTENT else str(check)


def amount(row: dict[str, Any]) -> str:
    """Ratio to the allowed value, or the reason of a rejected run."""
    if row["quantity"] == WHOLE:
        return f" ({row['reason']})" if row["reason"] else ""
    return f", {significant(row['ratio'], 2)} times the allowed value"


def checks_of(faults: list[dict[str, Any]]) -> list[tuple[str, str, int, list[str]]]:
    """Quantity, check, number of faults that it detects, and those that it alone detects; most faults first."""
    detecting = {r["name"]: set().union(*(c["pairs"] for c in r["cells"])) for r in faults}
    rows = [
        (*pair, sum(pair in by for by in detecting.values()), [f for f, by in detecting.items() if by == {pair}])
        for pair in sorted({p for by in detecting.values() for p in by})
    ]
    return sorted(rows, key=lambda r: (-r[2], r[0]))


def smallest(found: pd.DataFrame, scenes: list[str], about: dict[str, Any]) -> list[dict[str, Any]]:
    """Smallest detected sizes of the faults of which they were looked for, with the quantity that detects each."""
    sizes: dict[str, dict[tuple[str, str], dict[str, Any]]] = {}
    for row in records(found[found["metric"].isin((CAUGHT, MISSED))]):
        sizes.setdefault(row["fault"], {})[row["metric"], row["scene"]] = row
    return [
        {
            "name": name,
            "unit": about[name]["unit"],
            "natural": about[name]["natural"],
            "sizes": [size_text(*(own.get((m, s), {}).get("value") for m in (CAUGHT, MISSED))) for s in scenes],
            "checks": [own.get((CAUGHT, s), {}).get("text", "").replace("_", " ") for s in scenes],
        }
        for name, own in sizes.items()
    ]


def size_text(caught: float | None, missed: float | None) -> str:
    """``1.2e-07``; ``> 1.0`` if the largest size tried is not detected; empty where none was tried."""
    if caught is None:
        return "" if missed is None else f"> {significant(missed, 2)}"
    return f"≤ {significant(caught, 2)}" if missed is None else significant(caught, 2)
