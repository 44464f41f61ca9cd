"""Starts of the centre of mass from a state, or from Keplerian elements; the same for every form of a scene's orbit."""

from __future__ import annotations

import cmath
import math
from typing import TYPE_CHECKING

from scenarios.scene import Orbit

if TYPE_CHECKING:
    from scenarios.scene import CentralBody

MOST_ITERATIONS = 100  # bisection alone needs 60 for the last bit
CONVERGED_RAD = 4e-16


def orbit_of_state(body: CentralBody, position_m: complex, velocity_m_s: complex) -> Orbit:
    """Start from a position and a velocity in inertial axes, z1 + i z2.

    Parameters
    ----------
    body : CentralBody
    position_m : complex
        From the centre of the body, m.
    velocity_m_s : complex
        m/s.

    Returns
    -------
    Orbit
        Its altitude is negative below the surface, and its flight path leaves (-pi/2, pi/2) if the motion is clockwise.
    """
    radius_m = abs(position_m)
    speed_factor = abs(velocity_m_s) / math.sqrt(body.mu_m3_s2 / radius_m)
    along = velocity_m_s * position_m.conjugate()  # radial and horizontal parts, times the radius
    flight_path = cmath.phase(complex(along.imag, along.real)) if along else 0.0
    return Orbit(radius_m - body.radius_m, speed_factor, cmath.phase(position_m), flight_path)


def orbit_of_elements(
    body: CentralBody, periapsis_m: float, eccentricity: float, argument_rad: float, true_anomaly_rad: float
) -> Orbit:
    """Start on an orbit of given elements.

    With nu the true anomaly and lengths in units of the semi-latus rectum p, the radius is 1/(1 + e cos nu) and the
    velocity in units of sqrt(mu/p) is e sin nu along it and 1 + e cos nu across.

    Parameters
    ----------
    body : CentralBody
    periapsis_m : float
        Distance of the periapsis from the centre of the body, m.
    eccentricity : float
        Of any conic.
    argument_rad : float
        Longitude of the periapsis from the z1 axis, rad.
    true_anomaly_rad : float
        Angle of the start from the periapsis, rad.

    Returns
    -------
    Orbit

    Raises
    ------
    ValueError
        If an open orbit does not reach the anomaly.
    """
    across = 1.0 + eccentricity * math.cos(true_anomaly_rad)
    along = eccentricity * math.sin(true_anomaly_rad)
    if across <= 0.0:
        most = math.degrees(math.acos(-1.0 / eccentricity))
        raise ValueError(
            f"an orbit of eccentricity {eccentricity:g} does not reach it; allowed: within {most:.6g} degrees"
        )
    radius_m = periapsis_m * (1.0 + eccentricity) / across
    longitude = math.remainder(argument_rad + true_anomaly_rad, 2.0 * math.pi)
    speed_factor = math.hypot(across, along) / math.sqrt(across)
    return Orbit(radius_m - body.radius_m, speed_factor, longitude, math.atan2(along, across))


def true_anomaly_rad(eccentricity: float, mean_anomaly_rad: float) -> float:
    """True anomaly of an ellipse from the mean one, rad, by Newton's method on Kepler's equation M = E - e sin E.

    From E = pi, or from M + e where that is nearer, every step of Newton's method falls towards the solution.
    """
    mean = math.remainder(mean_anomaly_rad, 2.0 * math.pi)
    sign, mean = math.copysign(1.0, mean), abs(mean)
    eccentric = min(math.pi, mean + eccentricity)
    for _ in range(MOST_ITERATIONS):
        step = (eccentric - eccentricity * math.sin(eccentric) - mean) / (1.0 - eccentricity * math.cos(eccentric))
        eccentric -= step
        if abs(step) <= CONVERGED_RAD * eccentric:
            break
    half = 0.5 * eccentric
    high, low = math.sqrt(1.0 + eccentricity) * math.sin(half), math.sqrt(1.0 - eccentricity) * math.cos(half)
    return sign * 2.0 * math.atan2(high, low)
