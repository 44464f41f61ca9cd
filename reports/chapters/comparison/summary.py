"""Summary of the metrics table: one row per scene, engine and quantity, one cell per scene and engine."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

from reports.results.comparison import ALL_SCENES, JUDGING_SOLUTION, QUANTITY_UNITS, is_engine
from reports.results.outcome import Outcome, gravest
from reports.results.rows import Row, known, records
from reports.text.record import SceneRecord, is_complete
from scenarios.channels import CHANNELS

if TYPE_CHECKING:
    from reports.results.files import StudyTables

WORDS = {outcome: outcome.value.replace("_", " ") for outcome in Outcome}
SHORT_OF_THE_RUN = 0.999  # a limit beyond this share of the run counts as the whole run


@dataclass(frozen=True)
class QuantityRow:
    """Metrics of one quantity in one run."""

    quantity: str
    unit: str
    largest: float | None
    """Largest difference, or largest drift"""
    rms: float | None
    final: float | None
    bound: float | None
    ratio: float | None
    """Normalised error: largest ratio of the difference to its explained part"""
    first_orbit: float | None
    """Largest difference up to one orbit, where the run is longer"""
    detection_limit: float | None
    """Relative error that the comparison would have reported at every sample"""
    limit_s: float | None
    outcome: Outcome
    reason: str

    @property
    def name(self) -> str:
        """Name for people."""
        channel = CHANNELS.get(self.quantity)
        return channel.shown_label if channel else self.quantity.replace("_", " ")

    @property
    def unit_words(self) -> str:
        """Unit for people: ``rad``, or the denominator of a ratio."""
        channel = CHANNELS.get(self.quantity)
        return (channel and channel.share_of) or (self.unit if self.unit != "1" else "")

    @property
    def figures(self) -> tuple[float | None, ...]:
        """Numbers, in the order of the heads of the table of metrics."""
        limit_s = None if self.ratio is None else self.limit_s
        return (
            self.largest, self.first_orbit, self.rms, self.final, self.bound, self.ratio, self.detection_limit, limit_s,
        )  # fmt: skip

    @property
    def empty(self) -> bool:
        """Whether there is neither a number nor a reason nor a judgement."""
        return self.outcome is Outcome.REPORTED and self.largest is None and self.ratio is None and not self.reason


METRIC_OF = {
    "rms": "rms", "final": "final", "ratio": "normalised_error", "first_orbit": "first_orbit_max",
    "detection_limit": "detection_limit",
}  # fmt: skip
"""Metric of each further number of a row"""


@dataclass(frozen=True)
class RunCell:
    """One engine's run of one scene."""

    scene: str
    engine: str
    setting: str
    outcome: Outcome
    reason: str
    rows: tuple[QuantityRow, ...]
    duration_s: float | None
    judged_share: float | None = None
    """Share of the run that was judged, up to the predictability limit and restarted beyond it"""
    shows_first_orbit: bool = False
    """Whether small tables show the first orbit's errors, because the comparison ends at the predictability limit"""

    def row(self, quantity: str) -> QuantityRow | None:
        """Row of a quantity."""
        return next((r for r in self.rows if r.quantity == quantity), None)

    @property
    def told(self) -> list[QuantityRow]:
        """Rows of a large table: those that tell something."""
        return [r for r in self.rows if not r.empty] or list(self.rows)

    @property
    def shows_kinetic_ratio(self) -> bool:
        """Whether the kinetic energy about the centre of mass was judged: the motion was followed beyond its limit."""
        return any(r.quantity == "relative_energy" and r.largest is not None for r in self.rows)

    @property
    def word(self) -> str:
        """Outcome in words."""
        return WORDS[self.outcome]

    @property
    def shown(self) -> list[QuantityRow]:
        """Rows of a small cell: attitude and reactions, or else the CM track."""
        found = [r for q in ("attitude", "reaction") if (r := self.row(q)) and r.largest is not None]
        return found or [r for r in (self.row("com"),) if r and r.largest is not None]

    def shown_value(self, row: QuantityRow) -> float | None:
        """Error of a row that a small cell shows."""
        return row.first_orbit if self.shows_first_orbit else row.largest

    @property
    def detection_limit(self) -> float | None:
        """Largest detection limit of the shown rows: a smaller relative error may have passed."""
        found = [r.detection_limit for r in self.shown if r.detection_limit is not None]
        return max(found, default=None)

    @property
    def limit_s(self) -> float | None:
        """Earliest end of a pointwise comparison, if before the end of the run."""
        found = [r.limit_s for r in self.rows if r.limit_s is not None]
        if not found or (self.duration_s and min(found) > SHORT_OF_THE_RUN * self.duration_s):
            return None
        return min(found)

    @property
    def worst_ratio(self) -> QuantityRow | None:
        """Row of the largest normalised error."""
        found = [r for r in self.rows if r.ratio is not None]
        return max(found, key=lambda r: r.ratio or 0.0, default=None)


