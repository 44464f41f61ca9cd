"""The scene file: what a TOML scene may say, checked by pydantic, and its JSON Schema."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    ValidationInfo,
    field_validator,
    model_validator,
)

EARTH_MU_M3_S2 = 3.986004418e14  # EGM2008 / IAU value
EARTH_RADIUS_M = 6378e3  # the paper's R_eq

Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]

NUMBER, LIST = "number", "list"
PER_BAR = Discriminator(
    lambda value: LIST if isinstance(value, list) else NUMBER
)  # so that an error speaks of one of them
FinitePerBar = Annotated[Annotated[Finite, Tag(NUMBER)] | Annotated[list[Finite], Tag(LIST)], PER_BAR]
PositivePerBar = Annotated[Annotated[Positive, Tag(NUMBER)] | Annotated[list[Positive], Tag(LIST)], PER_BAR]


class Table(BaseModel):
    """A table of a scene file: unknown keys are errors, numbers are not guessed from strings."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class CentralBodyTable(Table):
    """The body orbited; Earth by default."""

    mu_m3_s2: Positive = Field(EARTH_MU_M3_S2, description="gravitational parameter, m^3/s^2")
    radius_m: Positive = Field(
        EARTH_RADIUS_M, description="radius of its surface, m; a bar that reaches it ends the run"
    )


class OrbitTable(Table):
    """Injection of the chain's centre of mass; velocity horizontal, counter-clockwise."""

    altitude_m: Positive = Field(description="height of the chain's centre of mass above the surface at t = 0, m")
    speed_factor: NotNegative = Field(
        1.0, description="beta: speed over the local circular speed; sqrt(2) is parabolic"
    )
    longitude_deg: Finite = Field(0.0, description="angle of the centre of mass from the z1 axis at t = 0, degrees")


class ChainTable(Table):
    """The bars. A number is repeated for every bar, a list gives one value per bar."""

    bars: int = Field(ge=1, description="number of bars N")
    mass_kg: PositivePerBar = Field(description="mass of each bar, kg")
    length_m: PositivePerBar = Field(description="length of each bar, m")
    inertia_kg_m2: PositivePerBar | None = Field(
        None,
        description="moment of inertia about the bar's own centre of mass, kg m^2; slender uniform bar by default",
    )
    angle_deg: FinitePerBar = Field(0.0, description="angle of each bar from the horizontal at t = 0, degrees")
    angle_from: Literal["chain", "bar"] = Field(
        "chain",
        description="whose horizontal the angles start from: the one through the chain's centre of mass, "
        "or the one through each bar's own (the paper's phi_j)",
    )
    rate_factor: FinitePerBar = Field(
        1.0,
        description="alpha: initial inertial rate of each bar over v0/r0; a prescribed bar takes its law's rate",
    )

    @field_validator("mass_kg", "length_m", "inertia_kg_m2", "angle_deg", "rate_factor")
    @classmethod
    def one_value_per_bar(cls, value: Any, info: ValidationInfo) -> Any:
        """Refuse a list whose length is not the number of bars."""
        bars = info.data.get("bars")
        if isinstance(value, list) and bars is not None and len(value) != bars:
            raise ValueError(f"a list needs one value per bar: {bars} of them (or give one number for all)")
        return value


class PrescribedRotationTable(Table):
    """One bar's rotation, given as the law of the paper's eq. (28)."""

    bar: int = Field(ge=1, description="which bar, counted from 1")
    amplitude_deg: Finite = Field(description="angle turned through, degrees")
    duration_s: Positive = Field(description="time of the manoeuvre, s")
    start_s: NotNegative = Field(0.0, description="when it starts, s; the bar is held before and after")
    frame: Literal["inertial", "local_horizontal"] = Field(
        "local_horizontal", description="against what the angle is measured"
    )
    actuator: Literal["external", "joint"] = Field(
        "external",
        description="torque from outside on the bar alone, or from a motor in the joint to the bar before it "
        "(bar 1: to bar 2)",
    )


class EffectsTable(Table):
    """The physical effects that act; nothing else does."""

    gravity: Literal["none", "point", "gradient"] = Field(
        "gradient",
        description="none; point mass at each bar's centre; or that with the gravity-gradient torque (the paper's)",
    )
    prescribed_rotation: list[PrescribedRotationTable] = Field(
        default_factory=list, description="bars whose rotation is given, and the torque wanted"
    )


