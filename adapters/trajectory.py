"""Results of one engine on one scene: arrays with units, and the table of named columns that stores them."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from scenarios.channels import CLOCK, IN_COLUMN_ORDER, STORED, TIME, Of
from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    import pandas as pd
    from matplotlib.figure import Figure

    from scenarios.channels import Channel
    from scenarios.scene import Scene

Array = NDArray[np.float64]
"""Array of double precision"""
OF_LAW = ("torque_law_{}",)
"""Columns of torques whose bars are not known, by the number of the prescribed rotation"""
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
    run_scene : Scene or None
        Scene of the run, of which derived channels are computed; None in a trajectory from elsewhere, until
        :meth:`of_run` sets it.
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
    run_scene: Scene | None = field(default=None, kw_only=True)

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
        optional = {c.observable: getattr(self, c.array) for c in STORED if c.observable}
        given = {Observable(name) for name, value in optional.items() if value is not None}
        return frozenset({Observable.COM} | given)

    def to_frame(self, derived: Sequence[str] = ()) -> pd.DataFrame:
        """Table with one row per sample and one named column per quantity (`angle_1_rad`, ...).

        Parameters
        ----------
        derived : sequence of str
            Channels that are computed of the stored ones, e.g. ``["joint_angle", "tension"]``
            (docs/reference/channels.md); their columns follow the stored ones.

        Raises
        ------
        ValueError
            If there is no such channel, with the nearest name, or if the trajectory lacks what it is computed of.
        RuntimeError
            If `derived` is given before any public name of barchain is used.
        """
        frame = to_frame(self)
        if not derived:
            return frame
        from scenarios.hooks import renderer

        compute = renderer("derived")
        if compute is None:
            raise RuntimeError("derived channels are not registered: use a public name of barchain first")
        joined: pd.DataFrame = compute(self, derived, frame)
        return joined

    def plot(
        self,
        channels: Sequence[str] = (),
        *,
        bars: Sequence[int] = (),
        joints: Sequence[int] = (),
        time: str = "",
        degrees: bool = False,
    ) -> tuple[Figure, NDArray[np.object_]]:
        """Draw channels over time in Matplotlib, one chart for each component.

        Parameters
        ----------
        channels : sequence of str
            Stored or derived, e.g. ``["joint_angle", "tension"]`` (docs/reference/channels.md); by default attitude,
            magnitude of reactions, change of the CM's radius, and residual, as far as the engine provides them.
        bars, joints : sequence of int
            Bars and joints that are drawn, from 1; all by default.
        time : str
            Unit of the time, ``s``, ``min``, ``h`` or ``orbits``; by default one that fits the run.
        degrees : bool
            Draw angles in degrees and rates in degrees a second, in place of rad and rad/s.

        Returns
        -------
        tuple of Figure and ndarray of Axes
            One axes for each component of a channel, with its unit.

        Raises
        ------
        ValueError
            If there is no such channel, bar, joint or unit, or the trajectory lacks what is drawn.
        RuntimeError
            Before any public name of barchain is used.
        """
        drawn: tuple[Figure, NDArray[np.object_]] = drawing("plot")(self, channels, bars, joints, time, degrees)
        return drawn

    def animate(self, path: str | Path, *, frame: str = "") -> Path:
        """Write an animation of the chain about its centre of mass, and return its path; a file there is replaced.

        Parameters
        ----------
        path : str or Path
            Its ending chooses: ``.gif``, ``.mp4`` (needs ffmpeg), or ``.html``, a page that works offline.
        frame : str
            ``vertical``: y points away from the body; ``inertial``: axes z1 and z2. By default the vertical where there
            is gravity.

        Raises
        ------
        ValueError
            If there is no such frame or ending, if the trajectory lacks angles or its scene, if bars turn too often,
            or if ffmpeg is missing.
        RuntimeError
            Before any public name of barchain is used.
        """
        written: Path = drawing("animation")(self, path, frame)
        return written

    def _repr_html_(self) -> str | None:
        """Charts and size for a notebook; None, so the text alone, before any public name of barchain is used."""
        from scenarios.hooks import html

        return html("trajectory", self.to_frame(), self.ended, self.info, (self.scene, self.engine, self.setting))

    def replace(self, **changes: Array | tuple[int, ...] | None) -> Trajectory:
        """Copy with some arrays replaced."""
        return dataclasses.replace(self, **changes)  # type: ignore[arg-type]

    def of_run(self, scene: Scene, engine: str = "", setting: str = "") -> Trajectory:
        """Copy with its scene, the names of its run, and the bars whose torques it holds."""
        bars = tuple(p.bar for p in scene.effects.prescribed_rotation)
        return dataclasses.replace(
            self, scene=scene.name, engine=engine, setting=setting, torque_bars=bars, run_scene=scene
        )

    def state(self, t_s: float | None = None) -> dict[str, Any]:
        """State at a sample, as the tables of a scene that starts there.

        Parameters
        ----------
        t_s : float, optional
            Instant of a sample, s; the last by default.

        Returns
        -------
        dict
            For :func:`barchain.go_on`, or for :func:`barchain.change_scene`: position and velocity of the centre of
            mass, angles and rates of the bars, and what the clock of the effects shows. A trajectory without its scene
            (:meth:`of_run`) counts from its own start.

        Raises
        ------
        ValueError
            If no sample is at that instant, or the engine gives no angles or rates; the message tells what there is.
        """
        from scenarios.toml.start_table import SAME_INSTANT, state_tables

        if self.angle_rad is None or self.rate_rad_s is None:
            raise ValueError(
                "this run has no angles or no rates of the bars, allowed: a run of an engine that gives both"
            )
        k = len(self.t_s) - 1 if t_s is None else int(np.abs(self.t_s - t_s).argmin())
        at_s = float(self.t_s[k])
        if t_s is not None and abs(at_s - t_s) > SAME_INSTANT * max(abs(t_s), 1.0):
            raise ValueError(f"{t_s:g} s given, allowed: the instant of a sample; the nearest is {at_s!r} s")
        arrays = (self.com_m, self.com_velocity_m_s, self.angle_rad, self.rate_rad_s)
        return state_tables(self.clock_s + at_s, *(array[k].tolist() for array in arrays))

    @property
    def clock_s(self) -> float:
        """What the clock of the effects' instants shows at the start of the run, s; 0 without its scene."""
        if self.run_scene is None:  # in a worker, which loads no files' models
            return 0.0
        from scenarios.toml.changing import clock_at_start

        return clock_at_start(self.run_scene)

    def samples(self, rows: slice | NDArray[np.intp]) -> Trajectory:
        """Some of the samples, in every array, as a trajectory."""
        arrays = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        return self.replace(**{name: v[rows] for name, v in arrays.items() if isinstance(v, np.ndarray)})

    def continued(self, later: Trajectory) -> Trajectory:
        """The samples of `self`, then those of `later`, in every array that both have; the end is that of `later`.

        Of a run that goes on from a state of this one, instants and sums of impulses count from the start of this one.
        A bar without a law has a torque of 0.
        """
        after_s = later.clock_s - self.clock_s
        bars = tuple(dict.fromkeys((*self.torque_bars, *later.torque_bars)))
        struck = self.impulse_N_s is not None or later.impulse_N_s is not None
        parts = [
            each.replace(torque_N_m=torques_on(each, bars), impulse_N_s=impulses_of(each) if struck else None)
            for each in (self, later)
        ]
        joined: dict[str, Array | None] = {}
        for f in dataclasses.fields(self):
            before, after = (getattr(part, f.name) for part in parts)
            if f.name == "t_s":
                after = after + after_s
            elif f.name == "impulse_N_s" and after_s > 0.0 and before is not None and after is not None:
                after = after + before[-1]
            if isinstance(before, np.ndarray):
                joined[f.name] = None if after is None else np.concatenate((before, after))
        return dataclasses.replace(self.replace(**joined), ended=later.ended, torque_bars=bars)


