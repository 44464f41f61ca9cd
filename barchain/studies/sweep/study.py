"""The parameter sweep: numbers of a scene on grids or drawn, run in some engines, and measures of each run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from adapters.engine import EngineError
from barchain.record.environment import external_versions
from barchain.record.scene_description import scene_facts
from barchain.runs.cases import run_cases
from barchain.runs.choices import choose_setting, chosen_engines, engine_facts
from barchain.runs.estimate import need_runnable
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import TIME_LIMIT_S
from barchain.studies.distributions import VariationError
from barchain.studies.sweep.batch import Batch, runs_of
from barchain.studies.sweep.measure import measures_of
from barchain.studies.sweep.variation import VariedScene, points_of, variations_of
from reports.results.outcome import Outcome
from reports.results.sweep import FILES, samples_of
from scenarios.key_words import unit

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    import pandas as pd

    from adapters.engine import Setting
    from adapters.registry import Registration
    from barchain.record.study_store import StudyStore
    from barchain.runs.executors import Executor
    from barchain.studies.study import Reporter
    from barchain.studies.sweep.batch import MeasuredRun
    from barchain.studies.sweep.measure import Measure
    from barchain.studies.sweep.variation import Variation
    from reports.results.files import StudyFiles
    from reports.results.rows import Row
    from scenarios import Scene

RUNS = 1000
"""Of each point of the grids, where numbers are drawn"""
BATCHES = 64
"""Of one engine: progress is smooth, an interruption costs little, and all processes have work to the end"""
MOST_IN_BATCH = 100
"""A call takes some ten milliseconds, a run of a short scene few: a larger batch would gain nothing"""


@dataclass(frozen=True)
class SweepResult:
    """Samples of a sweep."""

    samples: pd.DataFrame
    """One row a run: run, engine, setting, a column for each number that varies, outcome, reason, seconds, and a column
    for each measure, NaN where a run does not give it"""
    failures: tuple[str, ...] = ()
    """One line for each engine with failed runs, and for each measure that no run gives"""

    @property
    def passed(self) -> bool:
        """Whether no run failed, and every measure has a value."""
        return not self.failures


@dataclass(frozen=True)
class SweepStudy:
    """Runs of a scene with other numbers."""

    scene: Scene
    engines: dict[str, tuple[Registration, Setting]]
    variations: tuple[Variation, ...]
    points: tuple[tuple[float, ...], ...]
    """Values of the variations in each run"""
    measures: tuple[Measure, ...]
    seed: int
    time_limit_s: float
    """Wall time of one run"""
    executor: Executor = ALL_CORES
    files: ClassVar[StudyFiles] = FILES

    @property
    def paths(self) -> tuple[str, ...]:
        """Numbers that vary."""
        return tuple(each.path for each in self.variations)

    def record(self) -> dict[str, Any]:
        """Scene, engines, variations and measures."""
        return {
            "packages": external_versions({name: registration for name, (registration, _) in self.engines.items()}),
            "engines": {name: engine_facts(registration) for name, (registration, _) in self.engines.items()},
            "scene": {"name": self.scene.name} | scene_facts(self.scene),
            "vary": list(dict.fromkeys(each.text for each in self.variations)),
            "varied": {each.path: each.kind for each in self.variations},
            "measures": {str(measure): measure.channel.unit for measure in self.measures},
            "runs": len(self.points),
            "seed": self.seed,
            "time_limit_s": self.time_limit_s,
        }

    def batches(self) -> Iterator[tuple[range, Batch]]:
        """Batches with the numbers of their runs, engine by engine."""
        size = min(MOST_IN_BATCH, -(-len(self.points) // BATCHES))
        for name, (registration, setting) in self.engines.items():
            for first in range(0, len(self.points), size):
                numbers = range(first, min(first + size, len(self.points)))
                points = self.points[numbers.start : numbers.stop]
                yield numbers, Batch(self.scene, name, registration, setting, self.measures, self.paths, points)

    def run(self, store: StudyStore, reporter: Reporter) -> SweepResult:
        """Make all runs; an interrupted sweep leaves those so far."""
        store.write("values", [
            {"run": number, "quantity": each.path, "value": value, "unit": unit(each.path) or "1"}
            for number, point in enumerate(self.points, 1)
            for each, value in zip(self.variations, point, strict=True)
        ])  # fmt: skip
        batches = list(self.batches())
        tables: dict[str, dict[int, list[Row]]] = {"runs": {}, "measures": {}}
        cases = ((k, runs_of(batch, self.time_limit_s)) for k, (_, batch) in enumerate(batches))
        with reporter.counted("runs", len(self.engines) * len(self.points)) as done:
            for k, found in run_cases(cases, self.executor):
                numbers, batch = batches[k]
                tables["runs"][k], tables["measures"][k] = rows_of(numbers, batch, found)
                for name, parts in tables.items():  # in the order of the batches, whichever ends first
                    store.write(name, [row for number in sorted(parts) for row in parts[number]])
                done(len(found))
        samples = samples_of(*(store.read(name) for name in ("values", "runs", "measures")))
        return SweepResult(samples, failures(samples, self.measures))


def rows_of(numbers: range, batch: Batch, found: Iterable[MeasuredRun]) -> tuple[list[Row], list[Row]]:
    """Rows of the runs of a batch, and of their measures."""
    runs: list[Row] = []
    measured: list[Row] = []
    for number, run in zip(numbers, found, strict=True):
        place = {"engine": batch.engine, "setting": str(batch.setting), "run": number + 1}
        runs.append(place | {"outcome": run.outcome, "reason": run.reason, "seconds": run.seconds})
        measured += [
            place | {"quantity": str(measure), "value": value, "unit": measure.channel.unit}
            for measure, value in zip(batch.measures, run.values, strict=True)
        ]
    return runs, measured


def failures(samples: pd.DataFrame, measures: Iterable[Measure]) -> tuple[str, ...]:
    """Engines with failed runs, engines that run nowhere, and measures that no run gives; one line each."""
    lines = []
    for engine, own in samples.groupby("engine", sort=False):
        bad = own[~own["outcome"].isin([Outcome.PASS.value, Outcome.UNSUPPORTED.value])]
        bad = bad if len(bad) or (own["outcome"] == Outcome.PASS.value).any() else own
        if len(bad):
            first = bad.iloc[0]
            end = f"run {first['run']:.0f}: {first['outcome']}: {first['reason']}"
            lines.append(f"{engine}: {len(bad)} of {len(own)} runs gave no result, the first of them {end}")
    passed = samples[samples["outcome"] == Outcome.PASS.value]
    unmeasured = [str(measure) for measure in measures if len(passed) and passed[str(measure)].isna().all()]
    return (*lines, *(f"{name}: no run gives it: {passed['reason'].iloc[0]}" for name in unmeasured))


def sweep_study(
    scene: Scene,
    vary: Iterable[str],
    measures: Iterable[str] = (),
    *,
    engines: Iterable[str],
    settings: Mapping[str, Mapping[str, float]] | None = None,
    runs: int | None = None,
    seed: int = 1,
    time_limit_s: float = TIME_LIMIT_S,
    executor: Executor = ALL_CORES,
) -> SweepStudy:
    """Parameter sweep; its parameters are those of :func:`barchain.sweep`.

    Every scene is made and checked here, before anything runs.

    Raises
    ------
    UnknownEngineError, SettingError
        If an engine or a setting does not exist.
    VariationError, MeasureError
        If a variation or a measure can't be read, or the scene refuses a value.
    EngineError
        If an engine is not installed.
    ClusterError
        If a Dask cluster can't be used.
    """
    variations = variations_of(scene, vary)
    if runs is not None and not any(each.family for each in variations):
        raise VariationError(f"--runs {runs}: no number is drawn, allowed: beside --vary KEY=DISTRIBUTION(...)")
    points = points_of(variations, runs or RUNS, seed)
    most_bars, varied, paths = scene, VariedScene(scene), [each.path for each in variations]
    for point in points:
        one = varied.at(dict(zip(paths, point, strict=True)))
        need_runnable([one], time_limit_s)
        most_bars = max(most_bars, one, key=lambda each: each.bars)
    chosen = chosen_engines(engines)
    for name, registration in chosen.items():
        if registration.missing:
            raise EngineError(f"{name}: {registration.missing}")
    with_settings = {
        name: (registration, choose_setting(name, (settings or {}).get(name, {}), chosen))
        for name, registration in chosen.items()
    }
    executor.check()
    found = measures_of(measures, most_bars)
    return SweepStudy(scene, with_settings, variations, tuple(points), found, seed, time_limit_s, executor)
