"""Contract of every engine: build a scene, simulate it (the only timed phase), read the results.

An engine is a class, abstract (:class:`Engine`) or final (one per registered name). Class attributes declare the
supported effects and the observables. The harness can therefore state why a scene is skipped without running it.

The harness plans and judges by :class:`Declarations`: data, and answers to three questions. An engine's class has them,
and so have a program that is started as a command, an engine in another process, and a program that wrote a file.
"""

from __future__ import annotations

import numbers
from abc import ABC, abstractmethod
from dataclasses import dataclass, field, fields
from enum import StrEnum
from typing import TYPE_CHECKING, Any, ClassVar, final

from scenarios.effect_types import LAW_FORMS, Gravity
from scenarios.nearest import nearest
from scenarios.text import shorten

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from adapters.trajectory import Array, Observable, Trajectory
    from scenarios import Scene


GRAVITY_MODELS = tuple(f"gravity.{gravity}" for gravity in Gravity)
PRESCRIBED_ROTATIONS = tuple(f"prescribed_rotation.{form}" for form in LAW_FORMS)
"""Names of effects in the declarations of engines"""


class AccuracyParameter(StrEnum):
    """The one number that sets an engine's accuracy."""

    RTOL = "rtol"
    """Requested error of one step relative to each quantity's own scale."""
    STEPS_PER_ORBIT = "steps_per_orbit"
    """Equal steps per `Scene.step_period_s`; their number between two samples is rounded up to an even one."""


class Coordinates(StrEnum):
    """Coordinates that an engine integrates; they determine the source of its round-off."""

    RELATIVE = "relative"
    """The centre of mass, and bars relative to it."""
    MOVING_FRAME = "moving frame"
    """Relative to a frame that follows the centre of mass along its orbit, with axes of fixed direction."""
    ROTATING_FRAME = "rotating frame"
    """Relative to a frame that follows the centre of mass and rotates with its longitude."""
    JOINT = "joint coordinates"
    """One bar's end in a frame that follows the centre of mass, and each bar's angle relative to the previous bar."""
    ABSOLUTE = "absolute"
    """Positions relative to the centre of the central body."""
    ABSOLUTE_JOINT = "absolute joint coordinates"
    """One bar's end from the centre of the central body, and each bar's angle relative to the previous bar."""

    @property
    def absolute(self) -> bool:
        """Whether places count from the centre of the central body, and round as its radius does."""
        return self in (Coordinates.ABSOLUTE, Coordinates.ABSOLUTE_JOINT)

    @property
    def by_joints(self) -> bool:
        """Whether the centre of mass follows from the angles, and shares their errors."""
        return self in (Coordinates.JOINT, Coordinates.ABSOLUTE_JOINT)


class SettingError(ValueError):
    """A setting that no engine has, or that an engine does not have."""


@dataclass(frozen=True)
class Setting:
    """One value of an engine's accuracy parameter.

    Parameters
    ----------
    parameter : AccuracyParameter
        ``"rtol"``: requested error of one step relative to each quantity's own scale; or ``"steps_per_orbit"``: number
        of equal steps in one :attr:`~scenarios.scene.Scene.step_period_s`.
    value : float
        Its value, without unit.

    Raises
    ------
    SettingError
        If there is no such parameter, or the value is no number.
    """

    parameter: AccuracyParameter
    value: float

    def __post_init__(self) -> None:
        """Check both; the range of a value is the engine's."""
        if self.parameter not in [*AccuracyParameter]:
            raise SettingError(
                f"{shorten(self.parameter)} given as the parameter of a setting"
                f"{nearest(str(self.parameter), AccuracyParameter)}; allowed: {', '.join(AccuracyParameter)}"
            )
        check_number(self.parameter, self.value)

    def __str__(self) -> str:
        """Text form ``rtol=1e-10``, as the command line reads it."""
        return f"{self.parameter}={self.value:g}"


def check_number(name: str, value: object) -> None:
    """Reject the value of a setting that is no number; True and False are none.

    Raises
    ------
    SettingError
        With the given value.
    """
    if not is_number(value):
        raise SettingError(f"{name}={shorten(value)} given, allowed: a number")


def is_number(value: object) -> bool:
    """Whether a value is a real number; True and False are not."""
    return isinstance(value, numbers.Real) and not isinstance(value, bool)


