"""Plan of a study of releases."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from adapters.registry import engines, find_engine
from barchain.nightly.environments.faults import PinnedEnvironmentError
from barchain.nightly.releases.index import releases_of
from barchain.runs.declared import engine_class
from scenarios import load_scene
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.registry import Registration
    from barchain.nightly.releases.index import Release

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
