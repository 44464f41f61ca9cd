"""The table of channels: what a trajectory stores and what is judged, with unit, columns and words of each.

A channel is one quantity over time. Stored channels are arrays of a trajectory; invariants are computed of those when
they are judged. Names of columns, of figures and of errors, units and words all come from this table. Channels that are
computed on request are in :mod:`scenarios.derived_channels`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum, StrEnum
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from scenarios.scene import Scene


class Of(Enum):
    """What the values of a channel belong to; tables have their columns in this order."""

    TRACK = "centre of mass"
    BARS = "bar"
    JOINTS = "joint"
    LAWS = "prescribed bar"
    CHAIN = "chain"

    @property
    def numbered(self) -> bool:
        """Whether there are several, each with its number in the column's name."""
        return self not in (Of.TRACK, Of.CHAIN)


class Judged(StrEnum):
    """How a channel is judged."""

    NOT = ""
    DIFFERENCE = "difference"
    """By its difference from the judging solution; a file of another program may have it"""
    DRIFT = "drift"
    """By its size over the run"""


@dataclass(frozen=True)
class Channel:
    """One quantity over time."""

    name: str
    """In rows, figures, declared noise and options"""
    unit: str
    """SI; ``1`` of a ratio"""
    words: str
    """In a sentence, e.g. ``reactions``"""
    meaning: str
    """One sentence, with its sign and its axes"""
    of: Of = Of.CHAIN
    stems: tuple[str, ...] = ()
    """Columns without unit, one for each component; ``{}`` stands for the number of the bar or joint, from 1"""
    array: str = ""
    """Field of a trajectory, (n,), with axes for numbers and for components where there are any"""
    label: str = ""
    """In tables; default: the name"""
    title: str = ""
    """Of a chart; default: the label"""
    judged: Judged = Judged.NOT
    noise: bool = False
    """Whether an engine may declare errors of it that do not fall with the step"""
    observable: str = ""
    """Observable by which an engine declares it; empty of what is never declared"""
    effects: tuple[str, ...] = ()
    """Effects without any of which a scene has no such channel; empty of a channel of every scene"""
    section: str = ""
    """Of docs/explanation/engine_conventions.md"""
    share_of: str = ""
    """In place of the unit of a ratio, in words"""

    @property
    def shown_label(self) -> str:
        """Name in tables."""
        return self.label or self.name.replace("_", " ")

    @property
    def shown_title(self) -> str:
        """Name above a chart."""
        label = self.shown_label
        return self.title or label[:1].upper() + label[1:]

    @property
    def ending(self) -> str:
        """Unit at the end of a column's name."""
        return unit_ending(self.unit)

    @property
    def columns(self) -> tuple[str, ...]:
        """Patterns of columns, one for each component, ``{}`` for the number."""
        return tuple(stem + self.ending for stem in self.stems)

    def column_of(self, what: str = "") -> str:
        """Column of a number that belongs to the whole channel, e.g. ``reaction_error_N`` of ``error``."""
        return f"{self.name}{what and '_'}{what}{self.ending}"

    def absent_from(self, scene: Scene) -> bool:
        """Whether a scene has none of the effects without which there is no such channel."""
        return bool(self.effects) and not any(getattr(scene.effects, effect) for effect in self.effects)

    def numbers(self, scene: Scene) -> list[int]:
        """Numbers of its bars or joints in a scene; empty without its effects, and where none are counted."""
        if not self.of.numbered or self.absent_from(scene):
            return []
        if self.of is Of.LAWS:
            return [law.bar for law in scene.effects.prescribed_rotation]
        return list(range(1, scene.bars + (self.of is Of.BARS)))

    def names(self, scene: Scene) -> list[str]:
        """Columns without unit in a scene, number by number."""
        if not self.of.numbered:
            return list(self.stems)
        return [stem.format(j) for j in self.numbers(scene) for stem in self.stems]

    def shape(self, samples: int, scene: Scene) -> tuple[int, ...]:
        """Shape of its array in a scene."""
        counted = {Of.BARS: scene.bars, Of.JOINTS: scene.bars - 1, Of.LAWS: len(scene.effects.prescribed_rotation)}
        several = (len(self.stems),) if len(self.stems) > 1 else ()
        return (samples, *((counted[self.of],) if self.of.numbered else ()), *several)

    def split(self, values: Any, numbers: Iterable[int] = ()) -> dict[str, Any]:
        """Columns of an array of :meth:`shape`, each (n,), by name; `numbers` of its bars or joints if not from 1."""
        if not self.of.numbered:
            parts = values.T if len(self.stems) > 1 else [values]
            return dict(zip(self.columns, parts, strict=True))
        found = dict[str, Any]()
        for k, j in enumerate(numbers or range(1, values.shape[1] + 1)):
            parts = values[:, k].T if len(self.stems) > 1 else [values[:, k]]
            found |= {column.format(j): part for column, part in zip(self.columns, parts, strict=True)}
        return found


