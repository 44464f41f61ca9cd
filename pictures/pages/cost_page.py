"""Tables of the page of the cost study, from the record."""

from __future__ import annotations

from typing import TYPE_CHECKING

from adapters.registry import COMPILED, built_in
from pictures.pages.engine_page import COST_SCENE
from pictures.pages.record import MeasuredRecord, rows
from pictures.pages.words import table
from pictures.record.cost import APART
from reports.results.cost import INDEPENDENT, OWN_EQUATIONS
from reports.results.cost import KINDS as HEADINGS
from reports.text.numerals import decade, ratio_text

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from pictures.pages.record import Row

KINDS = ((True, f"{HEADINGS[INDEPENDENT]}:"), (False, f"{HEADINGS[OWN_EQUATIONS]}:"))


def cost_times() -> str:
    """Times at equal error of all engines on :data:`COST_SCENE`."""
    measured = MeasuredRecord()
    found = rows(measured.reach[measured.reach.scene == COST_SCENE])
    return "\n\n".join([introduction(found, measured), *tables(found)])


def introduction(found: Iterable[Row], measured: MeasuredRecord) -> str:
    """Sentences on the measurement."""
    run = measured.runs["cost"]
    costs = {r["target"]: r["cost"] for r in found if r["engine"] == COMPILED and r["cost"] is not None}
    times = ", ".join(f"{costs[t] * 1e6:.3g}" for t in sorted(costs, reverse=True))
    apart = [
        f"{', '.join(f'`{name}`' for name in APART[stage].engines)}: beside it, in a run on {own['created']} on "
        f"{own['environment']['cpu']}."
        for stage, own in measured.runs.items()
        if stage in APART
    ]
    return "\n".join([
        f"Measured on {run['created']} with barchain {run['barchain']} on {run['environment']['cpu']}.",
        f"`{COMPILED}` itself takes {times} µs.", *apart,
    ])  # fmt: skip


def tables(found: Iterable[Row]) -> Iterable[str]:
    """A heading and a table for each kind of engine that has a point."""
    cells = {(r["engine"], r["target"]): ratio(r) for r in found}
    targets = sorted({t for _, t in cells}, reverse=True)
    for independent, heading in KINDS:
        names = [e for e, r in built_in().items() if r.external is independent and (e, targets[0]) in cells]
        yield heading
        yield table(
            ("engine", f"{decade(targets[0])} rad:", *(f"{decade(t)}:" for t in targets[1:])),
            ([name, *(cells.get((name, t), "–") for t in targets)] for name in names),
        )


def ratio(row: Row) -> str:
    """Time relative to the compiled reference, with its interval."""
    sign = "≤ ×" if row["status"] == "at most" else "×"
    spread = (row["over_baseline"], row["over_baseline_low"], row["over_baseline_high"])
    return ratio_text(spread, sign) or "–"


TABLES: dict[str, Callable[[], str]] = {"cost-times": cost_times}
"""Tables by their names"""
