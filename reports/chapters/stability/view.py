"""View of a stability study, for the page and the terminal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.stability.charts import worst_panels
from reports.chapters.stability.long_runs import LongScene, long_scenes, rounding_sentence
from reports.chapters.stability.rows import KINDS, LATE, SIGNS, EngineStability, SceneRows, known, outcomes, records
from reports.tables.stability import Stability, read_stability
from reports.text.numerals import number
from reports.text.record import is_complete, mapping

if TYPE_CHECKING:
    from pathlib import Path

    from reports.plotting.panels import Panel
    from reports.tables.stability import StabilityTables

LARGE_ERROR_RAD = 0.01  # of the attitude: a larger error counts as wrong
FILES = {"coarse": "{}.coarse", "default": "{}", "finer": "{}.finer"}


@dataclass(frozen=True)
class Worst:
    """Run with the largest deviation."""

    outcome: EngineStability
    title: str
    panels: tuple[Panel, ...]


@dataclass(frozen=True)
class StabilityView:
    """Contents of the page."""

    record: dict[str, Any]
    engines: tuple[str, ...]
    scenes: tuple[SceneRows, ...]
    long: tuple[LongScene, ...]
    rounding: str
    plain: tuple[dict[str, Any], ...]
    worst: Worst | None

    @property
    def finished(self) -> bool:
        """Whether the study was finished."""
        return is_complete(self.record)

    @property
    def outcomes(self) -> tuple[EngineStability, ...]:
        """All outcomes."""
        return tuple(o for s in self.scenes for o in s.outcomes.values())

    @property
    def changes(self) -> tuple[EngineStability, ...]:
        """Outcomes that differ from the recorded ones."""
        return tuple(o for o in self.outcomes if o.change)

    @property
    def unstable_reference(self) -> tuple[EngineStability, ...]:
        """Outcomes of forms of the reference that finished in time and are not stable."""
        mine = self.record.get("references") or ()
        found = (o for o in self.outcomes if o.engine in mine and not o.slow)
        return tuple(o for o in found if o.stability is not Stability.STABLE)

    @property
    def late(self) -> tuple[EngineStability, ...]:
        """Outcomes of forms of the reference that timed out."""
        mine = self.record.get("references") or ()
        return tuple(o for o in self.outcomes if o.engine in mine and o.slow)

    @property
    def headline(self) -> str:
        """Result in one sentence."""
        mine = " and ".join(self.record.get("references") or ())
        if not mine:
            return f"{len(self.engines)} engines in {len(self.scenes)} scenes."
        if not self.unstable_reference:
            scenes = all_of(len(self.scenes)) + (", apart from timed-out runs" if self.late else "")
            return f"{mine} {'are' if ' and ' in mine else 'is'} stable in {scenes}."
        where = dict.fromkeys(o.scene for o in self.unstable_reference)
        return f"Not stable in {len(where)} of {len(self.scenes)} hard scenes: {', '.join(where)}."

    @property
    def counts(self) -> dict[Stability, int]:
        """Number of outcomes by class."""
        return {s: n for s in Stability if (n := sum(o.stability is s for o in self.outcomes))}

    @property
    def sentences(self) -> tuple[str, ...]:
        """Sentences below the headline."""
        counted = ", ".join(f"{n} {s}" for s, n in self.counts.items())
        late = sum(o.slow for o in self.outcomes)
        time = f" ({late} of the failed runs timed out; a faster machine may finish them)" if late else ""
        said = [f"Of {len(self.outcomes)} pairs of an engine and a scene: {counted}{time}."]
        if self.late:
            words = ", ".join(f"{o.engine} on {o.scene}" for o in self.late)
            said.append(f"Timed out, outcome unknown: {words}.")
        if self.changes:
            said.append(f"{len(self.changes)} outcomes differ from the recorded ones.")
        return tuple(said + [s for s in (self.plain_sentence, self.rounding) if s])

    @property
    def plain_sentence(self) -> str:
        """Sentence on SciPy at its default tolerances: reported success against actual errors."""
        succeeded = [r for r in self.plain if r["run"] == "pass"]
        if not self.plain:
            return ""
        off = [r for r in succeeded if (known(r["attitude_rad"]) or 0.0) > LARGE_ERROR_RAD]
        ended = [r for r in succeeded if r["judged"] == "incomplete"]
        wrong = {(r["scene"], r["engine"]) for r in (*off, *ended)}
        return (
            f"SciPy at its defaults (rtol = 1e-3, atol = 1e-6): success reported in {len(succeeded)} of "
            f"{len(self.plain)} runs; in {len(wrong)} of these the attitude error exceeds {LARGE_ERROR_RAD:g} rad, or "
            f"the run ends at another instant than the reference solution ({len(ended)})."
        )

    @property
    def signs(self) -> tuple[tuple[str, str, str, str], ...]:
        """Sign, name, class and meaning of every outcome."""
        found = [(SIGNS[s], str(s), KINDS[s], s.advice) for s in Stability]
        return (
            *found,
            (LATE, "timed out", "gone", "Ended at the time limit; a faster machine may give another outcome."),
        )


def all_of(scenes: int) -> str:
    """``all 33 hard scenes``."""
    return "the one hard scene" if scenes == 1 else f"all {scenes} hard scenes"


def view_stability(folder: Path) -> StabilityView:
    """View of the study in a result folder."""
    tables = read_stability(folder)
    found = outcomes(tables.outcomes)
    engines = tuple(mapping(tables.record.get("engines")))
    scenes = scene_rows(tables, found, engines)
    long = long_scenes(tables, engines)
    return StabilityView(
        tables.record,
        engines,
        scenes,
        long,
        rounding_sentence(tables.laws),
        tuple(records(tables.plain)),
        find_worst(tables, found),
    )


def scene_rows(
    tables: StabilityTables, found: dict[tuple[str, str], EngineStability], engines: tuple[str, ...]
) -> tuple[SceneRows, ...]:
    """Scenes in the order of the command."""
    evidence: dict[str, list[dict[str, Any]]] = {}
    for row in records(tables.evidence):
        evidence.setdefault(str(row["scene"]), []).append(row)
    about = mapping(tables.record.get("scenes"))
    return tuple(
        SceneRows(
            name,
            mapping(words),
            {e: found[name, e] for e in engines if (name, e) in found},
            tuple(evidence.get(name, ())),
        )
        for name, words in about.items()
    )


def find_worst(tables: StabilityTables, found: dict[tuple[str, str], EngineStability]) -> Worst | None:
    """Run with the largest deviation: largest energy of unstable runs, else largest error of inaccurate ones.

    Only runs with a stored attitude can be drawn.
    """
    rows = {(r["scene"], r["engine"]): r for r in records(tables.evidence) if r["level"] == "default"}
    for kind, measure in ((Stability.UNSTABLE, "kinetic_ratio"), (Stability.INACCURATE, "attitude_rad")):
        own = [(p, known(rows[p][measure])) for p, o in found.items() if o.stability is kind and p in rows]
        for pair, _ in sorted(((p, v) for p, v in own if v is not None), key=lambda x: -x[1]):
            panels = drawn(tables, *pair)
            if panels:
                title = str(mapping(mapping(tables.record.get("scenes")).get(pair[0])).get("title") or pair[0])
                return Worst(found[pair], title, tuple(panels))
    return None


def drawn(tables: StabilityTables, scene: str, engine: str) -> list[Panel]:
    """Charts of one engine's runs in one scene."""
    solution = tables.trajectory(scene, "solution")
    runs = {k: f for k, name in FILES.items() if (f := tables.trajectory(scene, name.format(engine))) is not None}
    if solution is None or not runs:
        return []
    about = mapping(mapping(tables.record.get("scenes")).get(scene))
    period, duration = number(about.get("period_s")) or 0.0, number(about.get("duration_s")) or 0.0
    in_orbits = period > 0.0 and duration > 0.5 * period
    return worst_panels(engine, runs, solution, period if in_orbits else 1.0, "orbits" if in_orbits else "s")