def unit_ending(unit: str) -> str:
    """Unit at the end of a column's name: ``_rad_s`` of rad/s."""
    return "" if unit == "1" else "_" + unit.replace("/", "_").replace(" ", "_")


DIFFERENCE, DRIFT = Judged.DIFFERENCE, Judged.DRIFT
TABLE = (
    Channel(
        "com", "m", "centre of mass", "Centre of mass of the chain, from the centre of the body, in inertial axes.",
        Of.TRACK, ("com_x", "com_y"), "com_m", label="CM track", judged=DIFFERENCE, noise=True, observable="com",
        section="centre-of-mass",
    ),
    Channel(
        "com_velocity", "m/s", "velocity of the centre of mass", "Velocity of the centre of mass, in inertial axes.",
        Of.TRACK, ("com_vx", "com_vy"), "com_velocity_m_s", label="CM velocity", judged=DIFFERENCE, noise=True,
        observable="com", section="centre-of-mass",
    ),
    Channel(
        "attitude", "rad", "angles", "Angle of each bar from the z1 axis, positive counter-clockwise, not wrapped.",
        Of.BARS, ("angle_{}",), "angle_rad", judged=DIFFERENCE, noise=True, observable="attitude", section="angles",
    ),
    Channel(
        "rate", "rad/s", "rates", "Rate of each bar's angle.",
        Of.BARS, ("rate_{}",), "rate_rad_s", judged=DIFFERENCE, noise=True, observable="rate", section="rates",
    ),
    Channel(
        "position", "m", "positions of the bars", "Centre of each bar from the centre of mass, in inertial axes; only "
        "of engines whose positions do not follow from the angles.",
        Of.BARS, ("position_{}_x", "position_{}_y"), "position_m",
    ),
    Channel(
        "reaction", "N", "reactions", "Force on bar j from bar j+1, in inertial axes.",
        Of.JOINTS, ("reaction_{}_x", "reaction_{}_y"), "reaction_N", title="Reactions", judged=DIFFERENCE, noise=True,
        observable="reaction", section="reactions",
    ),
    Channel(
        "torque", "N m", "torques", "Torque on bar b that its prescribed rotation takes, positive counter-clockwise.",
        Of.LAWS, ("torque_bar_{}",), "torque_N_m", judged=DIFFERENCE, noise=True, observable="torque",
        effects=("prescribed_rotation",), section="torques",
    ),
    Channel(
        "impulse", "N s", "impulses", "Sum of the impulsive reactions on bar j from bar j+1 so far, in inertial axes.",
        Of.JOINTS, ("impulse_{}_x", "impulse_{}_y"), "impulse_N_s", judged=DIFFERENCE, noise=True,
        observable="impulse", effects=("impulse",), section="impulses",
    ),
    Channel(
        "gap", "m", "joint gaps", "Distance between the two bar ends at joint j.",
        Of.JOINTS, ("gap_{}",), "gap_m", label="joint gap", judged=DRIFT, noise=True, observable="gap",
    ),
    Channel(
        "com_residual", "m", "centre-of-mass residual", "Distance of the bars' weighted centre from the centre of "
        "mass: rounding, or drift of an engine that integrates both. The residual of the paper's eq. (6).",
        Of.CHAIN, ("com_residual",), "com_residual_m",
        label="centre-of-mass residual", judged=DRIFT, observable="com_residual",
    ),
    Channel(
        "condition", "1", "condition number", "Condition number of the joint system, on request (`--condition`).",
        Of.CHAIN, ("condition",), "condition",
    ),
    Channel(
        "energy", "1", "energy", "Change of the chain's energy, relative to the largest kinetic energy.",
        judged=DRIFT, share_of="relative",
    ),
    Channel(
        "angular_momentum", "1", "angular momentum", "Change of the chain's angular momentum, relative to its size.",
        judged=DRIFT, share_of="relative",
    ),
    Channel(
        "energy_about_com", "1", "energy about the CM", "Change of the energy about the centre of mass that gravity "
        "does not explain, relative to the kinetic energy there.",
        label="energy about the CM", judged=DRIFT, share_of="relative",
    ),
    Channel(
        "angular_momentum_about_com", "1", "angular momentum about the CM", "Change of the angular momentum about the "
        "centre of mass that gravity does not explain, relative to its size.",
        label="angular momentum about the CM", judged=DRIFT, share_of="relative",
    ),
    Channel(
        "relative_energy", "1", "kinetic energy about the CM", "Kinetic energy about the centre of mass, relative to "
        "the largest possible one.",
        label="kinetic energy about the CM", judged=DRIFT, share_of="of the largest possible",
    ),
)  # fmt: skip
CHANNELS = {channel.name: channel for channel in TABLE}
"""Every stored or judged channel by its name"""
STORED = tuple(channel for channel in TABLE if channel.array)
"""Channels that are arrays of a trajectory"""
COMPARED = tuple(channel for channel in TABLE if channel.judged is DIFFERENCE)
"""Channels that are compared with the judging solution"""
DRIFTING = tuple(channel for channel in TABLE if channel.judged is DRIFT)
"""Residuals and invariants that are judged by their size"""
IN_COLUMN_ORDER = sorted(STORED, key=lambda channel: list(Of).index(channel.of))
"""Stored channels in the order of their columns"""
UNITS = {channel.name: channel.unit for channel in (*COMPARED, *DRIFTING)}
"""Units of all that is judged"""
WORDS = {channel.name: channel.words for channel in TABLE}
"""Words in a sentence by name"""
NOISE = tuple(channel.name for channel in TABLE if channel.noise)
"""Channels whose noise an engine may declare"""
TIME = "t_s"
"""Column of the instants"""
CLOCK = "clock_s"
"""Column of a run that started later than the clock of its effects: what that shows"""
NUMBER = re.compile(r"_([0-9]{1,9})(?=_)")


def columns_without_number(channels: Iterable[Channel] = STORED) -> Iterator[str]:
    """Columns of channels that a chain has once."""
    return (column for channel in channels if not channel.of.numbered for column in channel.columns)


def numbered_columns(channels: Iterable[Channel] = STORED) -> Iterator[str]:
    """Patterns of columns of bars and joints, ``{}`` for the number."""
    return (column for channel in channels if channel.of.numbered for column in channel.columns)


def numbered_part(column: str) -> tuple[str, int] | None:
    """Pattern and number of a column such as ``angle_3_rad``; None of one without a number between underscores."""
    found = NUMBER.search(column)
    return (f"{column[: found.start()]}_{{}}{column[found.end() :]}", int(found[1])) if found else None


def degree_column(column: str) -> str:
    """Column of the same quantity in degrees, or degrees a second: ``angle_1_deg``; one that is no angle as it is."""
    return re.sub("_rad(_s)?$", r"_deg\1", column)


def radian_column(column: str) -> str:
    """Column in rad or rad/s that a column in degrees stands for; any other as it is."""
    return re.sub("_deg(_s)?$", r"_rad\1", column)
