"""The scaling study: time of an evaluation and of an orbit, and memory, against the number of bars.

One chain is cut into more and more bars. All engines go to :data:`COMMON_BARS` before any goes on, so that each has
points enough for an exponent. Within that, and beyond, what is cheap comes first: engines take turns as long as a point
costs little more than its process, and those that get expensive wait, so that a budget that runs out has been spent on
as many points as it could. Each engine goes as far as its time limit allows. What the budget allows follows from the
times of the points so far, so that a study that goes on measures the same ones.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from adapters.registry import engines
from adapters.trajectory import Observable
from barchain.record.environment import external_versions
from barchain.record.scene_description import scene_words
from barchain.runs.asking import declarations_of
from barchain.runs.cases import run_cases
from barchain.runs.choices import chosen_engines, engine_facts
from barchain.runs.executors import ONE_BY_ONE
from barchain.runs.job import Job, Role
from barchain.runs.left_out import cannot, failures, said
from barchain.runs.phases import installed
from barchain.studies.defaults import BARS, DIVIDED_SCENE, FAST, SCALING
from barchain.studies.scaling.point import BUILDS, ScalingTask, measured_point
from barchain.studies.study import StudyEnd
from barchain.studies.timing.bench import OtherLoad, TimingBench
from barchain.studies.timing.evaluation import DIRECT, divided
from barchain.studies.timing.statistics import FEWEST, Interval, slope
from reports.results.outcome import Outcome
from reports.results.rows import NOT_RUN
from reports.results.scaling import EXPONENTS, FILES, POINTS
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    import pandas as pd

    from adapters.registry import Registration
    from adapters.trajectory import Array
    from barchain.record.study_store import StudyStore
    from barchain.runs.cases import Case
    from barchain.runs.executors import Executor
    from barchain.studies.study import Reporter
    from reports.results.files import StudyFiles
    from reports.results.rows import Row
    from scenarios import Scene

WARM_BARS = 3  # not a number that is measured: an adapter may keep what it compiled for one
FAILURES = 2  # in succession, after which more bars are not tried
NEVER = (
    Outcome.UNSUPPORTED,
    Outcome.MISSING,
    Outcome.TIMED_OUT,
    NOT_RUN,
)  # what more bars don't change
COMMON_BARS = 100
PROCESS_S = 4.0  # that a point takes whatever it runs: a process, imports, warming up, evaluations
MEMORY_SHARE = 0.5  # of the machine's memory that a model may take


@dataclass(frozen=True)
class ScalingStudy:
    """Engines, numbers of bars, and limits of time."""

    scene: Scene
    engines: dict[str, Registration]
    bars: tuple[int, ...]
    """At least 2; each engine goes as far as the limits allow"""
    repeats: int = SCALING.repeats
    """Times that each point is measured"""
    minutes: float = SCALING.minutes
    """Budget, after which no point is begun"""
    time_limit_s: float = SCALING.time_limit_s
    """Of one simulation: orbits that are expected to take longer are run in part, or not at all"""
    named: frozenset[str] = frozenset()
    """Engines that were asked for by name"""
    executor: Executor = ONE_BY_ONE
    files: ClassVar[StudyFiles] = FILES

    @property
    def turns(self) -> int:
        """Number of points to be reported, those that are not run among them."""
        return len(self.engines) * len(self.bars)

    def job(self, engine: str, bars: int, share: float) -> Job:
        """Run of the chain of `bars` bars over a share of its orbit, at the engine's default setting."""
        registration = self.engines[engine]
        setting = declarations_of(registration).sweep.setting()
        return Job(divided(self.scene, bars, share), engine, registration, setting, Role.MAIN)

    def record(self) -> dict[str, Any]:
        """Engines, chain, limits, and the targets, which follow at the end."""
        return {
            "packages": external_versions(self.engines),
            "engines": {name: engine_facts(r) for name, r in self.engines.items()},
            "bars": list(self.bars),
            "scene": scene_words(self.scene) | {"name": self.scene.name, "size_m": self.scene.size_m},
            "targets": [],
            "limits": {name: getattr(self, name) for name in ("repeats", "minutes", "time_limit_s")},
        }

    def run(self, store: StudyStore, reporter: Reporter) -> StudyEnd:
        """Measure points in the order of their expected time; an interrupted run leaves those measured so far."""
        run = ScalingRun(self, store, reporter)
        try:
            for _ in run_cases([(self.files.study, run.measured())], self.executor):
                pass
        finally:
            points = run.points()
            fits = fits_table(points)
            store.record["targets"] = targets(points, fits)
            store.write("exponents", fits)
            store.write("points", points)
        out = (str(Outcome.MISSING), str(Outcome.UNSUPPORTED))
        ran = {row["engine"] for row in run.rows if row["outcome"] not in out}
        idle = {row["engine"]: row["reason"] for row in run.rows if row["engine"] not in ran}
        return StudyEnd(failures(run.rows, self.named), idle, tuple(row["outcome"] for row in run.rows))


