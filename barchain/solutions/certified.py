"""Certified solutions: quadruple precision with error bars, from a committed table, a cache or a run."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import dataclass
from functools import cache as remembered
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from platformdirs import user_cache_path

import adapters
import reference_impl
import scenarios
from adapters.engine import EngineError
from adapters.registry import find_engine
from barchain.record.environment import package_version
from barchain.solutions.certified_table import (
    SAME_INSTANT,
    CertifiedTable,
    DamagedTableError,
    physics_digest,
    read_head,
    read_table,
    rows_at,
    write_table,
)

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

CERTIFIED_SOLUTIONS = Path(__file__).parent / "tables"
CACHE_VARIABLE = "BARCHAIN_CACHE"
MARGIN = 10.0  # a certified solution must be this many times more accurate than the judged run
INSTANTS = 21  # of a committed table, over the run and over the first orbit each
VERSIONS = ("heyoka", "numpy")
Source = Literal["committed", "cache", "computed"]


class CertifiedSolutionError(EngineError):
    """A scene has no certified solution; the message gives the remedy."""


@dataclass(frozen=True)
class CertifiedSolution:
    """Certified solution of one scene at its samples, with error bars; n samples."""

    scene: Scene
    trajectory: Trajectory
    """At `scene.times_s`; without gaps, as the joints are closed by construction"""
    error: dict[str, Array]
    """Bound for each quantity of `quantities.differences`, (n,), never falling"""
    precision: str
    """Precision and tolerances of the runs, in words"""
    source: Source


def certified(scene: Scene, *, cache: Path | None = None) -> CertifiedSolution:
    """Certified solution of `scene`: from a committed table, else from the cache, else from a run, which is cached.

    Parameters
    ----------
    scene : Scene
    cache : Path, optional
        Folder; by default that of the environment variable ``BARCHAIN_CACHE``, or the user's cache folder.

    Returns
    -------
    CertifiedSolution

    Raises
    ------
    CertifiedSolutionError
        If the solution must be run and heyoka is not installed.
    EngineError
        If the run fails.
    """
    path = cache_file(scene, cache)
    return available(scene, path) or computed(scene, path)


def available(scene: Scene, path: Path) -> CertifiedSolution | None:
    """Certified solution that needs no run: from a committed table, or from a file of the cache; None without one."""
    kept = committed(physics_digest(scene))
    return (served(scene, kept, "committed") if kept else None) or cached(scene, path)


def cache_file(scene: Scene, cache: Path | None = None) -> Path:
    """File of a scene's certified solution in the cache, or in another folder."""
    return (cache or cache_folder()) / "certified_solutions" / f"{cache_key(scene)}.csv"


def served(scene: Scene, table: CertifiedTable, source: Source) -> CertifiedSolution | None:
    """Certified solution from a table, or None if the table lacks an instant."""
    rows = rows_at(scene, table)
    return None if rows is None else CertifiedSolution(scene, *rows, table.precision, source)


def committed(physics: str) -> CertifiedTable | None:
    """Committed table for a scene of these physics, or None.

    Raises
    ------
    DamagedTableError
        If the file differs from its checksum.
    """
    path = committed_tables().get(physics)
    return None if path is None else read_table(path)


@remembered
def committed_tables() -> dict[str, Path]:
    """Files of the committed tables by digest of the physics."""
    return {read_head(path)["physics"]: path for path in sorted(CERTIFIED_SOLUTIONS.rglob("*.csv"))}


def cached(scene: Scene, path: Path) -> CertifiedSolution | None:
    """Certified solution from a file of the cache; None if it is missing, damaged, or of other physics."""
    try:
        table = read_table(path)
        return served(scene, table, "cache") if table.physics == physics_digest(scene) else None
    except (OSError, DamagedTableError, KeyError):
        return None


def computed(scene: Scene, path: Path) -> CertifiedSolution:
    """Certified solution from a run, which is then cached."""
    missing = find_engine("heyoka-quad").missing
    if missing:
        raise CertifiedSolutionError(no_solution_words(scene, missing))
    from barchain.solutions.certified_run import fresh  # noqa: PLC0415  # only here is heyoka needed

    table = fresh(scene, scene.times_s)
    write_table(path, table)
    return CertifiedSolution(scene, table.trajectory, table.error, table.precision, "computed")


def need_certifiable(scene: Scene) -> None:
    """Check, without a run, that a certified solution can be had.

    Raises
    ------
    CertifiedSolutionError
        If none comes with barchain at the scene's instants, none is kept here, and heyoka is not installed.
    """
    missing = find_engine("heyoka-quad").missing
    if missing and available(scene, cache_file(scene)) is None:
        raise CertifiedSolutionError(no_solution_words(scene, missing))


def no_solution_words(scene: Scene, missing: str) -> str:
    """Reason why a scene has no certified solution here."""
    return f"{scene.name}: no certified solution comes with barchain at its instants, and {missing}"


def cache_folder() -> Path:
    """Folder of the cache."""
    given = os.environ.get(CACHE_VARIABLE)
    return Path(given) if given else user_cache_path("barchain")


def cache_key(scene: Scene) -> str:
    """Hash of everything that decides a certified solution: scene, code, and versions of its packages."""
    made_of = [scene.digest, code_digest(), {name: package_version(name) for name in VERSIONS}]
    return hashlib.sha256(json.dumps(made_of).encode()).hexdigest()[:32]


@remembered
def code_digest() -> str:
    """Hash of the sources that compute a certified solution."""
    ours, theirs = Path(str(adapters.__file__)).parent, Path(reference_impl.__path__[0])
    files = [*sorted((ours / "heyoka").glob("*.py")), ours / "common" / "initial_state.py", ours / "trajectory.py"]
    files += sorted(Path(str(scenarios.__file__)).parent.rglob("*.py"))
    files += [theirs / "model" / f"{name}.py" for name in ("arrays", "chain", "complex_vectors", "kinematics", "state")]
    files += [Path(__file__).with_name(f"{name}.py") for name in ("certified_run", "certified_table")]
    files += [Path(__file__).parent.parent / "metrics" / f"{name}.py" for name in ("quantities", "rates")]
    return hashlib.sha256(b"".join(f.read_bytes() for f in files)).hexdigest()


def table_times(scene: Scene) -> Array:
    """Instants of a committed table: of the whole run, among its samples, and of the first orbit; (n,) s."""
    times = scene.times_s
    whole = times[np.round(np.linspace(0, len(times) - 1, INSTANTS)).astype(int)]
    first = np.linspace(0.0, min(scene.period_s, scene.run.duration_s), INSTANTS)
    both = np.unique(np.concatenate([first, whole]))
    kept: Array = both[np.append(True, np.diff(both) > SAME_INSTANT * both[1:])]
    return kept


def table_path(scene: Scene) -> Path:
    """File of the committed table of a shipped scene."""
    return CERTIFIED_SOLUTIONS / f"{scene.name}.csv"
