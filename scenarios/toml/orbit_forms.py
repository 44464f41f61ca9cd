"""Forms of the start of the centre of mass: by altitude and speed factor, by a state, or by elements."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

from scenarios.orbits import orbit_of_elements, orbit_of_state, true_anomaly_rad
from scenarios.scene import Orbit
from scenarios.size_limits import MOST_MAGNITUDE

if TYPE_CHECKING:
    from scenarios.scene import CentralBody
    from scenarios.toml.scene_tables import OrbitTable


def orbit_of(table: OrbitTable, body: CentralBody) -> Orbit:
    """Start of the centre of mass of a checked table.

    Angles that follow from a state or an anomaly are moved in their last digit to numbers of degrees, so that a file
    with the injection holds the same start.

    Raises
    ------
    ValueError
        If there is no such orbit, it is clockwise, or starts below the surface; without the table's name.
    """
    if table.altitude_m is not None:
        return Orbit(
            table.altitude_m, table.speed_factor, math.radians(table.longitude_deg), math.radians(table.flight_path_deg)
        )
    if table.position_m is not None and table.velocity_m_s is not None:
        if not any(table.position_m):
            raise ValueError("position_m is the centre of the body, allowed: outside the body")
        found = orbit_of_state(body, complex(*table.position_m), complex(*table.velocity_m_s))
        if abs(found.flight_path_rad) > 0.5 * math.pi:
            raise ValueError(
                "position_m and velocity_m_s move clockwise about the centre, allowed: counter-clockwise, or along the "
                "radius; the mirrored start (z2 and angles with the other sign) has the mirrored motion"
            )
    else:
        found = orbit_of_shape(table, body)
    if max(found.altitude_m, found.speed_factor) > MOST_MAGNITUDE:
        raise ValueError("the start is farther or faster than 1e+30, allowed: up to it")
    if found.altitude_m <= 0.0:
        raise ValueError(f"the start is {-found.altitude_m:g} m below the surface, allowed: above it")
    longitude, path = (math.radians(math.degrees(angle)) for angle in (found.longitude_rad, found.flight_path_rad))
    return dataclasses.replace(found, longitude_rad=longitude, flight_path_rad=path)


def orbit_of_shape(table: OrbitTable, body: CentralBody) -> Orbit:
    """Start on an orbit whose table gives two of its sizes, and an anomaly."""
    periapsis_m, eccentricity = shape_of(table, body)
    anomaly = math.radians(table.true_anomaly_deg or 0.0)
    if table.mean_anomaly_deg is not None:
        if eccentricity >= 1.0:
            raise ValueError(f"eccentricity {eccentricity:g} with mean_anomaly_deg, allowed: true_anomaly_deg")
        anomaly = true_anomaly_rad(eccentricity, math.radians(table.mean_anomaly_deg))
    try:
        argument = math.radians(table.argument_of_periapsis_deg)
        return orbit_of_elements(body, periapsis_m, eccentricity, argument, anomaly)
    except ValueError as error:
        raise ValueError(f"true_anomaly_deg: {table.true_anomaly_deg:g} given, {error}") from None


def shape_of(table: OrbitTable, body: CentralBody) -> tuple[float, float]:
    """Distance of the periapsis from the centre of the body, m, and eccentricity; two of four sizes are given."""
    axis, eccentricity = table.semi_major_axis_m, table.eccentricity
    apsides = (table.periapsis_altitude_m, table.apoapsis_altitude_m)
    low, high = (None if height is None else body.radius_m + height for height in apsides)
    if eccentricity is not None and eccentricity >= 1.0 and low is None:
        raise ValueError(f"eccentricity {eccentricity:g} given, allowed below 1, or from 1 with periapsis_altitude_m")
    if eccentricity is None:
        if axis is not None:
            low = 2.0 * axis - high if low is None and high is not None else low
            high = 2.0 * axis - low if low is not None else None
        assert low is not None
        assert high is not None
        eccentricity = (high - low) / (high + low)
    elif axis is not None:
        low = axis * (1.0 - eccentricity)
    elif high is not None:
        low = high * (1.0 - eccentricity) / (1.0 + eccentricity)
    assert low is not None
    if low <= 0.0 or eccentricity < 0.0:
        raise ValueError(
            f"the periapsis is {low:g} m from the centre of the body and the eccentricity is {eccentricity:g}, "
            "allowed: a positive distance, at most that of the apoapsis"
        )
    return low, eccentricity
