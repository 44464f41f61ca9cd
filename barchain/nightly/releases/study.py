"""The study of releases: each release in an environment of its own, on the same scenes."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from barchain.nightly.environments.sources import installed_tree
from barchain.nightly.releases.measuring import measure
from barchain.nightly.releases.plan import ReleasesPlan, make_plan
from barchain.runs.environment import temporary_root
from barchain.runs.facts import scene_words
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
        """Measure the releases one after the other; those that an interrupted study measured stay as they are."""
        states: dict[str, str] = {}
        if store.has("releases"):
            earlier = store.read("releases")
            states = dict(zip(earlier["version"].astype(str), earlier["state"], strict=True))
        with tempfile.TemporaryDirectory(dir=temporary_root(), ignore_cleanup_errors=True) as scratch:
            tree = installed_tree(Path(scratch) / "tree")
            for k, release in enumerate(plan.releases):
                version = str(release.version)
                if version not in states:
                    folder = Path(scratch) / f"{k}"
                    folder.mkdir()
                    found = measure(plan, release, tree, folder)
                    for table in ("errors", "runs", "times"):
                        rows = getattr(found, table)
                        if rows:
                            store.append(table, rows)
                    store.append("releases", [found.release])
                    states[version] = found.release["state"]
                reporter.step(plan.engine, version, states[version])
        return ReleasesResult(states)
