"""Certified solutions as files, which come with barchain or lie in the cache: one Parquet table a scene.

Its columns are those of a trajectory (`adapters.trajectory`), and ``error_q`` for each quantity q. Its last rows are
chosen instants, for studies of cost. Files of scenes that are judged have dense samples before them
(:func:`barchain.solutions.reference.densely_sampled`). Those that are the scene's own samples have ``error_q``,
``amplification`` and ``response_q``, rounded up to single precision, so that error bars stay bounds. Attributes give
the scene and the runs. A checksum over attributes and columns detects a damaged file; numbers read back bit for bit.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from dataclasses import dataclass
from functools import cache as remembered
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from adapters.trajectory import ENDED, from_frame, to_frame
from barchain.metrics.quantities import largest, rate_scale
from barchain.solutions.reference import ReferenceSolution, SolutionSource
from reports.results.writing import parquet, write_atomically

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

CERTIFIED_SOLUTIONS = Path(__file__).parent / "tables"
PHYSICS = ("central_body", "orbit", "chain", "effects")
SAME_INSTANT = 8.0 * float(np.finfo(float).eps)
"""Relative to the instant: nearer instants are the same instant, computed in another order."""
ERROR, RESPONSE, AMPLIFICATION = "error_", "response_", "amplification"
CHECKSUM = "checksum"
COMPRESSED = {"compression": "zstd", "compression_level": 19, "use_dictionary": False, "use_byte_stream_split": True,
              "write_statistics": False}  # fmt: skip
Head = dict[str, Any]


class DamagedTableError(ValueError):
    """A file that is no complete certified solution."""


@dataclass(frozen=True)
class CertifiedTable:
    """Certified solution at chosen instants, and its origin; n instants."""

    scene: str
    """Name"""
    physics: str
    """Digest of the parts of the scene that decide the motion"""
    precision: str
    """Precision and tolerances of the runs, in words"""
    trajectory: Trajectory
    error: dict[str, Array]
    """(n,) for each quantity of `quantities.differences`, never falling"""


def physics_digest(scene: Scene) -> str:
    """Hash of the motion: equal for scenes that differ in name, duration or sample instants only."""
    return scene.digest_of(*PHYSICS)


def shipped_path(name: str, folder: Path | None = None) -> Path:
    """File of a scene's solution in a folder, by default that of the solutions that come with barchain."""
    return (folder or CERTIFIED_SOLUTIONS) / f"{name}.parquet"


@remembered
def shipped_files() -> dict[str, Path]:
    """Files that come with barchain, by digest of their physics, and by that of the scene whose samples judge."""
    files = {path: head_of(path) for path in sorted(CERTIFIED_SOLUTIONS.rglob("*.parquet"))}
    return {head[key]: path for path, head in files.items() for key in ("physics", "digest") if key in head}


def shipped_solution(scene: Scene) -> ReferenceSolution | None:
    """Certified solution that comes with barchain for these physics and samples; None if there is none.

    Raises
    ------
    DamagedTableError
        If the file differs from its checksum.
    """
    path = shipped_files().get(scene.digest)
    return None if path is None else read_solution(path, scene)


def write_file(path: Path, table: CertifiedTable, solution: ReferenceSolution | None = None) -> None:
    """Write a table, and the solution that judges, and make the folder; an interruption leaves no partial file."""
    head: Head = {name: getattr(table, name) for name in ("scene", "physics", "precision")}
    head |= {"ended": table.trajectory.ended, ENDED: table.trajectory.info.get(ENDED)}
    parts = [to_frame(table.trajectory).assign(**with_prefix(ERROR, table.error))]
    if solution is not None:
        every, own = stride(solution), len(solution.amplification)
        head |= {"digest": solution.scene.digest, "dense": len(solution.fine.t_s), "samples": own, "every": every}
        head |= {"limit_s": solution.limit_s}
        columns = {AMPLIFICATION: solution.amplification} | with_prefix(ERROR, solution.error)
        columns |= with_prefix(RESPONSE, solution.response)
        at_own = {name: rounded_up(values[:own]) for name, values in columns.items()}
        rows = np.arange(own) * every
        parts.insert(0, to_frame(solution.fine).join(pd.DataFrame(at_own, index=rows, dtype=float)))
    write_frame(path, head, pd.concat(parts, ignore_index=True))


def write_frame(path: Path, head: Head, frame: pd.DataFrame) -> None:
    """Write attributes and columns with their checksum, and make the folder."""
    frame.attrs.clear()
    frame.attrs.update(head | {CHECKSUM: checksum(head, frame)})
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, parquet(frame, **COMPRESSED))
    shipped_files.cache_clear()  # the folder may be that of the shipped solutions


def stride(solution: ReferenceSolution) -> int:
    """Dense samples from one own sample to the next."""
    own = solution.trajectory.t_s
    return int(np.searchsorted(solution.fine.t_s, own[1])) if len(own) > 1 else 1


def with_prefix(prefix: str, values: dict[str, Array]) -> dict[str, Array]:
    """Columns of the quantities."""
    return {prefix + name: column for name, column in values.items()}