def scaling_study(engine_names: Iterable[str] | None = None, bars: Iterable[int] = BARS, **limits: Any) -> ScalingStudy:
    """Scaling study of engines, all registered ones by default, also those that only studies run.

    Further arguments are fields of the study.

    Raises
    ------
    UnknownEngineError
        For an engine that does not exist.
    ValueError
        For a number of bars below 2.
    """
    wanted = tuple(sorted(set(bars)))
    if not wanted or wanted[0] < 2:
        raise ValueError(f"bars {', '.join(map(str, wanted))}: allowed: 2 or more")
    chosen = engines() if engine_names is None else chosen_engines(engine_names)
    named = frozenset(() if engine_names is None else chosen)
    return ScalingStudy(load_scene(DIVIDED_SCENE), chosen, wanted, named=named, **limits)


class ScalingRun:
    """One run of the study over many engines on one chain."""

    def __init__(self, study: ScalingStudy, store: StudyStore, reporter: Reporter) -> None:
        """Prepare; `reporter` gets scene, engine and bars, and outcome after each point."""
        self.study, self.store, self.report = study, store, reporter.step
        self.bench = TimingBench()
        self.rows: list[Row] = []
        """Points so far"""
        self.done: dict[str, int] = {}
        self.failed: dict[str, int] = {}

    @property
    def over(self) -> bool:
        """Whether the budget is used up."""
        return self.bench.spent_s >= 60.0 * self.study.minutes

    def measured(self) -> Case[None]:
        """Measure the cheapest point that is left, again and again."""
        load = OtherLoad()
        while ahead := {e: n for e in self.study.engines if (n := self.next_bars(e))}:
            yield from self.point(*min(ahead.items(), key=lambda pair: self.price(*pair)))
            self.store.record["other_processors"] = load.processors()
            self.store.write("points", self.points())

    def points(self) -> pd.DataFrame:
        """All points so far, engine by engine as they first came."""
        order = list(dict.fromkeys(row["engine"] for row in self.rows))
        return POINTS.framed(sorted(self.rows, key=lambda row: order.index(row["engine"])))

    def next_bars(self, engine: str) -> int:
        """Bars of an engine's next point; 0 if there is none."""
        done = self.done.get(engine, 0)
        return 0 if done >= len(self.study.bars) else self.study.bars[done]

    def expected(self, engine: str, column: str, bars: int) -> float:
        """Cost of an engine's point by those of its points with fewer bars; 0 where nothing is known."""
        known = [(row["bars"], float(row[column])) for row in self.rows if row["engine"] == engine and column in row]
        return predicted([n for n, _ in known], [cost for _, cost in known], bars)

    def price(self, engine: str, bars: int) -> tuple[bool, float, int]:
        """Order of points: whether a point can wait, then its expected time, s, then its bars."""
        orbit_s = self.expected(engine, "orbit_s", bars)
        run_s = affordable(orbit_s, self.study.time_limit_s) * orbit_s
        return bars > COMMON_BARS, max(PROCESS_S, self.expected(engine, "build_s", bars) + run_s), bars

    def point(self, engine: str, bars: int) -> Case[None]:
        """One engine at one number of bars; those that are not worth a try after it are reported with it."""
        columns = yield from self.columns(engine, bars)
        self.rows.append({"engine": engine, "bars": bars} | columns)
        self.report(self.study.scene.name, f"{engine}, {bars} bars", said(columns))
        self.done[engine] = self.done.get(engine, 0) + 1
        self.failed[engine] = 0 if columns["outcome"] == Outcome.PASS else self.failed.get(engine, 0) + 1
        if columns["outcome"] in NEVER or self.failed[engine] >= FAILURES:
            for more in self.study.bars[self.done[engine] :]:
                self.report(self.study.scene.name, f"{engine}, {more} bars", f"{NOT_RUN}, as with {bars} bars")
            self.done[engine] = len(self.study.bars)

    def columns(self, engine: str, bars: int) -> Case[Row]:
        """Columns of a point, whether it can be run or not."""
        registration = self.study.engines[engine]
        out = cannot(divided(self.study.scene, bars), engine, registration)
        if out is not None:
            return {"outcome": str(out.outcome), "reason": out.reason}
        if Observable.ATTITUDE not in declarations_of(registration).observables:
            reason = "it follows the centre of mass alone, whatever the number of bars"
            return {"outcome": str(Outcome.UNSUPPORTED), "reason": reason}
        share, reason = self.share(engine, bars)
        if not share and (engine not in DIRECT or self.over):
            return {"outcome": NOT_RUN, "reason": reason}
        job, warm = self.study.job(engine, bars, share or SHARES[-1]), self.study.job(engine, WARM_BARS, SHARES[-1])
        task = ScalingTask(job, warm, share, self.study.repeats)
        found = yield from measured_point(self.bench, task, self.study.time_limit_s)
        if reason and found["outcome"] == Outcome.PASS.value:
            found["reason"] = f"orbit {NOT_RUN}: {reason}"
        return found

    def share(self, engine: str, bars: int) -> tuple[float, str]:
        """Share of an orbit to be run; 0 with the reason if none."""
        if self.over:
            return 0.0, f"the study's {self.study.minutes:g} minutes were over"
        build_s = self.expected(engine, "build_s", bars)
        if build_s > BUILDS * self.study.time_limit_s:
            return 0.0, f"building its model would take about {rounded(build_s)}"
        memory_B = self.expected(engine, "memory_B", bars)
        if memory_B > MEMORY_SHARE * installed():
            return 0.0, f"its model would take about {memory_B / 1e9:.2g} GB of memory"
        orbit_s = self.expected(engine, "orbit_s", bars)
        share = affordable(orbit_s, self.study.time_limit_s)
        if share:
            return share, ""
        return 0.0, f"would take about {rounded(orbit_s)}, the smallest share {rounded(SHARES[-1] * orbit_s)}"