class RunTable(Table):
    """How long and how often the motion is seen."""

    orbits: Positive | None = Field(
        None, description="duration in periods of the initial osculating orbit (bound ones only)"
    )
    duration_s: Positive | None = Field(None, description="duration in seconds, instead of `orbits`")
    samples: int = Field(501, ge=2, le=1_000_000, description="equally spaced instants, both ends included")

    @model_validator(mode="after")
    def one_duration(self) -> RunTable:
        """Refuse both durations, or none."""
        if (self.orbits is None) == (self.duration_s is None):
            raise ValueError("give exactly one of orbits, duration_s")
        return self


class SceneFile(Table):
    """A barchain scene: a chain of rigid bars joined by revolute joints in the plane of its orbit."""

    title: str = Field(min_length=1, description="one line, for people")
    source: str = Field(min_length=1, description="where the scene or its expected answer comes from")
    description: str = Field("", description="what is to be seen, for people")
    tags: list[str] = Field(default_factory=list, description="for choosing scenes: paper, basics, chaotic, ...")
    central_body: CentralBodyTable = Field(
        default_factory=lambda: CentralBodyTable(mu_m3_s2=EARTH_MU_M3_S2, radius_m=EARTH_RADIUS_M)
    )
    orbit: OrbitTable
    chain: ChainTable
    effects: EffectsTable = Field(default_factory=lambda: EffectsTable(gravity="gradient"))
    run: RunTable

    @model_validator(mode="after")
    def consistent(self) -> SceneFile:
        """Check what concerns several tables at once."""
        check_run_is_bound(self)
        check_above_surface(self)
        check_prescriptions(self)
        return self


def check_run_is_bound(scene: SceneFile) -> None:
    """`orbits` counts periods, so it needs an orbit that has one."""
    if scene.run.orbits is None:
        return
    if scene.effects.gravity == "none":
        raise ValueError("run.orbits: without gravity there is no period to count in; give duration_s")
    if scene.orbit.speed_factor**2 >= 2.0:
        raise ValueError(
            f"run.orbits: the orbit is not bound (speed_factor = {scene.orbit.speed_factor:g}, allowed below sqrt(2)); "
            "give duration_s"
        )


def check_above_surface(scene: SceneFile) -> None:
    """The whole chain, stretched towards the centre, must start above the surface."""
    length = scene.chain.length_m
    size_m = math.fsum(length) if isinstance(length, list) else scene.chain.bars * length
    if size_m >= scene.orbit.altitude_m:
        raise ValueError(
            f"orbit.altitude_m: {scene.orbit.altitude_m:g} lets a chain of {size_m:g} m reach the surface; "
            "allowed: more than the length of the chain"
        )


def check_prescriptions(scene: SceneFile) -> None:
    """Each bar has at most one law, exists, and has a neighbour if a joint drives it."""
    seen: set[int] = set()
    for i, p in enumerate(scene.effects.prescribed_rotation):
        where = f"effects.prescribed_rotation[{i}].bar"
        if p.bar > scene.chain.bars:
            raise ValueError(f"{where}: {p.bar} given, allowed: 1 to {scene.chain.bars}")
        if p.bar in seen:
            raise ValueError(f"{where}: bar {p.bar} already has a prescribed rotation; allowed: one for each bar")
        if p.actuator == "joint" and scene.chain.bars == 1:
            raise ValueError(f'{where}: actuator "joint" needs a neighbouring bar, and the chain has one bar')
        seen.add(p.bar)
    joints = [joint_of_motor(p.bar) for p in scene.effects.prescribed_rotation if p.actuator == "joint"]
    for joint in joints:
        if joints.count(joint) > 1:
            raise ValueError(
                f"effects.prescribed_rotation: joint {joint} would carry two motors (bar 1's motor is in joint 1); "
                "allowed: one motor for each joint"
            )


def joint_of_motor(bar: int) -> int:
    """Joint (from 1) whose motor turns `bar`: the one before it, and joint 1 for bar 1."""
    return max(bar - 1, 1)
