"""Track of an orbit whose elements drift at the mean rates of the oblateness, as an analytical propagator gives it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.initial_state import initial_state
from adapters.trajectory import Trajectory
from reference_impl.model.complex_vectors import as_vectors

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from scenarios import Scene

KEPLER_ROUNDS = 30
"""Rounds of Newton's method in Kepler's equation"""


def by_mean_elements(scene: Scene, _: Array, t_s: Array) -> Trajectory | None:
    """Track at instants (n,) s from the osculating elements of the start, taken as mean ones.

    With k = 3/2 J2 (R/p)^2 and an orbit in the equator's plane, the longitude of the pericentre drifts at k n, and the
    mean anomaly grows at n (1 + k sqrt(1 - e^2)). None of an orbit that is no ellipse, or clockwise.
    """
    oblate, mu, start = scene.effects.oblateness, scene.central_body.mu_m3_s2, initial_state(scene)
    place, velocity = complex(*start.com_m), complex(*start.com_velocity_m_s)
    spin = (place.conjugate() * velocity).imag
    if oblate is None or not scene.bound or spin <= 0.0:
        return None
    axis = 1.0 / (2.0 / abs(place) - abs(velocity) ** 2 / mu)
    pericentre = -1j * velocity * spin / mu - place / abs(place)
    e = abs(pericentre)
    turned = pericentre / e if e else place / abs(place)
    own = place / turned  # from the pericentre
    root = math.sqrt(1.0 - e**2)
    eccentric = math.atan2(own.imag / root, own.real + axis * e)
    n = math.sqrt(mu / axis**3)
    k = 1.5 * oblate.j2 * (oblate.radius_m / (axis * root**2)) ** 2
    mean = eccentric - e * math.sin(eccentric) + n * (1.0 + k * root) * t_s
    angle = mean.copy()
    for _round in range(KEPLER_ROUNDS):
        angle -= (angle - e * np.sin(angle) - mean) / (1.0 - e * np.cos(angle))
    frame = turned * np.exp(1j * k * n * t_s)
    at = axis * (np.cos(angle) - e + 1j * root * np.sin(angle)) * frame
    rate = n / (1.0 - e * np.cos(angle))
    speed = axis * rate * (-np.sin(angle) + 1j * root * np.cos(angle)) * frame
    return Trajectory(t_s, com_m=as_vectors(at), com_velocity_m_s=as_vectors(speed))
