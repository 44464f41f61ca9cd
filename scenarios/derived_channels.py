"""The table of derived channels: what is computed on request of a stored trajectory and its scene.

Nothing stores or judges them. Their functions, of the same names, are in :mod:`barchain.metrics.derived`.
"""

from __future__ import annotations

from scenarios.channels import STORED, Channel, Of, numbered_part

XY = ("x", "y")
RADIAL = ("radial", "transverse")
"""Axes of the local vertical frame: away from the body's centre, and turned by +90° from there"""


def of_bars(stem: str, parts: tuple[str, ...]) -> tuple[str, ...]:
    """Stems of the components of something that is numbered."""
    return tuple(f"{stem}_{{}}_{part}" for part in parts)


def of_ends(stem: str, parts: tuple[str, ...]) -> tuple[str, ...]:
    """Stems of the components at both free ends of the chain."""
    return tuple(f"{stem}_{end}_{part}" for end in ("first", "last") for part in parts)


FREE_ENDS = "Left end of bar 1 and right end of bar N"
DERIVED = (
    Channel(
        "joint_angle", "rad", "joint angles", "Angle of bar j+1 minus that of bar j, at joint j.",
        Of.JOINTS, ("joint_angle_{}",), title="Joint angles",
    ),
    Channel(
        "joint_rate", "rad/s", "joint rates", "Rate of bar j+1 minus that of bar j, at joint j.",
        Of.JOINTS, ("joint_rate_{}",), title="Joint rates",
    ),
    Channel(
        "vertical_angle", "rad", "angles from the local vertical", "Angle of each bar from the direction of the centre "
        "of mass, seen from the body's centre; counter-clockwise, not wrapped.", Of.BARS, ("vertical_angle_{}",),
    ),
    Channel(
        "bar_position", "m", "positions of the bars", "Centre of each bar from the body's centre, in inertial axes.",
        Of.BARS, of_bars("bar_position", XY),
    ),
    Channel(
        "joint_position", "m", "positions of the joints", "Right end of bar j from the body's centre, in inertial "
        "axes.",
        Of.JOINTS, of_bars("joint_position", XY),
    ),
    Channel(
        "end_position", "m", "positions of the free ends", f"{FREE_ENDS} from the body's centre, in inertial axes.",
        Of.CHAIN, of_ends("end_position", XY),
    ),
    Channel(
        "bar_from_com", "m", "positions of the bars about the centre of mass", "Centre of each bar from the centre of "
        "mass, in inertial axes.", Of.BARS, of_bars("bar_from_com", XY),
    ),
    Channel(
        "joint_from_com", "m", "positions of the joints about the centre of mass", "Right end of bar j from the centre "
        "of mass, in inertial axes.", Of.JOINTS, of_bars("joint_from_com", XY),
    ),
    Channel(
        "end_from_com", "m", "positions of the free ends about the centre of mass", f"{FREE_ENDS} from the centre of "
        "mass, in inertial axes.", Of.CHAIN, of_ends("end_from_com", XY),
    ),
    Channel(
        "bar_local", "m", "positions of the bars in the local vertical frame", "Centre of each bar from the centre of "
        "mass, along the local vertical and 90° ahead of it.", Of.BARS, of_bars("bar_local", RADIAL),
    ),
    Channel(
        "joint_local", "m", "positions of the joints in the local vertical frame", "Right end of bar j from the centre "
        "of mass, along the local vertical and 90° ahead of it.", Of.JOINTS, of_bars("joint_local", RADIAL),
    ),
    Channel(
        "end_local", "m", "positions of the free ends in the local vertical frame", f"{FREE_ENDS} from the centre of "
        "mass, along the local vertical and 90° ahead of it.", Of.CHAIN, of_ends("end_local", RADIAL),
    ),
    Channel(
        "tension", "N", "tension at the ends of the bars", "Reaction on the part before a cut from the part behind it, "
        "at each end of a bar, along the bar: positive if the bar is pulled.", Of.BARS,
        of_bars("tension", ("left", "right")),
    ),
    Channel(
        "shear", "N", "shear at the ends of the bars", "The same reaction across the bar: positive along its direction "
        "turned by +90°.", Of.BARS, of_bars("shear", ("left", "right")),
    ),
    Channel(
        "joint_torque", "N m", "torques in the joints", "Torque of spring, damper and motor of `joint_torque` on bar j "
        "from bar j+1.", Of.JOINTS, ("joint_torque_{}",), effects=("joint_spring_damper", "joint_torque"),
    ),
    Channel(
        "joint_power", "W", "powers in the joints", "Power of that torque into the bars: negative where it takes "
        "energy from the motion.", Of.JOINTS, ("joint_power_{}",), effects=("joint_spring_damper", "joint_torque"),
    ),
    Channel(
        "torque_power", "W", "powers of the torques", "Power of the torque of bar b's prescribed rotation: of a motor "
        "in a joint on both of its bars.", Of.LAWS, ("torque_power_bar_{}",), effects=("prescribed_rotation",),
    ),
    Channel(
        "effect_force", "N", "forces of effects", "Force of each effect on each bar, gravity among them, in inertial "
        "axes; the effect's name stands in place of `effect`.", Of.BARS, of_bars("effect_force", XY),
    ),
    Channel(
        "effect_torque", "N m", "torques of effects", "Torque of each effect about each bar's centre; without "
        "prescribed rotations, whose torques are stored.", Of.BARS, ("effect_torque_{}",),
    ),
    Channel(
        "spin_momentum", "N m s", "angular momentum about the centre of mass", "Angular momentum of the chain about "
        "its centre of mass.", Of.CHAIN, ("spin_momentum",),
    ),
    Channel(
        "kinetic_energy", "J", "kinetic energy about the centre of mass", "Kinetic energy of the motion relative to "
        "the centre of mass.", Of.CHAIN, ("kinetic_energy",),
    ),
    Channel(
        "gravity_energy", "J", "potential energy of gravity about the centre of mass", "Potential energy of the bars "
        "in the body's gravity, less that of the whole mass at the centre of mass; the torque of `gradient` gravity "
        "has none.", Of.CHAIN, ("gravity_energy",),
    ),
    Channel(
        "total_energy", "J", "energy about the centre of mass", "Kinetic energy about the centre of mass, potential "
        "energy of gravity about it, and energy of the springs.", Of.CHAIN, ("total_energy",),
    ),
    Channel(
        "altitude", "m", "altitude", "Distance of the centre of mass from the body's centre, less its radius.",
        Of.CHAIN, ("altitude",),
    ),
    Channel(
        "semi_major_axis", "m", "semi-major axis", "Of the osculating orbit of the centre of mass; negative of a "
        "hyperbola.", Of.CHAIN, ("semi_major_axis",),
    ),
    Channel(
        "eccentricity", "1", "eccentricity", "Of the osculating orbit of the centre of mass.",
        Of.CHAIN, ("eccentricity",),
    ),
    Channel(
        "periapsis", "rad", "longitude of the periapsis", "Of the osculating orbit of the centre of mass, from the z1 "
        "axis, between -π and π.", Of.CHAIN, ("periapsis",),
    ),
    Channel(
        "true_anomaly", "rad", "true anomaly", "Of the osculating orbit of the centre of mass, from the periapsis in "
        "the direction of the motion, from 0 to 2π.", Of.CHAIN, ("true_anomaly",),
    ),
)  # fmt: skip
DERIVED_CHANNELS = {channel.name: channel for channel in DERIVED}
"""Every derived channel by its name"""


EFFECT_COLUMNS = {
    column.removeprefix("effect"): channel
    for channel in DERIVED for column in channel.columns if column.startswith("effect_")
}  # fmt: skip
"""Channels by the ends of their columns' names, which begin with that of an effect"""


def channel_of(name: str) -> Channel | None:
    """Channel, stored or derived, of this name or with a column of this name; None if there is none.

    In columns of ``effect_force`` and ``effect_torque`` an effect's name stands in place of `effect`.
    """
    pattern = (numbered_part(name) or (name,))[0]
    found = next((c for c in (*STORED, *DERIVED) if name == c.name or pattern in c.columns), None)
    return found or next((c for end, c in EFFECT_COLUMNS.items() if pattern.endswith(end)), None)
