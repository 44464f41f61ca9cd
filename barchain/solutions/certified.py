"""Certified solutions: quadruple precision with error bars, from a committed file, a cache or a run of heyoka.

The files of the repository are made here, and compared with fresh runs.
"""

from __future__ import annotations

import dataclasses
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
from adapters.heyoka.compiled import QUAD
from adapters.heyoka.run import HeyokaRun
from adapters.registry import find_engine
from barchain.metrics.quantities import TRACK, components, differences
from barchain.record.environment import package_version
from barchain.solutions.certified_file import (
    SAME_INSTANT,
    CertifiedTable,
    DamagedTableError,
    columns_of,
    head_of,
    motion_of,
    physics_digest,
    read_file,
    read_table,
    rows_at,
    shipped_files,
    shipped_path,
    shipped_solution,
    write_file,
)
from barchain.solutions.judging import (
    CERTIFIED_CHECK_RTOL,
    CERTIFIED_RTOL,
    PRECISION,
    certified_jobs,
    error_bar,
    establish_certified,
)
from barchain.solutions.proof import MISSING, PROOF, PROVEN, NotCheckedError, check_proof, proof_of
from barchain.solutions.reference import closely_sampled

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

CACHE_VARIABLE = "BARCHAIN_CACHE"
MARGIN = 10.0  # a certified solution must be this many times more accurate than the judged run
INSTANTS = 21  # of a committed table, over the run and over the first orbit each
NOT_JUDGED = "hard/"
"""Scenes whose files have no solution that judges: `barchain stability` asks what they conserve"""
MOST_GROWN = 1e14
"""Largest amplification that a verdict uses: rounding to double then exceeds the predictability limit"""
AMPLIFICATION_SHARE = 0.01
"""Largest relative change of the amplification, whose perturbed runs are known to 1e-4"""
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
    kept = shipped_files().get(physics_digest(scene))
    return (served(scene, read_table(kept), "committed") if kept else None) or cached(scene, path)


def cache_file(scene: Scene, cache: Path | None = None) -> Path:
    """File of a scene's certified solution in the cache, or in another folder."""
    return (cache or cache_folder()) / "certified_solutions" / f"{cache_key(scene)}.parquet"


def served(scene: Scene, table: CertifiedTable, source: Source) -> CertifiedSolution | None:
    """Certified solution from a table, or None if the table lacks an instant."""
    rows = rows_at(scene, table)
    return None if rows is None else CertifiedSolution(scene, *rows, table.precision, source)


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

    table = fresh(scene, scene.times_s)
    write_file(path, table)
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
    files += [ours / "common" / "reference_model.py"]
    files += sorted(Path(str(scenarios.__file__)).parent.rglob("*.py"))
    files += [theirs / "model" / f"{name}.py" for name in ("arrays", "chain", "complex_vectors", "kinematics", "state")]
    files += [Path(__file__).with_name(f"{name}.py") for name in ("certified", "certified_file", "judging")]
    files += [Path(__file__).parent.parent / "metrics" / f"{name}.py" for name in ("quantities",)]
    return hashlib.sha256(b"".join(f.read_bytes() for f in files)).hexdigest()


def table_times(scene: Scene) -> Array:
    """Instants of a committed table: of the whole run, among its samples, and of the first orbit; (n,) s."""
    times = scene.times_s
    whole = times[np.round(np.linspace(0, len(times) - 1, INSTANTS)).astype(int)]
    first = np.linspace(0.0, min(scene.period_s, scene.run.duration_s), INSTANTS)
    both = np.unique(np.concatenate([first, whole]))
    kept: Array = both[np.append(True, np.diff(both) > SAME_INSTANT * both[1:])]
    return kept


def fresh(scene: Scene, times_s: Array) -> CertifiedTable:
    """Certified solution of `scene` at `times_s`, (n,) s, increasing from 0.

    Raises
    ------
    EngineError
        If either run fails.
    """
    fine, check = (run(scene, times_s, rtol) for rtol in (CERTIFIED_RTOL, CERTIFIED_CHECK_RTOL))
    return CertifiedTable(scene.name, physics_digest(scene), PRECISION, fine, error_bar(fine, check))


def run(scene: Scene, times_s: Array, rtol: float) -> Trajectory:
    """One run in quadruple precision, rounded to double."""
    made = HeyokaRun(scene, times_s, QUAD, rtol)
    made.walk()
    return made.trajectory()


def make(scene: Scene) -> CertifiedTable:
    """Certified solution of a shipped scene at the instants of its table, with errors from all samples of the run."""
    wanted = table_times(scene)
    every = np.unique(np.concatenate([wanted, scene.times_s]))
    full = fresh(scene, every)
    row = np.searchsorted(full.trajectory.t_s, wanted[wanted <= full.trajectory.t_s[-1]])
    error = {name: values[row] for name, values in full.error.items()}
    return dataclasses.replace(full, trajectory=full.trajectory.samples(row), error=error)


def maker(name: str) -> str:
    """Command that makes the certified solution of a shipped scene."""
    return f"barchain certified {name} --out DIR"


def make_judge(scene: Scene) -> ReferenceSolution:
    """Certified solution that judges a shipped scene, at the samples of a comparison."""
    sampled = closely_sampled(scene)
    jobs = certified_jobs(sampled)
    return establish_certified(sampled, *(j.registration.engine(j.options).run(j.scene, j.setting) for j in jobs))


def commit(scene: Scene, folder: Path) -> CertifiedTable:
    """Make a certified solution, and write its file into `folder` by the scene's name."""
    table = make(scene)
    judge = None if scene.name.startswith(NOT_JUDGED) else make_judge(scene)
    write_file(shipped_path(scene.name, folder), table, judge)
    return table


