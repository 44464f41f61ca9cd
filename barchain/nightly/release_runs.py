"""Study of the releases of an engine: each release in an environment of its own, on the same scenes."""

from __future__ import annotations

import math
import re
import statistics
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar

from packaging.version import Version

from barchain.nightly.environments import dependencies_at, installed_tree, pinned_environment, run_in
from barchain.nightly.faults import HistoryError, PinnedEnvironmentError
from barchain.nightly.figures import FigureKind
from barchain.nightly.releases import Release, ReleasesPlan
from barchain.nightly.results import read_figures_of
from barchain.record.scene_description import scene_words
from barchain.runs.call import Answer, Call
from barchain.runs.environment import scratch_folder
from barchain.runs.kept_answers import AnswerStore
from barchain.runs.message import message_bytes, read_message
from reports.tables.nights.releases import FILES, ReleaseState
from reports.tables.outcome import Outcome
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from barchain.nightly.environments import PinnedEnvironment
    from barchain.nightly.figures import Figure
    from barchain.nightly.releases import ReleasesPlan
    from barchain.record.study_store import StudyStore
    from barchain.studies.study import Reporter
    from reports.tables.files import StudyFiles


IMPORT = "import time; t = time.perf_counter(); import {module}; print(time.perf_counter() - t)"
IMPORTS = 5
"""Imports that are timed, the first one among them; the median is taken"""
SIZE = """
import sys
from importlib import metadata
files = [file.locate() for file in metadata.distribution(sys.argv[1]).files or ()]
print(sum(path.stat().st_size for path in files if path.is_file()))
"""
"""Program that prints the size of a distribution, B"""
ERROR_METRIC = ".max"
RATIO = "time_ratio"
RUN_FAULTS = {str(o) for o in (Outcome.FAILED, Outcome.TIMED_OUT, Outcome.MISSING)}
"""Verdicts of runs that gave no trajectory"""
ADDRESS = re.compile(r" at 0x[0-9a-f]+")
"""Address of an object in an error's text, another one in each process"""


@dataclass
class MeasuredRelease:
    """Rows of one release."""

    release: dict[str, Any]
    errors: list[dict[str, Any]] = field(default_factory=list)
    runs: list[dict[str, Any]] = field(default_factory=list)
    times: list[dict[str, Any]] = field(default_factory=list)


def measure(plan: ReleasesPlan, release: Release, tree: Path, scratch: Path) -> MeasuredRelease:
    """Rows of a release; a release that does not run has the reason.

    Parameters
    ----------
    plan : ReleasesPlan
    release : Release
    tree : Path
        Today's sources of barchain.
    scratch : Path
        Empty folder for results.
    """
    place = {"engine": plan.engine, "version": str(release.version)}
    found = MeasuredRelease(
        place | {"released": release.date, "wheel_B": release.wheel_B, "state": str(ReleaseState.RUNS)}
    )
    try:
        environment, facts, note = working_environment(plan, release, tree, scratch)
    except PinnedEnvironmentError as error:
        found.release |= {"state": str(ReleaseState.NOT_INSTALLED), "reason": str(error)}
        return found
    fault = str(facts.pop("fault", ""))
    found.release |= facts
    fault = fault or compare(plan, environment, tree, scratch, found)
    if fault:
        found.release |= {"state": str(ReleaseState.FAILS), "reason": ADDRESS.sub("", fault)}
        return found
    untimed = time(plan, environment, tree, scratch, found) if plan.timed else ""
    found.release["reason"] = "; ".join(filter(None, (note, untimed and f"not timed: {untimed}")))
    return found


def working_environment(
    plan: ReleasesPlan, release: Release, tree: Path, scratch: Path
) -> tuple[PinnedEnvironment, dict[str, Any], str]:
    """Environment in which a release imports, the facts of it, and a note on its dependencies.

    Dependencies of today come first. A release that does not import with them is tried with those of its own time.
    The facts have the entry ``fault`` if it imports with neither.

    Raises
    ------
    PinnedEnvironmentError
        If the release can't be installed.
    """
    pin = f"{plan.distribution}=={release.version}"
    today = pinned_environment([pin], also=plan.also)
    facts = described(plan, today, tree, scratch)
    if "fault" not in facts:
        return today, facts, ""
    try:
        dated = pinned_environment([*dependencies_at(pin, release.date), pin], also=plan.also)
    except PinnedEnvironmentError:
        return today, facts, ""
    dated_facts = described(plan, dated, tree, scratch)
    if "fault" in dated_facts:
        return today, facts, ""
    return dated, dated_facts, f"with the dependencies of its own time; with today's: {facts['fault']}"


