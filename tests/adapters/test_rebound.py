"""REBOUND's track of the centre of mass: against Kepler, and its lawful difference from a chain's."""

import math

import numpy as np
import pytest

from adapters.common.kepler import propagate
from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.rebound.adapter import Rebound
from scenarios import Gravity, load_scene
from tests.support.changed import lasting, on_orbit, under, with_chain
from tests.support.generic_scenes import solution
from tests.support.slow import one_in

EPS = np.finfo(float).eps


def particle(speed_factor, *, samples=201, orbits=2.0, duration_s=None, gravity=Gravity.POINT):
    """One point-like bar injected with `speed_factor`."""
    scene = under(load_scene("basics/kepler_circular"), gravity=gravity)
    scene = on_orbit(scene, speed_factor=speed_factor, longitude_rad=0.7)
    return lasting(scene, duration_s or orbits * scene.period_s, samples)


def chain(angle_deg, length_m, samples=3):
    """Five equal bars turning with the circular orbit they are on, for one orbit."""
    scene = load_scene("paper/fig05")
    changed = with_chain(
        scene,
        angle_rad=(math.radians(angle_deg),) * 5,
        length_m=(length_m,) * 5,
        inertia_kg_m2=(100.0 * length_m**2 / 12.0,) * 5,
    )
    return lasting(changed, scene.period_s, samples)


def kepler(scene):
    u = np.array([math.cos(0.7), math.sin(0.7)])
    return propagate(
        scene.central_body.mu_m3_s2,
        scene.radius0_m * u,
        scene.speed0_m_s * np.array([-u[1], u[0]]),
        scene.times_s,
    )


def round_off(scene):
    """Position error by rounding: an energy off by eps of the largest kinetic one shifts the phase."""
    v = scene.speed0_m_s
    binding = abs(scene.central_body.mu_m3_s2 / scene.radius0_m - 0.5 * v * v)
    phase_s = 1.5 * scene.run.duration_s * EPS * (0.5 * v * v / binding if scene.bound else 1.0)
    return 6.0 * (v * phase_s + EPS * v * scene.run.duration_s)


@pytest.mark.parametrize("rtol", one_in(5, Rebound.sweep.values))
@pytest.mark.parametrize("speed_factor", [1.0, 1.1, 1.2, 1.35, math.sqrt(2.0), 1.6])
def test_every_setting_keeps_its_promise_on_every_conic(speed_factor, rtol):
    scene = particle(speed_factor)
    found = Rebound().run(scene, Setting(AccuracyParameter.RTOL, rtol))
    place, _ = kepler(scene)
    assert np.abs(found.com_m - place).max() < rtol * scene.radius0_m + round_off(scene)
    assert found.info["integrator"] == ("whfast" if rtol > 3e-7 else "ias15")


def test_many_samples_cost_no_accuracy():
    scene = particle(1.0, samples=2001)
    place, velocity = kepler(scene)
    found = Rebound().run(scene)
    assert np.abs(found.com_m - place).max() < round_off(scene)
    rate = scene.speed0_m_s / scene.radius0_m
    assert np.abs(found.com_velocity_m_s - velocity).max() < rate * round_off(scene)
    assert found.info["steps"] < 100  # its own steps, not the samples'


def test_without_gravity_the_particle_moves_uniformly():
    scene = particle(1.0, duration_s=2000.0, gravity=Gravity.NONE)
    found = Rebound().run(scene)
    straight = found.com_m[0] + scene.times_s[:, None] * found.com_velocity_m_s[0]
    assert np.abs(found.com_m - straight).max() < 20.0 * EPS * np.hypot(*straight[-1])


@pytest.mark.parametrize("rtol", [1e-6, 1e-12])
def test_vertical_fall_ends_at_the_surface_at_the_closed_forms_instant(rtol):
    scene = particle(0.0, duration_s=600.0, samples=31)
    x = scene.central_body.radius_m / scene.radius0_m
    fall = math.sqrt(scene.radius0_m**3 / (2.0 * scene.central_body.mu_m3_s2))
    expected = fall * (math.acos(math.sqrt(x)) + math.sqrt(x * (1.0 - x)))
    found = Rebound().run(scene, Setting(AccuracyParameter.RTOL, rtol))
    assert "reached the surface" in found.ended
    assert float(found.ended.split()[-2]) == pytest.approx(expected, abs=1e-6)  # it prints six decimals
    assert found.t_s[-1] <= expected < found.t_s[-1] + 20.0


@pytest.mark.parametrize("samples", [2, 301])
def test_a_dip_below_the_surface_is_found_between_samples(samples):
    scene = particle(0.985, orbits=1.0, samples=samples)
    lowest = scene.radius0_m * 0.985**2 / (2.0 - 0.985**2)
    assert lowest < scene.central_body.radius_m
    found = Rebound().run(scene)
    assert "reached the surface" in found.ended
    assert len(found.t_s) < samples


def test_a_state_that_is_not_a_number_is_given_up_and_does_not_hang():
    engine = Rebound()
    engine.build(particle(1.0), Rebound.sweep.setting())
    engine.track.particles[1].vx = math.nan
    with pytest.raises(EngineError, match="state is not finite"):
        engine.simulate()


def test_chains_centre_of_mass_leaves_kepler_by_12_pi_as_the_square_of_its_length():
    lengths = np.array([20.0, 50.0, 100.0, 200.0, 400.0])
    distance = np.array([difference(chain(0.0, length)) for length in lengths])
    exponent = np.polyfit(np.log(lengths), np.log(distance), 1)[0]
    assert exponent == pytest.approx(2.0, abs=0.02)
    r = 6.728e6
    law = 12.0 * math.pi * r * (lengths / r) ** 2
    # beyond the small-l limit the unstable chain leaves the horizontal, an angle of exp(2 pi sqrt 3) l/r
    leaves = math.exp(2.0 * math.pi * math.sqrt(3.0)) * lengths / r
    own = 1e-12 * r  # the reference's own error, measured 2.6e-6 m at rtol = 1e-13
    assert np.all(np.abs(distance - law) < law * leaves**2 + own)
    assert distance[2] == pytest.approx(0.05600, abs=2e-5)


@pytest.mark.parametrize(("angle_deg", "factor"), [(80.0, 72.4207), (-80.0, 74.9627)])
def test_steep_chains_differ_by_their_own_factor(angle_deg, factor):
    r, length = 6.728e6, 100.0
    own = 1e-12 * r / (r * (length / r) ** 2)
    assert difference(chain(angle_deg, length)) / (r * (length / r) ** 2) == pytest.approx(factor, abs=own)


def difference(scene):
    """Distance at the end between the chain's centre of mass and REBOUND's particle, m."""
    return float(np.hypot(*(solution(scene).com_m[-1] - Rebound().run(scene).com_m[-1])))


def test_prescribed_rotations_do_not_stand_in_the_way_of_a_track():
    assert Rebound.unsupported(load_scene("paper/fig17")) is None
    assert Rebound().run(particle(1.1, samples=5)).angle_rad is None


def test_a_chain_that_passes_lower_than_it_is_long_is_none_of_a_particles_business():
    """It ends where a bar touches; higher up, and where the particle itself comes down, there is no doubt."""
    assert "the bars' attitude decides" in str(Rebound.unsupported(load_scene("hard/grazing_touch")))
    for name in ("hard/vertical_fall", "hard/perigee_099", "paper/fig05"):
        assert Rebound.unsupported(load_scene(name)) is None
