"""The contract every engine keeps: build a scene, simulate it (the only timed phase), read it out.

An engine is a class, abstract (:class:`Engine`) or final (one per registered name). What it can
carry and what it can show are declared as class attributes, so that the harness can say why a
scene is left out without running it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, ClassVar, final

if TYPE_CHECKING:
    from adapters.trajectory import Array, Observable, Trajectory
    from scenarios import Scene


class AccuracyParameter(StrEnum):
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


@dataclass(frozen=True)
class Setting:
    """One value of an engine's accuracy knob."""

    parameter: AccuracyParameter
    value: float

    def __str__(self) -> str:
        """``rtol=1e-10``, as the command line takes it."""
        return f"{self.parameter}={self.value:g}"


@dataclass(frozen=True)
class AccuracySweep:
    """An engine's settings from coarse to fine, and which of them it is compared at."""

    parameter: AccuracyParameter
    values: tuple[float, ...]
    default: float
    finer_rtol: float = 0.1
    """Share of a requested accuracy that the finer run asks for"""

    def setting(self, value: float | None = None) -> Setting:
        """Setting of this ladder's knob; the default one without a value."""
        return Setting(self.parameter, self.default if value is None else value)

    def finer(self, setting: Setting) -> Setting:
        """One step finer: a tenth of the requested accuracy (or `finer_rtol` of it), or twice the steps."""
        factor = self.finer_rtol if self.parameter is AccuracyParameter.RTOL else 2.0
        return Setting(self.parameter, setting.value * factor)

    @property
    def settings(self) -> tuple[Setting, ...]:
        """All settings, coarse to fine."""
        return tuple(Setting(self.parameter, v) for v in self.values)


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
    sweep: ClassVar[AccuracySweep]
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
    unsupported_reasons: ClassVar[dict[str, str]] = {}
    """Reason for each effect it can't carry, where there is more to say than that."""

    @classmethod
    def unsupported(cls, scene: Scene) -> str | None:
        """Why this engine can't do `scene`, or None if it can.

        An engine with limits beyond its effects (a number of bars, bound orbits) extends this.
        """
        lacking = sorted(scene.effects.names - cls.effects)
        if not lacking:
            return None
        return "; ".join(dict.fromkeys(cls.unsupported_reasons.get(name, f"does not carry {name}") for name in lacking))

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
        self.build(scene, setting or self.sweep.setting())
        self.simulate()
        return self.read()
