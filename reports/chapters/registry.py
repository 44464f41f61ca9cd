"""Everything that can be rendered of a result folder: a comparison's report, and the chapters of studies."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.chapters.cost.page import render_cost
from reports.chapters.effects.page import render_effects
from reports.chapters.roundoff.page import render_roundoff
from reports.chapters.scaling.page import render_scaling
from reports.chapters.selftest.page import render_selftest
from reports.chapters.stability.page import render_stability
from reports.render import render
from reports.tables.cost import has_cost
from reports.tables.effects import has_effects
from reports.tables.roundoff import has_roundoff
from reports.tables.scaling import has_scaling
from reports.tables.selftest import has_selftest
from reports.tables.stability import has_stability

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
