"""Measurements of two builds in one job, in turns: a slow minute hits both, and only their differences are told.

Scenes are compared in parts, each with the base and then with the head; times are measured base, head, base, head.
"""

from __future__ import annotations

import json
import math
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from barchain.nightly.attribution.environments import run_in
from barchain.nightly.errors import HistoryError, PinnedEnvironmentError
from barchain.nightly.figures.changes import NOT_REPRODUCIBLE, Change, Direction
from barchain.nightly.figures.figure import Figure, FigureIdentity, FigureKind, FigureUnit
from barchain.nightly.figures.results import read_night
from barchain.nightly.figures.steps import FALSE_ALARMS, discoveries, step_between
from barchain.runs.job import Role
from reports.results.comparison import FILES
from reports.results.outcome import Outcome
from reports.results.rows import BITS, MAIN

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence
    from pathlib import Path

    from barchain.nightly.figures.figure import Night

    Note = Callable[[str], None]
    Builds = tuple["Build", "Build"]

FIRST_PART = 4
"""Scenes of the first part, which tells the pace of later ones"""
PART_SHARE = 0.5
"""Share of the time left that a part is to take"""
START_S = 30.0
"""Time that the comparison of a part may take in any case"""
SLOWER = 3.0
"""Times that of the base which the head may take for a part"""
LONG_S = 0.1
TIMED = 4
"""Scenes whose times are measured: those that take longest in the base, of those that take less than :data:`LONG_S`;
if none does, the shortest one"""
MOST_ROUNDS = 15
"""More add little beside the least effect that is told"""


@dataclass(frozen=True)
class Build:
    """One of two builds of an engine: a requirement, a wheel, a Python, or a file of programs."""

    spec: str
    """As it was given"""
    python: Path
    """Python that runs it"""
    variables: Mapping[str, str] = field(default_factory=dict)
    """Of the environment of its runs"""


def compared_in_parts(
    builds: Builds, tree: Path, engine: str, scenes: Sequence[str], run_s: float, end: float, scratch: Path, note: Note
) -> tuple[list[Path], list[Path]]:
    """Folders with comparisons of the base and of the head, one for each part of the scenes.

    Parameters
    ----------
    builds : tuple of Build
        Base and head.
    tree : Path
        Sources of barchain.
    engine : str
    scenes : sequence of str
        In the order in which they are compared.
    run_s : float
        Longest time of one run.
    end : float
        Value of `time.monotonic` from which on no part begins; the first part always does.
    scratch : Path
        For the folders.
    note : callable
        Called with a sentence on each part.

    Raises
    ------
    PinnedEnvironmentError
        If a build gives no results, or the head takes far longer than the base.
    """
    folders: tuple[list[Path], list[Path]] = [], []
    left, size = list(scenes), FIRST_PART
    while left and size:
        part, left, begun = left[:size], left[size:], time.monotonic()
        note(f"scenes: {len(scenes) - len(left)} of {len(scenes)}")
        limit_s = max(end - begun, START_S)
        for build, made in zip(builds, folders, strict=True):
            out = scratch / f"{folders.index(made)}-{len(made)}"
            took_s = compare(build, tree, engine, part, run_s, limit_s, out)
            made.append(out)
            limit_s = SLOWER * took_s + START_S
        now = time.monotonic()
        size = int(max(PART_SHARE * (end - now), 0.0) / ((now - begun) / len(part)))
    return folders


def compare(
    build: Build, tree: Path, engine: str, scenes: Sequence[str], run_s: float, limit_s: float, out: Path
) -> float:
    """Compare a build with the solutions of scenes; the time that it took, s."""
    line = ("-m", "barchain", "-q", "compare", *scenes, "--engine", engine, "--time-limit", f"{run_s:g}",
            "--workers", "1", "--out", str(out))  # fmt: skip
    done = run_in(build.python, tree, line, limit_s=limit_s, folder=out.parent, variables=build.variables)
    if done.interrupted:
        raise PinnedEnvironmentError(f"{build.spec}: {', '.join(scenes)}: {done.reason}; --minutes allows more")
    if done.failed:
        raise PinnedEnvironmentError(f"{build.spec}: {done.reason}")
    return done.duration_s