def torques_on(run: Trajectory, bars: tuple[int, ...]) -> Array | None:
    """Torques on some bars, (n, P) N m: 0 on one without a law."""
    if run.torque_N_m is None or run.torque_N_m.shape[1] != len(run.torque_bars):
        return run.torque_N_m
    found = np.zeros((len(run.t_s), len(bars)))
    found[:, [bars.index(bar) for bar in run.torque_bars]] = run.torque_N_m
    return found


def impulses_of(run: Trajectory) -> Array | None:
    """Sums of impulsive reactions, (n, N-1, 2) N s: 0 in a scene without impulses."""
    if run.impulse_N_s is not None or run.run_scene is None or run.run_scene.effects.impulse:
        return run.impulse_N_s
    return np.zeros((len(run.t_s), run.run_scene.bars - 1, 2))


def drawing(kind: str) -> Callable[..., Any]:
    """Function of a higher package that draws trajectories.

    Raises
    ------
    RuntimeError
        Before any public name of barchain is used.
    """
    from scenarios.hooks import renderer

    found = renderer(kind)
    if found is None:
        raise RuntimeError(
            "no renderer of plots is registered: use a public name of barchain first, e.g. barchain.Trajectory"
        )
    return found


def to_frame(trajectory: Trajectory) -> pd.DataFrame:
    """Table with one row per sample; a quantity that the engine lacks has no column.

    Columns: those of :func:`instants`, then those of :data:`scenarios.channels.IN_COLUMN_ORDER`. Where `torque_bars` is
    not known, a torque is ``torque_law_p_N_m``, p the number of the prescribed rotation.
    """
    import pandas as pd  # a worker makes no tables

    columns = instants(trajectory)
    for channel in IN_COLUMN_ORDER:
        values = getattr(trajectory, channel.array)
        if values is None:
            continue
        if channel.of is not Of.LAWS:
            columns |= channel.split(values)
        elif len(trajectory.torque_bars) == values.shape[1]:
            columns |= channel.split(values, trajectory.torque_bars)
        else:
            columns |= dataclasses.replace(channel, stems=OF_LAW).split(values)
    return pd.DataFrame(columns)


