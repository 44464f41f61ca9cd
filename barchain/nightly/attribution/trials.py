"""Cells of an attribution: states of suspects that can be made here, and figures measured in them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from adapters.registry import built_in, engines, find_engine
from barchain.nightly.attribution.environments import (
    commit_tree,
    installed_tree,
    measured_figures,
    pinned_environment,
    replace_packages,
)
from barchain.nightly.errors import HistoryError, PinnedEnvironmentError
from barchain.nightly.figures.changes import COMPARED, OTHER_STUDIES, Direction, compared
from barchain.nightly.figures.dependencies import SOURCES, installed_parts
from barchain.nightly.figures.figure import STEPPED, Figure, FigureIdentity, FigureKind
from barchain.nightly.figures.package_origins import can_be_installed, requirement_of
from barchain.nightly.figures.table import PROGRAM
from barchain.studies.study import ignore
from scenarios import load_scene, scene_names

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from barchain.nightly.figures.figure import NightSummary
    from barchain.nightly.figures.suspects import Suspect


DISTRIBUTIONS = ("engine:", "library:")
SCENE = "scene:"
OWN_SOURCES = {"adapter": "adapters.{}", "scene": "scenarios", "solution": "barchain.solutions"}
"""Packages of barchain behind parts of these kinds"""
LIMIT_S = 300.0
REPEATS = 3
"""Measurements of a ratio in each cell; cells are measured in turns"""
HALF = 0.5
"""A ratio shows a change if it moved by more than this part of the change, as a logarithm"""
MINUTES = 0.2
FINER = "finer"
"""End of the quantities of runs at the finer setting"""
BY_SCENE = ("cost", "stability")
"""Studies of one scene and engine beside the comparison"""

OwnScenes = dict[str, str]
"""Files of scenes of one's own by the digests of the scenes"""
NO_SCENES: OwnScenes = {}


class CellError(HistoryError):
    """Raised for a figure that can't be measured by itself; the message is one line."""


def own_scenes(files: Iterable[str]) -> OwnScenes:
    """Scenes of some files.

    Raises
    ------
    SceneError
        If a file is none of a scene.
    """
    return {load_scene(Path(file)).digest: str(Path(file).resolve()) for file in files}


@dataclass(frozen=True)
class Swap:
    """Suspect whose states can be exchanged."""

    suspect: Suspect
    distribution: str = ""
    """Of a version; empty of barchain's own sources"""
    packages: tuple[str, ...] = ()
    """Of barchain's own sources"""
    scenes: tuple[str, ...] = ()
    """Files of a scene of one's own, before and after"""

    @property
    def name(self) -> str:
        """Name of the part."""
        return self.suspect.name

    @property
    def states(self) -> tuple[str, str]:
        """Versions of a distribution, before and after."""
        assert self.suspect.before is not None
        assert self.suspect.after is not None
        return self.suspect.before.version, self.suspect.after.version


def swaps_of(suspects: Iterable[Suspect], scenes: OwnScenes = NO_SCENES) -> tuple[list[Swap], list[str]]:
    """Exchanges of suspects, and the reasons why others can't be exchanged; `scenes` are one's own."""
    found = [swap_of(suspect, scenes) for suspect in suspects]
    return [one for one in found if isinstance(one, Swap)], [one for one in found if isinstance(one, str)]


def swap_of(suspect: Suspect, scenes: OwnScenes) -> Swap | str:
    """Exchange of a suspect, or why it can't be exchanged; `scenes` are one's own."""
    name, before, after = suspect.name, suspect.before, suspect.after
    kind, _, rest = name.partition(":")
    if before is None or after is None:
        return f"{name}: was not there on one of the nights"
    if name.startswith(DISTRIBUTIONS):
        if not can_be_installed(before.version) or not can_be_installed(after.version):
            return f"{name}: its sources of a night are in no commit, so that they can't be installed again"
        if before.version == after.version:
            return f"{name}: has the same version on both nights; other files of one version can't be installed again"
        return Swap(suspect, distribution=rest)
    if name.startswith(SCENE) and rest not in scene_names():
        files = tuple(scenes.get(part.digest, "") for part in (before, after))
        return Swap(suspect, scenes=files) if all(files) else f"{name}: give both of its files with --scene-file"
    packages = SOURCES.get(name) or ((OWN_SOURCES[kind].format(rest),) if kind in OWN_SOURCES else ())
    reason = "a program's earlier state is not kept" if kind == "program" else "can't be exchanged here"
    return Swap(suspect, packages=packages) if packages else f"{name}: {reason}"