def rounded_up(values: Array) -> Any:
    """Values in single precision, none smaller than before; zero stays zero."""
    near = values.astype(np.float32)
    return np.where(near < values, np.nextafter(near, np.float32(np.inf)), near)


def checksum(head: Head, frame: pd.DataFrame) -> str:
    """Hash of attributes, and of every column's name and numbers."""
    found = hashlib.sha256(json.dumps(head, sort_keys=True).encode())
    for name in frame.columns:
        found.update(str(name).encode())
        found.update(np.ascontiguousarray(frame[name].to_numpy()).tobytes())
    return found.hexdigest()[:16]


def head_of(path: Path) -> Head:
    """Attributes of a file, without its columns.

    Raises
    ------
    DamagedTableError
        If it has none.
    """
    import pyarrow.parquet as pq  # noqa: PLC0415  # takes long to import

    try:
        found: Head = json.loads(pq.read_schema(path).metadata[b"PANDAS_ATTRS"])
        found["physics"], found[CHECKSUM]
    except Exception as error:  # Arrow's errors have several bases
        raise DamagedTableError(f"{path}: not a certified solution") from error
    return found


def read_file(path: Path) -> tuple[Head, pd.DataFrame]:
    """Attributes and columns of a file.

    Raises
    ------
    DamagedTableError
        If the file is no certified solution, or differs from its checksum.
    """
    try:
        frame = pd.read_parquet(path)
    except Exception as error:  # Arrow's errors have several bases
        raise DamagedTableError(f"{path}: not a certified solution") from error
    head: Head = {str(key): value for key, value in frame.attrs.items()}
    said = head.pop(CHECKSUM, None)
    if said != checksum(head, frame):
        raise DamagedTableError(f"{path}: its numbers differ from their checksum")
    return head, frame


def read_table(path: Path) -> CertifiedTable:
    """Read the chosen instants; errors as in :func:`read_file`."""
    head, frame = read_file(path)
    rows = frame[head.get("dense", 0) :]
    return CertifiedTable(
        head["scene"], head["physics"], head["precision"], motion_of(rows, head), columns_of(rows, ERROR)
    )


def read_solution(path: Path, scene: Scene) -> ReferenceSolution:
    """Read the solution that judges a scene; errors as in :func:`read_file`."""
    head, frame = read_file(path)
    fine = motion_of(frame[: head["dense"]], head)
    own = frame[: head["samples"] * head["every"] : head["every"]]
    return ReferenceSolution(
        scene, fine.samples(slice(None, None, head["every"])), fine, columns_of(own, ERROR),
        own[AMPLIFICATION].to_numpy(float), columns_of(own, RESPONSE), head["limit_s"], SolutionSource.SHIPPED,
        head["precision"],
    )  # fmt: skip


def motion_of(rows: pd.DataFrame, head: Head) -> Trajectory:
    """Trajectory of some rows of a file."""
    seen = dataclasses.replace(from_frame(rows, ended=head["ended"]), gap_m=None)
    if head[ENDED] is not None:
        seen.info[ENDED] = head[ENDED]
    return seen


def columns_of(rows: pd.DataFrame, prefix: str) -> dict[str, Array]:
    """Columns of the quantities, (n,) each."""
    names = [name for name in map(str, rows) if name.startswith(prefix)]
    return {name.removeprefix(prefix): rows[name].to_numpy(float) for name in names}


def rows_at(scene: Scene, table: CertifiedTable) -> tuple[Trajectory, dict[str, Array]] | None:
    """Rows of a table at the instants of `scene`, and their errors; None if the table lacks an instant.

    Instants that differ in their last bits are the same instant. Place and angles are then extrapolated over the
    difference, and the possible change of the other quantities is added to the errors.
    """
    wanted, have = scene.times_s, table.trajectory.t_s
    if table.trajectory.ended and wanted[-1] > have[-1]:
        wanted = wanted[: np.searchsorted(wanted, have[-1], side="right")]
    row = np.clip(np.searchsorted(have, wanted), 1, len(have) - 1)
    row = np.where(np.abs(have[row - 1] - wanted) < np.abs(have[row] - wanted), row - 1, row)
    late = wanted - have[row]
    if not len(wanted) or np.any(np.abs(late) > SAME_INSTANT * wanted):
        return None
    return moved(scene, table.trajectory.samples(row), {k: e[row] for k, e in table.error.items()}, wanted, late)


def moved(
    scene: Scene, trajectory: Trajectory, error: dict[str, Array], t_s: Array, late_s: Array
) -> tuple[Trajectory, dict[str, Array]]:
    """Trajectory extrapolated to first order over a few roundings of time, and its errors."""
    if not late_s.any():
        return dataclasses.replace(trajectory, t_s=t_s), error
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    later = dataclasses.replace(
        trajectory,
        t_s=t_s,
        com_m=trajectory.com_m + late_s[:, None] * trajectory.com_velocity_m_s,
        angle_rad=trajectory.angle_rad + late_s[:, None] * trajectory.rate_rad_s,
    )
    share = float(np.abs(late_s).max()) * rate_scale(scene, trajectory)  # relative change of the fastest oscillation
    sizes = largest(trajectory)
    return later, {k: e + share * sizes[k] if k not in ("com", "attitude") else e for k, e in error.items()}
