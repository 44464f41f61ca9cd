"""Names that users of orbits and mechanisms write, and what says the same in a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

PERIGEE = "periapsis_altitude_m is the height of the perigee"
APOGEE = "apoapsis_altitude_m is the height of the apogee"
AXIS = "semi_major_axis_m is the semi-major axis"
ANOMALY = "true_anomaly_deg or mean_anomaly_deg is the start's angle from the periapsis"
ARGUMENT = "argument_of_periapsis_deg is the longitude of the periapsis"
STATE = "position_m and velocity_m_s are the state in inertial axes"
SPEED = "speed_factor is the initial speed over the local circular speed, and velocity_m_s goes with position_m"
CLIMB = "flight_path_deg is the angle of the velocity above the horizontal, and velocity_m_s goes with position_m"
BARS = "bars is the number of bars"
RATES = "rate_factor holds the bars' rates over the orbital rate, rate_rad_s and rate_deg_s hold inertial ones"
JOINTS = "bars are rigid; [effects.joint_spring_damper] puts springs and dampers into the joints"
IDEAL = "joints have no friction and no stops; [effects.joint_spring_damper] puts springs and dampers into them"
ENDS = "duration_s counts from start_s"
STEPS = "the step belongs to an engine's setting, not to a scene"
USUAL_NAMES: dict[str, dict[str, str]] = {
    "orbit": {
        "e": "eccentricity is the eccentricity", "perigee": PERIGEE, "perigee_altitude": PERIGEE,
        "periapsis": PERIGEE, "apogee": APOGEE, "apogee_altitude": APOGEE, "apoapsis": APOGEE,
        "a": AXIS, "semi_major_axis": AXIS, "sma": AXIS, "radius": "altitude_m is the height above the body's surface",
        "x": STATE, "y": STATE, "vx": STATE, "vy": STATE, "position": STATE, "velocity": STATE,
        "speed": SPEED, "radial_velocity": CLIMB, "flight_path_angle": CLIMB, "inclination": "the motion is planar",
        "nu": ANOMALY, "true_anomaly": ANOMALY, "mean_anomaly": ANOMALY, "anomaly": ANOMALY,
        "argument_of_perigee": ARGUMENT, "omega": ARGUMENT, "argument_of_periapsis": ARGUMENT,
    },
    "chain": {
        "n": BARS, "number": BARS, "links": BARS, "n_bars": BARS, "num_bars": BARS, "rate": RATES, "rates": RATES,
        "omega": RATES, "angular_velocity": RATES, "stiffness": JOINTS, "damping": JOINTS,
    },
    "effects": dict.fromkeys(("joint_stop", "joint_stops", "joint_friction", "joint_limit", "friction"), IDEAL),
    "effects.joint_spring_damper": dict.fromkeys(("friction", "stop", "stops"), IDEAL),
    "effects.thrust": {"stop": ENDS, "end": ENDS, "until": ENDS},
    "run": {"dt": STEPS, "step": STEPS, "time_step": STEPS, "timestep": STEPS},
}  # fmt: skip
"""By table, and by the name without its unit in lower case"""
UNITS = ("_rad_s", "_deg_s", "_m_s", "_km_s", "_n_m", "_deg", "_rad", "_km", "_m", "_s")


def usual_name(loc: Sequence[int | str]) -> str | None:
    """What says the same as the unknown key at `loc`; None for a name that is not usual either."""
    *table, key = (part for part in loc if isinstance(part, str))
    plain = key.lower()
    unit = next((unit for unit in UNITS if plain.endswith(unit)), "")
    return USUAL_NAMES.get(".".join(table), {}).get(plain.removesuffix(unit))
