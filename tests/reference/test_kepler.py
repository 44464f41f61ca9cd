"""The closed-form two-body motion against the classical equations in long double, and against itself."""

import math

import numpy as np
import pytest

from adapters.common import kepler
from adapters.common.kepler import displacements, propagate

MU = 3.986004418e14  # m³/s²
R0 = 6.728e6  # m
EPS = np.finfo(float).eps
LONG = np.longdouble

SPEED_FACTORS = (0.3, 1.0, 1.35, math.sqrt(2.0), 1.6, 3.0)


def injection(speed_factor, longitude=0.4):
    """Position and horizontal velocity at R0."""
    u = np.array([math.cos(longitude), math.sin(longitude)])
    return R0 * u, speed_factor * math.sqrt(MU / R0) * np.array([-u[1], u[0]])


def classical(speed_factor, t):
    """Radial and horizontal coordinates at `t` of an orbit that starts at an apsis, in long double."""
    v2 = (LONG(speed_factor) ** 2) * LONG(MU) / LONG(R0)
    inverse_a = 2 / LONG(R0) - v2 / LONG(MU)
    e = LONG(R0) * v2 / LONG(MU) - 1  # negative where the start is the far apsis
    a = 1 / inverse_a
    mean = LONG(t) * np.sqrt(LONG(MU) / abs(a) ** 3)
    x = mean.copy() if inverse_a > 0 else np.arcsinh(mean / e)
    for _ in range(100):
        if inverse_a > 0:
            x = x - (x - e * np.sin(x) - mean) / (1 - e * np.cos(x))
        else:
            x = x - (e * np.sinh(x) - x - mean) / (e * np.cosh(x) - 1)
    b = abs(a) * np.sqrt(abs(1 - e * e))
    if inverse_a > 0:
        return np.stack([a * (np.cos(x) - e), b * np.sin(x)], axis=-1)
    return np.stack([a * (np.cosh(x) - e), b * np.sinh(x)], axis=-1)


def round_off(speed_factor, t):
    """Allowed position error: instants and places rounded, at the fastest, a few times over.

    Rounding of v0 moves the period by 3/2 (v²/2)/(mu/2a) eps, which is what grows with time.
    """
    v, period_factor = speed_factor * math.sqrt(MU / R0), 1.0
    if speed_factor**2 < 2.0:
        fastest = v if speed_factor >= 1.0 else math.sqrt(MU / R0) * (2.0 - speed_factor**2) / speed_factor
        period_factor += 1.5 * fastest**2 * R0 / (MU * (2.0 - speed_factor**2))
        v = fastest
    return 4.0 * EPS * (R0 + v * np.abs(t).max()) * period_factor


@pytest.mark.parametrize("speed_factor", [b for b in SPEED_FACTORS if abs(b * b - 2.0) > 1e-9])
def test_position_is_that_of_the_classical_equations_to_round_off(speed_factor):
    t = np.linspace(-6000.0, 12000.0, 301)
    start, velocity = injection(speed_factor)
    u = start / R0
    radial_across = classical(speed_factor, t)
    expected = radial_across[:, :1] * u + radial_across[:, 1:] * np.array([-u[1], u[0]])
    found, _ = propagate(MU, start, velocity, t)
    assert np.abs(found - expected).max() < round_off(speed_factor, t)


def test_parabola_obeys_barkers_equation():
    t = np.linspace(0.0, 1e5, 101)
    start, velocity = injection(math.sqrt(2.0), 0.0)
    found, _ = propagate(MU, start, velocity, t)
    tangent = found[:, 1] / (R0 + np.hypot(*found.T) - (R0 - found[:, 0]))  # y/(x + r) is tan(nu/2)
    barker = math.sqrt(2.0 * R0**3 / MU) * (tangent + tangent**3 / 3.0)
    # sqrt(2) is rounded: an energy off by eps mu/r0, which grows against mu/r as the distance does
    assert np.all(np.abs(barker - t) <= EPS * (20.0 + np.hypot(*found.T) / R0) * t)


@pytest.mark.parametrize("speed_factor", SPEED_FACTORS)
def test_energy_and_angular_momentum_are_kept(speed_factor):
    t = np.linspace(0.0, 9000.0, 200)
    start, velocity = injection(speed_factor)
    x, v = propagate(MU, start, velocity, t)
    r = np.hypot(*x.T)
    kinetic, potential = 0.5 * np.sum(v * v, axis=1), MU / r
    energy = kinetic - potential - (0.5 * velocity @ velocity - MU / R0)
    # places are sums of terms as large as the largest distance, and rounded by eps of it
    steepness = r.max() / r.min()
    assert np.all(np.abs(energy) < 20.0 * EPS * steepness * np.maximum(kinetic, potential))
    momentum = x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]
    expected = start[0] * velocity[1] - start[1] * velocity[0]
    assert np.all(np.abs(momentum - expected) < 20.0 * EPS * np.hypot(*v.T) * r.max())


@pytest.mark.parametrize("speed_factor", [0.9, 1.1, 1.6])
def test_two_legs_make_one(speed_factor):
    start, velocity = injection(speed_factor)
    middle, its_velocity = propagate(MU, start, velocity, np.array([700.0]))
    end, _ = propagate(MU, middle[0], its_velocity[0], np.array([800.0]))
    whole, _ = propagate(MU, start, velocity, np.array([1500.0]))
    assert np.abs(end - whole).max() < 4.0 * round_off(speed_factor, np.array([1500.0]))


def test_displacement_over_a_short_time_keeps_all_its_digits():
    start, velocity = injection(1.1, 0.0)
    t = np.array([1e-3])
    moved, _ = displacements(MU, start, velocity, t)
    along = velocity[1] * t * (1.0 - MU / R0**3 * t**2 / 6.0)
    assert np.abs(moved[:, 0] + 0.5 * MU / R0**2 * t**2) < 1e-12 * abs(moved[0, 0])
    assert np.abs(moved[:, 1] - along) < 4.0 * EPS * along


def test_vertical_fall_takes_the_closed_forms_time():
    start = np.array([R0, 0.0])
    end = 0.9 * R0
    x = end / R0
    t = math.sqrt(R0**3 / (2.0 * MU)) * (math.acos(math.sqrt(x)) + math.sqrt(x * (1.0 - x)))
    found, _ = propagate(MU, start, np.zeros(2), np.array([t]))
    assert found[0, 0] == pytest.approx(end, rel=8.0 * EPS)
    assert found[0, 1] == 0.0


@pytest.mark.parametrize("speed_factor", [0.7, 1.6])
def test_an_anomaly_that_has_not_converged_is_an_error(speed_factor, monkeypatch):
    monkeypatch.setattr(kepler, "MOST_ITERATIONS", 2)
    with pytest.raises(ArithmeticError, match="has not converged after 2 iterations"):
        propagate(MU, *injection(speed_factor), np.array([2000.0]))
