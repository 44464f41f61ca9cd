"""The effects' tables of a scene file, checked by pydantic."""

from __future__ import annotations

import itertools
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Tag, model_validator

from scenarios.size_limits import LEAST_MAGNITUDE, MOST_MAGNITUDE, MOST_POINTS, MOST_TABLES


def check_not_tiny(value: float) -> float:
    """Reject a number that is not zero and smaller than any in physics; products of such numbers vanish."""
    if 0.0 < abs(value) < LEAST_MAGNITUDE:
        sizes = f"{LEAST_MAGNITUDE:g} to {MOST_MAGNITUDE:g}"
        raise ValueError(f"allowed: a magnitude from {sizes}, or 0 if the key takes 0")
    return value


NotTiny = AfterValidator(check_not_tiny)
Finite = Annotated[float, Field(ge=-MOST_MAGNITUDE, le=MOST_MAGNITUDE, allow_inf_nan=False), NotTiny]
Positive = Annotated[float, Field(gt=0, le=MOST_MAGNITUDE, allow_inf_nan=False), NotTiny]
NotNegative = Annotated[float, Field(ge=0, le=MOST_MAGNITUDE, allow_inf_nan=False), NotTiny]
Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]

NUMBER, LIST = "number", "list"
NUMBER_OR_LIST = Discriminator(
    lambda value: LIST if isinstance(value, list) else NUMBER
)  # so that an error message is on one of the two
FiniteEach = Annotated[Annotated[Finite, Tag(NUMBER)] | Annotated[list[Finite], Tag(LIST)], NUMBER_OR_LIST]
PositiveEach = Annotated[Annotated[Positive, Tag(NUMBER)] | Annotated[list[Positive], Tag(LIST)], NUMBER_OR_LIST]
ShareEach = Annotated[Annotated[Share, Tag(NUMBER)] | Annotated[list[Share], Tag(LIST)], NUMBER_OR_LIST]
NotNegativeEach = Annotated[
    Annotated[NotNegative, Tag(NUMBER)] | Annotated[list[NotNegative], Tag(LIST)], NUMBER_OR_LIST
]

EARTH_J2 = 1.08262668e-3  # EGM2008
EARTH_ROTATION_RAD_S = 7.292115e-5
SUN_RATE_RAD_S = 1.99098659e-7  # 2 pi in a sidereal year
SUNLIGHT_PA = 4.56e-6  # 1361 W/m² over the speed of light, at one astronomical unit
THIRD_BODIES = {"moon": (4.9028e12, 3.844e8), "sun": (1.32712440018e20, 1.495978707e11)}  # mu m³/s², distance m


def each(value: float | list[float], count: int) -> tuple[float, ...]:
    """One value for each bar or joint."""
    return tuple(map(float, value)) if isinstance(value, list) else (float(value),) * count


def slender_inertia(mass_kg: float, length_m: float) -> float:
    """Moment of inertia of a uniform slender bar about its centre of mass, m l²/12, kg m²."""
    return mass_kg * length_m * length_m / 12.0


