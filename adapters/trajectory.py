"""Results of one engine on one scene: arrays with units, and the table of named columns that stores them."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from scenarios.plural import plural

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from scenarios.scene import Scene

Array = NDArray[np.float64]
"""Array of double precision"""
NUMBERED = {
    "angle_rad": ("angle_{}_rad",),
    "rate_rad_s": ("rate_{}_rad_s",),
    "position_m": ("position_{}_x_m", "position_{}_y_m"),
    "reaction_N": ("reaction_{}_x_N", "reaction_{}_y_N"),
    "impulse_N_s": ("impulse_{}_x_N_s", "impulse_{}_y_N_s"),
    "gap_m": ("gap_{}_m",),
}
"""Columns of each array that has one for each bar or joint, by their number"""
ENDED = "ended_s"
"""Key in `info` of the instant at which the run ended, s; set by engines that locate the instant, and then judged"""


class Observable(StrEnum):
    """Quantity that an engine can provide for a run."""

    COM = "com"
    """`com_m` and `com_velocity_m_s`"""
    ATTITUDE = "attitude"
    """`angle_rad`"""
    RATE = "rate"
    """`rate_rad_s`"""
    REACTION = "reaction"
    """`reaction_N`"""
    GAP = "gap"
    """`gap_m`"""
    COM_RESIDUAL = "com_residual"
    """`com_residual_m`"""
    TORQUE = "torque"
    """`torque_N_m`, in scenes with prescribed rotations"""
    IMPULSE = "impulse"
    """`impulse_N_s`, in scenes with impulses"""


@dataclass(frozen=True)
class Trajectory:
    """Results of one engine on one scene: SI units, inertial axes, one row per sample.

    n samples, N bars, P prescribed rotations. A sample at an event (an impulse, the end of a thrust) holds the state
    just before the event. A quantity that the engine does not provide is None, never zeros. A run that ended early (a
    bar reached the surface) has fewer samples and gives the reason in `ended`.

    Attributes
    ----------
    t_s : ndarray, shape (n,), s
        Sample instants.
    com_m : ndarray, shape (n, 2), m
        Centre of mass of the chain from the centre of the body.
    com_velocity_m_s : ndarray, shape (n, 2), m/s
        Velocity of the centre of mass.
    angle_rad : ndarray or None, shape (n, N), rad
        Angle of each bar from the z1 axis, unwrapped.
    rate_rad_s : ndarray or None, shape (n, N), rad/s
        Rate of each bar's angle.
    reaction_N : ndarray or None, shape (n, N-1, 2), N
        Force on bar j from bar j+1.
    gap_m : ndarray or None, shape (n, N-1), m
        Distance between the two bar ends at joint j.
    com_residual_m : ndarray or None, shape (n,), m
        Centre-of-mass residual ``|sum mu_j d_j|`` of eq. (6): distance of the bars' weighted centre from the centre of
        mass.
    torque_N_m : ndarray or None, shape (n, P), N m
        Torque on each prescribed bar, positive counter-clockwise.
    impulse_N_s : ndarray or None, shape (n, N-1, 2), N s
        Sum of the impulsive reactions on bar j from bar j+1 so far; None in scenes without impulses.
    condition : ndarray or None, shape (n,)
        Condition number of the joint system, if requested.
    ended : str
        Reason why the run ended before its last sample; empty if it did not.
    info : dict of str to float or str
        Counters of the engine: steps, right-hand side evaluations, ...
    position_m : ndarray or None, shape (n, N, 2), m
        Centre of each bar relative to the chain's centre of mass, inertial axes; None where the positions follow from
        the angles (minimal coordinates).
    scene, engine, setting : str
        Names of the run, as :func:`barchain.simulate` sets them; empty in a trajectory from elsewhere.
    torque_bars : tuple of int, length P
        Bar of each column of `torque_N_m`, from 1, as :func:`barchain.simulate` sets them; empty in a trajectory from
        elsewhere.
    """

    t_s: Array
    com_m: Array
    com_velocity_m_s: Array
    angle_rad: Array | None = None
    rate_rad_s: Array | None = None
    reaction_N: Array | None = None
    gap_m: Array | None = None
    com_residual_m: Array | None = None
    position_m: Array | None = field(default=None, kw_only=True)
    torque_N_m: Array | None = None
    impulse_N_s: Array | None = None
    condition: Array | None = None
    ended: str = ""
    info: dict[str, float | str] = field(default_factory=dict)
    scene: str = field(default="", kw_only=True)
    engine: str = field(default="", kw_only=True)
    setting: str = field(default="", kw_only=True)
    torque_bars: tuple[int, ...] = field(default=(), kw_only=True)

    def __repr__(self) -> str:
        """Run, size and span in one line; arrays would fill screens."""
        run = " in ".join(filter(None, [self.scene, self.engine]))
        name = ", ".join(filter(None, [f"Trajectory of {run}" if run else "Trajectory", self.setting]))
        bars = None if self.bars is None else plural(self.bars, "bar")
        size = ", ".join(filter(None, [bars, plural(len(self.t_s), "sample")]))
        span = f" from {self.t_s[0]:.6g} to {self.t_s[-1]:.6g} s" if len(self.t_s) else ""
        return f"<{name}: {size}{span}{', ended early' if self.ended else ''}>"

    @property
    def bars(self) -> int | None:
        """Number of bars N; None where no quantity of single bars is given."""
        of_bars = next((a for a in (self.angle_rad, self.rate_rad_s, self.position_m) if a is not None), None)
        return None if of_bars is None else int(of_bars.shape[1])

    @property
    def observables(self) -> frozenset[Observable]:
        """Quantities that this trajectory holds."""
        optional = {
            Observable.ATTITUDE: self.angle_rad,
            Observable.RATE: self.rate_rad_s,
            Observable.REACTION: self.reaction_N,
            Observable.GAP: self.gap_m,
            Observable.COM_RESIDUAL: self.com_residual_m,
            Observable.TORQUE: self.torque_N_m,
            Observable.IMPULSE: self.impulse_N_s,
        }
        return frozenset({Observable.COM} | {name for name, value in optional.items() if value is not None})

    def to_frame(self) -> pd.DataFrame:
        """Table with one row per sample and one named column per quantity (`angle_1_rad`, ...)."""
        return to_frame(self)

    def plot(self) -> tuple[Figure, NDArray[np.object_]]:
        """Draw attitude, magnitude of reactions, change of the CM's radius, and residual over time, in Matplotlib.

        Returns
        -------
        tuple of Figure and ndarray of Axes
            One axes for each quantity that the engine provides: rad, N, m, m; time in s.

        Raises
        ------
        RuntimeError
            Before any public name of barchain is used.
        """
        from scenarios.display import renderer

        draw = renderer("plot")
        if draw is None:
            raise RuntimeError(
                "no renderer of plots is registered: use a public name of barchain first, e.g. barchain.Trajectory"
            )
        drawn: tuple[Figure, NDArray[np.object_]] = draw(self.to_frame())
        return drawn

    def _repr_html_(self) -> str | None:
        """Charts and size for a notebook; None, so the text alone, before any public name of barchain is used."""
        from scenarios.display import html

        return html("trajectory", self.to_frame(), self.ended, self.info, (self.scene, self.engine, self.setting))

    def replace(self, **changes: Array | tuple[int, ...] | None) -> Trajectory:
        """Copy with some arrays replaced."""
        return dataclasses.replace(self, **changes)  # type: ignore[arg-type]

    def of_run(self, scene: Scene, engine: str = "", setting: str = "") -> Trajectory:
        """Copy with the names of its run, and the bars whose torques it holds."""
        bars = tuple(p.bar for p in scene.effects.prescribed_rotation)
        return dataclasses.replace(self, scene=scene.name, engine=engine, setting=setting, torque_bars=bars)

    def samples(self, rows: slice | NDArray[np.intp]) -> Trajectory:
        """Some of the samples, in every array, as a trajectory."""
        arrays = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        return self.replace(**{name: v[rows] for name, v in arrays.items() if isinstance(v, np.ndarray)})

    def continued(self, later: Trajectory) -> Trajectory:
        """The samples of `self`, then those of `later`, in every array that `self` has; the end is that of `later`."""
        arrays = {f.name: (getattr(self, f.name), getattr(later, f.name)) for f in dataclasses.fields(self)}
        joined = {name: np.concatenate(both) for name, both in arrays.items() if isinstance(both[0], np.ndarray)}
        return dataclasses.replace(self.replace(**joined), ended=later.ended)


def to_frame(trajectory: Trajectory) -> pd.DataFrame:
    """Table with one row per sample; a quantity that the engine lacks has no column.

    Columns: ``t_s, com_x_m, com_y_m, com_vx_m_s, com_vy_m_s``, ``angle_j_rad``, ``rate_j_rad_s`` (j = 1..N),
    ``position_j_x_m, position_j_y_m`` (j = 1..N), ``reaction_j_x_N, reaction_j_y_N, impulse_j_x_N_s, impulse_j_y_N_s,
    gap_j_m`` (j = 1..N-1), ``torque_bar_b_N_m`` for each prescribed bar b, ``com_residual_m``, ``condition``. Where
    `torque_bars` is not known, a torque is ``torque_law_p_N_m``, p the number of the prescribed rotation.
    """
    import pandas as pd  # a worker makes no tables

    columns: dict[str, Array] = {
        "t_s": trajectory.t_s,
        "com_x_m": trajectory.com_m[:, 0],
        "com_y_m": trajectory.com_m[:, 1],
        "com_vx_m_s": trajectory.com_velocity_m_s[:, 0],
        "com_vy_m_s": trajectory.com_velocity_m_s[:, 1],
    }
    for name, patterns in NUMBERED.items():
        values = getattr(trajectory, name)
        if values is not None:
            for j in range(values.shape[1]):
                parts = values[:, j].T if len(patterns) > 1 else [values[:, j]]
                columns |= {pattern.format(j + 1): part for pattern, part in zip(patterns, parts, strict=True)}
    if trajectory.torque_N_m is not None:
        count = trajectory.torque_N_m.shape[1]
        known = len(trajectory.torque_bars) == count
        names = [f"bar_{b}" for b in trajectory.torque_bars] if known else [f"law_{p + 1}" for p in range(count)]
        columns |= {f"torque_{name}_N_m": trajectory.torque_N_m[:, p] for p, name in enumerate(names)}
    for name, single in (("com_residual_m", trajectory.com_residual_m), ("condition", trajectory.condition)):
        if single is not None:
            columns[name] = single
    return pd.DataFrame(columns)


def from_frame(frame: pd.DataFrame, *, ended: str = "") -> Trajectory:
    """Trajectory of a table made by :func:`to_frame`.

    A single bar has no joints, and so the table has no columns of joint quantities. They return as empty arrays where
    the table holds an attitude, as in the trajectory that was stored. Torques are in the order of their columns; before
    0.7 they were named by the number of the prescribed rotation alone, ``torque_p_N_m``.
    """

    def pair(x: str, y: str) -> Array:
        return frame[[x, y]].to_numpy(float)

    def numbered(name: str) -> Array | None:
        patterns = [re.compile(pattern.format(r"([0-9]+)")) for pattern in NUMBERED[name]]
        found = [{int(m[1]): c for c in frame.columns if (m := pattern.fullmatch(c))} for pattern in patterns]
        if not all(found):
            return None
        arrays = [frame[[columns[j] for j in sorted(columns)]].to_numpy(float) for columns in found]
        return np.stack(arrays, axis=-1) if len(arrays) > 1 else arrays[0]

    def or_empty(values: Array | None, *shape: int) -> Array | None:
        single_bar = "angle_1_rad" in frame and "angle_2_rad" not in frame
        return np.empty((len(frame), 0, *shape)) if values is None and single_bar else values

    torques = {c: m for c in frame.columns if (m := re.fullmatch(r"torque_(bar_|law_|)([0-9]+)_N_m", c))}
    return Trajectory(
        t_s=frame["t_s"].to_numpy(float),
        com_m=pair("com_x_m", "com_y_m"),
        com_velocity_m_s=pair("com_vx_m_s", "com_vy_m_s"),
        angle_rad=numbered("angle_rad"),
        rate_rad_s=numbered("rate_rad_s"),
        reaction_N=or_empty(numbered("reaction_N"), 2),
        gap_m=or_empty(numbered("gap_m")),
        torque_N_m=frame[list(torques)].to_numpy(float) if torques else None,
        torque_bars=tuple(int(m[2]) for m in torques.values() if m[1] == "bar_"),
        impulse_N_s=numbered("impulse_N_s"),
        com_residual_m=frame["com_residual_m"].to_numpy(float) if "com_residual_m" in frame else None,
        position_m=numbered("position_m"),
        condition=frame["condition"].to_numpy(float) if "condition" in frame else None,
        ended=ended,
    )