@dataclass(frozen=True)
class Summary:
    """Input of the verdict and the matrix."""

    scenes: tuple[SceneRecord, ...]
    engines: tuple[str, ...]
    cells: dict[tuple[str, str], RunCell]
    finished: bool
    outside: frozenset[str] = frozenset()
    """Independent engines"""
    outside_known: bool = False
    """Whether the record tells which engines are independent"""

    def external(self, engine: str) -> bool:
        """Whether an engine's equations of motion are not barchain's own."""
        return engine in self.outside

    def shares_equations(self, cell: RunCell) -> bool:
        """Whether an engine steps the equations of the solution that judges it: agreement shows its arithmetic."""
        scene = next((s for s in self.scenes if s.name == cell.scene), None)
        shared = None if scene is None else scene.data.get("same_equations")
        return isinstance(shared, list) and cell.engine in shared

    def cell(self, scene: str, engine: str) -> RunCell | None:
        """Cell of a run; None if there was none."""
        return self.cells.get((scene, engine))

    def of_scene(self, scene: str) -> list[RunCell]:
        """Cells of a scene, in the engines' order."""
        return [c for e in self.engines if (c := self.cell(scene, e))]

    def of_several(self, scene: str) -> list[RunCell]:
        """Cells that concern several engines of a scene together."""
        return [c for (name, engine), c in self.cells.items() if name == scene and not is_engine(engine)]

    def shows_first_orbit(self, scene: str) -> bool:
        """Whether cells of a scene show the errors of the first orbit."""
        return any(c.shows_first_orbit for c in self.of_scene(scene))

    @property
    def unsolved(self) -> list[RunCell]:
        """Cells of scenes without a judging solution, with the reason."""
        return [c for s in self.scenes if (c := self.cell(s.name, JUDGING_SOLUTION))]

    @property
    def idle(self) -> list[RunCell]:
        """Cells of engines that should have been compared and were compared on no scene, with the reason."""
        return [c for (scene, _), c in self.cells.items() if scene == ALL_SCENES]

    def shown_in(self, scene: str) -> list[RunCell]:
        """Cells of a scene's own table: of the missing judging solution, if so, and of the engines."""
        return [*(c for c in self.unsolved if c.scene == scene), *self.of_scene(scene)]

    def of_track(self, scene: str) -> bool:
        """Whether an engine that follows the centre of mass alone was judged on a scene."""
        return any(c.row("com") and not c.row("attitude") for c in self.of_scene(scene))

    @cached_property
    def all(self) -> list[RunCell]:
        """All cells, scene by scene."""
        return [c for s in self.scenes for c in self.of_scene(s.name)]

    def with_outcome(self, *outcomes: Outcome) -> list[RunCell]:
        """Cells that ended so."""
        return [c for c in self.all if c.outcome in outcomes]