def rounded(seconds: float) -> str:
    """Expected time to two digits, in the unit that suits it."""
    for unit, size_s in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size_s:
            return f"{seconds / size_s:.2g} {unit}"
    return f"{seconds:.2g} s"


SHARES = (1.0, 0.5, 0.2, 0.1, 0.05)  # of an orbit; the last is two steps between samples for the fewest steps taken
LAST = 3  # points that tell how costs grow
FEW_EXPONENT, MOST_GROWTH = 2.0, 3.0  # beyond which growth is not believed, of fewer points and of all of them
LEAST_BARS = 20  # fewer have more of a call's own price in them than of the bars'
FAST_BARS = (100, 100_000)  # where the compiled reference's evaluation is fitted
LEAST_MEMORY_B = 2.0**20  # what allocators keep in store hides less
QUANTITIES = {
    "evaluation": "evaluation_s",
    "orbit": "orbit_s",
    "memory": "memory_B",
    "evaluations per orbit": "evaluations",
    "steps per orbit": "steps",
}
LONG = (500, 100_000)  # bars
MOST_EXPONENT, MOST_SHORT_S, MOST_PER_BAR_S = 1.05, 1e-6, 50e-9


def predicted(bars: Sequence[int], cost: Sequence[float], wanted: int) -> float:
    """Cost at `wanted` bars by the last points' own exponent; 0 where nothing is known.

    Points come in order of rising N; costs that are not positive numbers are none.
    """
    known = [(n, c) for n, c in zip(bars, cost, strict=True) if math.isfinite(c) and c > 0.0][-LAST:]
    if not known:
        return 0.0
    n, c = known[-1]
    exponent = FEW_EXPONENT
    if len(known) > 1:
        x, y = np.log([k[0] for k in known]), np.log([k[1] for k in known])
        exponent = float(np.clip(np.polyfit(x, y, 1)[0], 0.0, MOST_GROWTH if len(known) == LAST else FEW_EXPONENT))
    return float(c * (wanted / n) ** exponent)


