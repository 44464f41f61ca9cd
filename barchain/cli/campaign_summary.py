"""Cells, findings and rates of a campaign, printed."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from rich.table import Table

from barchain.cli.common.terminal import literal, say, show
from reports.tables.faults.campaign import ALL, ENGINE_CLASSES, FAULT_CLASSES

if TYPE_CHECKING:
    from barchain.studies.selftest.campaign import Campaign
    from barchain.studies.selftest.rating import CampaignCell, Rate
    from barchain.studies.selftest.shrinking import KeptFinding
    from reports.tables.faults.campaign import CellClass


def show_campaign(found: Campaign, *, kept: bool) -> None:
    """Print the cells' classes by engine and by fault, the findings, and the rates; `kept`: scenes can be looked at."""
    engines, faults = ([c for c in found.cells if bool(c.fault) is faulty] for faulty in (False, True))
    show(count_table("engine", found.plan.unmodified, [(c.engine, c) for c in engines], ENGINE_CLASSES))
    if faults:
        show(count_table("fault", found.plan.faults, [(c.fault, c) for c in faults], FAULT_CLASSES))
    for one in found.findings:
        say(finding_words(one, kept=kept))
    for rate in found.rates:
        if rate.by in (ALL, "outcome"):
            say(rate_words(rate))
    say("passed" if found.passed else "not passed")


def count_table(
    what: str, names: tuple[str, ...], cells: list[tuple[str, CampaignCell]], columns: tuple[CellClass, ...]
) -> Table:
    """Table of cell counts by name and class."""
    table = Table(what, *(str(k) for k in columns), box=None, header_style="bold")
    for column in table.columns[1:]:
        column.justify = "right"
    counts = Counter((name, cell.kind) for name, cell in cells)
    for name in names:
        table.add_row(literal(name), *(str(counts[name, k] or "") for k in columns))
    return table


def finding_words(found: KeptFinding, *, kept: bool) -> str:
    """Finding as one line of text."""
    cell = found.cell
    what = f"{cell.fault} in {cell.engine}" if cell.fault else cell.engine
    times = f" ({found.times} times)" if found.times > 1 else ""
    size = "" if cell.size is None else f" {cell.size:.2g}, stated as detected from {cell.limit or 0.0:.2g} on"
    said = f"{cell.kind}: {what} on {cell.scene}{times}: {cell.outcome}, {cell.quantity}{size}"
    return " ".join(f"{said} {cell.reason}".split()) + (f"; {found.path}" if kept else "")


def rate_words(rate: Rate) -> str:
    """``false alarm: 2 of 400, 0.50 % (0.14 % to 1.80 %)``."""
    low, high = rate.interval
    name = "" if rate.by == ALL else f", {rate.name}"
    share = f"{100.0 * rate.rate:.2f} % ({100.0 * low:.2f} % to {100.0 * high:.2f} %)" if rate.n else "none tried"
    return f"{rate.what}{name}: {rate.count} of {rate.n}, {share}"
