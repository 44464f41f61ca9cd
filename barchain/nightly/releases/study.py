"""The study of releases: each release in an environment of its own, on the same scenes."""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from packaging.version import Version

from barchain.nightly.environments.sources import installed_tree
from barchain.nightly.releases.index import Release
from barchain.nightly.releases.measuring import measure
from barchain.nightly.releases.plan import ReleasesPlan, make_plan
from barchain.runs.call import Answer, Call
from barchain.runs.environment import temporary_root
from barchain.runs.facts import scene_words
from barchain.runs.kept_answers import AnswerStore
from barchain.runs.message import message_bytes, read_message
from reports.tables.nights.releases import FILES
from scenarios import load_scene

if TYPE_CHECKING:
    from barchain.record.study_store import StudyStore
    from barchain.studies.study import Reporter
    from reports.tables.files import StudyFiles


@dataclass(frozen=True)
class ReleasesOptions:
    """Options of a study of releases."""

    engine: str
    """Engine, or distribution"""
    scenes: tuple[str, ...] = ()
    since: str | None = None
    """First version; all by default"""


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

    files: ClassVar[StudyFiles] = FILES

    def plan(self, options: ReleasesOptions) -> ReleasesPlan:
        """Releases and scenes; errors as :func:`barchain.nightly.releases.plan.make_plan`."""
        return make_plan(options.engine, options.scenes, options.since)

    def record(self, plan: ReleasesPlan) -> dict[str, Any]:
        """Engine, scenes and releases."""
        return {
            "engine": plan.engine,
            "distribution": plan.distribution,
            "scenes": {name: scene_words(load_scene(name)) for name in plan.scenes},
            "anchor": plan.anchor,
            "versions": [str(release.version) for release in plan.releases],
        }

    def run(self, plan: ReleasesPlan, store: StudyStore, reporter: Reporter) -> ReleasesResult:
        """Measure the releases one after the other; an interrupted study has left the answers of those it measured."""
        states: dict[str, str] = {}
        answers = AnswerStore(store.folder)
        with tempfile.TemporaryDirectory(dir=temporary_root(), ignore_cleanup_errors=True) as scratch:
            tree = installed_tree(Path(scratch) / "tree")
            for k, release in enumerate(plan.releases):
                version = str(release.version)
                given = replace(plan, releases=()), version, release.date, release.wheel_B
                call = Call(measured_tables, given, math.inf, aside=(tree, Path(scratch) / f"{k}"))
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