def instants(trajectory: Trajectory) -> dict[str, Array]:
    """Column ``t_s``, and ``clock_s`` of a run that started later than the clock of its effects, (n,) s each."""
    start_s = trajectory.clock_s
    later = {CLOCK: start_s + trajectory.t_s} if start_s else {}
    return {TIME: trajectory.t_s} | later


def from_frame(frame: pd.DataFrame, *, ended: str = "") -> Trajectory:
    """Trajectory of a table made by :func:`to_frame`.

    A single bar has no joints, and so the table has no columns of joint quantities. They return as empty arrays where
    the table holds an attitude, as in the trajectory that was stored. Torques are in the order of their columns; before
    0.7 they were named by the number of the prescribed rotation alone, ``torque_p_N_m``.
    """
    torques = {c: m for c in frame.columns if (m := re.fullmatch(r"torque_(bar_|law_|)([0-9]+)_N_m", c))}
    arrays = {c.array: array_of(c, frame) for c in STORED if c.of is not Of.LAWS}
    if "angle_1_rad" in frame and "angle_2_rad" not in frame:
        joints = [c for c in STORED if c.of is Of.JOINTS and not c.effects and arrays[c.array] is None]
        arrays |= {c.array: np.empty((len(frame), 0, 2) if len(c.stems) > 1 else (len(frame), 0)) for c in joints}
    return Trajectory(
        t_s=frame[TIME].to_numpy(float),
        **arrays,  # type: ignore[arg-type]  # the track is always there
        torque_N_m=frame[list(torques)].to_numpy(float) if torques else None,
        torque_bars=tuple(int(m[2]) for m in torques.values() if m[1] == "bar_"),
        ended=ended,
    )


def array_of(channel: Channel, frame: pd.DataFrame) -> Array | None:
    """Array of a channel whose bars or joints count from 1, from its columns; None where a component has none."""
    if not channel.of.numbered:
        if channel.of is Of.CHAIN and not set(channel.columns) <= set(frame.columns):
            return None
        values: Array = frame[list(channel.columns)].to_numpy(float)
        return values if len(channel.columns) > 1 else values[:, 0]
    patterns = [re.compile(pattern.format("([0-9]+)")) for pattern in channel.columns]
    found = [{int(m[1]): c for c in frame.columns if (m := pattern.fullmatch(c))} for pattern in patterns]
    if not all(found):
        return None
    arrays = [frame[[columns[j] for j in sorted(columns)]].to_numpy(float) for columns in found]
    return np.stack(arrays, axis=-1) if len(arrays) > 1 else arrays[0]
