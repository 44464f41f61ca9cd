"""States of suspects that can be made here: versions of distributions, and barchain's own sources of a commit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from barchain.nightly.environments.faults import PinnedEnvironmentError
from barchain.nightly.environments.sources import commit_tree, installed_tree, replace_packages
from barchain.nightly.history.model.parts import SOURCES, installed_parts

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from barchain.nightly.history.changes.suspects import Suspect
    from barchain.nightly.history.model.figures import NightPart
    from barchain.nightly.history.model.series_model import NightSummary

DISTRIBUTIONS = ("engine:", "library:")
ADAPTER, SCENE, SOLUTION = "adapter:", "scene:", "solution:"
CERTIFIED = "barchain.solutions.certified_solutions"


@dataclass(frozen=True)
class Swap:
    """Suspect whose states can be exchanged."""

    suspect: Suspect
    distribution: str = ""
    """Of a version; empty of barchain's own sources"""
    packages: tuple[str, ...] = ()
    """Of barchain's own sources"""

    @property
    def name(self) -> str:
        """Name of the part."""
        return self.suspect.name


def swap_of(suspect: Suspect) -> Swap | str:
    """Exchange of a suspect, or why it can't be exchanged."""
    name, before, after = suspect.name, suspect.before, suspect.after
    if before is None or after is None:
        return f"{name}: was not there on one of the nights"
    if name.startswith(DISTRIBUTIONS):
        if not before.version or not after.version or before.version == after.version:
            return f"{name}: has the same version on both nights; other files of one version can't be installed again"
        return Swap(suspect, distribution=name.partition(":")[2])
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


def swaps_of(suspects: Iterable[Suspect]) -> tuple[list[Swap], list[str]]:
    """Exchanges of suspects, and the reasons why others can't be exchanged."""
    found: list[Swap] = []
    reasons = []
    for suspect in suspects:
        one = swap_of(suspect)
        if isinstance(one, str):
            reasons.append(one)
        else:
            found.append(one)
    return found, reasons


def pins_of(cell: frozenset[str], swaps: Sequence[Swap], since: NightSummary, depends: Iterable[str]) -> list[str]:
    """Versions of a cell: old ones of suspects outside of it, new ones of all other distributions of the figure."""
    versions = {}
    for name in depends:
        part = since.part_named.get(name)
        if part is not None and name.startswith(DISTRIBUTIONS) and part.version:
            versions[name.partition(":")[2]] = part.version
    for swap in swaps:
        if swap.distribution:
            state = swap.suspect.after if swap.name in cell else swap.suspect.before
            assert state is not None
            versions[swap.distribution] = state.version
    return [f"{name}=={version}" for name, version in sorted(versions.items())]


class NightTrees:
    """Sources of two nights, and mixtures of both; each is made once."""

    def __init__(self, folder: Path, last: NightSummary, since: NightSummary, depends: Iterable[str]) -> None:
        """Take an empty folder; trees are made when they are asked for."""
        self.folder, self.last, self.since, self.depends = folder, last, since, tuple(depends)
        self.made: dict[str, Path] = {}

    def tree(self, cell: frozenset[str], swaps: Sequence[Swap]) -> Path:
        """Sources of a cell.

        Raises
        ------
        PinnedEnvironmentError
            If the sources of a night can't be made again.
        """
        old = [swap for swap in swaps if swap.packages and swap.name not in cell]
        if not old:
            return self.whole(self.since)
        key = "+".join(sorted(swap.name for swap in old))
        if key not in self.made:
            tree = self.copy(self.since, f"mixed-{len(self.made)}")
            for swap in old:
                replace_packages(tree, self.whole(self.last), swap.packages)
            self.made[key] = tree
        return self.made[key]

    def whole(self, night: NightSummary) -> Path:
        """Sources of a night."""
        if night.name not in self.made:
            self.made[night.name] = self.copy(night, f"night-{len(self.made)}")
        return self.made[night.name]

    def copy(self, night: NightSummary, name: str) -> Path:
        """New tree of a night's sources: those of this installation if they are the same, else those of its commit."""
        if same_sources(night, self.depends):
            return installed_tree(self.folder / name)
        if not night.commit:
            raise PinnedEnvironmentError(
                f"{night.name}: its sources are not those of this installation, and it knows no commit"
            )
        return commit_tree(night.commit, self.folder / name)


def same_sources(night: NightSummary, depends: Iterable[str]) -> bool:
    """Whether barchain's sources behind some parts are those of this installation."""
    here = {part.name: part for part in installed_here(night)}
    own = [name for name in depends if name in SOURCES or name.startswith((ADAPTER, SCENE, SOLUTION))]
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
