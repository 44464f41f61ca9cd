"""Study of the releases of an engine: each release in an environment of its own, on the same scenes."""

from __future__ import annotations

import math
import re
import statistics
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

from packaging.version import Version

from adapters.registry import engines, find_engine
from barchain.nightly.attribution.environments import (
    dependencies_at,
    installed_tree,
    measured_figures,
    pinned_environment,
    run_in,
)
from barchain.nightly.attribution.releases import Release, releases_of
from barchain.nightly.errors import PinnedEnvironmentError
from barchain.nightly.figures.figure import FigureKind
from barchain.record.scene_description import scene_words
from barchain.runs.asking import declarations_of
from barchain.runs.call import Answer, Call
from barchain.runs.environment import scratch_folder
from barchain.runs.kept_answers import AnswerStore
from barchain.runs.message import message_bytes, read_message
from barchain.studies.study import StudyEnd
from reports.results.outcome import Outcome
from reports.results.releases import FILES, ReleaseState
from scenarios import load_scene
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from barchain.nightly.attribution.environments import PinnedEnvironment
    from barchain.nightly.figures.figure import Figure
    from barchain.record.study_store import StudyStore
    from barchain.studies.study import Reporter
    from reports.results.files import StudyFiles

    Tables = dict[str, list[dict[str, Any]]]


SCENES = ("paper/fig05", "paper/fig13", "basics/two_bars_free", "basics/kepler_circular")
"""Scenes where none is named: those that the engine supports"""
MOST_SCENES = 3
ANCHOR = "reference-fast"
LIMIT_S = 180.0
"""Longest command"""
MINUTES_EACH = 0.3
"""Budget of the times of one release: with less, an engine of a hundredth of a second a run reaches no error"""
MODULES = {"drake": "pydrake", "pin": "pinocchio", "scikit-sundae": "sksundae"}
"""Modules of distributions that are imported under another name"""
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


@dataclass(frozen=True)
class ReleasesStudy:
    """The study of releases: releases of one engine, and the scenes that each of them runs."""

    engine: str
    distribution: str
    releases: tuple[Release, ...]
    scenes: tuple[str, ...]
    """Times are measured on the first one"""
    files: ClassVar[StudyFiles] = FILES

    @property
    def turns(self) -> int:
        """Number of releases to be reported."""
        return len(self.releases)

    def record(self) -> dict[str, Any]:
        """Engine, scenes and releases."""
        return {
            "engine": self.engine,
            "distribution": self.distribution,
            "scenes": {name: scene_words(load_scene(name)) for name in self.scenes},
            "anchor": ANCHOR,
            "versions": [str(release.version) for release in self.releases],
        }

    def run(self, store: StudyStore, reporter: Reporter) -> StudyEnd:
        """Measure the releases one after the other; an interrupted study has left the answers of those it measured.

        Old releases that don't run are results: it is a failure if none runs.
        """
        states = []
        answers = AnswerStore(store.answers)
        with scratch_folder() as scratch:
            tree = installed_tree(scratch / "tree")
            for k, release in enumerate(self.releases):
                version = str(release.version)
                given = replace(self, releases=()), version, release.date, release.wheel_B
                call = Call(measured_tables, given, math.inf, aside=(tree, scratch / f"{k}"))
                answer = answers.answer(call, lambda made: Answer(made.function(*made.given, *made.aside)))
                tables, _ = read_message(answer.content)
                for table, rows in tables.items():
                    if rows:
                        store.append(table, rows)
                states.append(tables["releases"][0]["state"])
                reporter.step(self.engine, version, states[-1])
        return StudyEnd(() if str(ReleaseState.RUNS) in states else ("no release runs",))


