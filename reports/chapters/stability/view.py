"""The stability study: from its tables to what the templates and the terminal show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.stability.charts import worst_panels
from reports.chapters.stability.long import LongScene, long_scenes, rounding_sentence
from reports.chapters.stability.rows import KINDS, LATE, SIGNS, EngineStability, SceneRows, known, outcomes, records
from reports.tables.stability import Stability, read_stability
from reports.text.numerals import number
from reports.text.record import mapping

if TYPE_CHECKING:
    from pathlib import Path

    from reports.plotting.panels import Panel
    from reports.tables.stability import StabilityTables

OFF_RAD = 0.01  # an attitude that is off by more has parted from the truth
FILES = {"coarse": "{}.coarse", "default": "{}", "finer": "{}.finer"}


@dataclass(frozen=True)
class Worst:
    """The run that went farthest wrong."""

    outcome: EngineStability
    title: str
    panels: tuple[Panel, ...]


@dataclass(frozen=True)
class StabilityView:
    """All that is shown."""

    record: dict[str, Any]
    engines: tuple[str, ...]
    scenes: tuple[SceneRows, ...]
    long: tuple[LongScene, ...]
    rounding: str
    plain: tuple[dict[str, Any], ...]
    worst: Worst | None

    @property
    def finished(self) -> bool:
        """Whether it came to its end."""
        return bool(self.record.get("finished"))

    @property
    def outcomes(self) -> tuple[EngineStability, ...]:
        """All outcomes."""
        return tuple(o for s in self.scenes for o in s.outcomes.values())

    @property
    def changes(self) -> tuple[EngineStability, ...]:
        """Those that are not as recorded."""
        return tuple(o for o in self.outcomes if o.change)

    @property
    def ours(self) -> tuple[EngineStability, ...]:
        """Where a form of the reference came in time, and is not stable."""
        mine = self.record.get("ours") or ()
        found = (o for o in self.outcomes if o.engine in mine and not o.slow)
        return tuple(o for o in found if o.stability is not Stability.STABLE)

    @property
    def late(self) -> tuple[EngineStability, ...]:
        """Where a form of the reference did not come in time."""
        mine = self.record.get("ours") or ()
        return tuple(o for o in self.outcomes if o.engine in mine and o.slow)

    @property
    def headline(self) -> str:
        """The result in a sentence."""
        mine = " and ".join(self.record.get("ours") or ())
        if not mine:
            return f"{len(self.engines)} engines in {len(self.scenes)} scenes."
        if not self.ours:
            scenes = all_of(len(self.scenes)) + (", or too slow to tell" if self.late else "")
            return f"{mine} {'are' if ' and ' in mine else 'is'} stable in {scenes}."
        where = dict.fromkeys(o.scene for o in self.ours)
        return f"Not stable in {len(where)} of {len(self.scenes)} hard scenes: {', '.join(where)}."

    @property
    def counts(self) -> dict[Stability, int]:
        """How many ended how."""
        return {s: n for s in Stability if (n := sum(o.stability is s for o in self.outcomes))}

    @property
    def sentences(self) -> tuple[str, ...]:
        """What stands below it."""
        counted = ", ".join(f"{n} {s}" for s, n in self.counts.items())
        late = sum(o.slow for o in self.outcomes)
        time = f" ({late} of the failed: not in time, which a faster machine may be)" if late else ""
        said = [f"Of {len(self.outcomes)} pairs of an engine and a scene: {counted}{time}."]
        if self.late:
            words = ", ".join(f"{o.engine} on {o.scene}" for o in self.late)
            said.append(f"Not in time, so that nothing is known: {words}.")
        if self.changes:
            said.append(f"{len(self.changes)} are not as they were recorded.")
        return tuple(said + [s for s in (self.plain_sentence, self.rounding) if s])

    @property
    def plain_sentence(self) -> str:
        """What SciPy says of itself at its own default tolerances, and what is so."""
        succeeded = [r for r in self.plain if r["run"] == "pass"]
        if not self.plain:
            return ""
        off = [r for r in succeeded if (known(r["attitude_rad"]) or 0.0) > OFF_RAD]
        ended = [r for r in succeeded if r["judged"] == "incomplete"]
        wrong = {(r["scene"], r["engine"]) for r in (*off, *ended)}
        return (
            f"SciPy at its defaults (rtol = 1e-3, atol = 1e-6): success reported in {len(succeeded)} of "
            f"{len(self.plain)} runs; in {len(wrong)} of these attitude is off by more than {OFF_RAD:g} rad, or the "
            f"run ends where the truth does not ({len(ended)})."
        )

    @property
    def signs(self) -> tuple[tuple[str, str, str, str], ...]:
        """Sign, name, class and meaning of every outcome."""
        found = [(SIGNS[s], str(s), KINDS[s], s.advice) for s in Stability]
        return (*found, (LATE, "time", "gone", "Failed by its time limit: a faster machine may see another outcome."))


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
    """Scenes in the order in which they were asked for."""
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
    """The run that went farthest wrong: of unstable ones that with the most energy, of inaccurate ones the least right.

    Only runs that left their attitude can be drawn.
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
