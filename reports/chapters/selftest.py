"""Chapter of the self-test: matrix of faults and scenes, survivors, smallest detected sizes, faults by check."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from reports.page import paragraphs
from reports.tables.faults.selftest import CAUGHT, FILES, KILLED, MISSED, FaultOutcome, read_selftest
from reports.tables.outcome import Outcome
from reports.tables.rows import records, spread
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
WHOLE, LANDING, CONTROL = "run", "landing", "control"
UNDETECTED = (FaultOutcome.SURVIVES, FaultOutcome.INVISIBLE)


def view_selftest(folder: Path) -> SimpleNamespace:
    """Contents of the page and of the terminal, from the study in a result folder."""
    tables = read_selftest(folder)
    about, scenes = tables.record.get("faults") or {}, list(tables.record.get("scenes") or {})
    cells = cells_of(tables.fates, tables.readings)
    rows = [
        row_of(name, words, [cells[name, s] for s in scenes if (name, s) in cells]) for name, words in about.items()
    ]
    faults = [r for r in rows if r["group"] != CONTROL]
    checks = checks_of(faults)
    used = {str(check) for _, check, *_ in checks}
    headline, *sentences = paragraphs("selftest/result.txt.j2", **counts(rows, faults))
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


def row_of(name: str, about: dict[str, Any], cells: list[dict[str, Any]]) -> dict[str, Any]:
    """A fault in all scenes, with the numbers of scenes that detect it and to which it applies."""
    return {
        "name": name,
        "words": str(about["words"]),
        "stands_for": str(about["stands_for"]),
        "group": str(about["group"]),
        "cells": cells,
        "detected": sum(c["fate"] is FaultOutcome.KILLED for c in cells),
        "tried": sum(c["fate"] is not FaultOutcome.NOTHING for c in cells),
    }


def counts(rows: list[dict[str, Any]], faults: list[dict[str, Any]]) -> dict[str, Any]:
    """Numbers of the result: of faults, of pairs with scenes, of runs of the unmodified engine."""
    controls = [r for r in rows if r["group"] == CONTROL]

    def missed(fate: FaultOutcome) -> list[str]:
        return [r["name"] for r in faults if not r["detected"] and any(c["fate"] is fate for c in r["cells"])]

    return {
        "detected": sum(r["detected"] > 0 for r in faults),
        "tried": sum(r["tried"] > 0 for r in faults),
        "undetected": missed(FaultOutcome.SURVIVES),
        "invisible": missed(FaultOutcome.INVISIBLE),
        "killed": sum(r["detected"] for r in faults),
        "pairs": sum(r["tried"] for r in faults),
        "runs": sum(r["tried"] for r in controls),
        "forms": sum(r["tried"] > 0 for r in controls),
        "clean": sum(c["fate"] is FaultOutcome.CLEAN for r in controls for c in r["cells"]),
    }


def cells_of(fates: pd.DataFrame, readings: pd.DataFrame) -> dict[tuple[str, str], dict[str, Any]]:
    """Cells by fault and scene, in the table's order; of each the detections, rejections of the whole run first."""
    groups: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in records(readings[readings["killed"] == KILLED]):
        groups.setdefault((row["fault"], row["scene"]), []).append(row)
    found = {}
    for fault, scene, word, why in fates[["fault", "scene", "fate", "why"]].itertuples(index=False):
        fate, killers = FaultOutcome(word), groups.get((fault, scene), [])
        killers.sort(key=lambda r: (r["quantity"] != WHOLE, -float(r["ratio"])))
        text, kind = FATES[fate]
        if fate is FaultOutcome.KILLED:
            first = killers[0]
            text = (
                f"{CHECKS[first['check']][0]} {quantity_of(first) or named(first['check']).replace('_', ' ')}".strip()
            )
        found[fault, scene] = {
            "fault": fault,
            "scene": scene,
            "fate": fate,
            "text": text,
            "kind": kind,
            "further": len({r["quantity"] for r in killers}) - 1,
            "pairs": {(r["quantity"], r["check"]) for r in killers},
            "title": "; ".join(f"{quantity_of(r) or WHOLE}: {r['check']}{amount(r)}" for r in killers) or why,
            "reason": why,
        }
    return found


def quantity_of(row: dict[str, Any]) -> str:
    """Quantity whose check rejects the run; empty if the whole run is rejected."""
    return "" if row["quantity"] == WHOLE else str(row["quantity"]).replace("_", " ")


def named(check: str) -> str:
    """Name of a check."""
    return LANDING if check == Outcome.INCONSISTENT else str(check)


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
    sizes: dict[str, dict[str, dict[str, dict[str, Any]]]] = {}
    for row in records(found[found["metric"].isin((CAUGHT, MISSED))]):
        sizes.setdefault(row["fault"], {CAUGHT: {}, MISSED: {}})[row["metric"]][row["scene"]] = row
    rows = []
    for name, own in sizes.items():
        caught, missed = own[CAUGHT], own[MISSED]
        rows.append(
            {
                "name": name,
                "unit": str(about[name]["unit"]),
                "natural": float(about[name]["natural"]),
                "sizes": [size_text(*(r[s]["value"] if s in r else None for r in (caught, missed))) for s in scenes],
                "checks": [str(caught[s]["text"]).replace("_", " ") if s in caught else "" for s in scenes],
            }
        )
    return rows


def size_text(caught: float | None, missed: float | None) -> str:
    """``1.2e-07``; ``> 1.0`` if the largest size tried is not detected; empty where none was tried."""
    if caught is None:
        return "" if missed is None else f"> {significant(missed, 2)}"
    return f"≤ {significant(caught, 2)}" if missed is None else significant(caught, 2)
