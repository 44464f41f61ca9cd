"""Tables of a scene file besides its effects, checked by pydantic."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, ValidationInfo, field_validator, model_validator

from scenarios.limits import (
    BARS,
    MOST_DESCRIPTION,
    MOST_SOURCE,
    MOST_TAG,
    MOST_TAGS,
    MOST_TITLE,
)
from scenarios.text import check_text
from scenarios.toml.effect_tables import EffectsTable, Finite, FiniteEach, NotNegative, Positive, PositiveEach, Table


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

EARTH_MU_M3_S2 = 3.986004418e14  # EGM2008 / IAU value
EARTH_RADIUS_M = 6378e3  # the paper's R_eq


class CentralBodyTable(Table):
    """Central body; the Earth by default."""

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
    mass_kg: PositiveEach = Field(description="mass of each bar, kg")
    length_m: PositiveEach = Field(description="length of each bar, m")
    inertia_kg_m2: PositiveEach | None = Field(
        None,
        description="moment of inertia about the bar's own centre of mass, kg m^2; slender uniform bar by default",
    )
    angle_deg: FiniteEach = Field(0.0, description="angle of each bar from the horizontal at t = 0, degrees")
    angle_from: Literal["chain", "bar"] = Field(
        "chain",
        description="whose horizontal the angles start from: the one through the chain's centre of mass, "
        "or the one through each bar's own (the paper's phi_j)",
    )
    centre_m: list[Place] | None = Field(
        None,
        description="places of the bars' centres at t = 0 from any one point, [along the horizontal, up], m; the "
        "angles decide; a start with contradicting places is corrected or rejected",
    )
    rate_factor: FiniteEach = Field(
        1.0,
        description="alpha: initial inertial rate of each bar over v0/r0; a prescribed bar takes its law's rate",
    )

    @field_validator("bars")
    @classmethod
    def not_too_many(cls, bars: int) -> int:
        """Reject more bars than memory is meant for."""
        BARS.check(bars)
        return bars

    @field_validator("mass_kg", "length_m", "inertia_kg_m2", "angle_deg", "rate_factor")
    @classmethod
    def one_value_per_bar(cls, value: Any, info: ValidationInfo) -> Any:
        """Reject a list whose length is not the number of bars."""
        bars = info.data.get("bars")
        if isinstance(value, list) and bars is not None and len(value) != bars:
            raise ValueError(f"a list needs one value per bar: {bars} of them (or give one number for all)")
        return value


class RunTable(Table):
    """Duration and samples of a run."""

    orbits: Positive | None = Field(
        None,
        description="duration in periods of the initial osculating orbit (bound ones only); "
        "required unless duration_s is given",
    )
    duration_s: Positive | None = Field(None, description="duration; required unless orbits is given")
    samples: int = Field(501, ge=2, le=1_000_000, description="equally spaced instants, both ends included")

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
    orbit: OrbitTable = Field(description="start of the centre of mass")
    chain: ChainTable = Field(description="bars and their initial angles and rates")
    effects: EffectsTable = Field(
        default_factory=lambda: EffectsTable(gravity="gradient"),
        description="forces on the bars; gravity with its gradient torque by default",
    )
    run: RunTable = Field(description="length of the run and its samples")
