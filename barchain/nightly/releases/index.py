"""Releases of a distribution that the package index has for this Python and platform."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from packaging.specifiers import InvalidSpecifier, SpecifierSet
from packaging.tags import sys_tags
from packaging.utils import InvalidWheelFilename, parse_wheel_filename
from packaging.version import InvalidVersion, Version
from pypi_simple import PyPISimple

from barchain.nightly.environments.faults import PinnedEnvironmentError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from pypi_simple import DistributionPackage

LIMIT_S = 30.0
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
    for package in packages(distribution):
        release = release_of(package)
        if release is not None and (first is None or release.version >= first):
            found.setdefault(release.version, release)
    return tuple(found[version] for version in sorted(found))


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


def packages(distribution: str) -> Iterable[DistributionPackage]:
    """Files of a distribution in the index."""
    place = configured_index()
    try:
        with PyPISimple(endpoint=place) if place else PyPISimple() as index:
            return index.get_project_page(distribution, timeout=LIMIT_S).packages
    except Exception as error:  # of several libraries below
        name = type(error).__name__
        raise PinnedEnvironmentError(f"{distribution}: the package index gave no list of releases ({name})") from None


@cache
def configured_index() -> str:
    """Index that pip is configured to use; empty for the usual one."""
    line = [sys.executable, "-m", "pip", "config", "get", "global.index-url"]
    try:
        done = subprocess.run(line, capture_output=True, text=True, timeout=LIMIT_S, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""
