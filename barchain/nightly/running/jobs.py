"""Jobs of a night: each part of the plan as a command line of barchain, with tonight's scenes and faults."""

from __future__ import annotations

import fnmatch
import os
import shlex
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from adapters.engine import SettingError
from adapters.registry import UnknownEngineError
from barchain.nightly.running.plan import (
    ComparisonTable,
    PartTable,
    PlanError,
    ScenesTable,
    SelftestTable,
    default_engines,
    missing_engines,
)
from scenarios import SceneError, load_scene, scene_names
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from barchain.nightly.running.plan import NightPlan


HUGE = "huge"
"""Tag of scenes that take hours, and are run only where they are named"""
SCENE_FILE = ".toml"


def part_scenes(part: ScenesTable, folder: Path) -> tuple[str, ...]:
    """All scenes of a part, in the order of the plan.

    Raises
    ------
    PlanError
        If a name is no scene or no file, or a pattern fits none.
    """
    found = [scene for given in part.scenes or part.scenes_of_study for scene in scenes_of(given, folder)]
    return tuple(dict.fromkeys(found))


def scenes_of(given: str, folder: Path) -> list[str]:
    """Scenes of one entry: a file, a name, or a pattern."""
    if given.endswith(SCENE_FILE):
        path = (folder / given).resolve()
        if not path.is_file():
            raise PlanError(f"scenes: {given!r} given, and there is no such file beside the plan")
        return [str(path)]
    known = scene_names()
    if given in known:
        return [given]
    fitting = fnmatch.filter(known, given)
    if not fitting:
        raise PlanError(f"scenes: {given!r} given, which is no scene and fits none{nearest(given, known)}")
    return [name for name in fitting if HUGE not in load_scene(name).tags]


def beside(scene: str) -> str:
    """Scene as commands, records and pages name it: a file by its path from the working folder."""
    return os.path.relpath(scene) if scene.endswith(SCENE_FILE) else scene


def tonights(scenes: Sequence[str], nights: int, turn: int) -> tuple[str, ...]:
    """Scenes of one night, where they are divided among several: all are done once in `nights` nights."""
    return tuple(scenes[turn % nights :: nights])


FIRST = "-left"
"""Ending of the name of a job that does what an earlier night left"""
RUNS = 6
"""Longest runs that fit into the time of their part"""
LEAST_RUN_S, MOST_RUN_S = 10.0, 120.0


@dataclass(frozen=True)
class NightJob:
    """Part of a plan on one night, as a command line."""

    name: str
    """Of the part, and of the folder of the results"""
    part: str
    """Name of the part in the plan"""
    study: str
    share: float
    arguments: tuple[str, ...]
    """Command and options, without scenes and place of the results"""
    scenes: tuple[str, ...] = ()
    """Scenes in their order; empty where the command chooses its own"""
    others: int = 0
    """Number of items of a job without scenes: faults"""
    waits: bool = False
    """Whether the night before did nothing of the part for want of time"""
    favoured: bool = False
    """Whether it is the part's turn among those that wait"""
    missing: str = ""
    """Why engines and scenes that the part names can't run here; empty if all can"""
    bad_input: bool = False
    """Whether a scene of the part can't be read"""

    @property
    def items(self) -> int:
        """Number of items: scenes, faults, or one."""
        return len(self.scenes) or self.others or 1

    def command(self, out: Path, *more: str) -> tuple[str, ...]:
        """Arguments of barchain with the place of the results."""
        return (*self.arguments, *map(beside, self.scenes), "--out", str(out), *more)

    def shown(self, out: Path) -> str:
        """Command line that repeats the job, in the working folder."""
        return shlex.join(("barchain", *self.command(Path(os.path.relpath(out)))))


