"""The contract every engine keeps: build a scene, simulate it (the only timed phase), read it out.

An engine is a class, abstract (:class:`Engine`) or final (one per registered name). What it can
carry and what it can show are declared as class attributes, so that the harness can say why a
scene is left out without running it.
"""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, ClassVar, final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas as pd

    from scenarios import Scene

Array = NDArray[np.float64]
ENDED = "ended_s"
"""Entry in a trajectory's `info` of an engine that locates the instant at which its run ended, s: it is judged"""


class Knob(StrEnum):
    """The one number that sets an engine's accuracy."""

    RTOL = "rtol"
    """Requested accuracy of one step, in each quantity's own scale."""
    STEPS_PER_ORBIT = "steps_per_orbit"
    """Equal steps in one `Scene.step_period_s`, rounded up to an even number from sample to sample."""


class Coordinates(StrEnum):
    """In what an engine integrates: it decides where its round-off comes from."""

    RELATIVE = "relative"
    """The centre of mass apart from what is relative to it."""
    MOVING_FRAME = "moving frame"
    """Relative to a frame that follows the centre of mass along its orbit, its axes fixed in direction."""
    ROTATING_FRAME = "rotating frame"
    """Relative to a frame that follows the centre of mass and turns with its longitude."""
    JOINT = "joint coordinates"
    """In a frame that follows the centre of mass: one bar's end, and each bar's angle against the one before."""
    ABSOLUTE = "absolute"
    """Distances from the centre of the body."""


class Observable(StrEnum):
    """What an engine can show of a run."""

    COM = "com"
    ATTITUDE = "attitude"
    RATE = "rate"
    REACTION = "reaction"
    GAP = "gap"
    IDENTITY = "identity"
    TORQUE = "torque"
    IMPULSE = "impulse"


@dataclass(frozen=True)
class Setting:
    """One value of an engine's accuracy knob."""

    knob: Knob
    value: float

    def __str__(self) -> str:
        """``rtol=1e-10``, as the command line takes it."""
        return f"{self.knob}={self.value:g}"


@dataclass(frozen=True)
class Ladder:
    """An engine's settings from coarse to fine, and which of them it is compared at."""

    knob: Knob
    values: tuple[float, ...]
    default: float
    finer_rtol: float = 0.1
    """Share of a requested accuracy that the finer run asks for"""

    def setting(self, value: float | None = None) -> Setting:
        """Setting of this ladder's knob; the default one without a value."""
        return Setting(self.knob, self.default if value is None else value)

    def finer(self, setting: Setting) -> Setting:
        """One step finer: a tenth of the requested accuracy (or `finer_rtol` of it), or twice the steps."""
        factor = self.finer_rtol if self.knob is Knob.RTOL else 2.0
        return Setting(self.knob, setting.value * factor)

    @property
    def settings(self) -> tuple[Setting, ...]:
        """All settings, coarse to fine."""
        return tuple(Setting(self.knob, v) for v in self.values)


@dataclass(frozen=True)
class Trajectory:
    """What one engine saw of one scene: SI units, inertial axes, one row per sample.

    n samples, N bars, P prescribed rotations. A sample at an instant where something jumps (an impulse, the end of a
    thrust) shows what was just before it. What an engine has not got is None, never zeros.
    A run that ended early (a bar reached the surface) has fewer samples, and says so in `ended`.
    """

    t_s: Array
    """(n,) s"""
    com_m: Array
    """(n, 2) centre of mass of the chain from the centre of the body, m"""
    com_velocity_m_s: Array
    """(n, 2) m/s"""
    angle_rad: Array | None = None
    """(n, N) angle of each bar from the z1 axis, unwrapped, rad"""
    rate_rad_s: Array | None = None
    """(n, N) rad/s"""
    reaction_N: Array | None = None
    """(n, N-1, 2) force on bar j from bar j+1, N"""
    gap_m: Array | None = None
    """(n, N-1) distance between the two ends that joint j ties, m"""
    identity_m: Array | None = None
    """(n,) distance of the bars' weighted centre from the centre of mass, |sum mu_j d_j| of eq. (6), m"""
    position_m: Array | None = field(default=None, kw_only=True)
    """(n, N, 2) centre of each bar from the chain's centre of mass, inertial axes, m; given by engines whose places of
    the bars are state of their own (redundant coordinates), None where places follow from the angles"""
    torque_N_m: Array | None = None
    """(n, P) torque on each prescribed bar, positive counter-clockwise, N m"""
    impulse_N_s: Array | None = None
    """(n, N-1, 2) sum of the impulsive reactions on bar j from bar j+1 so far, N s; None where the scene has no blow"""
    condition: Array | None = None
    """(n,) condition number of the joint system, if asked for"""
    ended: str = ""
    """Why the run ended before its last sample; empty if it did not"""
    info: dict[str, float | str] = field(default_factory=dict)
    """Counters of the engine: steps, right-hand-side evaluations, ..."""

    @property
    def observables(self) -> frozenset[Observable]:
        """What this trajectory holds."""
        optional = {
            Observable.ATTITUDE: self.angle_rad,
            Observable.RATE: self.rate_rad_s,
            Observable.REACTION: self.reaction_N,
            Observable.GAP: self.gap_m,
            Observable.IDENTITY: self.identity_m,
            Observable.TORQUE: self.torque_N_m,
            Observable.IMPULSE: self.impulse_N_s,
        }
        return frozenset({Observable.COM} | {name for name, value in optional.items() if value is not None})

    def to_frame(self) -> pd.DataFrame:
        """Table with one row per sample and one named column per quantity (`angle_1_rad`, ...)."""
        from adapters.table import to_frame

        return to_frame(self)

    def replace(self, **changes: Array | None) -> Trajectory:
        """Copy with some arrays exchanged."""
        return dataclasses.replace(self, **changes)  # type: ignore[arg-type]

    def samples(self, rows: slice | NDArray[np.intp]) -> Trajectory:
        """Some of the samples, in every array, as a trajectory."""
        arrays = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        return self.replace(**{name: v[rows] for name, v in arrays.items() if isinstance(v, np.ndarray)})