@dataclass(frozen=True)
class AccuracySweep:
    """Settings of an engine from coarse to fine, and the default setting of comparisons."""

    parameter: AccuracyParameter
    """The number that sets the accuracy"""
    values: tuple[float, ...]
    """From coarse to fine, none twice"""
    default: float
    """Value of comparisons"""
    finer_rtol: float = 0.1
    """Requested error of the finer run relative to that of the run itself, between 0 and 1"""

    def setting(self, value: float | None = None) -> Setting:
        """Setting of the sweep's accuracy parameter; the default value if none is given."""
        return Setting(self.parameter, self.default if value is None else value)

    def finer(self, setting: Setting) -> Setting:
        """Next finer setting: `finer_rtol` times the requested error, or twice the steps."""
        factor = self.finer_rtol if self.parameter is AccuracyParameter.RTOL else 2.0
        return Setting(self.parameter, setting.value * factor)

    @property
    def settings(self) -> tuple[Setting, ...]:
        """All settings, coarse to fine."""
        return tuple(Setting(self.parameter, v) for v in self.values)


class EngineError(RuntimeError):
    """Failure of an engine on a scene; the message gives the cause in one line."""


class UnsupportedMotionError(EngineError):
    """Motion that the engine does not support: a limit that the engine states, and no failure."""


class Answers:
    """Answers to questions that data can't answer; an engine's class has methods of these names, see :class:`Engine`.

    Here they are those of an engine without limits beyond its effects, and without noise.
    """

    def unsupported(self, scene: Scene, /) -> str | None:
        """Reason why the engine does not support a scene, or None."""
        del scene
        return None

    def unsupported_motion(self, scene: Scene, motion: Trajectory, /) -> str | None:
        """Reason why the engine does not support a motion of a scene, or None."""
        del scene, motion
        return None

    def noise(self, scene: Scene, setting: Setting, t_s: Array, /) -> dict[str, float | Array]:
        """Errors that do not decrease with the step, at instants of shape (n,)."""
        del scene, setting, t_s
        return {}


QUESTIONS = ("unsupported", "unsupported_motion", "noise")
"""Methods of :class:`Answers`"""
ASKED = ("questions", "answers")
"""Fields of :class:`Declarations` that are no attributes of an engine's class"""


@dataclass(frozen=True)
class StatedAnswers(Answers):
    """Answers of a program that can't be asked: the errors that a person states of it."""

    errors: Mapping[str, float | Array] = field(hash=False)
    """By quantity, in SI units, the same in all scenes"""

    def noise(self, scene: Scene, setting: Setting, t_s: Array, /) -> dict[str, float | Array]:
        """Stated errors."""
        del scene, setting, t_s
        return dict(self.errors)


