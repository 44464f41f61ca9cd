"""Charts of differences from the judging solution, of drifts, and of the error amplification."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reports.chapters.crossval.scene_data import group
from reports.chapters.crossval.summary import SHORT_OF_THE_RUN
from reports.plotting.palette import COLOURS, Pen
from reports.plotting.panels import Legend, Line, linear_panel, log_panel
from reports.plotting.series import column
from reports.tables.crossval import AMPLIFICATION, QUANTITY_UNITS

if TYPE_CHECKING:
    from reports.chapters.crossval.scene_data import ChartGroup, SceneData
    from reports.plotting.panels import Panel

DIFFERENCES = {
    "attitude": "Attitude",
    "reaction": "Reactions",
    "com": "CM track",
    "com_velocity": "CM velocity",
}
DRIFTS = {
    "gap": "Joint gap",
    "com_residual": "Centre-of-mass residual",
    "energy": "Energy",
    "angular_momentum": "Angular momentum",
}
LITTLE_AMPLIFICATION = 10.0  # times; up to it a linear axis shows more than whole decades do


class DifferenceCharts:
    """Charts of one scene's engines."""

    def __init__(self, data: SceneData) -> None:
        self.data = data

    def difference_panel(self, quantity: str, title: str) -> tuple[Panel | None, list[str]]:
        """Differences of one quantity on a log axis, their explained part dashed; and the engines shown."""
        lines, engines = [], []
        for engine, table in self.data.differences.items():
            y = column(table, f"{quantity}_difference")
            if y is None:
                continue
            t, predictability_limit = table["t_s"].to_numpy(float), self.data.predictability_limit(engine, quantity)
            compared = t <= predictability_limit
            tolerance = column(table, f"{quantity}_tolerance")
            shown = None if tolerance is None else tolerance[compared]
            cut = predictability_limit < SHORT_OF_THE_RUN * self.data.end_s
            lines.append(Line(t[compared] / self.data.unit_s, y[compared], self.data.pens[engine], shown, cut))
            engines.append(engine)
        return log_panel(self.data.frame(title, QUANTITY_UNITS[quantity], lines)), engines

    def drift_panel(self, quantity: str, title: str) -> tuple[Panel | None, list[str]]:
        """One drift over the whole run, its bound dashed; and the engines shown."""
        lines, engines = [], []
        for engine, table in self.data.differences.items():
            y = column(table, f"{quantity}_drift")
            if y is not None:
                bound = column(table, f"{quantity}_bound")
                t = table["t_s"].to_numpy(float) / self.data.unit_s
                lines.append(Line(t, np.abs(y), self.data.pens[engine], bound))
                engines.append(engine)
        unit = QUANTITY_UNITS[quantity]
        return log_panel(self.data.frame(title, "relative" if unit == "1" else unit, lines)), engines

    def difference_group(self) -> ChartGroup | None:
        """Charts of all differences."""
        found = [self.difference_panel(q, title) for q, title in DIFFERENCES.items()]
        text = "Dashed: explained part of the difference. A tick marks a line that ends at its predictability limit."
        return group("Differences from the judging solution", text, self.legend(found), [p for p, _ in found])

    def drift_group(self) -> ChartGroup | None:
        """Charts of all drifts and of the error amplification."""
        found = [self.drift_panel(q, title) for q, title in DRIFTS.items()]
        text = (
            "Drifts over the whole run, also beyond the predictability limit. Dashed: their bounds."
            if any(p for p, _ in found)
            else ""
        )
        panels = [*(p for p, _ in found), self.amplification_panel()]
        return group("Drifts and error amplification", text, self.legend(found), panels)

    def amplification_panel(self) -> Panel | None:
        """Error amplification over time; None where it is not stored."""
        table = self.data.results.differences(self.data.scene.name, AMPLIFICATION)
        y = None if table is None else column(table, "amplification")
        if table is None or y is None:
            return None
        lines = [Line(table["t_s"].to_numpy(float) / self.data.unit_s, y, Pen(COLOURS["ink"]))]
        frame = self.data.frame("Error amplification", "times the initial perturbation", lines)
        return log_panel(frame) if np.nanmax(y) > LITTLE_AMPLIFICATION else linear_panel(frame)

    def legend(self, found: list[tuple[Panel | None, list[str]]]) -> tuple[Legend, ...]:
        """Entries of the engines that appear in any of the panels."""
        used = {e for panel, engines in found if panel for e in engines}
        return tuple(Legend(e, self.data.pens[e]) for e in self.data.summary.engines if e in used)
