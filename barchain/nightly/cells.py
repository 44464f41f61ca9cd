"""Cells of an attribution: states of suspects that can be made here, and figures measured in them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from adapters.registry import find_engine
from barchain.nightly.changes import OTHER_STUDIES, RULES, Direction, compared
from barchain.nightly.environments import commit_tree, installed_tree, pinned_environment, replace_packages, run_in
from barchain.nightly.faults import HistoryError, PinnedEnvironmentError
from barchain.nightly.figures import STEPPED, Figure, FigureIdentity, FigureKind
from barchain.nightly.origins import can_be_installed, requirement_of
from barchain.nightly.parts import SOURCES, installed_parts, scene_part
from barchain.nightly.results import read_figures_of
from scenarios import load_scene, scene_names

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from barchain.nightly.figures import NightPart, NightSummary
    from barchain.nightly.suspects import Suspect


DISTRIBUTIONS = ("engine:", "library:")
ADAPTER, SCENE, SOLUTION = "adapter:", "scene:", "solution:"


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


def swap_of(suspect: Suspect, scenes: OwnScenes) -> Swap | str:
    """Exchange of a suspect, or why it can't be exchanged; `scenes` are one's own."""
    name, before, after = suspect.name, suspect.before, suspect.after
    if before is None or after is None:
        return f"{name}: was not there on one of the nights"
    if name.startswith(DISTRIBUTIONS):
        if not can_be_installed(before.version) or not can_be_installed(after.version):
            return f"{name}: its sources of a night are in no commit, so that they can't be installed again"
        if before.version == after.version:
            return f"{name}: has the same version on both nights; other files of one version can't be installed again"
        return Swap(suspect, distribution=name.partition(":")[2])
    if name.startswith(SCENE) and name.removeprefix(SCENE) not in scene_names():
        files = tuple(scenes.get(part.digest, "") for part in (before, after))
        return Swap(suspect, scenes=files) if all(files) else f"{name}: give both of its files with --scene-file"
    packages = packages_of(name)
    return Swap(suspect, packages=packages) if packages else f"{name}: can't be exchanged here"


def packages_of(name: str) -> tuple[str, ...]:
    """Packages of barchain behind a part; none of Python, BLAS, the machine."""
    if name in SOURCES:
        return SOURCES[name]
    kind, _, rest = name.partition(":")
    if kind == "adapter":
        return (f"adapters.{rest}",)
    if kind == "scene":
        return ("scenarios",)
    return ("barchain.solutions",) if kind == "solution" else ()


OwnScenes = dict[str, str]
"""Files of scenes of one's own by the digests of the scenes"""
NO_SCENES: OwnScenes = {}


def own_scenes(files: Iterable[str]) -> OwnScenes:
    """Scenes of some files.

    Raises
    ------
    SceneError
        If a file is none of a scene.
    """
    return {load_scene(Path(file)).digest: str(Path(file).resolve()) for file in files}


def swaps_of(suspects: Iterable[Suspect], scenes: OwnScenes = NO_SCENES) -> tuple[list[Swap], list[str]]:
    """Exchanges of suspects, and the reasons why others can't be exchanged; `scenes` are one's own."""
    found: list[Swap] = []
    reasons = []
    for suspect in suspects:
        one = swap_of(suspect, scenes)
        if isinstance(one, str):
            reasons.append(one)
        else:
            found.append(one)
    return found, reasons


LIMIT_S = 300.0
REPEATS = 3
"""Measurements of a ratio in each cell; cells are measured in turns"""
HALF = 0.5
"""A ratio shows a change if it moved by more than this part of the change, as a logarithm"""
MINUTES = 0.2
FINER = "finer"
"""End of the quantities of runs at the finer setting"""
STUDIES = {"cost": "cost", "stability": "stability"}


class CellError(HistoryError):
    """Raised for a figure that can't be measured by itself; the message is one line."""


