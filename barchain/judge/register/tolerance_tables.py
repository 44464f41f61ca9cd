"""Markdown tables of the register of tolerances, of the outcomes, and of the judging solutions that come with barchain.

``python -m barchain.judge.register.tolerance_tables FILE...`` rewrites the tables in Markdown files.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from barchain.judge.register.tolerances import SAFEGUARDS, TOLERANCES
from barchain.solutions.sampling import closely_sampled
from barchain.solutions.shipped import read_solution, shipped_path
from reports.tables.outcome import SEVERITY
from scenarios import load_scene, scene_names

if TYPE_CHECKING:
    from collections.abc import Iterable


def tolerance_table() -> list[tuple[str, ...]]:
    """Rows of :data:`TOLERANCES` for Markdown, its header first."""
    head = ("quantity", "tolerance", "value", "derivation", "tested by")
    return [head, *((t.quantity, t.name, t.value, t.derivation, f"`{t.tested_by}`") for t in TOLERANCES)]


def safeguard_table() -> list[tuple[str, ...]]:
    """Rows of :data:`SAFEGUARDS` for Markdown, its header first."""
    head = ("quantity that an engine controls", "bound", "fault that tests the bound", "tested by")
    return [head, *((s.widened_by, s.bound, s.fault, f"`{s.tested_by}`") for s in SAFEGUARDS)]


def outcome_table() -> list[tuple[str, ...]]:
    """Rows of all outcomes for Markdown, from the least to the most severe, the header first."""
    head = ("outcome", "exit code", "meaning")
    return [head, *((f"`{o}`", "0" if o.ok else "1", o.advice) for o in SEVERITY)]


def solution_table() -> list[tuple[str, ...]]:
    """Rows of the judging solutions that come with barchain for Markdown, by scene, the header first."""
    head = ("scene", "kB", "error bar of the attitude at the end, rad", "of the reactions, N", "error amplification")
    return [head, *(solution_row(name) for name in scene_names() if shipped_path(name).is_file())]


def solution_row(name: str) -> tuple[str, ...]:
    """Row of one scene's judging solution."""
    path, scene = shipped_path(name), closely_sampled(load_scene(name))
    found = read_solution(path, scene)
    reaction = f"{found.error['reaction'][-1]:.1e}" if "reaction" in found.error else "–"
    size, angle, grown = path.stat().st_size / 1e3, found.error["attitude"][-1], found.amplification[-1]
    return name, f"{size:.0f}", f"{angle:.1e}", reaction, f"{grown:.2g}"


TABLES = {
    "tolerances": tolerance_table, "safeguards": safeguard_table, "outcomes": outcome_table,
    "judging-solutions": solution_table,
}  # fmt: skip
"""Generated tables by the name in their markers"""


def markdown(rows: Iterable[tuple[str, ...]]) -> str:
    """Markdown table of rows of text, the first of them its header."""
    head, *body = ("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows)
    return "\n".join([head, "|" + "---|" * (head.replace("\\|", "").count("|") - 1), *body])


def with_tables(text: str) -> str:
    """Markdown text with each table rewritten, from ``<!-- NAME: generated -->`` to ``<!-- end of NAME -->``."""
    for name, rows in TABLES.items():
        start, end = f"<!-- {name}: generated -->", f"<!-- end of {name} -->"
        before, marker, rest = text.partition(start)
        if marker:
            text = f"{before}{start}\n{markdown(rows())}\n{end}{rest.partition(end)[2]}"
    return text


def rewrite(paths: Iterable[str]) -> None:
    """Rewrite the generated tables in Markdown files."""
    for path in map(Path, paths):
        path.write_text(with_tables(path.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    rewrite(sys.argv[1:])