class Cells:
    """Figures of one scene and engine in cells: some suspects in their old state, the rest as later.

    A cell is given by the names of the suspects that have their new state. Its runs are made once, in an environment
    with the versions of the cell and with a tree of its sources.
    """

    def __init__(
        self, was: Figure, now: Figure, last: NightSummary, since: NightSummary, swaps: Sequence[Swap],
        scenes: OwnScenes, scratch: Path, note: Callable[[str], None] = ignore,
    ) -> None:  # fmt: skip
        """Take the figure of both nights and the suspects that can be exchanged; nothing is made yet.

        `note` is told of each run when it begins: one may take minutes.

        Raises
        ------
        CellError
            If no command measures the figure by itself.
        """
        self.identity, self.last, self.since, self.swaps, self.scenes = was.identity, last, since, swaps, scenes
        self.depends = sorted({*was.depends, *now.depends})
        programs = {name[len(PROGRAM) :].partition(" (")[0] for name in self.depends if name.startswith(PROGRAM)}
        if outside := sorted(programs - built_in().keys()):
            said = f"is of the program {', '.join(outside)}, which no fresh environment has, so that it can't be tried"
            raise CellError(f"{self.identity.name}: {said}")
        self.scratch, self.trees, self.note = scratch, dict[str, Path](), note
        self.repeats = REPEATS if self.identity.kind in STEPPED else 1
        self.measured: dict[tuple[Any, ...], Mapping[FigureIdentity, Figure] | str] = {}
        command_of(self.identity, self.scene())

    def figure(
        self, new: frozenset[str] = frozenset(), repeat: int = 0, walked: tuple[Swap, str] | None = None
    ) -> Figure:
        """Figure of a cell; missing, with the reason, if the cell does not run.

        Parameters
        ----------
        new : frozenset of str
            Suspects with their new state.
        repeat : int
            Number of the measurement.
        walked : tuple, optional
            A suspect and the state that it has instead: that of a distribution, or a commit of barchain.

        Raises
        ------
        PinnedEnvironmentError
            If the sources of a night can't be made again.
        """
        pins, scene = tuple(self.pins(new, walked)), self.scene(new)
        commit = walked[1] if walked is not None and not walked[0].distribution else ""
        old = [swap for swap in self.swaps if swap.packages and swap.name not in new]
        key = pins, commit or tuple(sorted(swap.name for swap in old)), scene, repeat
        if key not in self.measured:
            self.measured[key] = self.measure(pins, self.tree(commit, old), scene)
        found = self.measured[key]
        if isinstance(found, str):
            return Figure(self.identity, reason=found)
        return found.get(self.identity, Figure(self.identity, reason="the run gave no such figure"))

    def measure(self, pins: tuple[str, ...], tree: Path, scene: str) -> Mapping[FigureIdentity, Figure] | str:
        """All figures of a run in a cell, or why there are none."""
        folder = self.scratch / f"cell-{len(self.measured)}"
        folder.mkdir(parents=True)
        self.note(f"run {len(self.measured) + 1}, in an environment with {', '.join(pins) or 'the same versions'}")
        registrations = [find_engine(name) for name in (self.identity.engine, self.identity.anchor) if name]
        also = sorted({name for r in registrations for name in (r.requires, r.distribution)} - {""})
        try:
            environment = pinned_environment(pins, also=also)
        except PinnedEnvironmentError as error:
            return str(error)
        line = command_of(self.identity, scene)
        found = measured_figures(environment, tree, line, limit_s=LIMIT_S, out=folder / "out")
        return found if isinstance(found, str) else {figure.identity: figure for figure in found}

    def pins(self, new: frozenset[str], walked: tuple[Swap, str] | None) -> list[str]:
        """Versions of a cell: old ones of suspects outside of it, new ones of all other distributions of the figure."""
        states = {}
        for name in self.depends:
            part = self.since.part_named.get(name)
            if part is not None and name.startswith(DISTRIBUTIONS) and can_be_installed(part.version):
                states[name.partition(":")[2]] = part.version
        for swap in self.swaps:
            if swap.distribution:
                states[swap.distribution] = swap.states[swap.name in new]
        if walked is not None and walked[0].distribution:
            states[walked[0].distribution] = walked[1]
        return [requirement_of(name, state) for name, state in sorted(states.items())]

    def scene(self, new: frozenset[str] = frozenset()) -> str:
        """Scene of a cell: its name, or the file of one's own scene in the state of the cell.

        Raises
        ------
        CellError
            If no file is the scene of the night.
        """
        name = self.identity.scene
        if name in scene_names():
            return name
        for swap in self.swaps:
            if swap.name == SCENE + name:
                return swap.scenes[swap.name in new]
        part = self.since.part_named.get(SCENE + name)
        if part is None or part.digest not in self.scenes:
            said = "belongs to a scene of a file; give the file as it was on the night with --scene-file"
            raise CellError(f"{self.identity.name}: {said}")
        return self.scenes[part.digest]

    def tree(self, commit: str, old: Sequence[Swap] = ()) -> Path:
        """Sources of a commit; else of the later night, with some packages of the earlier one."""
        name = commit or "+".join(sorted(swap.name for swap in old)) or self.since.name
        if name not in self.trees:
            target = self.scratch / f"tree-{len(self.trees)}"
            self.trees[name] = commit_tree(commit, target) if commit else self.sources(self.since, target)
            for swap in old if not commit else ():
                replace_packages(target, self.earlier, swap.packages)
        return self.trees[name]

    @property
    def earlier(self) -> Path:
        """Sources of the earlier night."""
        if self.last.name not in self.trees:
            self.trees[self.last.name] = self.sources(self.last, self.scratch / "tree-earlier")
        return self.trees[self.last.name]

    def sources(self, night: NightSummary, target: Path) -> Path:
        """New tree of a night's sources: those of this installation if they are the same, else those of its commit."""
        if same_sources(night, self.depends):
            return installed_tree(target)
        if not night.commit:
            said = "its sources are not those of this installation, and it knows no commit"
            raise PinnedEnvironmentError(f"{night.name}: {said}")
        return commit_tree(night.commit, target)