def affordable(orbit_s: float, limit_s: float) -> float:
    """Largest share of an orbit that keeps to the limit; 0 if even the smallest does not."""
    return next((share for share in SHARES if share * orbit_s <= limit_s), 0.0)


def exponent(bars: Array, cost: Array) -> Interval | None:
    """Exponent p of ``cost = C N^p`` by least squares in both logarithms, with Student's interval.

    None of fewer than :data:`FEWEST` points: two always lie on a line.
    """
    good = np.isfinite(cost) & (cost > 0.0)
    if good.sum() < FEWEST:
        return None
    if np.ptp(cost[good]) == 0.0:
        return Interval(0.0, 0.0, 0.0)
    return slope(np.log(bars[good]), np.log(cost[good]))


def fit_row(rows: pd.DataFrame, quantity: str) -> dict[str, Any] | None:
    """One engine's exponent of one quantity; None if there are too few points."""
    engine = str(rows.engine.iloc[0])
    least, most = FAST_BARS if engine == FAST and quantity == "evaluation" else (LEAST_BARS, math.inf)
    floor = LEAST_MEMORY_B if quantity == "memory" else 0.0
    bars, cost = rows.bars.to_numpy(float), rows[QUANTITIES[quantity]].to_numpy(float)
    used = (bars >= least) & (bars <= most) & (cost > floor)
    found = exponent(bars[used], cost[used])
    if found is None:
        return None
    per = rows.per[used].iloc[-1] if quantity == "evaluation" else ""
    ends = {"points": used.sum(), "bars_from": bars[used].min(), "bars_to": bars[used].max()}
    value = {"exponent": found.value, "low": found.low, "high": found.high}
    return {"engine": engine, "quantity": quantity, "per": per} | value | ends


def fits_table(points: pd.DataFrame) -> pd.DataFrame:
    """All exponents."""
    found = [fit_row(own, q) for _, own in points.groupby("engine", sort=False) for q in QUANTITIES]
    return EXPONENTS.framed(r for r in found if r)


def targets(points: pd.DataFrame, fits: pd.DataFrame) -> list[dict[str, Any]]:
    """Targets of the compiled reference's evaluation and the measured values; empty if it was not measured."""
    own = points[points.engine == FAST].set_index("bars").evaluation_s
    found = [target("one evaluation of 5 bars", own.get(5, math.nan), MOST_SHORT_S, "s")]
    found += [target(f"one evaluation of {n} bars, a bar", own.get(n, math.nan) / n, MOST_PER_BAR_S, "s") for n in LONG]
    fit = fits[(fits.engine == FAST) & (fits.quantity == "evaluation")]
    whole = fit[(fit.bars_from == FAST_BARS[0]) & (fit.bars_to == FAST_BARS[1])]
    value = float(whole.exponent.iloc[0]) if len(whole) else math.nan
    found.append(
        target(f"exponent of one evaluation between {FAST_BARS[0]} and {FAST_BARS[1]} bars", value, MOST_EXPONENT, "")
    )
    return [t for t in found if math.isfinite(t["measured"])]


def target(what: str, measured: float, most: float, unit: str) -> dict[str, Any]:
    """One of them."""
    return {"what": what, "measured": float(measured), "most": most, "unit": unit, "met": bool(measured <= most)}