class Table(BaseModel):
    """A table of a scene file: unknown keys are errors, numbers are not guessed from strings."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class PrescribedRotationTable(Table):
    """Turn of one bar, or of a joint, by a law or a table. Several of one bar, one after the other, are one law."""

    bar: int = Field(ge=1, description="which bar, counted from 1")
    amplitude_deg: Finite | None = Field(None, description="angle turned through, degrees")
    duration_s: Positive | None = Field(None, description="time of the turn, s")
    start_s: NotNegative | None = Field(
        None, description="when it starts, s; 0 by default; the bar is held before and after"
    )
    course: Literal["paper", "quintic"] | None = Field(
        None, description="course in time: that of the paper's eq. (28), the default, or 10 s^3 - 15 s^4 + 6 s^5"
    )
    times_s: list[NotNegative] | None = Field(
        None, max_length=MOST_POINTS, description="increasing instants of a table, s, in place of the four keys above"
    )
    angle_deg: list[Finite] | None = Field(
        None,
        description="angle turned through up to each of times_s, degrees, the first 0: a quintic spline in between",
    )
    frame: Literal["inertial", "local_horizontal", "previous_bar"] = Field(
        "local_horizontal",
        description="against what the angle is measured; previous_bar: the angle of the joint to the bar before it, "
        "which amplitude_deg = 0 locks",
    )
    actuator: Literal["external", "joint"] = Field(
        "external",
        description="torque from outside on the bar alone, or from a motor in the joint to the bar before it "
        "(bar 1: to bar 2), as always with previous_bar",
    )

    @model_validator(mode="before")
    @classmethod
    def joints_have_motors(cls, given: Any) -> Any:
        """Table of a joint's angle with the motor that makes it."""
        if isinstance(given, dict) and given.get("frame") == "previous_bar":
            return {"actuator": "joint"} | given
        return given

    @model_validator(mode="after")
    def made_by_motor(self) -> PrescribedRotationTable:
        """Check that a joint's angle has a joint, and is made by its motor."""
        if self.frame == "previous_bar" and self.bar == 1:
            raise ValueError('frame = "previous_bar" needs a bar before it: bar = 1 given, allowed: 2 and more')
        if self.frame == "previous_bar" and self.actuator != "joint":
            raise ValueError(
                f'frame = "previous_bar" is the angle of a joint: actuator = "{self.actuator}" given, allowed: "joint"'
            )
        return self

    @model_validator(mode="after")
    def law_or_table(self) -> PrescribedRotationTable:
        """Check that there is an amplitude with its duration, or a table alone."""
        turn = {name: getattr(self, name) for name in ("amplitude_deg", "duration_s", "start_s", "course")}
        if self.times_s is None and self.angle_deg is None:
            missing = [name for name in ("amplitude_deg", "duration_s") if turn[name] is None]
            if missing:
                raise ValueError(
                    f"{missing[0]} is missing: give amplitude_deg and duration_s, or times_s and angle_deg"
                )
            return self
        if self.times_s is None or self.angle_deg is None:
            raise ValueError("give lists as both times_s and angle_deg")
        beside = [name for name, value in turn.items() if value is not None]
        if beside:
            raise ValueError(f"{beside[0]} is given beside a table; times_s and angle_deg say all")
        check_instants("angle_deg", self.times_s, self.angle_deg)
        if self.angle_deg[0] != 0.0:
            raise ValueError(
                f"angle_deg counts from the start of the table: {self.angle_deg[0]:g} given first, allowed: 0"
            )
        return self

    @property
    def ends_s(self) -> tuple[float, float]:
        """Start and end of the turn, s."""
        if self.times_s is not None:
            return self.times_s[0], self.times_s[-1]
        start_s = self.start_s or 0.0
        return start_s, start_s + (self.duration_s or 0.0)


class OblatenessTable(Table):
    """Flattening of the central body: the J2 term of its field, in its equatorial plane."""

    j2: Finite = Field(EARTH_J2, description="zonal coefficient J2; the Earth's by default")
    radius_m: Positive | None = Field(
        None, description="radius that j2 belongs to, m; that of the central body by default"
    )


class ThirdBodyTable(Table):
    """A point mass on a circular orbit about the centre, in the plane of motion."""

    body: Literal["moon", "sun", "other"] = Field("moon", description="gives mu and distance, unless they are given")
    mu_m3_s2: Positive | None = Field(
        None, description="gravitational parameter, m^3/s^2; that of the Moon or the Sun by default"
    )
    distance_m: Positive | None = Field(
        None, description="radius of its orbit about the centre, m; that of the Moon or the Sun by default"
    )
    longitude_deg: Finite = Field(0.0, description="angle of the body from the z1 axis at t = 0, degrees")

    @model_validator(mode="after")
    def complete(self) -> ThirdBodyTable:
        """Check that a body other than the Moon and the Sun has both numbers."""
        if self.body == "other" and (self.mu_m3_s2 is None or self.distance_m is None):
            raise ValueError('body = "other" needs both mu_m3_s2 and distance_m')
        return self


