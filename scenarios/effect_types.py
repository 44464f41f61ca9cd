"""Physical effects on a chain: one frozen dataclass for each effect, in SI units and radians."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, fields, replace
from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


class Gravity(StrEnum):
    """Model of the central body's gravity on a bar."""

    NONE = "none"
    """No gravity: the centre of mass moves uniformly."""
    POINT = "point"
    """A point mass at the bar's centre of mass, no torque."""
    GRADIENT = "gradient"
    """The paper's model: the point-mass force, and the gravity-gradient torque of eq. (17)."""
    QUADRUPOLE = "quadrupole"
    """Force and torque from one potential, expanded to the bar's second moment."""
    SLENDER = "slender"
    """Exact force and torque on a uniform slender bar."""

    @property
    def turns(self) -> bool:
        """Whether a field's gradient turns a bar."""
        return self in (Gravity.GRADIENT, Gravity.QUADRUPOLE, Gravity.SLENDER)

    @property
    def has_potential(self) -> bool:
        """Whether forces and torques come from one potential."""
        return self is not Gravity.GRADIENT


class Frame(StrEnum):
    """Reference direction of a prescribed angle."""

    INERTIAL = "inertial"
    LOCAL_HORIZONTAL = "local_horizontal"
    """The horizontal through the bar's own centre of mass (the paper's phi)."""
    PREVIOUS_BAR = "previous_bar"
    """The bar before it: the angle of the joint, made by the joint's motor."""

    @property
    def of_bar(self) -> bool:
        """Whether the angle is that of a bar, and not of a joint."""
        return self is not Frame.PREVIOUS_BAR


class Actuator(StrEnum):
    """Source of the torque of a prescribed rotation."""

    EXTERNAL = "external"
    """External torque on the bar alone (the paper's Fig. 18)."""
    JOINT = "joint"
    """A motor in the joint to the bar before it (for bar 1, to bar 2): equal and opposite on that neighbour."""


class End(StrEnum):
    """An end of a bar."""

    LEFT = "left"
    """End with the joint to the bar before."""
    RIGHT = "right"
    """End with the joint to the next bar."""

    @property
    def sign(self) -> float:
        """+1 for the right end, -1 for the left."""
        return 1.0 if self is End.RIGHT else -1.0


class Axes(StrEnum):
    """Axes of a given direction of a thrust or an impulse."""

    BODY = "body"
    """From the bar's own direction: the thrust turns with the bar."""
    INERTIAL = "inertial"
    """From the z1 axis."""


class Course(StrEnum):
    """Course of a turn in time, from rest to rest."""

    PAPER = "paper"
    """The paper's eq. (28), smooth to the third derivative: 1/2 - 9/16 cos(pi s) + 1/16 cos(3 pi s)"""
    QUINTIC = "quintic"
    """10 s³ - 15 s⁴ + 6 s⁵, smooth to the second derivative"""
    SPLINE = "spline"
    """Piece of a table's quintic spline: without rate and acceleration at its ends, smooth to the fourth derivative
    in between"""

    def share(self, s: float) -> tuple[float, float, float]:
        """Share of a turn from rest to rest at the share `s` of its duration, and two derivatives by `s`."""
        s = min(max(s, 0.0), 1.0)
        if self is Course.QUINTIC:
            rest = 1.0 - s
            return s**3 * (10.0 - 15.0 * s + 6.0 * s * s), 30.0 * (s * rest) ** 2, 60.0 * s * rest * (rest - s)
        if self is not Course.PAPER:
            raise ValueError(f"a turn by {self} has no share of its own")
        if s in (0.0, 1.0):
            return s, 0.0, 0.0
        w, x = math.pi, math.pi * s
        return (
            (math.cos(3 * x) - 9 * math.cos(x) + 8) / 16.0,
            w * (9 * math.sin(x) - 3 * math.sin(3 * x)) / 16.0,
            w * w * (9 * math.cos(x) - 9 * math.cos(3 * x)) / 16.0,
        )


