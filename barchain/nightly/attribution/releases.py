"""Releases of a distribution that the package index, or a folder of wheels, has for this Python and platform."""

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

from barchain.nightly.errors import PinnedEnvironmentError
from barchain.nightly.figures.package_origins import pip_setting, wheel_folders

if TYPE_CHECKING:
    from collections.abc import Iterable


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
    try:
        first = Version(since) if since else None
    except InvalidVersion:
        raise PinnedEnvironmentError(f"{since[:40] if since else ''} given, allowed: a version such as 3.2.0") from None
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
    place = pip_setting("index-url")
    try:
        with PyPISimple(endpoint=place) if place else PyPISimple() as index:
            return index.get_project_page(distribution, timeout=INDEX_S).packages
    except Exception as error:  # of several libraries below
        if not needed:
            return ()
        name = type(error).__name__
        raise PinnedEnvironmentError(f"{distribution}: the package index gave no list of releases ({name})") from None
