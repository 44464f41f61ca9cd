"""Names that users of orbits and mechanisms write, and what says the same in a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

ECCENTRICITY = "speed_factor = sqrt(1 + e) starts at the perigee of an orbit with the eccentricity e"
PERIGEE = "altitude_m is that of the start, which is the perigee if speed_factor is above 1"
APOGEE = "from a perigee, speed_factor = sqrt(2 r_a/(r_a + r_p)) reaches it"
AXIS = "it follows from the start: a = r_0/(2 - speed_factor^2)"
SPEED = "speed_factor is the initial speed over the local circular speed"
BARS = "bars is the number of bars"
RATES = "rate_factor holds the bars' rates over the orbital rate"
JOINTS = "bars are rigid; [effects.joint_spring_damper] puts springs and dampers into the joints"
ENDS = "duration_s counts from start_s"
STEPS = "the step belongs to an engine's setting, not to a scene"
USUAL_NAMES: dict[str, dict[str, str]] = {
    "orbit": {
        "eccentricity": ECCENTRICITY, "ecc": ECCENTRICITY, "perigee": PERIGEE, "perigee_altitude": PERIGEE,
        "periapsis": PERIGEE, "apogee": APOGEE, "apogee_altitude": APOGEE, "apoapsis": APOGEE,
        "semi_major_axis": AXIS, "sma": AXIS, "radius": "altitude_m is the height above the body's surface",
        "velocity": SPEED, "speed": SPEED, "inclination": "the motion is planar",
        "true_anomaly": "an orbit starts at its perigee or apogee; longitude_deg turns it",
    },
    "chain": {
        "n": BARS, "number": BARS, "links": BARS, "n_bars": BARS, "num_bars": BARS, "rate": RATES, "rates": RATES,
        "omega": RATES, "angular_velocity": RATES, "stiffness": JOINTS, "damping": JOINTS,
    },
    "effects.thrust": {"stop": ENDS, "end": ENDS, "until": ENDS},
    "run": {"dt": STEPS, "step": STEPS, "time_step": STEPS, "timestep": STEPS},
}  # fmt: skip
"""By table, and by the name without its unit in lower case"""
UNITS = ("_rad_s", "_deg_s", "_m_s", "_km_s", "_deg", "_rad", "_km", "_m", "_s")


def usual_name(loc: Sequence[int | str]) -> str | None:
    """What says the same as the unknown key at `loc`; None for a name that is not usual either."""
    *table, key = (part for part in loc if isinstance(part, str))
    plain = key.lower()
    unit = next((unit for unit in UNITS if plain.endswith(unit)), "")
    return USUAL_NAMES.get(".".join(table), {}).get(plain.removesuffix(unit))
