"""Run of a gate inside its budget: builds of an engine, a comparison of each, times in turns."""

from __future__ import annotations

import hashlib
import os
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from packaging.requirements import InvalidRequirement, Requirement
from packaging.utils import InvalidWheelFilename, parse_wheel_filename

from adapters.command.entries import FILES
from adapters.registry import UnknownEngineError, find_engine
from barchain.nightly.attribution.environments import installed_tree, pinned_environment
from barchain.nightly.errors import PinnedEnvironmentError
from barchain.nightly.figures.package_origins import AT
from barchain.nightly.gate.judging import judged_gate
from barchain.nightly.gate.measuring import Build, compared_in_parts, night_of, timed_scenes, times_in_turns
from barchain.runs.environment import scratch_folder
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from barchain.nightly.gate.known import KnownFailure
    from reports.results.nights.gate import GateResult

ALLOWED = "allowed: a requirement such as pymunk==7.2.0, a wheel, a Python, or a file of engines (.toml)"
WHEEL, ENTRIES = ".whl", ".toml"
END_S = 12.0
"""Time for the start, and for judging and telling"""
SHARE = 0.65
"""Share of the time after which no part of the comparisons begins"""
RUN_SHARE = 0.1
"""Share of the time that one run may take"""


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


def run_gate(
    engine: str, base: str, head: str, scenes: Sequence[str], known: tuple[KnownFailure, ...], minutes: float,
    note: Callable[[str], None],
) -> GateResult:  # fmt: skip
    """Measure two builds of an engine in turns, and judge the head against the base.

    Parameters
    ----------
    engine : str
        Name that both builds know.
    base, head : str
        Builds, see :func:`build_of`.
    scenes : sequence of str
        Names, or paths of files.
    known : tuple of KnownFailure
    minutes : float
        Budget of wall time; the making of environments is part of it.
    note : callable
        Called with a sentence on what begins.

    Raises
    ------
    PinnedEnvironmentError
        If a build can't be installed or gives no results, the base passes no scene, or the processor changed.
    SceneError
        If a scene can't be read.
    """
    end = time.monotonic() + 60.0 * minutes - END_S
    files = {load_scene(name).name: str(Path(name).resolve()) if Path(name).is_file() else name for name in scenes}
    note(f"environments of {base} and {head}")
    builds = build_of(base, engine), build_of(head, engine)
    with scratch_folder() as scratch:
        tree, now = installed_tree(scratch / "tree"), time.monotonic()
        folders = compared_in_parts(
            builds, tree, engine, list(files.values()), RUN_SHARE * 60.0 * minutes, now + SHARE * (end - now), scratch,
            note,
        )  # fmt: skip
        nights = night_of(folders[0], builds[0]), night_of(folders[1], builds[1])
        timed = {name: files[name] for name in timed_scenes(folders[0])}
        times = times_in_turns(builds, tree, engine, timed, end, note)
    return judged_gate(engine, (base, head), nights, times, known, len(files))