@dataclass(frozen=True)
class CommittedTableCheck:
    """Comparison of a fresh certified solution with the committed one."""

    scene: str
    share: dict[str, float]
    """For each quantity, the largest difference over what both error bars allow"""
    fault: str = ""
    """Why they can't be compared, or what is wrong with a proof; empty if nothing is"""
    proof: str = ""
    """What was checked of a proof, in words"""

    @property
    def agrees(self) -> bool:
        """Whether all of it lies inside the error bars."""
        return not self.fault and all(s <= 1.0 for s in self.share.values())

    @property
    def said(self) -> str:
        """One line."""
        worst = max(self.share.values(), default=0.0)
        verdict = "agrees" if self.agrees else "DIFFERS"
        return f"{self.scene}: {self.fault or f'{verdict}, by {worst:.2f} of the error bars{self.proof}'}"


def check(scene: Scene) -> CommittedTableCheck:
    """Compare a fresh certified solution with the committed one, inside both error bars."""
    path, name = shipped_path(scene.name), scene.name
    if not path.is_file():
        return CommittedTableCheck(name, {}, f"has no certified solution; make it: {maker(name)}")
    try:
        kept = read_table(path)
    except DamagedTableError as error:
        return CommittedTableCheck(name, {}, str(error))
    if kept.physics != physics_digest(scene):
        return CommittedTableCheck(name, {}, f"has changed since; make it again: {maker(name)}")
    again = make(scene)
    if kept.trajectory.t_s.shape != again.trajectory.t_s.shape:
        return CommittedTableCheck(name, {}, f"has other instants than committed; make it again: {maker(name)}")
    fault, unchecked = "", MISSING
    try:
        fault = check_proof(scene, path)
    except NotCheckedError as error:
        unchecked = str(error)
    checked = f"; its proof was checked in part: {unchecked}" if unchecked else ", with its proof"
    proof = checked if PROOF in head_of(path) else ""
    table = CommittedTableCheck(name, shares(kept, again), fault or check_digits(scene, path), proof)
    judge = shipped_solution(closely_sampled(scene)) if table.agrees else None
    if judge is None:
        return table
    other = check_judge(scene, judge)
    return dataclasses.replace(table, share={k: max(table.share.get(k, 0.0), other[k]) for k in other})


def check_digits(scene: Scene, path: Path) -> str:
    """Fault of heyoka's digits beyond double precision against proven ones; empty if there is none, or no proof.

    At the chosen instants they are the proven digits, and at all proven rows the value is as near as is proven.
    """
    stored = proof_of(path)
    if stored is None:
        return ""
    (values, proof), (head, frame) = stored, read_file(path)
    rows = frame[frame[f"{PROVEN}attitude"].notna()]
    times_s, at = np.unique(rows["t_s"].to_numpy(), return_inverse=True)
    made = HeyokaRun(scene, times_s, QUAD, CERTIFIED_RTOL)
    made.walk()
    allowed = CERTIFIED_CHECK_RTOL * float(np.nanmax(frame.get("amplification", 1.0)))
    high, low = (components(x.samples(at)) for x in (made.trajectory(), made.trajectory(beyond=True)))
    own, proven_low, bounds = components(motion_of(rows, head)), components(proof.low), columns_of(rows, PROVEN)
    for name, x in high.items():
        beyond, least = (x - own[name]) + low[name], allowed * np.abs(x).max()
        apart = np.abs(beyond[-len(values.t_s) :] - proven_low[name]).max()
        if apart > least + proof.radius[name].max():
            return f"the {name} in quadruple precision is {apart:.1e} from the proven one (SI units)"
        far = np.linalg.norm(beyond, axis=-1).max(axis=1, initial=0.0) > bounds[name] + least
        if far.any():
            return f"the {name} at {rows['t_s'].to_numpy()[far][0]:.9g} s is farther off than is proven"
    return ""


def check_judge(scene: Scene, kept: ReferenceSolution) -> dict[str, float]:
    """Shares of a fresh judging solution's difference from the shipped one: error bars, and equally amplified.

    Its close samples, of which derivatives are made, have the error bars of the next sample.
    """
    again = make_judge(scene)
    found = shares(kept, again)
    t_s, last = kept.trajectory.t_s, len(kept.error["attitude"]) - 1
    after = np.minimum(np.searchsorted(t_s, kept.fine.t_s), last)
    inside = kept.fine.t_s <= t_s[last]
    for name, apart in differences(kept.fine, again.fine).items():
        bars = (kept.error[name] + again.error[name])[after]
        found[name] = max(found[name], share(apart[inside], bars[inside]))
    counted = kept.amplification <= MOST_GROWN
    grown = np.abs(again.amplification / kept.amplification - 1.0)[counted]
    found["amplification"] = float(grown.max()) / AMPLIFICATION_SHARE
    for name in kept.response.keys() - set(TRACK):  # which no perturbation of the attitude moves beyond rounding
        was, now = (x.response[name][: len(counted)][counted] for x in (kept, again))
        found[f"response of the {name}"] = share(np.abs(now - was), np.full(len(was), was.max())) / AMPLIFICATION_SHARE
    return found


def shares(kept: CertifiedTable | ReferenceSolution, again: CertifiedTable | ReferenceSolution) -> dict[str, float]:
    """Largest difference of each quantity at the same instants, relative to both error bars."""
    apart = differences(kept.trajectory, again.trajectory)
    return {k: share(d[: len(kept.error[k])], kept.error[k] + again.error[k]) for k, d in apart.items()}


def share(apart: Array, allowed: Array) -> float:
    """Largest share of what is allowed; nothing is allowed where both are zero."""
    return float(np.divide(apart, allowed, out=np.where(apart > 0.0, np.inf, 0.0), where=allowed > 0.0).max())