def night_jobs(
    plan: NightPlan, turn: int, left: Mapping[str, Sequence[str]], waiting: Collection[str] = ()
) -> tuple[NightJob, ...]:
    """Jobs of a night in their order.

    Planted faults come first, then parts of which the night before did nothing, then what it left of others, then the
    other parts. Among the parts that wait, one has its turn and comes before the others.

    Parameters
    ----------
    plan : NightPlan
    turn : int
        Number of the night among those of its plan.
    left : mapping
        Scenes that the night before left, by the name of the part; the part's name where all of it was left.
    waiting : collection of str
        Parts of which the night before did nothing.

    Raises
    ------
    PlanError
        If the plan names a scene, an engine, a setting or a part of a study that does not exist.
    """
    names = [part.name for part in plan.file.parts]
    begin = turn % len(names)  # the turn goes round: each part that keeps waiting comes first within as many nights
    favoured = next((name for name in (*names[begin:], *names[:begin]) if name in waiting), "")
    placed: list[tuple[int, NightJob]] = []
    for part in plan.file.parts:
        jobs = checked_jobs(part, plan, turn, left.get(part.name, ()))
        lacking = [f"{name}: {reason}" for name, reason in missing_engines(part.named_engines).items()]
        for k, job in enumerate(jobs):
            waits = k == 0 and part.name in waiting
            made = replace(
                job, waits=waits, favoured=waits and part.name == favoured,
                missing="; ".join(filter(None, (*lacking, job.missing))),
            )  # fmt: skip
            place = 1 if made.favoured else 2 if waits else 3 if k == 0 and part.name in left else 4
            placed.append((0 if job.study == SelftestTable.study else place, made))
    return tuple(job for _, job in sorted(placed, key=lambda entry: entry[0]))


def plan_engines(plan: NightPlan) -> tuple[str, ...]:
    """Engines that the parts of a plan run: those that it names, and those that commands take without names."""
    found = dict.fromkeys(default_engines())
    for part in plan.file.parts:
        found |= dict.fromkeys(part.named_engines)
    return tuple(found)


def checked_jobs(part: PartTable, plan: NightPlan, turn: int, left: Sequence[str]) -> list[NightJob]:
    """Jobs of a part; an error names the plan's file and the part.

    A run of a comparison that hangs must not take the time of the others. Its limit follows from the plan alone, so
    that a run that ends within it does so on every night.
    """
    try:
        jobs = part_jobs(part, plan.folder, turn, left)
    except (PlanError, SettingError, UnknownEngineError) as error:
        raise PlanError(f"{plan.shown}: {part.name}: {error}") from None
    if isinstance(part, ComparisonTable) and part.time_limit_s is None:
        share_s = 60.0 * plan.file.minutes * part.share / sum(each.share for each in plan.file.parts)
        longest = ("--time-limit", f"{min(max(share_s / RUNS, LEAST_RUN_S), MOST_RUN_S):.0f}")
        jobs = [replace(job, arguments=(*job.arguments, *longest)) for job in jobs]
    return jobs


def part_jobs(part: PartTable, folder: Path, turn: int, left: Sequence[str]) -> list[NightJob]:
    """Jobs of a part: of one with scenes that were left, those scenes come first and by themselves."""
    if not isinstance(part, ScenesTable):
        arguments, others = part.command(turn)
        return [NightJob(part.name, part.name, part.study, part.share, arguments, (), others)]
    every, faults = readable(part_scenes(part, folder))
    waiting = dict.fromkeys(str(Path(scene).resolve()) if scene.endswith(SCENE_FILE) else scene for scene in left)
    before = tuple(scene for scene in waiting if scene in every)  # the longest waiting ones first
    now = tuple(scene for scene in tonights(every, part.nights, turn) if scene not in before)
    arguments, _ = part.command(turn)
    total = len(before) + len(now)
    return [
        NightJob(
            name, part.name, part.study, part.share * len(scenes) / total, arguments, scenes,
            missing=faults, bad_input=bool(faults),
        )
        for name, scenes in ((part.name + FIRST, before), (part.name, now)) if scenes
    ]  # fmt: skip


def readable(scenes: Sequence[str]) -> tuple[tuple[str, ...], str]:
    """Scenes that can be read, and why the files of others can't; without any that can, all of them."""
    faults = {}
    for scene in scenes:
        if scene.endswith(SCENE_FILE):
            try:
                load_scene(beside(scene))
            except SceneError as error:
                faults[scene] = str(error).replace("\n", "; ")
    good = tuple(scene for scene in scenes if scene not in faults)
    return (good, "; ".join(faults.values())) if good else (tuple(scenes), "")