@dataclass(frozen=True)
class Declarations:
    """What an engine declares, as :class:`Engine` has it: all that planning and judging know of an engine.

    Names are sorted tuples and no sets, as a judgement that is kept in a file is known by the bytes of its arguments.
    """

    title: str
    coordinates: Coordinates
    order: float | None
    sweep: AccuracySweep
    effects: tuple[str, ...]
    """Supported effects, and each variant of an effect by a name of its own"""
    observables: tuple[Observable, ...]
    options: tuple[str, ...] = ()
    joints_in_place: bool = False
    track_by_length: bool = False
    step_constant: float = 1.0
    unsupported_reasons: Mapping[str, str] = field(default_factory=dict, hash=False)
    questions: tuple[str, ...] = ()
    """Questions that the engine answers itself; of another one the answer of :class:`Answers` holds"""
    answers: Answers | type[Engine] = field(default_factory=Answers)

    @property
    def declares_noise(self) -> bool:
        """Whether the engine declares noise in any scene."""
        return "noise" in self.questions

    def unsupported(self, scene: Scene) -> str | None:
        """Reason why the engine does not support `scene`, or None if it does.

        An effect that is not declared by its name is not supported, whatever the engine answers.
        """
        reason = self.answers.unsupported(scene) if "unsupported" in self.questions else None
        return reason or lacking_effects(scene, self.effects, self.unsupported_reasons)

    def unsupported_motion(self, scene: Scene, motion: Trajectory) -> str | None:
        """Reason why the engine does not support a motion, see :meth:`Engine.unsupported_motion`."""
        return self.answers.unsupported_motion(scene, motion) if "unsupported_motion" in self.questions else None

    def noise(self, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        """Errors that do not decrease with the step, see :meth:`Engine.noise`."""
        return self.answers.noise(scene, setting, t_s) if self.declares_noise else {}


def lacking_effects(scene: Scene, effects: Collection[str], reasons: Mapping[str, str]) -> str | None:
    """Reasons against the effects of a scene that are not among `effects`; None if all are."""
    lacking = sorted(scene.needs.difference(effects))
    if not lacking:
        return None
    return "; ".join(dict.fromkeys(reasons.get(name, f"does not support {name}") for name in lacking))


class Engine(ABC):
    """One engine in one configuration.

    One object serves one run: :meth:`build`, then :meth:`simulate`, then :meth:`read`, each once.
    """

    title: ClassVar[str]
    """One line for tables and reports."""
    coordinates: ClassVar[Coordinates]
    """Coordinates that the engine integrates; they decide which round-off is expected"""
    order: ClassVar[float | None]
    """Order of the method in the step; None if the method controls its step."""
    sweep: ClassVar[AccuracySweep]
    """Accuracy parameter, its values from coarse to fine, and the default"""
    effects: ClassVar[frozenset[str]]
    """Supported effects, named as in `Scene.needs`; each is modelled without approximation."""
    observables: ClassVar[frozenset[Observable]]
    """Quantities that every result holds; torques and impulses only in scenes that have them"""
    options: ClassVar[frozenset[str]] = frozenset()
    """Names of options, each taken by the constructor as ``name=True``: optional observables that cost time, and
    ``repeated_load``, with which barchain's loads are applied twice, at half strength"""
    joints_in_place: ClassVar[bool] = False
    """Whether every step closes the joints at position level, so that gaps do not grow with time"""
    track_by_length: ClassVar[bool] = False
    """Whether a requested accuracy is relative to the bar length for the centre of mass too, not to its distance"""
    step_constant: ClassVar[float] = 1.0
    """Largest error of one step relative to the requested one, of a method that controls its step; at most ten."""
    unsupported_reasons: ClassVar[dict[str, str]] = {}
    """Reason for an unsupported effect, where the name alone does not explain it."""

    @classmethod
    def declarations(cls) -> Declarations:
        """All that the class declares; it answers the questions whose methods it replaces."""
        data = {f.name: in_order(getattr(cls, f.name)) for f in fields(Declarations) if f.name not in ASKED}
        return Declarations(**data, questions=own_questions(cls), answers=cls)

    @classmethod
    def unsupported(cls, scene: Scene) -> str | None:
        """Reason why this engine does not support `scene`, or None if it does.

        An engine with limits beyond its effects (a number of bars, bound orbits) extends this method.
        """
        return lacking_effects(scene, cls.effects, cls.unsupported_reasons)

    @classmethod
    def unsupported_motion(cls, scene: Scene, motion: Trajectory) -> str | None:
        """Reason why this engine does not support the motion of `scene`, or None if it does.

        Some limits depend on the motion alone. An engine with such a limit extends this method. It also raises
        :class:`UnsupportedMotionError` where its own run meets the limit.

        Parameters
        ----------
        scene : Scene
        motion : Trajectory
            Judging solution at close samples.
        """
        del scene, motion
        return None

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        """Errors that do not decrease with the step, beyond the rounding of coordinates; none by default.

        Examples are the tolerance at which an engine's iterations stop, multipliers differenced over a step, and a
        start-up transient. An adapter that declares such an error derives it in its docstring.

        Parameters
        ----------
        scene : Scene
        setting : Setting
        t_s : ndarray, shape (n,)
            Instants of the errors.

        Returns
        -------
        dict
            ``attitude`` (rad), ``rate`` (rad/s), ``reaction`` (N), ``torque`` (N m), ``com`` (m), ``com_velocity``
            (m/s), ``gap`` (m for each step; m in total where `joints_in_place`): numbers, or arrays of shape (n,).
        """
        del scene, setting, t_s
        return {}

    @abstractmethod
    def build(self, scene: Scene, setting: Setting) -> None:
        """Make the model of `scene`; not timed."""

    @abstractmethod
    def simulate(self) -> None:
        """Run from 0 to `scene.run.duration_s`: the only timed phase, and no other work belongs here.

        Raises
        ------
        EngineError
            If the engine fails before the end.
        """

    @abstractmethod
    def read(self) -> Trajectory:
        """Return the recorded samples in the units, axes and signs of :class:`Trajectory`; not timed."""

    @final
    def run(self, scene: Scene, setting: Setting | None = None) -> Trajectory:
        """Build, simulate and read in this process, untimed.

        Raises
        ------
        ValueError
            If the engine does not support `scene`.
        """
        reason = self.unsupported(scene)
        if reason:
            raise ValueError(reason)
        self.build(scene, setting or self.sweep.setting())
        self.simulate()
        return self.read()


def own_questions(engine: type[Engine]) -> tuple[str, ...]:
    """Questions that an engine answers itself: it replaces their methods."""
    return tuple(q for q in QUESTIONS if getattr(engine, q).__func__ is not getattr(Engine, q).__func__)


def in_order(value: Any) -> Any:
    """Value of a declaration; a set as a sorted tuple, and a mapping by sorted keys."""
    if isinstance(value, (set, frozenset)):
        return tuple(sorted(value))
    return dict(sorted(value.items())) if isinstance(value, dict) else value