def described(plan: ReleasesPlan, environment: PinnedEnvironment, tree: Path, scratch: Path) -> dict[str, Any]:
    """Distributions that moved with a release, its size and its import time, or the entry ``fault``."""
    others = [each for each in environment.moved if not each.startswith(f"{plan.distribution} ")]
    return probe(plan, environment, tree, scratch) | {"moved": ", ".join(others)}


def probe(plan: ReleasesPlan, environment: PinnedEnvironment, tree: Path, scratch: Path) -> dict[str, Any]:
    """Size and import time, or the entry ``fault``."""
    import_s = []
    for _ in range(IMPORTS):
        line = ("-c", IMPORT.format(module=plan.module))
        done = run_in(environment, tree, line, limit_s=plan.limit_s, folder=scratch)
        if done.reason:
            return {"fault": done.reason}
        import_s.append(float(done.output.split()[-1]))
    low_s, *_, high_s = sorted(import_s)
    size = run_in(environment, tree, ("-c", SIZE, plan.distribution), limit_s=plan.limit_s, folder=scratch)
    if size.reason:
        return {"fault": size.reason}
    return {
        "import_s": statistics.median(import_s), "import_low": low_s, "import_high": high_s,
        "installed_B": int(size.output),
    }  # fmt: skip


def compare(
    plan: ReleasesPlan, environment: PinnedEnvironment, tree: Path, scratch: Path, found: MeasuredRelease
) -> str:
    """Add errors and trajectories; returns why nothing ran, or an empty text."""
    line = ("compare", *plan.scenes, "--engine", plan.engine, "--workers", "1")
    figures = measured_figures(line, plan, environment, tree, scratch / "comparison")
    if isinstance(figures, str):
        return figures
    own = [figure for figure in figures if figure.identity.engine == plan.engine]
    place = {"engine": plan.engine, "version": found.release["version"]}
    verdicts = {f.identity.scene: f for f in own if f.identity.quantity == "verdict"}
    found.errors += [place | row for row in error_rows(own, verdicts)]
    found.runs += [place | row for row in run_rows(own)]
    broken = [f for f in verdicts.values() if f.word in RUN_FAULTS]
    return broken[0].reason if broken and len(broken) == len(verdicts) else "" if verdicts else "no scene was judged"


def measured_figures(
    line: tuple[str, ...], plan: ReleasesPlan, environment: PinnedEnvironment, tree: Path, out: Path
) -> tuple[Figure, ...] | str:
    """Figures of a command of barchain with a release, or why there are none."""
    arguments = ("-m", "barchain", "-q", *line, "--out", str(out))
    done = run_in(environment, tree, arguments, limit_s=plan.limit_s, folder=out.parent)
    try:
        return read_figures_of(out)
    except (HistoryError, FileNotFoundError, ValueError):
        return done.reason or f"ended with exit code {done.code}"


def error_rows(figures: Iterable[Figure], verdicts: dict[str, Figure]) -> Iterable[dict[str, Any]]:
    """Largest errors of each scene, or the verdict of a scene without errors."""
    seen = set()
    for figure in figures:
        i = figure.identity
        if i.kind is FigureKind.ERROR and i.quantity.endswith(ERROR_METRIC) and "first_orbit" not in i.quantity:
            seen.add(i.scene)
            yield {
                "scene": i.scene, "quantity": i.quantity.removesuffix(ERROR_METRIC), "unit": str(i.unit),
                "value": figure.value, "rounding": figure.tolerance, "verdict": verdicts[i.scene].word,
                "reason": verdicts[i.scene].reason or figure.reason,
            }  # fmt: skip
    for scene, figure in verdicts.items():
        if scene not in seen:
            yield {"scene": scene, "quantity": "", "unit": "", "verdict": figure.word, "reason": figure.reason}


