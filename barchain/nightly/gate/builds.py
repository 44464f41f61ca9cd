"""Builds of an engine: a requirement, a wheel, a Python, or a file of programs, each with the Python that runs it."""

from __future__ import annotations

import hashlib
import os
import sys
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from packaging.requirements import InvalidRequirement, Requirement
from packaging.utils import InvalidWheelFilename, parse_wheel_filename

from adapters.command.entries import FILES
from adapters.registry import UnknownEngineError, find_engine
from barchain.nightly.attribution.environments import pinned_environment
from barchain.nightly.errors import PinnedEnvironmentError
from barchain.nightly.figures.origins import AT

if TYPE_CHECKING:
    from collections.abc import Mapping

ALLOWED = "allowed: a requirement such as pymunk==7.2.0, a wheel, a Python, or a file of engines (.toml)"
WHEEL, ENTRIES = ".whl", ".toml"


@dataclass(frozen=True)
class Build:
    """One of two builds of an engine."""

    spec: str
    """As it was given"""
    python: Path
    variables: Mapping[str, str] = field(default_factory=dict)
    """Of the environment of its runs"""


def build_of(spec: str, engine: str) -> Build:
    """Build as it is given on the command line; its environment is made now, or was made earlier.

    Raises
    ------
    PinnedEnvironmentError
        If it is none of the allowed forms, or can't be installed; the message is one line.
    """
    path = Path(spec)
    if path.suffix in {WHEEL, ENTRIES} and not path.is_file():
        raise PinnedEnvironmentError(f"{spec}: no such file; {ALLOWED}")
    if path.suffix == ENTRIES:
        return Build(spec, Path(sys.executable), {FILES: str(path.resolve())})
    if path.suffix != WHEEL and path.is_file() and os.access(path, os.X_OK):
        return Build(spec, path.absolute())  # the link of a virtual environment stays
    requirement = wheel_requirement(path) if path.suffix == WHEEL else spec
    try:
        name = Requirement(requirement).name
    except InvalidRequirement:
        raise PinnedEnvironmentError(f"{spec}: is none; {ALLOWED}") from None
    also: set[str] = set()
    with suppress(UnknownEngineError):  # an engine that only the builds have
        registration = find_engine(engine)
        also = {registration.requires, registration.distribution} - {"", name}
    return Build(spec, pinned_environment([requirement], also=sorted(also)).python)


def wheel_requirement(path: Path) -> str:
    """Requirement of a wheel, by its content: another wheel of the same name is another build."""
    try:
        name = parse_wheel_filename(path.name)[0]
    except InvalidWheelFilename as error:
        raise PinnedEnvironmentError(f"{path}: {error}") from None
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    return f"{name}{AT}{path.resolve().as_uri()}#sha256={digest}"