class Cells:
    """Figures of one scene and engine in cells: some suspects in their old state, the rest as later.

    A cell is given by the names of the suspects that have their new state. Its runs are made once, in an environment
    with the versions of the cell and with a tree of its sources.
    """

    def __init__(
        self, was: Figure, now: Figure, last: NightSummary, since: NightSummary, swaps: Sequence[Swap],
        scenes: OwnScenes, scratch: Path,
    ) -> None:  # fmt: skip
        """Take the figure of both nights and the suspects that can be exchanged; nothing is made yet.

        Raises
        ------
        CellError
            If no command measures the figure by itself.
        """
        self.identity, self.last, self.since, self.swaps, self.scenes = was.identity, last, since, swaps, scenes
        self.depends = depends_of(was, now)
        self.scratch, self.trees = scratch, dict[str, Path]()
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
        key = pins, commit or self.tree_name(new), scene, repeat
        if key not in self.measured:
            self.measured[key] = self.measure(pins, self.of_commit(commit) if commit else self.tree(new), scene)
        found = self.measured[key]
        if isinstance(found, str):
            return Figure(self.identity, reason=found)
        return found.get(self.identity, Figure(self.identity, reason="the run gave no such figure"))

    def middle(self, walked: tuple[Swap, str]) -> Figure:
        """Figure at a state of a suspect, of several measurements the one with the median value."""
        return middle([self.figure(repeat=repeat, walked=walked) for repeat in range(self.repeats)])

    def measure(self, pins: tuple[str, ...], tree: Path, scene: str) -> Mapping[FigureIdentity, Figure] | str:
        """All figures of a run in a cell, or why there are none."""
        folder = self.scratch / f"cell-{len(self.measured)}"
        folder.mkdir(parents=True)
        try:
            environment = pinned_environment(pins, also=needed_by(self.identity))
        except PinnedEnvironmentError as error:
            return str(error)
        line = ("-m", "barchain", "-q", *command_of(self.identity, scene), "--out", str(folder / "out"))
        done = run_in(environment, tree, line, limit_s=LIMIT_S, folder=folder)
        try:
            return {figure.identity: figure for figure in read_figures_of(folder / "out")}
        except (HistoryError, FileNotFoundError, ValueError):
            return done.reason or f"ended with exit code {done.code}"

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
        swapped = next((swap for swap in self.swaps if swap.name == scene_part(name)), None)
        if swapped is not None:
            return swapped.scenes[swapped.name in new]
        part = self.since.part_named.get(scene_part(name))
        if part is None or part.digest not in self.scenes:
            said = "belongs to a scene of a file; give the file as it was on the night with --scene-file"
            raise CellError(f"{self.identity.name}: {said}")
        return self.scenes[part.digest]

    def tree_name(self, new: frozenset[str]) -> str:
        """Name of a mixture of sources: the suspects that have their old state; empty of the later night's."""
        return "+".join(sorted(swap.name for swap in self.swaps if swap.packages and swap.name not in new))

    def tree(self, new: frozenset[str]) -> Path:
        """Sources of a cell: those of the later night, and in them old ones of suspects outside of the cell."""
        name = self.tree_name(new)
        if not name:
            return self.whole(self.since)
        if name not in self.trees:
            tree = self.copy(self.since)
            for swap in self.swaps:
                if swap.packages and swap.name not in new:
                    replace_packages(tree, self.whole(self.last), swap.packages)
            self.trees[name] = tree
        return self.trees[name]

    def whole(self, night: NightSummary) -> Path:
        """Sources of a night."""
        if night.name not in self.trees:
            self.trees[night.name] = self.copy(night)
        return self.trees[night.name]

    def of_commit(self, commit: str) -> Path:
        """Sources of a commit."""
        if commit not in self.trees:
            self.trees[commit] = commit_tree(commit, self.scratch / f"commit-{commit}")
        return self.trees[commit]

    def copy(self, night: NightSummary) -> Path:
        """New tree of a night's sources: those of this installation if they are the same, else those of its commit."""
        target = self.scratch / f"tree-{len(list(self.scratch.glob('tree-*')))}"
        if same_sources(night, self.depends):
            return installed_tree(target)
        if not night.commit:
            said = "its sources are not those of this installation, and it knows no commit"
            raise PinnedEnvironmentError(f"{night.name}: {said}")
        return commit_tree(night.commit, target)


def depends_of(was: Figure, now: Figure) -> tuple[str, ...]:
    """Parts that a figure depends on, on either night."""
    return tuple(sorted({*was.depends, *now.depends}))


def same_sources(night: NightSummary, depends: Iterable[str]) -> bool:
    """Whether barchain's sources behind some parts are those of this installation."""
    here = {part.name: part for part in installed_here(night)}
    shipped = scene_names()
    own = [
        name for name in depends
        if name in SOURCES or name.startswith(ADAPTER)
        or (name.startswith((SCENE, SOLUTION)) and name.partition(":")[2] in shipped)
    ]  # fmt: skip
    return all(name in here and alike(here[name], night.part_named.get(name)) for name in own)


def alike(here: NightPart, there: NightPart | None) -> bool:
    """Whether a part has the same known digest here and there."""
    return there is not None and bool(there.digest) and here.digest == there.digest


def installed_here(night: NightSummary) -> tuple[NightPart, ...]:
    """Parts of this installation, of the kinds that a night has."""
    from adapters.registry import engines  # noqa: PLC0415
    from scenarios import scene_names  # noqa: PLC0415

    names = set(night.part_named)
    shipped = [name for name in scene_names() if f"{SCENE}{name}" in names]
    return installed_parts(engines(), shipped, night.environment)


def needed_by(identity: FigureIdentity) -> tuple[str, ...]:
    """Distributions that the engines of a figure need."""
    registrations = [find_engine(name) for name in (identity.engine, identity.anchor) if name]
    names = {name for r in registrations for name in (r.requires, r.distribution)}
    return tuple(sorted(names - {""}))


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
        raise CellError(f"{identity.name}: belongs to a run at the finer setting, which no command makes by itself")
    if not identity.scene or not identity.engine:
        raise CellError(f"{identity.name}: belongs to no scene and engine, so that it can't be measured by itself")
    if study in OTHER_STUDIES - STUDIES.keys():
        raise CellError(f"{identity.name}: figures of {study} are not measured by themselves")
    scene = scene or identity.scene
    if study in STUDIES:
        anchor = ("--engine", identity.anchor) if identity.anchor else ()
        line = (STUDIES[study], scene, "--engine", identity.engine, *anchor)
        return (*line, "--repeats", "5", "--minutes", f"{MINUTES}") if study == "cost" else line
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
    if identity.kind in RULES:
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
