"""Engines of a repository or a folder of wheels, and scenes of files: their states are known, walked and exchanged."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from adapters.command.own_python import VARIABLE
from barchain.nightly.attribution import releases
from barchain.nightly.attribution.attribute import attribute, reasons_against, worth_attributing
from barchain.nightly.attribution.bisection import bisect_nights
from barchain.nightly.attribution.trials import own_scenes
from barchain.nightly.figures import package_origins
from barchain.nightly.figures.figure import Figure, NightPart
from barchain.nightly.figures.package_origins import installed_state, requirement_of, state_words, states_between
from barchain.nightly.figures.results import read_figures_of
from barchain.nightly.history.judging import judge
from barchain.nightly.history.nights import open_store
from tests.nightly.history.synthetic import night

if TYPE_CHECKING:
    from pathlib import Path

SCENE = """
title = "Two bars"
source = "test"
[orbit]
altitude_m = 500e3
[chain]
bars = 2
mass_kg = 5.0
length_m = 20.0
angle_deg = 80.0
[run]
orbits = 0.1
"""
PROJECT = """
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"
[project]
name = "mine-engine"
version = "0.1.0"
[project.entry-points."barchain.engines"]
mine = "mine_engine:Mine"
"""
ENGINE = """
import dataclasses
from adapters.registry import ENGINES
TURNED_RAD = {turned}
class Mine(ENGINES["reference"].load()):
    def read(self):
        seen = super().read()
        return dataclasses.replace(seen, angle_rad=seen.angle_rad + TURNED_RAD)
"""
ABOUT = "Metadata-Version: 2.1\nName: mine-engine\nVersion: 0.1.0\n"


@pytest.fixture(autouse=True)
def nothing_known(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Environments of the test's own, and no folder of wheels from before."""
    monkeypatch.setenv(VARIABLE, str(tmp_path / "environments"))
    package_origins.wheel_folders.cache_clear()


def git(folder: Path, *words: str) -> str:
    done = subprocess.run(["git", "-C", str(folder), *words], check=True, capture_output=True, text=True)
    return done.stdout.strip()


def repository(folder: Path) -> list[str]:
    """Commits of an engine, of which the third turns all bars."""
    (folder / "mine_engine").mkdir(parents=True)
    git(folder, "init", "-q")
    git(folder, "config", "user.name", "Ada")
    git(folder, "config", "user.email", "ada@example.org")
    (folder / "pyproject.toml").write_text(PROJECT, "utf-8")
    made = []
    for number, turned in enumerate(("0.0", "0.0", "1e-3", "1e-3")):
        (folder / "mine_engine" / "__init__.py").write_text(ENGINE.format(turned=turned), "utf-8")
        (folder / "notes.txt").write_text(f"{number}", "utf-8")
        git(folder, "add", ".")
        git(folder, "commit", "-qm", f"{number}")
        made.append(git(folder, "rev-parse", "HEAD"))
    return made


def installed(folder: Path, origin: dict[str, object] | None) -> Path:
    """Folder in which the engine's distribution is installed, as pip notes it."""
    about = folder / "mine_engine-0.1.0.dist-info"
    about.mkdir(parents=True, exist_ok=True)
    (about / "METADATA").write_text(ABOUT, "utf-8")
    (about / "RECORD").write_text("", "utf-8")
    (about / "entry_points.txt").write_text("[barchain.engines]\nmine = mine_engine:Mine\n", "utf-8")
    if origin is not None:
        (about / "direct_url.json").write_text(json.dumps(origin), "utf-8")
    return folder