def run_rows(figures: Iterable[Figure]) -> Iterable[dict[str, Any]]:
    """Digest and steps of each run."""
    own = list(figures)
    steps = {(f.identity.scene, f.identity.setting): f.value for f in own if f.identity.quantity == "steps"}
    for figure in own:
        i = figure.identity
        if i.quantity == "trajectory" and figure.word:
            place = (i.scene, i.setting)
            yield {"scene": i.scene, "setting": i.setting, "trajectory": figure.word, "steps": steps.get(place)}


def time(plan: ReleasesPlan, environment: PinnedEnvironment, tree: Path, scratch: Path, found: MeasuredRelease) -> str:
    """Add times at equal error, relative to the anchor that is timed in turns; why there are none, or an empty text."""
    line = (
        "cost", plan.timed, "--engine", plan.engine, "--engine", plan.anchor, "--repeats", "5", "--minutes",
        f"{plan.minutes_each:.3f}", "--time-limit", "1",
    )  # fmt: skip
    figures = measured_figures(line, plan, environment, tree, scratch / "cost")
    if isinstance(figures, str):
        return figures
    ratios = [f for f in figures if f.identity.kind is FigureKind.RATIO and f.identity.engine == plan.engine]
    for figure in (f for f in ratios if f.identity.quantity.endswith(RATIO)):
        i = figure.identity
        if figure.value:
            found.times.append({
                "engine": plan.engine, "version": found.release["version"], "scene": i.scene, "target": i.setting,
                "anchor": i.anchor, "ratio": figure.value, "low": figure.low, "high": figure.high,
            })  # fmt: skip
    return "" if found.times else next((f.reason for f in ratios if f.reason), "no error was reached by both engines")


@dataclass(frozen=True)
class ReleasesResult:
    """End of a study of releases."""

    states: dict[str, str]
    """State of each release"""

    @property
    def passed(self) -> bool:
        """Whether a release ran: old releases that don't run are results."""
        return "runs" in self.states.values()


@dataclass(frozen=True)
class ReleasesStudy:
    """The study of releases."""

    plan: ReleasesPlan
    files: ClassVar[StudyFiles] = FILES

    @property
    def turns(self) -> int:
        """Number of releases to be reported."""
        return self.plan.turns

    def record(self) -> dict[str, Any]:
        """Engine, scenes and releases."""
        plan = self.plan
        return {
            "engine": plan.engine,
            "distribution": plan.distribution,
            "scenes": {name: scene_words(load_scene(name)) for name in plan.scenes},
            "anchor": plan.anchor,
            "versions": [str(release.version) for release in plan.releases],
        }

    def run(self, store: StudyStore, reporter: Reporter) -> ReleasesResult:
        """Measure the releases one after the other; an interrupted study has left the answers of those it measured."""
        plan, states = self.plan, dict[str, str]()
        answers = AnswerStore(store.answers)
        with scratch_folder() as scratch:
            tree = installed_tree(scratch / "tree")
            for k, release in enumerate(plan.releases):
                version = str(release.version)
                given = replace(plan, releases=()), version, release.date, release.wheel_B
                call = Call(measured_tables, given, math.inf, aside=(tree, scratch / f"{k}"))
                answer = answers.answer(call, lambda made: Answer(made.function(*made.given, *made.aside)))
                tables, _ = read_message(answer.content)
                for table, rows in tables.items():
                    if rows:
                        store.append(table, rows)
                states[version] = tables["releases"][0]["state"]
                reporter.step(plan.engine, version, states[version])
        return ReleasesResult(states)


def measured_tables(
    plan: ReleasesPlan, version: str, date: str, wheel_B: int | None, tree: Path, scratch: Path
) -> bytes:
    """Message with the rows of a release by table, measured with the sources in `tree` and results in `scratch`."""
    scratch.mkdir()
    found = measure(plan, Release(Version(version), date, wheel_B), tree, scratch)
    tables = {"errors": found.errors, "runs": found.runs, "times": found.times, "releases": [found.release]}
    return message_bytes(tables, {})