class DragTable(Table):
    """Free-molecular drag in an exponential atmosphere that turns with the central body."""

    density_kg_m3: Positive = Field(description="density of the air at altitude_m, kg/m^3")
    altitude_m: NotNegative = Field(description="height above the surface that density_kg_m3 belongs to, m")
    scale_height_m: Positive = Field(description="height in which the density falls e times, m")
    width_m: PositiveEach = Field(description="width of each bar across its line, m")
    normal_coefficient: NotNegative = Field(
        2.0, description="C_n: pressure over half the density times the square of the speed across the bar"
    )
    tangential_coefficient: NotNegative = Field(
        2.0, description="C_t: shear over half the density times the product of the speeds across and along the bar"
    )
    rotation_rad_s: Finite = Field(EARTH_ROTATION_RAD_S, description="rate of the atmosphere, rad/s")


class SolarPressureTable(Table):
    """Sunlight on flat bars, each rotated about its own line towards the Sun."""

    pressure_Pa: Positive = Field(SUNLIGHT_PA, description="pressure on a black surface that faces the Sun, Pa")
    width_m: PositiveEach = Field(description="width of each bar across its line, m")
    reflectivity: Share = Field(0.0, description="share of the light reflected as by a mirror; the rest is absorbed")
    sun_longitude_deg: Finite = Field(0.0, description="direction to the Sun from the z1 axis at t = 0, degrees")
    sun_rate_rad_s: Finite = Field(SUN_RATE_RAD_S, description="rate of that direction, rad/s")
    shadow: bool = Field(
        True,
        description="whether the central body's cylindrical shadow darkens the chain while its centre of mass is in it",
    )


class JointSpringDamperTable(Table):
    """A rotational spring and damper in every joint. A number is repeated, a list gives one value per joint."""

    stiffness_N_m_rad: NotNegativeEach = Field(0.0, description="torque per angle between the bars, N m/rad")
    damping_N_m_s_rad: NotNegativeEach = Field(0.0, description="torque per rate of that angle, N m s/rad")
    rest_deg: FiniteEach = Field(
        0.0, description="angle of a joint's second bar less that of its first at rest, degrees"
    )
    set_point: list[SetPointTable] = Field(
        default_factory=list, max_length=MOST_TABLES, description="rest angles that move in time, of single joints"
    )

    @model_validator(mode="after")
    def something(self) -> JointSpringDamperTable:
        """Reject a table without stiffness and damping; a written zero is allowed."""
        if not self.model_fields_set & {"stiffness_N_m_rad", "damping_N_m_s_rad"}:
            raise ValueError("give stiffness_N_m_rad, damping_N_m_s_rad, or both")
        return self


ConstantStart = Annotated[NotNegative | None, Field(description="when a constant one starts, s; 0 by default")]
ConstantDuration = Annotated[
    Positive | None, Field(description="how long it lasts, s; to the end of the run by default")
]
TableInstants = Annotated[
    list[NotNegative] | None,
    Field(max_length=MOST_POINTS, description="increasing instants of a table, s; 0 outside it"),
]


class SetPointTable(Table):
    """Rest angle of one joint's spring and damper that moves in time: the set point of a PD control."""

    joint: int = Field(ge=1, description="which joint, counted from 1: joint j ties bar j to bar j+1")
    times_s: list[NotNegative] = Field(max_length=MOST_POINTS, description="increasing instants, s")
    angle_deg: list[Finite] = Field(
        description="rest angle at these instants, degrees: linear between them, the first before and the last after"
    )

    @model_validator(mode="after")
    def equally_many(self) -> SetPointTable:
        """Check that there are as many angles as increasing instants."""
        check_instants("angle_deg", self.times_s, self.angle_deg)
        return self


class JointTorqueTable(Table):
    """Torque of a motor in a joint: constant over an interval, or a table of sizes with linear interpolation."""

    joint: int = Field(ge=1, description="which joint, counted from 1: joint j ties bar j to bar j+1")
    torque_N_m: FiniteEach = Field(
        description="torque on the joint's second bar, counter-clockwise, and the opposite one on its first, N m: "
        "a number, or one for each of times_s, of which two may be equal: a jump"
    )
    start_s: ConstantStart = None
    duration_s: ConstantDuration = None
    times_s: TableInstants = None

    @model_validator(mode="after")
    def constant_or_table(self) -> JointTorqueTable:
        """Check that the torque is a number, or a table."""
        check_sizes("torque_N_m", self, jumps=True)
        return self