class EngineError(RuntimeError):
    """An engine could not finish a scene; the message says why, in one line."""


class UnsupportedMotionError(EngineError):
    """A run came to a motion that its engine does not support: a limit it states, and no fault of its own."""


class Engine(ABC):
    """One engine in one configuration.

    One object serves one run: :meth:`build`, then :meth:`simulate`, then :meth:`read`, each once.
    """

    title: ClassVar[str]
    """One line for people."""
    coordinates: ClassVar[Coordinates]
    order: ClassVar[float | None]
    """Order of the method in the step; None if the method chooses its steps."""
    ladder: ClassVar[Ladder]
    effects: ClassVar[frozenset[str]]
    """What it carries exactly, in the words of `Effects.names`."""
    observables: ClassVar[frozenset[Observable]]
    options: ClassVar[frozenset[str]] = frozenset()
    """Names of extras that its constructor takes as ``name=True``: observables that cost time"""
    joints_in_place: ClassVar[bool] = False
    """Whether every step puts the joints' ends together again, so that gaps do not open with the step"""
    track_by_length: ClassVar[bool] = False
    """Whether a requested accuracy counts in bar lengths for the centre of mass too, not in its distance"""
    step_constant: ClassVar[float] = 1.0
    """Requests that one step may leave, of a method that chooses its steps; the harness believes up to ten."""
    why_not: ClassVar[dict[str, str]] = {}
    """Reason for each effect it can't carry, where there is more to say than that."""

    @classmethod
    def unsupported(cls, scene: Scene) -> str | None:
        """Why this engine can't do `scene`, or None if it can.

        An engine with limits beyond its effects (a number of bars, bound orbits) extends this.
        """
        lacking = sorted(scene.effects.names - cls.effects)
        if not lacking:
            return None
        return "; ".join(dict.fromkeys(cls.why_not.get(name, f"does not carry {name}") for name in lacking))

    @classmethod
    def unsupported_motion(cls, scene: Scene, motion: Trajectory) -> str | None:
        """Why this engine can't follow the motion of `scene`, or None if it can.

        Some limits are known only from the motion. An engine that has one extends this, and raises
        :class:`UnsupportedMotionError` where it comes to it in its own run.

        Parameters
        ----------
        scene : Scene
        motion : Trajectory
            Reference solution at close samples.
        """
        del scene, motion
        return None

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        """Errors that do not shrink with the step, beyond the rounding of coordinates; none by default.

        The tolerance at which an engine's iterations stop, multipliers that are differences over a step,
        a start-up transient. An adapter that declares one derives it in its docstring.

        Parameters
        ----------
        scene : Scene
        setting : Setting
        t_s : ndarray, shape (n,)
            Instants it is wanted at.

        Returns
        -------
        dict
            ``attitude`` (rad), ``rate`` (rad/s), ``reaction`` (N), ``torque`` (N m), ``com`` (m), ``com_velocity``
            (m/s), ``gap`` (m for each step; in all where joints are put in place): numbers, or arrays of shape (n,).
        """
        del scene, setting, t_s
        return {}

    @abstractmethod
    def build(self, scene: Scene, setting: Setting) -> None:
        """Make the model of `scene`; not timed."""

    @abstractmethod
    def simulate(self) -> None:
        """Run it from 0 to `scene.run.duration_s`; the only phase that is timed, so it does nothing else.

        Raises
        ------
        EngineError
            If the engine gives up.
        """

    @abstractmethod
    def read(self) -> Trajectory:
        """Bring out what was seen, in the units, axes and signs of :class:`Trajectory`; not timed."""

    @final
    def run(self, scene: Scene, setting: Setting | None = None) -> Trajectory:
        """All three phases in this process, untimed.

        Raises
        ------
        ValueError
            If `scene` is one that this engine can't do.
        """
        reason = self.unsupported(scene)
        if reason:
            raise ValueError(reason)
        self.build(scene, setting or self.ladder.setting())
        self.simulate()
        return self.read()
