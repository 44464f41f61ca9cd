"""Installation that a night's results come from: barchain, its machine, and all parts with their digests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from adapters.registry import PACKAGES, find_engine
from barchain.nightly.history.model.environment import capture
from barchain.nightly.history.model.figures import Environment, NightPart
from barchain.nightly.history.model.identity import content_digest
from barchain.nightly.history.model.parts import commit, installed_parts
from barchain.record.environment import package_version
from barchain.record.sources import digest_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

DIGITS = 16


@dataclass(frozen=True)
class Installation:
    """Installation at one moment."""

    barchain: str
    """Version"""
    environment: Environment
    parts: tuple[NightPart, ...] = ()
    commit: str | None = None


def installation_here(engines: Iterable[str], scenes: Iterable[str]) -> Installation:
    """Installation of this process, with the digests of the installed files of some engines.

    Parameters
    ----------
    engines : iterable of str
        Names.
    scenes : iterable of str
        Names of scenes that come with barchain.

    Raises
    ------
    UnknownEngineError, SceneError
        If a name is none.
    """
    environment = capture()
    parts = installed_parts(sorted(set(engines)), sorted(set(scenes)), environment)
    return Installation(package_version("barchain"), environment, parts, commit())


def code_of(installation: Installation, engines: Iterable[str]) -> str:
    """Digest of all sources, engines and libraries, and of the environment.

    Parameters
    ----------
    installation : Installation
    engines : iterable of str
        Names: sources of engines outside barchain count too, wherever they lie.
    """
    tops = {find_engine(name).target.partition(":")[0].partition(".")[0] for name in engines} - set(PACKAGES)
    sources = digest_of(*PACKAGES, *sorted(tops))
    return content_digest([sources, installation.environment, list(installation.parts)])[:DIGITS]


def installation_of(found: Mapping[str, Any]) -> Installation:
    """Installation of its entries in a file.

    Raises
    ------
    ValueError, TypeError, KeyError
        If they are something else.
    """
    parts = tuple(NightPart(**part) for part in found["parts"])
    return Installation(str(found["barchain"]), Environment(**found["environment"]), parts, found["commit"])
