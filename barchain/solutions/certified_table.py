"""Certified solutions as text files: the motion of a scene at chosen instants, with error bars.

Header lines give the scene and the runs. The columns are those of a trajectory (`adapters.trajectory`) and one
``..._error_...`` for each quantity. Numbers read back bit for bit, and a checksum detects a damaged file.
"""

from __future__ import annotations

import dataclasses
import hashlib
import io
from dataclasses import dataclass
from functools import cache as remembered
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from adapters.trajectory import from_frame, to_frame
from barchain.metrics.quantities import largest, rate_scale
from reports.results.writing import write_atomically
from scenarios.channels import COMPARED

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

ERROR_COLUMNS = {channel.name: channel.column_of("error") for channel in COMPARED}
CERTIFIED_SOLUTIONS = Path(__file__).parent / "tables"
TITLE = "barchain certified solution"
PHYSICS = ("central_body", "orbit", "chain", "effects")
SAME_INSTANT = 8.0 * float(np.finfo(float).eps)
"""Relative to the instant: nearer instants are the same instant, computed in another order."""


class DamagedTableError(ValueError):
    """A file that is no complete table of a certified solution."""


@dataclass(frozen=True)
class CertifiedTable:
    """Certified solution and its origin; n instants."""

    scene: str
    """Name"""
    physics: str
    """Digest of the parts of the scene that decide the motion"""
    precision: str
    """Precision and tolerances of the runs, in words"""
    command: str
    """Command that makes the table again; empty for a cached table"""
    trajectory: Trajectory
    error: dict[str, Array]
    """(n,) for each quantity of `quantities.differences`, never falling"""


def physics_digest(scene: Scene) -> str:
    """Hash of the motion: equal for scenes that differ in name, duration or sample instants only."""
    return scene.digest_of(*PHYSICS)


def write_table(path: Path, table: CertifiedTable) -> None:
    """Write a table and make its folder; an interruption leaves no partial file."""
    frame = to_frame(table.trajectory.replace(torque_bars=()))
    frame = frame.rename(columns=lambda name: name.replace("torque_law_", "torque_"))  # as in all committed tables
    for name, column in ERROR_COLUMNS.items():
        if name in table.error:
            frame[column] = table.error[name]
    body = frame.to_csv(index=False)
    head = {
        "scene": table.scene,
        "physics": table.physics,
        "precision": table.precision,
        "command": table.command,
        "ended": table.trajectory.ended,
        "checksum": checksum(body),
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [f"# {TITLE}", *(f"# {key}: {value}".rstrip() for key, value in head.items())]
    write_atomically(path, "\n".join(lines) + "\n" + body)


def checksum(body: str) -> str:
    """Hash of the columns and rows."""
    return hashlib.sha256(body.encode()).hexdigest()[:16]


def read_head(path: Path) -> dict[str, str]:
    """Header of a table.

    Raises
    ------
    DamagedTableError
        If there is none.
    """
    lines = []
    with path.open(encoding="utf-8", errors="replace") as file:
        for line in file:
            if not line.startswith("# "):
                break
            lines.append(line[2:].rstrip("\n"))
    if not lines or lines[0] != TITLE:
        raise DamagedTableError(f"{path}: not a table of a certified solution")
    return {key: value.strip() for key, _, value in (line.partition(":") for line in lines[1:])}


def read_table(path: Path) -> CertifiedTable:
    """Read a table.

    Raises
    ------
    DamagedTableError
        If the file has another title or checksum.
    """
    head = read_head(path)
    text = path.read_text(encoding="utf-8", errors="replace")
    body = "".join(line for line in text.splitlines(keepends=True) if not line.startswith("#"))
    if head.get("checksum") != checksum(body):
        raise DamagedTableError(f"{path}: its numbers differ from their checksum")
    words = pd.read_csv(io.StringIO(body), dtype=str, keep_default_na=False)
    frame = words.map(float)  # exact; pandas' own conversion is not in every version
    seen = dataclasses.replace(from_frame(frame, ended=head["ended"]), gap_m=None)
    error = {name: frame[column].to_numpy(float) for name, column in ERROR_COLUMNS.items() if column in frame}
    return CertifiedTable(head["scene"], head["physics"], head["precision"], head["command"], seen, error)


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


def table_path(scene: Scene) -> Path:
    """File of the committed table of a shipped scene."""
    return CERTIFIED_SOLUTIONS / f"{scene.name}.csv"
