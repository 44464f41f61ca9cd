"""Tables of a scene file besides its effects, checked by pydantic."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, ValidationInfo, field_validator, model_validator

from scenarios.size_limits import (
    BARS,
    MOST_DESCRIPTION,
    MOST_PATH,
    MOST_SOURCE,
    MOST_TAG,
    MOST_TAGS,
    MOST_TITLE,
)
from scenarios.text import check_text
from scenarios.toml.effect_tables import (
    EffectsTable,
    Finite,
    FiniteEach,
    NotNegative,
    Positive,
    PositiveEach,
    ShareEach,
    Table,
    each,
    slender_inertia,
)
from scenarios.toml.orbit_keys import check_form


def words(most: int, but: str = "") -> AfterValidator:
    """Check of a text of at most `most` characters, none of them hidden except those in `but`."""

    def checked(text: str) -> str:
        check_text(text, most, but=but)
        return text

    return AfterValidator(checked)


def shown_limit(most: int) -> Any:
    """Largest number of characters in the JSON Schema, which knows no check in Python."""
    return Field(json_schema_extra={"maxLength": most})


Title = Annotated[str, words(MOST_TITLE), shown_limit(MOST_TITLE)]
Source = Annotated[str, words(MOST_SOURCE), shown_limit(MOST_SOURCE)]
Description = Annotated[str, words(MOST_DESCRIPTION, but="\n\t"), shown_limit(MOST_DESCRIPTION)]
Tag = Annotated[str, words(MOST_TAG), shown_limit(MOST_TAG)]
Place = Annotated[list[Finite], Field(min_length=2, max_length=2)]
FlightPath = Annotated[float, Field(ge=-90.0, le=90.0, allow_inf_nan=False)]

MATERIAL_KEYS = ("mass_kg", "length_m", "inertia_kg_m2", "com_share")
MIDWAY = 0.5
ANGLE_KEYS = ("angle_deg", "angle_rad")
RATE_KEYS = ("rate_factor", "rate_deg_s", "rate_rad_s")

EARTH_MU_M3_S2 = 3.986004418e14  # EGM2008 / IAU value
EARTH_RADIUS_M = 6378e3  # the paper's R_eq


class CentralBodyTable(Table):
    """Central body; the Earth by default."""

    mu_m3_s2: Positive = Field(EARTH_MU_M3_S2, description="gravitational parameter, m^3/s^2")
    radius_m: Positive = Field(
        EARTH_RADIUS_M, description="radius of its surface, m; a bar that reaches it ends the run"
    )


class OrbitTable(Table):
    """Start of the chain's centre of mass, counter-clockwise, in one of three forms.

    Altitude with speed factor, flight path and longitude; position with velocity; or two of semi-major axis,
    eccentricity and the altitudes of the apsides, with an anomaly.
    """

    altitude_m: Positive | None = Field(
        None,
        description="height of the chain's centre of mass above the surface at t = 0, m; required unless a state or "
        "elements are given",
    )
    speed_factor: NotNegative = Field(
        1.0, description="beta: speed over the local circular speed; sqrt(2) is parabolic"
    )
    flight_path_deg: FlightPath = Field(0.0, description="angle of the velocity above the horizontal at t = 0, degrees")
    longitude_deg: Finite = Field(0.0, description="angle of the centre of mass from the z1 axis at t = 0, degrees")
    position_m: Place | None = Field(
        None, description="position of the centre of mass at t = 0 from the centre of the body, [z1, z2], m"
    )
    velocity_m_s: Place | None = Field(None, description="its velocity, [z1, z2], m/s")
    semi_major_axis_m: Positive | None = Field(None, description="semi-major axis of an ellipse, m")
    eccentricity: NotNegative | None = Field(
        None, description="eccentricity; of an open orbit from 1, with periapsis_altitude_m"
    )
    periapsis_altitude_m: Finite | None = Field(
        None, description="height of the periapsis above the surface, m; negative below it"
    )
    apoapsis_altitude_m: Finite | None = Field(None, description="height of the apoapsis above the surface, m")
    argument_of_periapsis_deg: Finite = Field(0.0, description="longitude of the periapsis from the z1 axis, degrees")
    true_anomaly_deg: Finite | None = Field(
        None, description="angle from the periapsis at t = 0, degrees; 0 by default"
    )
    mean_anomaly_deg: Finite | None = Field(
        None, description="mean anomaly at t = 0 on an ellipse, degrees, in place of true_anomaly_deg"
    )

    @model_validator(mode="after")
    def one_form(self) -> OrbitTable:
        """Check that one of the forms is given, whole and alone."""
        check_form(self.model_fields_set)
        return self


class EndBodyTable(Table):
    """A body at an end of the chain, in place of its first or last bar: a hub, a satellite, the base of an arm.

    It is a bar of twice the distance of its joint from its centre of mass, with a mass and an inertia of its own.
    Gravity turns it as a bar of that inertia.
    """

    at: Literal["first", "last"] = Field(description="which bar it is: 1 or N")
    mass_kg: Positive = Field(description="mass, kg")
    inertia_kg_m2: Positive = Field(description="moment of inertia about its own centre of mass, kg m^2")
    joint_m: Positive = Field(description="distance of its joint from its centre of mass, m")


class JointMassTable(Table):
    """A point mass at a joint: a coupling, a motor. It belongs to the bar before the joint.

    That bar's mass, moment of inertia and centre of mass follow. Given to the bar after the joint the point would move
    alike, as both bars have the same point there; the joint's force is that between the bar with the mass and the
    other. Models of gravity act on a bar at its centre of mass, so that under gravity the choice counts by what a model
    leaves out, of order (length/radius)² of gravity.
    """

    joint: int = Field(ge=1, description="joint, 1 to N-1; joint j is between bars j and j+1")
    mass_kg: Positive = Field(description="mass, kg")


class ChainTable(Table):
    """The bars. A number is repeated for every bar, a list gives one value per bar.

    Lists of masses, lengths, inertias and centres have no values for end bodies, those of angles and rates have.
    """

    bars: int = Field(ge=1, description="number of bars N, end bodies included")
    end_body: list[EndBodyTable] = Field(
        default_factory=list, max_length=2, description="bodies at the ends, in place of bar 1 or bar N"
    )
    mass_kg: PositiveEach = Field(description="mass of each bar, kg")
    length_m: PositiveEach = Field(description="length of each bar, m")
    inertia_kg_m2: PositiveEach | None = Field(
        None,
        description="moment of inertia about the bar's own centre of mass, kg m^2; slender uniform bar by default",
    )
    com_share: ShareEach = Field(
        MIDWAY,
        description="share of each bar's length from its left end to its centre of mass, 0 to 1; midway by default, "
        "other values need inertia_kg_m2",
    )
    joint_mass: list[JointMassTable] = Field(default_factory=list, description="point masses at the joints")
    angle_deg: FiniteEach = Field(0.0, description="angle of each bar from the horizontal at t = 0, degrees")
    angle_rad: FiniteEach | None = Field(None, description="the same in rad, in place of angle_deg")
    angle_from: Literal["chain", "bar", "inertial"] = Field(
        "chain",
        description="whose horizontal the angles start from: the one through the chain's centre of mass, "
        "or the one through each bar's own (the paper's phi_j); inertial: they start from the z1 axis",
    )
    centre_m: list[Place] | None = Field(
        None,
        description="places of the bars' centres of mass at t = 0 from any one point, [along the horizontal, up], m; "
        "the angles decide; a start with contradicting places is corrected or rejected",
    )
    rate_factor: FiniteEach = Field(
        1.0,
        description="alpha: initial inertial rate of each bar over that of the centre of mass's longitude, v0/r0 at an "
        "apsis; a prescribed bar takes its law's rate",
    )
    rate_deg_s: FiniteEach | None = Field(
        None, description="initial inertial rate of each bar, deg/s, in place of rate_factor"
    )
    rate_rad_s: FiniteEach | None = Field(None, description="the same, rad/s")

    @field_validator("bars")
    @classmethod
    def not_too_many(cls, bars: int) -> int:
        """Reject more bars than memory is meant for."""
        BARS.check(bars)
        return bars

    @model_validator(mode="after")
    def one_of_each(self) -> ChainTable:
        """Check that angles, rates and bodies are given once."""
        ends = [body.at for body in self.end_body]
        if len(set(ends)) < len(ends):
            raise ValueError(f'two end bodies at = "{ends[0]}" are given, allowed: one at each end')
        if ends and self.bars <= len(ends):
            raise ValueError(
                f"bars: {self.bars} given, allowed with end bodies: at least one bar besides, {len(ends) + 1}"
            )
        if self.inertia_kg_m2 is None and set(each(self.com_share, self.bars - len(ends))) != {MIDWAY}:
            raise ValueError("com_share is given without inertia_kg_m2, which is that of a uniform bar by default")
        for i, point in enumerate(self.joint_mass, start=1):
            if point.joint >= self.bars:
                raise ValueError(f"joint_mass[{i}].joint: {point.joint} given, allowed: 1 to {self.bars - 1}")
        for keys in (ANGLE_KEYS, RATE_KEYS):
            given = [key for key in keys if key in self.model_fields_set]
            if len(given) > 1:
                raise ValueError(f"{' and '.join(given)} are given, allowed: one of {', '.join(keys)}")
        return self

    @field_validator(
        "mass_kg", "length_m", "inertia_kg_m2", "com_share", "angle_deg", "angle_rad", "rate_factor", "rate_deg_s",
        "rate_rad_s",
    )  # fmt: skip
    @classmethod
    def one_value_per_bar(cls, value: Any, info: ValidationInfo) -> Any:
        """Reject a list whose length is not the number of bars."""
        bars, bodies = info.data.get("bars"), len(info.data.get("end_body", ()))
        of_material = info.field_name in MATERIAL_KEYS
        if not isinstance(value, list) or bars is None or (of_material and "end_body" not in info.data):
            return value  # the faults of the bodies, or of the number of bars, are told
        wanted, but = (bars - bodies, " that is no end body" if bodies else "") if of_material else (bars, "")
        if len(value) != wanted:
            raise ValueError(f"a list needs one value per bar{but}: {wanted} of them (or give one number for all)")
        return value

    @property
    def angles_rad(self) -> tuple[float, ...]:
        """Initial angles, rad."""
        if self.angle_rad is not None:
            return each(self.angle_rad, self.bars)
        return tuple(map(math.radians, each(self.angle_deg, self.bars)))

    def material(self) -> tuple[tuple[float, ...], ...]:
        """Masses, lengths, moments of inertia and shares of all bars, end bodies and joint masses included."""
        count = self.bars - len(self.end_body)
        mass, length = each(self.mass_kg, count), each(self.length_m, count)
        given = self.inertia_kg_m2
        inertia = tuple(map(slender_inertia, mass, length)) if given is None else each(given, count)
        rows = list(zip(mass, length, inertia, each(self.com_share, count), strict=True))
        for body in self.end_body:
            own = body.mass_kg, 2.0 * body.joint_m, body.inertia_kg_m2, MIDWAY
            rows.insert(0 if body.at == "first" else len(rows), own)
        for point in self.joint_mass:
            j = point.joint - 1
            of_body = j == 0 and any(one.at == "first" for one in self.end_body)
            rows[j] = with_point(*rows[j], point.mass_kg, body=of_body)
        return tuple(zip(*rows, strict=True))


def with_point(
    mass: float, length: float, inertia: float, share: float, added: float, *, body: bool
) -> tuple[float, float, float, float]:
    """Mass, length, moment of inertia and share of a bar with a point mass on its right end.

    An end body stays a bar of twice the distance of its joint from its centre of mass.
    """
    whole, lever = mass + added, (1.0 - share) * length
    moved = lever * added / whole  # by this the centre of mass comes nearer to the point
    turning = inertia + lever * moved * mass
    return (whole, 2.0 * (lever - moved), turning, MIDWAY) if body else (whole, length, turning, share + moved / length)


class StartTable(Table):
    """Start in a state of another run: in place of `[orbit]` and of the bars' angles and rates."""

    from_: str = Field(
        alias="from",
        min_length=1,
        max_length=MOST_PATH,
        description="table of that run, .csv or .parquet, with the columns of `barchain simulate`; its path is "
        "relative to the folder of this file",
    )
    row: int | None = Field(None, ge=1, description="which row, counted from 1; the last by default")
    time_s: Finite | None = Field(None, description="instant of a row, s, in place of row")

    @model_validator(mode="after")
    def one_row(self) -> StartTable:
        """Reject a row that is given twice."""
        if self.row is not None and self.time_s is not None:
            raise ValueError("row and time_s are given, allowed: one of them")
        return self