def releases_study(given: str, scenes: Sequence[str] = (), since: str | None = None) -> ReleasesStudy:
    """Study of the releases of an engine.

    Parameters
    ----------
    given : str
        An engine, or a distribution that engines need, e.g. ``mujoco`` or ``scipy``.
    scenes : sequence of str
        Names; up to three that the engine supports by default.
    since : str, optional
        First version.

    Raises
    ------
    PinnedEnvironmentError
        If no release is known, or the engine supports none of the scenes.
    UnknownEngineError, SceneError
        If a name is none.
    """
    name, distribution = engine_and_distribution(given)
    declared = declarations_of(find_engine(name))
    reasons = {scene: declared.unsupported(load_scene(scene)) for scene in scenes or SCENES}
    able = [scene for scene, reason in reasons.items() if not reason]
    for scene, reason in reasons.items() if scenes else ():
        if reason:
            raise PinnedEnvironmentError(f"{name} does not support {scene}: {reason}")
    if not able:
        raise PinnedEnvironmentError(f"{name} supports none of {', '.join(SCENES)}; name a scene")
    releases = releases_of(distribution, since)
    if not releases:
        from_words = f" from {since} on" if since else ""
        raise PinnedEnvironmentError(
            f"{distribution}: the package index has no wheel for this Python and platform{from_words}"
        )
    return ReleasesStudy(name, distribution, releases, tuple(able[: None if scenes else MOST_SCENES]))


def engine_and_distribution(given: str) -> tuple[str, str]:
    """Engine and its distribution, of the name of either.

    Raises
    ------
    PinnedEnvironmentError
        If there is none, or the engine is barchain's own.
    """
    known = engines()
    if given in known:
        own = known[given]
        found = own.distribution or own.requires
        if not found or (own.ours and not own.requires):
            raise PinnedEnvironmentError(
                f"{given}: is part of barchain and has no releases of its own; give an engine of a library"
            )
        return given, found
    for name, registration in known.items():
        if given in {registration.distribution, registration.requires}:
            return name, given
    names = {*known, *(r.requires for r in known.values() if r.requires)}
    raise PinnedEnvironmentError(f"{given[:60]}: no such engine{nearest(given, names)}; `barchain engines` lists all")


def measured_tables(
    study: ReleasesStudy, version: str, date: str, wheel_B: int | None, tree: Path, scratch: Path
) -> bytes:
    """Message with the rows of a release by table, measured with the sources in `tree` and results in `scratch`."""
    scratch.mkdir()
    return message_bytes(measure(study, Release(Version(version), date, wheel_B), tree, scratch), {})


def measure(study: ReleasesStudy, release: Release, tree: Path, scratch: Path) -> Tables:
    """Rows of a release by table; a release that does not run has the reason.

    Parameters
    ----------
    study : ReleasesStudy
    release : Release
    tree : Path
        Today's sources of barchain.
    scratch : Path
        Empty folder for results.
    """
    place = {"engine": study.engine, "version": str(release.version)}
    own = place | {"released": release.date, "wheel_B": release.wheel_B, "state": str(ReleaseState.RUNS)}
    tables: Tables = {"errors": [], "runs": [], "times": [], "releases": [own]}
    try:
        environment, facts, note = working_environment(study, release, tree, scratch)
    except PinnedEnvironmentError as error:
        own |= {"state": str(ReleaseState.NOT_INSTALLED), "reason": str(error)}
        return tables
    fault = str(facts.pop("fault", ""))
    own |= facts
    fault = fault or compare(study, environment, tree, scratch, place, tables)
    if fault:
        own |= {"state": str(ReleaseState.FAILS), "reason": ADDRESS.sub("", fault)}
        return tables
    untimed = time(study, environment, tree, scratch, place, tables)
    own["reason"] = "; ".join(filter(None, (note, untimed and f"not timed: {untimed}")))
    return tables


def working_environment(
    study: ReleasesStudy, release: Release, tree: Path, scratch: Path
) -> tuple[PinnedEnvironment, dict[str, Any], str]:
    """Environment in which a release imports, the facts of it, and a note on its dependencies.

    Dependencies of today come first. A release that does not import with them is tried with those of its own time.
    The facts have the entry ``fault`` if it imports with neither.

    Raises
    ------
    PinnedEnvironmentError
        If the release can't be installed.
    """
    pin, registration = f"{study.distribution}=={release.version}", find_engine(study.engine)
    also = sorted({registration.requires, registration.distribution} - {"", study.distribution})
    today = pinned_environment([pin], also=also)
    facts = probe(study.distribution, today, tree, scratch)
    if "fault" not in facts:
        return today, facts, ""
    try:
        dated = pinned_environment([*dependencies_at(pin, release.date), pin], also=also)
    except PinnedEnvironmentError:
        return today, facts, ""
    dated_facts = probe(study.distribution, dated, tree, scratch)
    if "fault" in dated_facts:
        return today, facts, ""
    return dated, dated_facts, f"with the dependencies of its own time; with today's: {facts['fault']}"