@dataclass(frozen=True)
class Turn:
    """A turn from rest to rest, or a piece of a spline.

    Attributes
    ----------
    amplitude_rad : float
        Angle turned through, rad.
    duration_s : float
        Duration, s.
    start_s : float
        Start, s.
    course : Course
        Course in time.
    rates_rad_s : tuple of float
        Rates at both ends of a piece of a spline, rad/s; zero for other turns.
    accelerations_rad_s2 : tuple of float
        Accelerations there, rad/s².
    """

    amplitude_rad: float
    duration_s: float
    start_s: float
    course: Course = Course.PAPER
    rates_rad_s: tuple[float, float] = (0.0, 0.0)
    accelerations_rad_s2: tuple[float, float] = (0.0, 0.0)

    @property
    def end_s(self) -> float:
        """End, s."""
        return self.start_s + self.duration_s

    def law(self, t_s: float) -> tuple[float, float, float]:
        """Angle gained (rad), its rate (rad/s) and acceleration (rad/s²)."""
        s, a, w = (t_s - self.start_s) / self.duration_s, self.amplitude_rad, 1.0 / self.duration_s
        if self.course is not Course.SPLINE:
            angle, rate, acceleration = self.course.share(s)
            return a * angle, a * w * rate, a * w * w * acceleration
        if not 0.0 <= s < 1.0:  # what it has turned through stays; at an instant of two pieces the later one moves
            return (a if s >= 1.0 else 0.0), 0.0, 0.0
        c1, c2, c3, c4, c5 = self.coefficients_rad
        return (
            s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5)))),
            w * (c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))),
            w * w * (2.0 * c2 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5))),
        )

    @property
    def coefficients_rad(self) -> tuple[float, float, float, float, float]:
        """Coefficients of a piece of a spline by the powers 1 to 5 of the share of its duration, rad."""
        a, length = self.amplitude_rad, self.duration_s
        v0, v1 = (length * rate for rate in self.rates_rad_s)
        w0, w1 = (length * length * acceleration for acceleration in self.accelerations_rad_s2)
        return (
            v0,
            0.5 * w0,
            10.0 * a - 6.0 * v0 - 4.0 * v1 - 1.5 * w0 + 0.5 * w1,
            -15.0 * a + 8.0 * v0 + 7.0 * v1 + 1.5 * w0 - w1,
            6.0 * a - 3.0 * v0 - 3.0 * v1 - 0.5 * w0 + 0.5 * w1,
        )

    @property
    def reach_rad(self) -> float:
        """Size of the turn, rad: how far it goes, or would at the rate of either end."""
        return max(abs(self.amplitude_rad), *(abs(rate) * self.duration_s for rate in self.rates_rad_s))


@dataclass(frozen=True)
class PrescribedRotation:
    """Rotation of one bar by a law: held, turned by `amplitude_rad` in `duration_s`, held, perhaps turned again.

    Attributes
    ----------
    bar : int
        Counted from 1, as in the paper.
    amplitude_rad : float
        Angle by which the bar is turned, rad.
    duration_s : float
        Duration of the turn, s.
    start_s : float
        Start of the turn, s.
    frame : Frame
        Axes against which the angle is prescribed.
    actuator : Actuator
        Source of the torque.
    course : Course
        Course of the turn in time.
    further : tuple of Turn
        Turns after the first, in the order of time, none beginning before another's end.
    rates_rad_s : tuple of float
        Rates at both ends of the first turn if it is a piece of a spline, rad/s.
    accelerations_rad_s2 : tuple of float
        Accelerations there, rad/s².
    """

    bar: int
    amplitude_rad: float
    duration_s: float
    start_s: float
    frame: Frame
    actuator: Actuator
    course: Course = Course.PAPER
    further: tuple[Turn, ...] = ()
    rates_rad_s: tuple[float, float] = (0.0, 0.0)
    accelerations_rad_s2: tuple[float, float] = (0.0, 0.0)

    @property
    def turns(self) -> tuple[Turn, ...]:
        """All turns, in the order of time."""
        first = Turn(**{field.name: getattr(self, field.name) for field in fields(Turn)})
        return (first, *self.further)

    def with_turns(self, changed: Callable[[Turn], Turn]) -> PrescribedRotation:
        """Law with every turn changed."""
        first, *further = map(changed, self.turns)
        return replace(self, **vars(first), further=tuple(further))

    @property
    def breaks_s(self) -> tuple[float, ...]:
        """Starts and ends of the turns, s, where a high derivative of the law jumps."""
        return tuple(t for turn in self.turns for t in (turn.start_s, turn.end_s))

    def law(self, t_s: float) -> tuple[float, float, float]:
        """Angle gained since the start (rad), its rate (rad/s) and acceleration (rad/s²)."""
        angle, rate, acceleration = zip(*(turn.law(t_s) for turn in self.turns), strict=True)
        return sum(angle), sum(rate), sum(acceleration)


