"""Plain words and units of keys whose names end with their unit: ``altitude_m`` is an altitude in m."""

from __future__ import annotations

UNITS = {
    "_kg_m3": "kg/m³",
    "_kg_m2": "kg m²",
    "_kg": "kg",
    "_N_m_s_rad": "N m s/rad",
    "_N_m_rad": "N m/rad",
    "_rad_s": "rad/s",
    "_deg_s": "deg/s",
    "_m3_s2": "m³/s²",
    "_m_s": "m/s",
    "_Pa": "Pa",
    "_N_s": "N s",
    "_N_m": "N m",
    "_deg": "degrees",
    "_rad": "rad",
    "_N": "N",
    "_m": "m",
    "_s": "s",
}
"""Unit by the end of a key's name; the first that fits counts"""

WORDS = {
    "mu_m3_s2": "gravitational parameter",
    "speed_factor": "speed over the local circular speed (beta)",
    "rate_factor": "rates over v0/r0 (alpha)",
    "flight_path_deg": "velocity above the horizontal",
    "mass_kg": "masses",
    "length_m": "lengths",
    "inertia_kg_m2": "moments of inertia",
    "angle_deg": "angles",
    "angle_from": "angles count from the local horizontal of the",
    "longitude_deg": "longitude from the z1 axis",
    "j2": "zonal coefficient J2",
    "at_s": "instant",
    "times_s": "instants",
    "start_s": "start",
    "end": "end of the bar",
    "axes": "axes of the direction",
    "rest_deg": "angle at rest",
    "orbit_period_s": "period of the orbit",
    "lowest_height_m": "lowest height of the orbit",
    "duration_orbits": "duration in periods",
    "engines": "engine",
    "conserves": "conserved quantities",
}
"""Words for keys whose name alone does not tell them"""


def unit(key: str) -> str:
    """Unit that a key's name ends with; empty if there is none."""
    return next((said for end, said in UNITS.items() if key.endswith(end)), "")


def in_words(key: str) -> str:
    """Key in plain words, without its unit."""
    if key in WORDS:
        return WORDS[key]
    end = next((end for end in UNITS if key.endswith(end)), "")
    return key.removesuffix(end).replace("_", " ")


def labelled(key: str) -> str:
    """``altitude, m``: words and unit of a key."""
    return ", ".join(filter(None, [in_words(key), unit(key)]))