def same_sources(night: NightSummary, depends: Iterable[str]) -> bool:
    """Whether barchain's sources behind some parts have the same known digests on a night and in this installation."""
    shipped, there = set(scene_names()), night.part_named
    scenes = [name for name in shipped if SCENE + name in there]
    packages = [name for name, registration in engines().items() if not registration.entry]
    here = {part.name: part.digest for part in installed_parts(packages, scenes, night.environment)}
    for name in depends:
        kind, _, rest = name.partition(":")
        own = name in SOURCES or kind == "adapter" or (kind in {"scene", "solution"} and rest in shipped)
        if own and (name not in there or not there[name].digest or here.get(name) != there[name].digest):
            return False
    return True


def command_of(identity: FigureIdentity, scene: str = "") -> tuple[str, ...]:
    """Command that measures a figure and little else; `scene` is the file of one's own scene.

    Raises
    ------
    CellError
        If no command does, e.g. of a figure without engine.
    """
    study, _, last = identity.quantity.rpartition(".")
    study = study.partition(".")[0] or last
    if last == FINER:
        raise CellError(f"{identity.name}: it is of a run at the finer setting, which no command makes by itself")
    if not identity.scene or not identity.engine:
        raise CellError(f"{identity.name}: belongs to no scene and engine, so that it can't be measured by itself")
    scene = scene or identity.scene
    if study in BY_SCENE:
        anchor = ("--engine", identity.anchor) if identity.anchor else ()
        times = ("--repeats", "5", "--minutes", f"{MINUTES}") if study == "cost" else ()
        return (study, scene, "--engine", identity.engine, *anchor, *times)
    if study in OTHER_STUDIES:
        raise CellError(f"{identity.name}: figures of {study} are not measured by themselves")
    setting = ("--set", identity.setting) if "=" in identity.setting else ()
    return ("compare", scene, "--engine", identity.engine, *setting)


def shows(identity: FigureIdentity, base: Figure, found: Figure, factor: float | None) -> bool:
    """Whether a figure of a cell differs from that of the old state as a change says.

    Parameters
    ----------
    identity : FigureIdentity
    base : Figure
        Of the cell in which all suspects have their old state.
    found : Figure
    factor : float, optional
        New value of the change over its old one, of times and memory.
    """
    if base.missing or found.missing:
        return base.missing is not found.missing
    if identity.kind is FigureKind.BITS:
        return base.word != found.word
    if identity.kind in COMPARED:
        judged = compared(base, found)
        return judged is not None and judged.direction is not Direction.SAME
    assert base.value is not None
    assert found.value is not None
    if factor is None or factor <= 0.0:
        return False
    return math.log(found.value / base.value) / math.log(factor) > HALF


def middle(figures: list[Figure]) -> Figure:
    """Figure with the median value of several measurements; a missing one if most are."""
    known = sorted((f for f in figures if f.value is not None), key=lambda f: f.value or 0.0)
    return known[len(known) // 2] if 2 * len(known) > len(figures) else figures[0]
