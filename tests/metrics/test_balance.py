"""Balance about the centre of mass: what gravity does is explained, and what nothing does is seen."""

import dataclasses

import pytest

from adapters.trajectory import Trajectory
from barchain.metrics.quantities import balanced, drifts
from scenarios import Scene, load_scene
from tests.support import solutions
from tests.support.slow import slow_but

ABOUT_COM = ("energy_about_com", "angular_momentum_about_com")
FIELDS = ("paper/fig15", "effects/oblateness", "effects/slender", "effects/third_body", "effects/joint_springs")


def run(name: str, samples: int) -> tuple[Scene, Trajectory]:
    scene = load_scene(name)
    duration_s = min(scene.run.duration_s, 0.3 * scene.period_s)
    scene = dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=duration_s, samples=samples))
    return scene, solutions.run(scene, 1e-11)


@pytest.mark.parametrize("name", slow_but(FIELDS, ["paper/fig15", "effects/third_body"]))
def test_gravity_explains_every_change_of_a_right_run(name: str) -> None:
    scene, seen = run(name, 401)
    if balanced(scene):  # springs of a scene may be damped
        assert max(drifts(scene, seen)[quantity].max() for quantity in ABOUT_COM) < 1e-8
    else:
        assert not set(ABOUT_COM) & set(drifts(scene, seen))


def test_a_drift_of_the_spin_that_vanishes_beside_the_orbit_is_seen() -> None:
    """Of the whole angular momentum of a 100 m chain a change of 1e-5 of its spin is 1e-15."""
    scene, seen = run("paper/fig15", 401)
    growing = 1.0 + 1e-5 * seen.t_s[:, None] / seen.t_s[-1]
    drifted = drifts(scene, seen.replace(rate_rad_s=seen.rate_rad_s * growing))
    assert 3e-6 < drifted["angular_momentum_about_com"].max() <= 1.01e-5  # less where the chain turns slower at the end
    assert 3e-6 < drifted["energy_about_com"].max() <= 2.02e-5


@pytest.mark.parametrize("samples", [2, 4])
def test_a_run_of_few_samples_has_a_drift_at_each(samples: int) -> None:
    scene, seen = run("paper/fig15", samples)
    assert all(drifts(scene, seen)[quantity].shape == (samples,) for quantity in ABOUT_COM)