@dataclass(frozen=True)
class Oblateness:
    """The central body's flattening, seen in its equatorial plane.

    Attributes
    ----------
    j2 : float
        Zonal coefficient J2 of the body.
    radius_m : float
        Reference radius of `j2`, m.
    """

    j2: float
    radius_m: float


@dataclass(frozen=True)
class ThirdBody:
    """A point mass on a circular orbit about the centre, in the plane of motion.

    Attributes
    ----------
    name : str
        Name of the body.
    mu_m3_s2 : float
        Gravitational parameter, m³/s².
    distance_m : float
        Distance from the centre, m.
    longitude_rad : float
        Longitude at t = 0, from the z1 axis, rad.
    rate_rad_s : float
        Rate of the longitude, counter-clockwise, rad/s.
    """

    name: str
    mu_m3_s2: float
    distance_m: float
    longitude_rad: float
    rate_rad_s: float


@dataclass(frozen=True)
class Drag:
    """Free-molecular drag in an exponential atmosphere that turns with the central body.

    Attributes
    ----------
    density_kg_m3 : float
        Density at `altitude_m`, kg/m³.
    altitude_m : float
        Height above the surface of the central body, m.
    scale_height_m : float
        Height over which the density falls by e, m.
    rotation_rad_s : float
        Rate of the atmosphere, counter-clockwise, rad/s.
    width_m : tuple of float
        Width of each bar, (N,), m.
    normal_coefficient : float
        Coefficient of the force across the bar.
    tangential_coefficient : float
        Coefficient of the force along the bar.
    """

    density_kg_m3: float
    altitude_m: float
    scale_height_m: float
    rotation_rad_s: float
    width_m: tuple[float, ...]
    normal_coefficient: float
    tangential_coefficient: float


@dataclass(frozen=True)
class SolarPressure:
    """Sunlight on flat bars, each rotated about its own line towards the Sun.

    Attributes
    ----------
    pressure_Pa : float
        Pressure on a black surface that faces the Sun, Pa.
    sun_longitude_rad : float
        Direction to the Sun at t = 0, from the z1 axis, rad.
    sun_rate_rad_s : float
        Rate of that direction, counter-clockwise, rad/s.
    width_m : tuple of float
        Width of each bar, (N,), m.
    reflectivity : float
        Share of specularly reflected light, 0 to 1; the rest is absorbed.
    shadow : bool
        Whether the central body's cylindrical shadow darkens the chain while its centre of mass is in it.
    """

    pressure_Pa: float
    sun_longitude_rad: float
    sun_rate_rad_s: float
    width_m: tuple[float, ...]
    reflectivity: float
    shadow: bool


@dataclass(frozen=True)
class JointSpringDamper:
    """A rotational spring and damper in every joint; every tuple has one value per joint.

    Attributes
    ----------
    stiffness_N_m_rad : tuple of float
        Torque of the spring per angle, N m/rad.
    damping_N_m_s_rad : tuple of float
        Torque of the damper per rate, N m s/rad.
    rest_rad : tuple of float
        Angle of bar j+1 less that of bar j at which the spring is at rest, rad.
    """

    stiffness_N_m_rad: tuple[float, ...]
    damping_N_m_s_rad: tuple[float, ...]
    rest_rad: tuple[float, ...]


def size_at(t_s: float, times_s: tuple[float, ...], sizes: tuple[float, ...]) -> float:
    """Piecewise linear size at an instant, the one-sided limit from inside at the table's ends; 0 outside the table."""
    for (t0, f0), (t1, f1) in itertools.pairwise(zip(times_s, sizes, strict=True)):
        if t0 <= t_s <= t1 and t0 < t1:
            return f0 + (f1 - f0) * ((t_s - t0) / (t1 - t0))
    return 0.0


