"""Cells of the factorial: the figure of a change, measured in a fresh environment."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from adapters.registry import find_engine
from barchain.nightly.environments.faults import PinnedEnvironmentError
from barchain.nightly.environments.making import pinned_environment
from barchain.nightly.environments.running import run_in
from barchain.nightly.history.changes.levels import RULES, compared
from barchain.nightly.history.changes.model import Direction
from barchain.nightly.history.changes.verdicts import OTHER_STUDIES
from barchain.nightly.history.faults import HistoryError
from barchain.nightly.history.folders.reading import read_figures_of
from barchain.nightly.history.model.figures import Figure, FigureIdentity, FigureKind
from scenarios import scene_names

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

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


@dataclass(frozen=True)
class CellPlace:
    """Environment and sources of a cell."""

    pins: tuple[str, ...]
    tree: Path


@dataclass
class CellRunner:
    """Measures the figures of one scene and engine in cells; each cell and repeat is measured once."""

    identity: FigureIdentity
    folder: Path
    limit_s: float = LIMIT_S
    measured: dict[tuple[tuple[str, ...], str, int], Mapping[FigureIdentity, Figure]] = field(default_factory=dict)
    reasons: dict[tuple[tuple[str, ...], str], str] = field(default_factory=dict)
    """Why a cell gave no figures"""

    def figure(self, place: CellPlace, identity: FigureIdentity, repeat: int = 0) -> Figure:
        """Figure of a cell; missing, with the reason, if the cell does not run."""
        key = (place.pins, str(place.tree), repeat)
        if key not in self.measured:
            self.measured[key] = self.measure(place, len(self.measured))
        reason = self.reasons.get(key[:2], "the run gave no such figure")
        return self.measured[key].get(identity, Figure(identity, reason=reason))

    def measure(self, place: CellPlace, number: int) -> Mapping[FigureIdentity, Figure]:
        """All figures of a run in a cell."""
        scratch = self.folder / f"cell-{number}"
        scratch.mkdir(parents=True)
        try:
            environment = pinned_environment(place.pins, also=needed_by(self.identity))
        except PinnedEnvironmentError as error:
            self.reasons[place.pins, str(place.tree)] = str(error)
            return {}
        line = ("-m", "barchain", "-q", *command_of(self.identity), "--out", str(scratch / "out"))
        done = run_in(environment, place.tree, line, limit_s=self.limit_s, folder=scratch)
        try:
            return {figure.identity: figure for figure in read_figures_of(scratch / "out")}
        except (HistoryError, FileNotFoundError, ValueError):
            self.reasons[place.pins, str(place.tree)] = done.reason or f"ended with exit code {done.code}"
            return {}


def needed_by(identity: FigureIdentity) -> tuple[str, ...]:
    """Distributions that the engines of a figure need."""
    registrations = [find_engine(name) for name in (identity.engine, identity.anchor) if name]
    names = {name for r in registrations for name in (r.requires, r.distribution)}
    return tuple(sorted(names - {""}))


def command_of(identity: FigureIdentity) -> tuple[str, ...]:
    """Command that measures a figure and little else.

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
    if identity.scene not in scene_names():
        raise CellError(
            f"{identity.name}: belongs to a scene of a file, and only scenes that come with barchain are run again"
        )
    if study in STUDIES:
        anchor = ("--engine", identity.anchor) if identity.anchor else ()
        line = (STUDIES[study], identity.scene, "--engine", identity.engine, *anchor)
        return (*line, "--repeats", "5", "--minutes", f"{MINUTES}") if study == "cost" else line
    setting = ("--set", identity.setting) if "=" in identity.setting else ()
    return ("compare", identity.scene, "--engine", identity.engine, *setting)


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