def night_of(folders: Sequence[Path], build: Build) -> Night:
    """Figures of a build as those of one night.

    Raises
    ------
    PinnedEnvironmentError
        If the folders hold none.
    """
    try:
        return read_night(*folders)
    except (HistoryError, FileNotFoundError, ValueError) as error:
        raise PinnedEnvironmentError(f"{build.spec}: {error}") from None


def timed_scenes(folders: Iterable[Path]) -> list[str]:
    """Names of the scenes whose times are measured, from the comparison of the base."""
    took = {
        run["scene"]: float(run["seconds"]["simulate"])
        for folder in folders
        for run in FILES.sound_record(folder)["runs"]
        if run["role"] == str(Role.MAIN) and run["outcome"] == str(Outcome.PASS)
    }
    short = [scene for scene, seconds in took.items() if seconds < LONG_S]
    return sorted(short, key=lambda scene: -took[scene])[:TIMED] or sorted(took, key=lambda scene: took[scene])[:1]


@dataclass(frozen=True)
class SceneTimes:
    """Times and digests of one scene, of base and head."""

    seconds: tuple[list[float], list[float]] = field(default_factory=lambda: ([], []))
    bits: tuple[set[str], set[str]] = field(default_factory=lambda: (set(), set()))

    @property
    def rounds(self) -> int:
        """Times that both builds have."""
        return min(map(len, self.seconds))


def times_in_turns(
    builds: Builds, tree: Path, engine: str, scenes: dict[str, str], end: float, note: Note
) -> dict[str, SceneTimes]:
    """Times of scenes in rounds of both builds.

    Parameters are those of :func:`compared_in_parts`; the scenes are those that are given to barchain, by their names.
    """
    found = {name: SceneTimes() for name in scenes}
    line = ("-m", "barchain.nightly.gate.turn", engine, *scenes.values())
    longest_s = 1.0
    for number in range(MOST_ROUNDS if scenes else 0):
        begun = time.monotonic()
        if end - begun < longest_s:
            break
        note(f"times: round {number + 1} of {MOST_ROUNDS}")
        for which, build in enumerate(builds):
            done = run_in(build.python, tree, line, limit_s=end - begun, folder=tree, variables=build.variables)
            answers = {} if done.reason else json.loads(done.output.splitlines()[-1])
            for name, given in scenes.items():
                if "seconds" in answers.get(given, {}):
                    found[name].seconds[which].append(answers[given]["seconds"])
                    found[name].bits[which].add(answers[given]["bits"])
        longest_s = max(longest_s, time.monotonic() - begun)
    return found


def least_rounds(series: int) -> int:
    """Rounds from which on a step in one of some series can be told at all."""
    return next(n for n in range(1, 30) if 2.0 / math.comb(2 * n, n) <= FALSE_ALARMS / max(series, 1))


def time_changes_between(times: dict[str, SceneTimes], engine: str, base: Night, head: Night) -> list[Change]:
    """Changes of times between two builds, and runs that the head alone does not reproduce."""
    changes = []
    known = {name: one for name, one in times.items() if one.rounds >= least_rounds(len(times))}
    steps = {name: step_between(*(np.log(each) for each in one.seconds)) for name, one in known.items()}
    told = discoveries(list(steps.values()))
    for name, step in ((name, step) for name, step in steps.items() if step in told):
        identity = FigureIdentity(name, engine, "", "time", FigureKind.RATIO, FigureUnit.SECOND)
        was, now = (Figure(identity, float(np.median(each))) for each in times[name].seconds)
        direction = Direction.WORSE if step.slower else Direction.BETTER
        said = f"{times[name].rounds} times of each build in turns; by chance with {step.probability:.1g}"
        change = Change(identity, was, now, base.name, head.name, direction, said, step.factor, step.low, step.high)
        changes.append(change)
    for name, one in times.items():
        before, after = map(sorted, one.bits)
        if len(before) == 1 and len(after) > 1:
            identity = FigureIdentity(name, engine, "", f"{BITS}.{MAIN}", FigureKind.BITS)
            was, now = (Figure(identity, word=word) for word in after[:2])
            wild = NOT_REPRODUCIBLE
            changes.append(
                Change(identity, was, now, base.name, head.name, wild.direction, wild.reason, irreproducible=True)
            )
    return changes