def summarise(results: StudyTables) -> Summary:
    """Gather the metrics of a result folder: the paper's scenes come first, then the others, each by name."""
    metrics, record = results.metrics, results.record
    recorded, facts = ({} if record.get(k) is None else record[k] for k in ("scenes", "engines"))
    names = [n for n in dict.fromkeys([*recorded, *metrics["scene"].astype(str)]) if n != ALL_SCENES]
    scenes = [SceneRecord(n, recorded.get(n, {})) for n in names]
    scenes.sort(key=lambda s: ("paper" not in s.tags and not s.name.startswith("paper/"), s.name))
    durations = {s.name: s.value("duration_s") for s in scenes}
    engines = list(dict.fromkeys([*facts, *sorted(set(metrics["engine"].astype(str)))]))
    pairs: dict[tuple[str, str], list[Row]] = {}
    for row in records(metrics):
        pairs.setdefault((str(row["scene"]), str(row["engine"])), []).append(row)
    cells = {pair: make_cell(*pair, pairs[pair], durations.get(pair[0])) for pair in sorted(pairs)}
    for scene in scenes:
        show_first_orbit(cells, scene)
    return Summary(
        tuple(scenes),
        tuple(e for e in engines if is_engine(e)),
        cells,
        finished=is_complete(record) or "finished" not in record,
        outside=frozenset(e for e, f in facts.items() if f.get("external")),
        outside_known=any("external" in f for f in facts.values()),
    )


def show_first_orbit(cells: dict[tuple[str, str], RunCell], scene: SceneRecord) -> None:
    """Mark all cells of a scene to show the errors of the first orbit, if most comparisons end before the run.

    Chaos ends the comparisons of all engines. A single one that ends early tells of its engine's round-off: the others'
    largest errors stay as they are. A comparison that ends within the first orbit shows its largest error.
    """
    own = {key: cell for key, cell in cells.items() if cell.scene == scene.name}
    compared = [cell for cell in own.values() if is_engine(cell.engine) and cell.shown]
    if 2 * sum(cell.limit_s is not None for cell in compared) <= len(compared):
        return
    for key, cell in own.items():
        whole = cell.limit_s is None or cell.limit_s >= scene.period_s
        if whole and cell.shown and all(r.first_orbit is not None for r in cell.shown):
            cells[key] = replace(cell, shows_first_orbit=True)


def make_cell(scene: str, engine: str, rows: list[Row], duration_s: float | None) -> RunCell:
    """Cell from all metric rows of one run."""
    there = {r["quantity"] for r in rows}
    order = [q for q in QUANTITY_UNITS if q in there] + sorted(there.difference(QUANTITY_UNITS))
    found = [make_row(quantity, [r for r in rows if r["quantity"] == quantity]) for quantity in order]
    worst = gravest(r.outcome for r in found)
    reason = "; ".join(
        r.reason if r.quantity == "run" else f"{r.name}: {r.reason}" for r in found if r.outcome is worst and r.reason
    )
    share = next((r["value"] for r in rows if r["metric"] == "judged_share" and known(r["value"])), None)
    return RunCell(scene, engine, str(rows[0]["setting"]), worst, reason, tuple(found), duration_s, share)


def make_row(quantity: str, rows: list[Row]) -> QuantityRow:
    """Row from all metric rows of one quantity of one run; NaN where a metric has a row without a number."""
    by_metric = {r["metric"]: r for r in rows if r["metric"] != "outcome"}
    largest = by_metric.get("max", by_metric.get("drift", {}))
    worst = gravest(Outcome(r["outcome"]) for r in rows)
    reasons = dict.fromkeys(r["reason"] for r in rows if r["outcome"] == worst and r["reason"])
    return QuantityRow(
        quantity=quantity,
        unit=largest.get("unit") or next((r["unit"] for r in rows if r["unit"]), QUANTITY_UNITS.get(quantity, "")),
        largest=largest.get("value"),
        bound=largest["tolerance"] if known(largest.get("tolerance")) else None,
        limit_s=min((r["limit_s"] for r in rows if known(r["limit_s"])), default=None),
        outcome=worst,
        reason="; ".join(reasons),
        **{field: by_metric[metric]["value"] if metric in by_metric else None for field, metric in METRIC_OF.items()},
    )