@dataclass(frozen=True)
class JointTorque:
    """Torque of a motor in a joint; its size is piecewise linear in time, and zero outside the table.

    Attributes
    ----------
    joint : int
        Between bar `joint` and the next one; counted from 1.
    times_s : tuple of float
        Instants of the table, s; two equal ones are a jump. The torque jumps at the first and the last.
    torque_N_m : tuple of float
        Torque on the joint's second bar at those instants, and the opposite one on its first, N m.
    """

    joint: int
    times_s: tuple[float, ...]
    torque_N_m: tuple[float, ...]

    @property
    def breaks_s(self) -> tuple[float, ...]:
        """Instants at which the torque or its slope jumps, s."""
        return self.times_s

    @property
    def sizes(self) -> tuple[float, ...]:
        """Sizes at the instants of the table, N m."""
        return self.torque_N_m

    def size_N_m(self, t_s: float) -> float:
        """Size at an instant, N m; see :func:`size_at`."""
        return size_at(t_s, self.times_s, self.torque_N_m)


@dataclass(frozen=True)
class Thrust:
    """Force on one end of a bar; its size is piecewise linear in time, and zero outside the table.

    Attributes
    ----------
    bar : int
        Counted from 1.
    end : End
        End of the bar that the force acts on.
    axes : Axes
        Axes of the direction.
    direction_rad : float
        From the bar's direction, or from the z1 axis, rad.
    times_s : tuple of float
        Instants of the table, s; the force jumps at the first and the last.
    force_N : tuple of float
        Size at those instants, N.
    """

    bar: int
    end: End
    axes: Axes
    direction_rad: float
    times_s: tuple[float, ...]
    force_N: tuple[float, ...]

    @property
    def breaks_s(self) -> tuple[float, ...]:
        """Instants at which the force or its slope jumps, s."""
        return self.times_s

    @property
    def sizes(self) -> tuple[float, ...]:
        """Sizes at the instants of the table, N."""
        return self.force_N

    def size_N(self, t_s: float) -> float:
        """Size at an instant, N; see :func:`size_at`."""
        return size_at(t_s, self.times_s, self.force_N)


@dataclass(frozen=True)
class Impulse:
    """Impulse on one end of a bar at an instant.

    Attributes
    ----------
    bar : int
        Counted from 1.
    end : End
        End of the bar that the impulse acts on.
    axes : Axes
        Axes of the direction.
    direction_rad : float
        From the bar's direction, or from the z1 axis, rad.
    impulse_N_s : float
        Size, N s.
    at_s : float
        Instant, s.
    """

    bar: int
    end: End
    axes: Axes
    direction_rad: float
    impulse_N_s: float
    at_s: float


SINGLE_NAME_EFFECTS = (
    "oblateness", "third_body", "drag", "solar_pressure", "joint_spring_damper", "joint_torque", "impulse",
)  # fmt: skip
"""Effects that engines declare by one name, without variants"""
LAW_FORMS = (*Frame, *Actuator, Course.QUINTIC, Course.SPLINE, "several_turns")
"""Variants of prescribed rotations that engines declare by name"""
WITHOUT_FORCE = frozenset({"prescribed_rotation", "joint_spring_damper", "joint_torque"})
"""Effects that are torques: none moves the centre of mass by itself"""
COM_SHARE = "chain.com_share"
"""Name by which engines declare bars whose centre of mass is not midway between their ends"""
EXTENDED_GRAVITY = (Gravity.QUADRUPOLE, Gravity.SLENDER)
"""Models of gravity in which the force on a bar is not that on a point mass"""