def probe(distribution: str, environment: PinnedEnvironment, tree: Path, scratch: Path) -> dict[str, Any]:
    """Distributions that moved with a release, its size and its import time, or the entry ``fault``."""
    facts: dict[str, Any] = {
        "moved": ", ".join(each for each in environment.moved if not each.startswith(f"{distribution} "))
    }
    importing = ("-c", IMPORT.format(module=MODULES.get(distribution, distribution.replace("-", "_"))))
    said = []
    for line in (*[importing] * IMPORTS, ("-c", SIZE, distribution)):
        done = run_in(environment.python, tree, line, limit_s=LIMIT_S, folder=scratch)
        if done.reason:
            return facts | {"fault": done.reason}
        said.append(float(done.output.split()[-1]))
    *import_s, size_B = said
    return facts | {
        "import_s": statistics.median(import_s), "import_low": min(import_s), "import_high": max(import_s),
        "installed_B": int(size_B),
    }  # fmt: skip


def compare(
    study: ReleasesStudy, environment: PinnedEnvironment, tree: Path, scratch: Path, place: dict[str, Any],
    tables: Tables,
) -> str:  # fmt: skip
    """Add errors and trajectories; returns why nothing ran, or an empty text."""
    line = ("compare", *study.scenes, "--engine", study.engine, "--workers", "1")
    figures = measured_figures(environment, tree, line, limit_s=LIMIT_S, out=scratch / "comparison")
    if isinstance(figures, str):
        return figures
    own = [figure for figure in figures if figure.identity.engine == study.engine]
    verdicts = {f.identity.scene: f for f in own if f.identity.quantity == "verdict"}
    tables["errors"] += [place | row for row in error_rows(own, verdicts)]
    steps = {(f.identity.scene, f.identity.setting): f.value for f in own if f.identity.quantity == "steps"}
    for figure in own:
        scene, setting = figure.identity.scene, figure.identity.setting
        if figure.identity.quantity == "trajectory" and figure.word:
            run = {"scene": scene, "setting": setting, "trajectory": figure.word, "steps": steps.get((scene, setting))}
            tables["runs"].append(place | run)
    broken = [f for f in verdicts.values() if f.word in RUN_FAULTS]
    return broken[0].reason if broken and len(broken) == len(verdicts) else "" if verdicts else "no scene was judged"


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


def time(
    study: ReleasesStudy, environment: PinnedEnvironment, tree: Path, scratch: Path, place: dict[str, Any],
    tables: Tables,
) -> str:  # fmt: skip
    """Add times at equal error, relative to the anchor that is timed in turns; why there are none, or an empty text."""
    line = (
        "cost", study.scenes[0], "--engine", study.engine, "--engine", ANCHOR, "--repeats", "5", "--minutes",
        f"{MINUTES_EACH:.3f}", "--time-limit", "1",
    )  # fmt: skip
    figures = measured_figures(environment, tree, line, limit_s=LIMIT_S, out=scratch / "cost")
    if isinstance(figures, str):
        return figures
    ratios = [f for f in figures if f.identity.kind is FigureKind.RATIO and f.identity.engine == study.engine]
    tables["times"] += [
        place | {
            "scene": f.identity.scene, "setting": f.identity.setting, "relative_to": f.identity.anchor,
            "ratio": f.value, "low": f.low, "high": f.high,
        }
        for f in ratios if f.identity.quantity.endswith(RATIO) and f.value
    ]  # fmt: skip
    reasons = (figure.reason for figure in ratios if figure.reason)
    return "" if tables["times"] else next(reasons, "no error was reached by both engines")
