"""Releases of an engine: those that the package index has for this Python and platform, and the plan of their study."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from packaging.specifiers import InvalidSpecifier, SpecifierSet
from packaging.tags import sys_tags
from packaging.utils import InvalidWheelFilename, canonicalize_name, parse_wheel_filename
from packaging.version import InvalidVersion, Version
from pypi_simple import DistributionPackage, Link, PyPISimple

from adapters.registry import engines, find_engine
from barchain.nightly.faults import PinnedEnvironmentError
from barchain.nightly.origins import wheel_folders
from barchain.runs.asking import engine_class
from barchain.runs.processes import run
from scenarios import load_scene
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from adapters.registry import Registration


INDEX_S = 30.0
PYTHON = ".".join(map(str, sys.version_info[:3]))


@dataclass(frozen=True, order=True)
class Release:
    """Release of a distribution with a wheel that fits here."""

    version: Version
    date: str = ""
    """Day of the wheel's upload, ISO 8601; empty where the index gives none"""
    wheel_B: int | None = None
    """Size of the wheel"""


def releases_of(distribution: str, since: str | None = None) -> tuple[Release, ...]:
    """Releases with a wheel for this Python and platform, in the order of their versions.

    Parameters
    ----------
    distribution : str
    since : str, optional
        First version; all by default. Pre-releases and withdrawn releases are left out.

    Raises
    ------
    PinnedEnvironmentError
        If the index does not answer, does not know the distribution, or `since` is no version.
    """
    first = version_of(since) if since else None
    found: dict[Version, Release] = {}
    beside = wheels_of(distribution)
    for package in (*beside, *packages(distribution, needed=not beside)):
        release = release_of(package)
        if release is not None and (first is None or release.version >= first):
            found.setdefault(release.version, release)
    return tuple(found[version] for version in sorted(found))


def wheels_of(distribution: str) -> list[DistributionPackage]:
    """Wheels of a distribution in the folders that pip looks into beside the index."""
    files = [path for folder in wheel_folders() for path in sorted(folder.glob("*.whl"))]
    found = [DistributionPackage.from_link(Link(path.name, path.as_uri(), {})) for path in files]
    return [one for one in found if canonicalize_name(one.project or "") == canonicalize_name(distribution)]


def version_of(text: str) -> Version:
    """Version of a text."""
    try:
        return Version(text)
    except InvalidVersion:
        raise PinnedEnvironmentError(f"{text[:40]} given, allowed: a version such as 3.2.0") from None


def release_of(package: DistributionPackage) -> Release | None:
    """Release of a file of the index; None if it is no wheel for this Python and platform."""
    try:
        _, version, _, tags = parse_wheel_filename(package.filename)
        fits = SpecifierSet(package.requires_python or "").contains(PYTHON)
    except (InvalidWheelFilename, InvalidVersion, InvalidSpecifier):
        return None
    if version.is_prerelease or package.is_yanked or not fits or tags.isdisjoint(known_tags()):
        return None
    day = package.upload_time.date().isoformat() if package.upload_time else ""
    return Release(version, day, package.size)


@cache
def known_tags() -> frozenset[object]:
    """Tags of wheels that fit here."""
    return frozenset(sys_tags())


def packages(distribution: str, *, needed: bool = True) -> Iterable[DistributionPackage]:
    """Files of a distribution in the index; none where it gives none, and they are not needed."""
    place = configured_index()
    try:
        with PyPISimple(endpoint=place) if place else PyPISimple() as index:
            return index.get_project_page(distribution, timeout=INDEX_S).packages
    except Exception as error:  # of several libraries below
        if not needed:
            return ()
        name = type(error).__name__
        raise PinnedEnvironmentError(f"{distribution}: the package index gave no list of releases ({name})") from None


@cache
def configured_index() -> str:
    """Index that pip is configured to use; empty for the usual one."""
    done = run([sys.executable, "-m", "pip", "config", "get", "global.index-url"], limit_s=INDEX_S)
    return "" if done.reason else done.output.strip()


SCENES = ("paper/fig05", "paper/fig13", "basics/two_bars_free", "basics/kepler_circular")
"""Scenes where none is named: those that the engine supports"""
MOST_SCENES = 3
ANCHOR = "reference-fast"
LIMIT_S = 180.0
MODULES = {"drake": "pydrake", "pin": "pinocchio", "scikit-sundae": "sksundae"}
"""Modules of distributions that are imported under another name"""


@dataclass(frozen=True)
class ReleasesPlan:
    """Releases of one engine, and what is measured of each."""

    engine: str
    distribution: str
    releases: tuple[Release, ...]
    scenes: tuple[str, ...]
    anchor: str = ANCHOR
    limit_s: float = LIMIT_S
    """Longest command"""
    minutes_each: float = 0.12
    """Budget of the times of one release"""

    @property
    def module(self) -> str:
        """Module that is imported."""
        return MODULES.get(self.distribution, self.distribution.replace("-", "_"))

    @property
    def timed(self) -> str:
        """Scene of the times."""
        return self.scenes[0]

    @property
    def also(self) -> tuple[str, ...]:
        """Further distributions that the engine needs."""
        registration = find_engine(self.engine)
        named = {registration.requires, registration.distribution} - {"", self.distribution}
        return tuple(sorted(named))

    @property
    def turns(self) -> int:
        """Number of releases."""
        return len(self.releases)


def make_plan(given: str, scenes: Sequence[str] = (), since: str | None = None) -> ReleasesPlan:
    """Plan of a study.

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
    declared = engine_class(find_engine(name))
    able = [scene for scene in scenes or SCENES if not declared.unsupported(load_scene(scene))]
    if scenes and len(able) < len(scenes):
        scene = next(scene for scene in scenes if scene not in able)
        raise PinnedEnvironmentError(f"{name} does not support {scene}: {declared.unsupported(load_scene(scene))}")
    if not able:
        raise PinnedEnvironmentError(f"{name} supports none of {', '.join(SCENES)}; name a scene")
    releases = releases_of(distribution, since)
    if not releases:
        from_words = f" from {since} on" if since else ""
        raise PinnedEnvironmentError(
            f"{distribution}: the package index has no wheel for this Python and platform{from_words}"
        )
    return ReleasesPlan(name, distribution, releases, tuple(able[: None if scenes else MOST_SCENES]))


def engine_and_distribution(given: str) -> tuple[str, str]:
    """Engine and its distribution, of the name of either.

    Raises
    ------
    PinnedEnvironmentError
        If there is none, or the engine is barchain's own.
    """
    known = engines()
    for name, registration in known.items():
        if name == given:
            return name, need_distribution(name, registration)
    for name, registration in known.items():
        if given in {registration.distribution, registration.requires}:
            return name, given
    names = {*known, *(r.requires for r in known.values() if r.requires)}
    raise PinnedEnvironmentError(f"{given[:60]}: no such engine{nearest(given, names)}; `barchain engines` lists all")


def need_distribution(name: str, registration: Registration) -> str:
    """Distribution of an engine."""
    found = registration.distribution or registration.requires
    if not found or (registration.ours and not registration.requires):
        raise PinnedEnvironmentError(
            f"{name}: is part of barchain and has no releases of its own; give an engine of a library"
        )
    return found
