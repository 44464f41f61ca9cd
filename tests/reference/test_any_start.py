"""A start that is no apsis: the motion of Kepler's equation in the reference and in heyoka, and its scales."""

import math
from typing import Any

import numpy as np
import pytest

from adapters.common.kepler import propagate
from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from adapters.trajectory import Trajectory
from reports.notebook.scene import osculating
from scenarios import Scene, make_scene
from tests.support.effect_cases import vectors

RTOL = 1e-12
MU = 3.986004418e14
AXIS_M, ECCENTRICITY, ARGUMENT_DEG = 1e7, 0.3, 40.0


def one_bar(orbit: dict[str, Any], gravity: str = "point", **run: Any) -> Scene:
    """Bar whose centre of mass moves as a particle."""
    chain = {"bars": 1, "mass_kg": 10.0, "length_m": 10.0, "rate_rad_s": 2e-3}
    tables = {"title": "t", "source": "s", "orbit": orbit, "chain": chain, "effects": {"gravity": gravity}}
    return make_scene(tables | {"run": {"orbits": 1.0, "samples": 101} | run})


ELEMENTS = {"semi_major_axis_m": AXIS_M, "eccentricity": ECCENTRICITY, "argument_of_periapsis_deg": ARGUMENT_DEG}


def run(engine: str, scene: Scene) -> Trajectory:
    """Run of an engine at the requested accuracy."""
    if ENGINES[engine].missing:
        pytest.skip(f"{engine} is not installed")
    return ENGINES[engine].load()().run(scene, Setting(AccuracyParameter.RTOL, RTOL))


@pytest.mark.parametrize("engine", ["reference", "reference-fast", "reference-absolute", "heyoka"])
def test_a_start_at_a_true_anomaly_of_100_degrees_moves_by_keplers_equation(engine: str) -> None:
    """An orbit multiplies an error along the track by 6 pi and (1 + e)/(1 - e); a run has some 100 steps."""
    seen = run(engine, one_bar(ELEMENTS | {"true_anomaly_deg": 100.0}))
    anomaly, argument, e = math.radians(100.0), math.radians(ARGUMENT_DEG), ECCENTRICITY
    start = AXIS_M * (1.0 - e * e) / (1.0 + e * math.cos(anomaly)) * np.exp(1j * (anomaly + argument))
    drift = (
        math.sqrt(MU / AXIS_M / (1.0 - e * e)) * 1j * (np.exp(1j * (anomaly + argument)) + e * np.exp(1j * argument))
    )
    place, velocity = propagate(MU, vectors(start), vectors(drift), seen.t_s)
    grown = 100.0 * 6.0 * math.pi * (1.0 + ECCENTRICITY) / (1.0 - ECCENTRICITY) * RTOL
    assert np.abs(seen.com_m - place).max() <= grown * AXIS_M
    assert np.abs(seen.com_velocity_m_s - velocity).max() <= grown * math.sqrt(MU / AXIS_M)
    np.testing.assert_allclose(seen.rate_rad_s, 2e-3, rtol=1e-12)


@pytest.mark.parametrize("path_deg", [-60.0, 60.0])
def test_without_gravity_any_start_moves_on_a_straight_line(path_deg: float) -> None:
    scene = one_bar({"altitude_m": 8e6, "flight_path_deg": path_deg}, "none", orbits=None, duration_s=1000.0)
    seen = run("reference", scene)
    line = seen.com_m[0] + seen.t_s[:, None] * seen.com_velocity_m_s[0]
    np.testing.assert_allclose(seen.com_m, line, rtol=1e-14)
    upward = float(seen.com_m[0] @ seen.com_velocity_m_s[0]) / scene.radius0_m
    assert upward == pytest.approx(scene.speed0_m_s * math.sin(math.radians(path_deg)))
    assert np.linalg.norm(line, axis=1).min() >= scene.lowest_radius_m * (1.0 - 1e-15)


@pytest.mark.parametrize("orbit", [
    ELEMENTS | {"true_anomaly_deg": 240.0},
    {"periapsis_altitude_m": 1e6, "eccentricity": 1.4, "true_anomaly_deg": -80.0},
    {"altitude_m": 8e6, "speed_factor": 0.5, "flight_path_deg": 90.0},
])  # fmt: skip
def test_the_drawn_path_is_that_of_the_motion(orbit: dict[str, Any]) -> None:
    scene = one_bar(orbit, orbits=None, duration_s=1500.0)
    seen, path = run("reference", scene), osculating(scene)
    apart = np.linalg.norm(seen.com_m[:, None] - path[None], axis=2).min(axis=1)
    between = np.linalg.norm(np.diff(path, axis=0), axis=1).max()
    inside = np.linalg.norm(seen.com_m, axis=1) <= np.linalg.norm(path, axis=1).max()
    assert inside[0]
    assert np.all(apart[inside] <= between)
