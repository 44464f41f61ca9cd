"""A trajectory as a table of named columns, and back."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd

from adapters.engine import Array, Trajectory


def to_frame(trajectory: Trajectory) -> pd.DataFrame:
    """One row per sample; a quantity that the engine lacks has no column.

    Columns: ``t_s, com_x_m, com_y_m, com_vx_m_s, com_vy_m_s``, ``angle_j_rad``, ``rate_j_rad_s`` (j = 1..N),
    ``position_j_x_m, position_j_y_m`` (j = 1..N), ``reaction_j_x_N, reaction_j_y_N, impulse_j_x_N_s, impulse_j_y_N_s,
    gap_j_m`` (j = 1..N-1), ``torque_p_N_m``, ``identity_m``, ``condition``.
    """
    columns: dict[str, Array] = {
        "t_s": trajectory.t_s,
        "com_x_m": trajectory.com_m[:, 0],
        "com_y_m": trajectory.com_m[:, 1],
        "com_vx_m_s": trajectory.com_velocity_m_s[:, 0],
        "com_vy_m_s": trajectory.com_velocity_m_s[:, 1],
    }
    for pattern, values in (("angle_{}_rad", trajectory.angle_rad), ("rate_{}_rad_s", trajectory.rate_rad_s)):
        if values is not None:
            columns |= {pattern.format(j + 1): values[:, j] for j in range(values.shape[1])}
    for name, unit, vectors in (
        ("position", "m", trajectory.position_m),
        ("reaction", "N", trajectory.reaction_N),
        ("impulse", "N_s", trajectory.impulse_N_s),
    ):
        if vectors is not None:
            for j in range(vectors.shape[1]):
                columns[f"{name}_{j + 1}_x_{unit}"] = vectors[:, j, 0]
                columns[f"{name}_{j + 1}_y_{unit}"] = vectors[:, j, 1]
    for pattern, values in (("gap_{}_m", trajectory.gap_m), ("torque_{}_N_m", trajectory.torque_N_m)):
        if values is not None:
            columns |= {pattern.format(j + 1): values[:, j] for j in range(values.shape[1])}
    for name, single in (("identity_m", trajectory.identity_m), ("condition", trajectory.condition)):
        if single is not None:
            columns[name] = single
    return pd.DataFrame(columns)


def from_frame(frame: pd.DataFrame, *, ended: str = "") -> Trajectory:
    """Trajectory of a table made by :func:`to_frame`.

    Quantities that have no columns because there is nothing of them (the joints of a single bar) come
    back empty where there is an attitude, as they were.
    """

    def numbered(pattern: str) -> Array | None:
        found = {int(m[1]): c for c in frame.columns if (m := re.fullmatch(pattern, c))}
        return frame[[found[j] for j in sorted(found)]].to_numpy(float) if found else None

    def pair(x: str, y: str) -> Array:
        return frame[[x, y]].to_numpy(float)

    def vectors(name: str, unit: str) -> Array | None:
        x, y = numbered(rf"{name}_(\d+)_x_{unit}"), numbered(rf"{name}_(\d+)_y_{unit}")
        return None if x is None or y is None else np.stack([x, y], axis=-1)

    def or_empty(values: Array | None, *shape: int) -> Array | None:
        single_bar = "angle_1_rad" in frame and "angle_2_rad" not in frame
        return np.empty((len(frame), 0, *shape)) if values is None and single_bar else values

    return Trajectory(
        t_s=frame["t_s"].to_numpy(float),
        com_m=pair("com_x_m", "com_y_m"),
        com_velocity_m_s=pair("com_vx_m_s", "com_vy_m_s"),
        angle_rad=numbered(r"angle_(\d+)_rad"),
        rate_rad_s=numbered(r"rate_(\d+)_rad_s"),
        reaction_N=or_empty(vectors("reaction", "N"), 2),
        gap_m=or_empty(numbered(r"gap_(\d+)_m")),
        torque_N_m=numbered(r"torque_(\d+)_N_m"),
        impulse_N_s=vectors("impulse", "N_s"),
        identity_m=frame["identity_m"].to_numpy(float) if "identity_m" in frame else None,
        position_m=vectors("position", "m"),
        condition=frame["condition"].to_numpy(float) if "condition" in frame else None,
        ended=ended,
    )
