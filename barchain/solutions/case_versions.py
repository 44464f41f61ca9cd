"""Identifiers of cases to cite, and versions of their values.

A case is a scene with its certified samples. `case_versions.csv` is the changelog of values: a row for each version of
each case, the latest of a case last. A case keeps its identifier; its version rises with every change of a value.
"""

from __future__ import annotations

import csv
import hashlib
from collections import Counter
from dataclasses import dataclass
from functools import cache as remembered
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from adapters.trajectory import to_frame
from barchain.solutions.certified_file import shipped_files, shipped_solution
from barchain.solutions.reference import at_own_samples, closely_sampled
from scenarios import load_scene, scene_names

if TYPE_CHECKING:
    from collections.abc import Iterable

    import pandas as pd

    from barchain.solutions.reference import ReferenceSolution

TABLE = Path(__file__).with_suffix(".csv")
NO_VALUES = ("gap", "com_residual", "position")
"""Beginnings of columns that a case leaves out: what follows from the others, or vanishes"""
DIGITS = 16
"""Of a digest of values"""


@dataclass(frozen=True)
class CaseVersion:
    """A row of the table."""

    identifier: str
    """With the version of the values, e.g. ``BC-fig05-1``"""
    scene: str
    data_set: str
    """Version of the data set that has it first"""
    digest: str
    """Of the values, :func:`values_digest`"""
    change: str
    """What changed, and why"""


@remembered
def versions() -> tuple[CaseVersion, ...]:
    """Rows of the table."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        return tuple(CaseVersion(**row) for row in csv.DictReader(file))


def current(rows: Iterable[CaseVersion] | None = None) -> dict[str, CaseVersion]:
    """Latest version of each case, by its scene."""
    return {row.scene: row for row in (versions() if rows is None else rows)}


def data_set_version() -> str:
    """Version of the data set: that of the latest change of a value."""
    return versions()[-1].data_set


def case_scenes() -> list[str]:
    """Scenes with certified samples that come with barchain."""
    there = shipped_files()
    return [name for name in scene_names() if closely_sampled(load_scene(name)).digest in there]


def case_solution(name: str) -> ReferenceSolution:
    """Certified solution of a case at its scene's own samples.

    Raises
    ------
    ValueError
        If the scene has none.
    """
    scene = load_scene(name)
    found = shipped_solution(closely_sampled(scene))
    if found is None:
        raise ValueError(f"{name} given, allowed: a scene with certified samples, {', '.join(case_scenes())}")
    return at_own_samples(found, scene)


def values(solution: ReferenceSolution) -> pd.DataFrame:
    """Values of a case: instants and channels, at the scene's own samples."""
    seen = solution.trajectory.samples(slice(len(solution.amplification))).of_run(solution.scene)
    frame = to_frame(seen)
    return frame[[name for name in frame if not str(name).startswith(NO_VALUES)]]


def values_digest(solution: ReferenceSolution) -> str:
    """Hash of the values of a case, bit for bit, with their columns; error bars are none of them."""
    frame, found = values(solution), hashlib.sha256()
    for name in frame:
        found.update(f"{name}\n".encode())
        found.update(np.ascontiguousarray(frame[name].to_numpy(), dtype="<f8").tobytes())
    return found.hexdigest()[:DIGITS]


def missing_rows(rows: tuple[CaseVersion, ...], digests: dict[str, str]) -> list[CaseVersion]:
    """Rows that the table lacks: of scenes that are in no row, and of those whose values have changed.

    Parameters
    ----------
    rows : tuple of CaseVersion
    digests : dict of str to str
        Digest of the values of each scene as they are.
    """
    have = current(rows)
    major, minor = (rows[-1].data_set if rows else "1.-1").split(".")
    data_set, found = f"{major}.{int(minor) + 1}", []
    for scene, digest in digests.items():
        row = have.get(scene)
        if row is None:
            found.append(CaseVersion(f"{stem_of(scene)}-1", scene, data_set, digest, "first values"))
        elif row.digest != digest:
            stem, _, version = row.identifier.rpartition("-")
            found.append(CaseVersion(f"{stem}-{int(version) + 1}", scene, data_set, digest, "TELL WHAT CHANGED"))
    return found


def stem_of(scene: str) -> str:
    """Identifier of a case without its version: the scene's name, after its folder where a name is in several."""
    folder, _, name = scene.rpartition("/")
    several = Counter(each.rpartition("/")[2] for each in scene_names())[name] > 1
    return f"BC-{folder}-{name}" if several else f"BC-{name}"