class RunTable(Table):
    """Duration and samples of a run."""

    orbits: Positive | None = Field(
        None,
        description="duration in periods of the initial osculating orbit (bound ones only); "
        "required unless duration_s is given",
    )
    duration_s: Positive | None = Field(None, description="duration; required unless orbits is given")
    samples: int = Field(501, ge=2, le=1_000_000, description="equally spaced instants, both ends included")
    start_s: NotNegative = Field(
        0.0,
        description="instant of the start on the clock that instants and longitudes of effects belong to, s; results "
        "count from the start. With [start] that of its row by default",
    )

    @model_validator(mode="after")
    def one_duration(self) -> RunTable:
        """Reject two durations, or none."""
        if (self.orbits is None) == (self.duration_s is None):
            raise ValueError("give exactly one of orbits, duration_s")
        return self


class SceneTables(Table):
    """All tables of a scene file, each checked by itself."""

    title: Title = Field(min_length=1, description="one line, for people")
    source: Source = Field(min_length=1, description="where the scene or its expected answer comes from")
    description: Description = Field("", description="expected motion, for people")
    tags: list[Tag] = Field(
        default_factory=list, max_length=MOST_TAGS, description="words to choose scenes by: paper, basics, chaotic, ..."
    )
    central_body: CentralBodyTable = Field(
        default_factory=lambda: CentralBodyTable(mu_m3_s2=EARTH_MU_M3_S2, radius_m=EARTH_RADIUS_M),
        description="body that the chain orbits; the Earth by default",
    )
    orbit: OrbitTable = Field(
        None,  # type: ignore[assignment]  # `[start]` has become an orbit before a file is checked
        description="start of the centre of mass; required unless start is given",
    )
    start: StartTable | None = Field(None, description="start in a state of another run")
    chain: ChainTable = Field(description="bars and their initial angles and rates")
    effects: EffectsTable = Field(
        default_factory=lambda: EffectsTable(gravity="gradient"),
        description="forces on the bars; gravity with its gradient torque by default",
    )
    run: RunTable = Field(description="length of the run and its samples")
