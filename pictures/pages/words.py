"""Numbers and cells of the pages as text."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from reports.results.comparison import LINEAR_GROWTH

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

SIGNS = {"pass": "✓ pass", "unsupported": "– unsupported", "roundoff_limited": "≈ roundoff limited"}
"""Outcomes of comparisons with a sign; ✗ stands before all others"""
STABILITY_SIGNS = {
    "stable": "✓ stable", "drifting": "≈ drifting", "unsupported": "– unsupported", "rejected": "– rejected",
    "failed: time": "✗ timed out",
}  # fmt: skip


def short(value: float | None, unit: str = "") -> str:
    """Number of the record with its three digits: ``1.29e-7 rad``; empty without one."""
    if value is None:
        return ""
    text = re.sub(r"e([+-])0*(\d)", lambda m: f"e{m[1].strip('+')}{m[2]}", f"{value:.3g}")
    if re.fullmatch(r"\d(?:\.\d+)?e[1-5]", text):
        text = f"{float(text):.0f}"
    return f"{text} {unit}".strip()


def growth_text(value: float) -> str:
    """Error amplification; beyond the largest one that is measured a bound."""
    return short(value) if value <= LINEAR_GROWTH else f"more than {short(LINEAR_GROWTH)}"


def outcome_text(outcome: str) -> str:
    """Outcome of a comparison with its sign."""
    return SIGNS.get(outcome, f"✗ {outcome.replace('_', ' ')}")


def stability_text(word: str) -> str:
    """Outcome of the stability study with its sign."""
    return STABILITY_SIGNS.get(word, f"✗ {word}") if word else ""


def errors(row: Mapping[str, Any]) -> str:
    """Error of a pair in the quantity that its engine has: attitude, else the centre of mass."""
    if row["attitude_rad"] is not None:
        return short(row["attitude_rad"], "rad")
    return short(row["com_m"], "m")


def cell(text: object) -> str:
    """Text that does not end a table's cell."""
    return str(text).replace("|", "\\|").replace("\n", " ")


def table(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """Markdown table; the first column is text, and columns whose head ends with a colon are to the right."""
    heads = list(head)
    rule = ["---:" if h.endswith(":") else "---" for h in heads]
    lines = [[h.removesuffix(":") for h in heads], rule, *([cell(c) for c in row] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