def test_the_state_of_a_distribution_tells_where_it_came_from_and_leads_to_those_between(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commits = repository(tmp_path / "repository")
    site = installed(tmp_path / "site", None)
    monkeypatch.syspath_prepend(site)
    assert installed_state("mine-engine") == "0.1.0"
    uri = (tmp_path / "repository").as_uri()
    installed(site, {"url": "https://example.org/e.git", "vcs_info": {"vcs": "git", "commit_id": "0123456789abcdef"}})
    assert installed_state("mine-engine") == "0.1.0 @ git+https://example.org/e.git@0123456789abcdef"
    installed(site, {"url": uri, "dir_info": {"editable": True}})
    state = installed_state("mine-engine")
    assert state == f"0.1.0 @ git+{uri}@{commits[-1]}"
    assert requirement_of("mine-engine", state) == f"mine-engine @ git+{uri}@{commits[-1]}"
    assert state_words(state) == commits[-1][:12]
    (tmp_path / "repository" / "notes.txt").write_text("changed", "utf-8")
    assert installed_state("mine-engine") == "0.1.0 (not committed)"
    states = [f"0.1.0 @ git+{uri}@{commit}" for commit in commits]
    (tmp_path / "one").mkdir()
    (tmp_path / "other").mkdir()
    assert states_between(states[0], states[-1], tmp_path / "one") == states
    assert states_between(states[-1], states[0], tmp_path / "other") == states[::-1]
    assert states_between("0.1.0", states[0], tmp_path) is None


def test_wheels_of_a_folder_are_releases_where_no_index_has_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("mine_engine-0.2.0", "mine_engine-0.1.0", "other-0.3.0"):
        (tmp_path / f"{name}-py3-none-any.whl").write_bytes(b"")
    monkeypatch.setenv("PIP_FIND_LINKS", str(tmp_path))
    monkeypatch.setattr(releases, "pip_setting", lambda _: (tmp_path / "nowhere").as_uri())
    found = releases.releases_of("mine-engine")
    assert [str(release.version) for release in found] == ["0.1.0", "0.2.0"]


def figures(repository: Path, commit: str, scene: Path, depends: tuple[str, ...]) -> list[Figure]:
    """Figures of the engine at a commit on a scene of a file."""
    git(repository, "checkout", "-q", commit)
    out = repository.parent / f"out-{commit}"
    line = [sys.executable, "-m", "barchain", "-q", "compare", str(scene), "--engine", "mine", "--out", str(out)]
    paths = [str(repository), str(repository.parent / "site"), *filter(None, sys.path)]
    subprocess.run(line, env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)}, check=False, capture_output=True)
    found = [dataclasses.replace(figure, depends=depends) for figure in read_figures_of(out)]
    return [figure for figure in found if figure.identity.quantity == "verdict"]


@pytest.mark.exhaustive
def test_a_commit_of_ones_own_engine_is_found_by_a_scene_of_ones_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = tmp_path / "repository"
    commits, scene = repository(own), tmp_path / "two_bars.toml"
    scene.write_text(SCENE, "utf-8")
    uri = own.as_uri()
    site = installed(tmp_path / "site", {"url": uri, "vcs_info": {"vcs": "git", "commit_id": commits[-1]}})
    monkeypatch.syspath_prepend(site)
    monkeypatch.syspath_prepend(own)
    scenes = own_scenes([str(scene)])
    (digest,) = scenes
    engine, depends = "engine:mine-engine", ("engine:mine-engine", "scene:two_bars")
    store = open_store(str(tmp_path / "history"), create=True)
    names = []
    for number, commit in enumerate((commits[0], commits[0], commits[-1])):
        parts = NightPart(engine, f"0.1.0 @ git+{uri}@{commit}", commit), NightPart(depends[1], "", digest)
        one = night(*figures(own, commit, scene, depends), number=number, parts=parts)
        store.add(one)
        names.append(one.name)
    judged = judge(store, "latest")
    assert worth_attributing(judged, 10) == []
    assert any("--scene-file" in reason for reason in reasons_against(judged))
    (change,) = worth_attributing(judged, 10, scenes)
    (found,) = attribute(store, judged, [change], scenes=scenes)
    step = bisect_nights(store, change.identity.name, names[1], names[2], scenes=scenes)
    assert (found.verdict, found.culprits) == ("confirmed", (engine,))
    assert f"new since {engine} {commits[2][:12]}; {commits[1][:12]} still has the old value" in step
