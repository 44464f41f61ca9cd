"""Everything that can be rendered of a result folder: a comparison's report, and the chapters of studies."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.cost_page import render_cost
from reports.cost_tables import has_cost
from reports.effects_page import render_effects
from reports.effects_tables import has_effects
from reports.render import render
from reports.roundoff_page import render_roundoff
from reports.roundoff_tables import has_roundoff
from reports.scaling_page import render_scaling
from reports.scaling_tables import has_scaling
from reports.selftest_page import render_selftest
from reports.selftest_tables import has_selftest
from reports.stability_page import render_stability
from reports.stability_tables import has_stability

if TYPE_CHECKING:
    from pathlib import Path


def render_all(folder: Path) -> list[Path]:
    """Render what a folder holds, and return the pages.

    Raises
    ------
    FileNotFoundError
        If it holds neither a comparison nor a study.
    """
    pages: list[Path] = []
    if has_cost(folder):
        pages.append(render_cost(folder)[0])
    if has_scaling(folder):
        pages.append(render_scaling(folder))
    if has_roundoff(folder):
        pages.append(render_roundoff(folder))
    if has_effects(folder):
        pages.append(render_effects(folder))
    if has_selftest(folder):
        pages.append(render_selftest(folder))
    if has_stability(folder):
        pages.append(render_stability(folder))
    if not pages or (folder / "metrics.csv").is_file():
        pages += render(folder)
    return list(dict.fromkeys(pages))