@dataclass(frozen=True)
class Effects:
    """All physical effects of a scene.

    Attributes
    ----------
    gravity : Gravity
        Model of the central body's gravity.
    prescribed_rotation : tuple of PrescribedRotation
        Bars that are turned by a law.
    oblateness : Oblateness or None
        Flattening of the central body; None without.
    third_body : tuple of ThirdBody
        Further bodies, e.g. Moon and Sun.
    drag : Drag or None
        Atmosphere; None without.
    solar_pressure : SolarPressure or None
        Sunlight; None without.
    joint_spring_damper : JointSpringDamper or None
        Springs and dampers in the joints; None without.
    joint_torque : tuple of JointTorque
        Torques of motors in joints.
    thrust : tuple of Thrust
        Forces at ends of bars.
    impulse : tuple of Impulse
        Impulses at ends of bars.
    """

    gravity: Gravity
    prescribed_rotation: tuple[PrescribedRotation, ...] = ()
    oblateness: Oblateness | None = None
    third_body: tuple[ThirdBody, ...] = ()
    drag: Drag | None = None
    solar_pressure: SolarPressure | None = None
    joint_spring_damper: JointSpringDamper | None = None
    joint_torque: tuple[JointTorque, ...] = ()
    thrust: tuple[Thrust, ...] = ()
    impulse: tuple[Impulse, ...] = ()

    @property
    def names(self) -> frozenset[str]:
        """Names by which an engine declares the effects that it supports, e.g. ``gravity.gradient``."""
        found = {f"gravity.{self.gravity}"}
        for p in self.prescribed_rotation:
            found |= {f"prescribed_rotation.{form}" for form in forms_of(p)}
        found |= {name for name in SINGLE_NAME_EFFECTS if getattr(self, name)}
        if self.solar_pressure and self.solar_pressure.shadow:
            found.add("solar_pressure.shadow")
        found |= {f"thrust.{thrust.axes}" for thrust in self.thrust}
        return frozenset(found)

    @property
    def kinds(self) -> frozenset[str]:
        """Names of the fields that the scene has: those of `names` without their variants."""
        return frozenset(name.partition(".")[0] for name in self.names)

    @property
    def on_faces(self) -> tuple[Drag | SolarPressure, ...]:
        """Effects whose forces jump in their slope where a bar turns its other face."""
        return tuple(effect for effect in (self.drag, self.solar_pressure) if effect)

    @property
    def tables(self) -> tuple[Thrust | JointTorque, ...]:
        """Effects whose sizes are tables in time."""
        return (*self.thrust, *self.joint_torque)

    def at_instants(self, moved: Callable[[float], float]) -> Effects:
        """Effects with other instants of laws, tables in time and impulses, each a function of the present one."""

        def later(turn: Turn) -> Turn:
            start_s = moved(turn.start_s)
            return replace(turn, start_s=start_s, duration_s=moved(turn.end_s) - start_s)

        return replace(
            self,
            prescribed_rotation=tuple(law.with_turns(later) for law in self.prescribed_rotation),
            thrust=tuple(replace(p, times_s=tuple(map(moved, p.times_s))) for p in self.thrust),
            joint_torque=tuple(replace(p, times_s=tuple(map(moved, p.times_s))) for p in self.joint_torque),
            impulse=tuple(replace(p, at_s=moved(p.at_s)) for p in self.impulse),
        )

    @property
    def breaks_s(self) -> tuple[float, ...]:
        """Instants at which an effect is not smooth in time, s, increasing: no step may contain them."""
        found = {t for law in self.prescribed_rotation for t in law.breaks_s}
        found |= {t for table in self.tables for t in table.breaks_s}
        return tuple(sorted(found | {p.at_s for p in self.impulse}))

    @property
    def beyond_basic(self) -> bool:
        """Whether the scene has effects besides point or gradient gravity and prescribed rotations."""
        return any(getattr(self, name) for name in (*SINGLE_NAME_EFFECTS, "thrust")) or self.gravity in EXTENDED_GRAVITY


def forms_of(law: PrescribedRotation) -> Iterator[str]:
    """Those of :data:`LAW_FORMS` that a law has."""
    yield from (law.frame, law.actuator)
    yield from sorted({turn.course for turn in law.turns} - {Course.PAPER})
    if law.further:
        yield "several_turns"


def all_effect_names() -> frozenset[str]:
    """Every name that `Scene.needs`, and an engine's ``effects``, may hold.

    Returns
    -------
    frozenset of str
        E.g. ``gravity.gradient``, ``prescribed_rotation.joint``, ``impulse``.
    """
    return frozenset(
        {
            *(f"gravity.{gravity}" for gravity in Gravity),
            *(f"prescribed_rotation.{form}" for form in LAW_FORMS),
            *SINGLE_NAME_EFFECTS,
            COM_SHARE,
            "solar_pressure.shadow",
            *(f"thrust.{axes}" for axes in Axes),
        }
    )