class AtEnd(Table):
    """Place and direction of a thrust or an impulse."""

    bar: int = Field(ge=1, description="which bar, counted from 1")
    end: Literal["left", "right"] = Field("right", description="which end of it; right is towards the next bar")
    axes: Literal["body", "inertial"] = Field("body", description="whether the direction turns with the bar")
    direction_deg: Finite = Field(description="angle from the bar's own direction, or from the z1 axis, degrees")


class ThrustTable(AtEnd):
    """Force on one end of a bar: constant over an interval, or a table of sizes with linear interpolation."""

    force_N: FiniteEach = Field(description="size, N: a number, or one for each of times_s")
    start_s: ConstantStart = None
    duration_s: ConstantDuration = None
    times_s: TableInstants = None

    @model_validator(mode="after")
    def constant_or_table(self) -> ThrustTable:
        """Check that the force is a number, or a table."""
        check_sizes("force_N", self)
        return self


class ImpulseTable(AtEnd):
    """Impulse on one end of a bar at an instant: velocities jump, joints stay closed."""

    impulse_N_s: Finite = Field(description="size, N s")
    at_s: Positive = Field(description="when, s; after the start and before the end of the run")


class EffectsTable(Table):
    """All physical effects of a scene."""

    gravity: Literal["none", "point", "gradient", "quadrupole", "slender"] = Field(
        "gradient",
        description="none; point mass at each bar's centre; or that with the gravity-gradient torque (the paper's); "
        "or the potential to the bar's second moment; or the exact gravity of a uniform slender bar",
    )
    prescribed_rotation: list[PrescribedRotationTable] = Field(
        default_factory=list,
        max_length=MOST_TABLES,
        description="bars whose rotation is given; their torque is computed",
    )
    oblateness: OblatenessTable | None = Field(None, description="flattening of the central body")
    third_body: list[ThirdBodyTable] = Field(
        default_factory=list, max_length=MOST_TABLES, description="the Moon, the Sun, others"
    )
    drag: DragTable | None = Field(None, description="drag in an atmosphere that turns with the central body")
    solar_pressure: SolarPressureTable | None = Field(None, description="pressure of sunlight on the bars")
    joint_spring_damper: JointSpringDamperTable | None = Field(None, description="springs and dampers in the joints")
    joint_torque: list[JointTorqueTable] = Field(
        default_factory=list, max_length=MOST_TABLES, description="torques of motors in joints"
    )
    thrust: list[ThrustTable] = Field(
        default_factory=list, max_length=MOST_TABLES, description="forces on ends of bars"
    )
    impulse: list[ImpulseTable] = Field(
        default_factory=list, max_length=MOST_TABLES, description="impulses on ends of bars"
    )


def check_sizes(key: str, table: ThrustTable | JointTorqueTable, *, jumps: bool = False) -> None:
    """Check that the size `key` is a number, or a table alone; whether it may jump."""
    sizes, times_s = getattr(table, key), table.times_s
    if isinstance(sizes, list) != (times_s is not None):
        raise ValueError(f"give a number as {key}, or lists as both {key} and times_s")
    if times_s is None:
        return
    if table.start_s is not None or table.duration_s is not None:
        raise ValueError("times_s gives the start and the end; leave out start_s and duration_s")
    check_instants(key, times_s, sizes, jumps=jumps)


def check_instants(key: str, times_s: list[float], sizes: list[float], *, jumps: bool = False) -> None:
    """Check that a table has as many sizes as increasing instants, two or more; at a jump two instants are equal."""
    if len(times_s) != len(sizes) or len(times_s) < 2:
        raise ValueError(
            f"times_s and {key} have {len(times_s)} and {len(sizes)} values; allowed: equally many, two or more"
        )
    if any(b < a or (a == b and not jumps) for a, b in itertools.pairwise(times_s)) or times_s[0] == times_s[-1]:
        raise ValueError("times_s must increase from one instant to the next")
