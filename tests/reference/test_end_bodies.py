"""End bodies: bodies whose joints are at any distance from their centres of mass, and a librating dumbbell."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from scipy.special import ellipk

from adapters.common.initial_state import initial_state
from adapters.common.reference_model import chain_model
from adapters.engine import AccuracyParameter, Setting
from adapters.reference.numpy_engines import Reference
from reference_impl.model.kinematics import cross, relative_positions, relative_velocities
from scenarios import SceneError, change_scene, load_scene, make_scene

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

EPS = float(np.finfo(float).eps)
BODIES = [
    {"at": "first", "mass_kg": 500.0, "inertia_kg_m2": 120.0, "joint_m": 0.8},
    {"at": "last", "mass_kg": 200.0, "inertia_kg_m2": 40.0, "joint_m": 0.5},
]


def chain_of(bodies: list[dict[str, Any]], chain: dict[str, Any], **others: Any) -> Scene:
    """Chain with end bodies."""
    tables = {"title": "t", "source": "s", "orbit": {"altitude_m": 500e3}, "run": {"duration_s": 1.0, "samples": 2}}
    return make_scene(tables | {"chain": chain | {"end_body": bodies}} | others)


def run(scene: Scene, rtol: float = 1e-10) -> Trajectory:
    """Run of the reference."""
    return Reference().run(scene, Setting(AccuracyParameter.RTOL, rtol))


def reactions_with_multipliers(
    before_m: Array, after_m: Array, mass: Array, inertia: Array, angle: Array, rate: Array
) -> Array:
    """Forces on each body from the next one, (N-1, 2), of a free chain, from Lagrange's equations with multipliers.

    A body has its joints `before_m` and `after_m` from its centre of mass: no bar of some length is mentioned.
    """
    n = len(mass)
    along, across = (np.stack(v, axis=1) for v in ((np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))))
    jacobian, accelerated = np.zeros((2 * n - 2, 3 * n)), np.zeros(2 * n - 2)
    for j in range(n - 1):
        rows = slice(2 * j, 2 * j + 2)
        jacobian[rows, 3 * j : 3 * j + 2], jacobian[rows, 3 * j + 3 : 3 * j + 5] = np.eye(2), -np.eye(2)
        jacobian[rows, 3 * j + 2], jacobian[rows, 3 * j + 5] = after_m[j] * across[j], before_m[j + 1] * across[j + 1]
        accelerated[rows] = after_m[j] * rate[j] ** 2 * along[j] + before_m[j + 1] * rate[j + 1] ** 2 * along[j + 1]
    inverse = 1.0 / np.stack([mass, mass, inertia], axis=1).ravel()
    force: Array = np.linalg.solve(jacobian * inverse @ jacobian.T, accelerated)
    return force.reshape(-1, 2)


def test_a_body_is_a_bar_of_twice_the_distance_of_its_joint() -> None:
    """50 random chains without forces; rounding of a system of some condition decides how far they agree."""
    rng = np.random.default_rng(7)
    worst = 0.0
    for _ in range(50):
        inner = int(rng.integers(1, 5))
        bodies = [body | {"mass_kg": 10.0 ** rng.uniform(-1, 2), "inertia_kg_m2": 10.0 ** rng.uniform(-1, 2),
                          "joint_m": 10.0 ** rng.uniform(-1, 1)} for body in BODIES[: rng.integers(1, 3)]]  # fmt: skip
        bars = inner + len(bodies)
        chain = {
            "bars": bars,
            "mass_kg": rng.uniform(1.0, 9.0, inner).tolist(),
            "length_m": rng.uniform(1.0, 9.0, inner).tolist(),
            "angle_deg": rng.uniform(-180.0, 180.0, bars).tolist(),
            "rate_rad_s": rng.uniform(-1.0, 1.0, bars).tolist(),
        }
        scene = chain_of(bodies, chain, effects={"gravity": "none"})
        state, half = initial_state(scene), [0.5 * length for length in chain["length_m"]]
        before = np.array([np.nan, *half, *(body["joint_m"] for body in bodies if body["at"] == "last")])
        after = np.array([*(body["joint_m"] for body in bodies if body["at"] == "first"), *half, np.nan])
        mass, inertia = np.array(scene.chain.mass_kg), np.array(scene.chain.inertia_kg_m2)
        expected = reactions_with_multipliers(before, after, mass, inertia, state.angle_rad, state.rate_rad_s)
        found = run(scene).reaction_N
        assert found is not None
        worst = max(worst, float(np.abs(found[0] - expected).max() / np.abs(expected).max()))
    assert worst <= 1e4 * EPS


def test_a_scene_with_bodies_is_the_scene_of_these_bars() -> None:
    scene = chain_of(BODIES, {"bars": 4, "mass_kg": 5.0, "length_m": [10.0, 20.0], "angle_deg": 80.0})
    chain = {"bars": 4, "mass_kg": [500.0, 5.0, 5.0, 200.0], "length_m": [1.6, 10.0, 20.0, 1.0], "angle_deg": 80.0,
             "inertia_kg_m2": [120.0, 500.0 / 12.0, 2000.0 / 12.0, 40.0]}  # fmt: skip
    assert scene.digest == chain_of([], chain).digest
    assert scene.chain.bodies == (1, 4)
    assert change_scene(scene, {"chain": {"end_body": BODIES[:1], "bars": 3}}).chain.bodies == (1,)


def librating(amplitude_rad: float) -> Scene:
    """Dumbbell at rest in the rotating axes, off the radius by an amplitude."""
    chain = {"bars": 3, "mass_kg": 1e-3, "length_m": 200.0, "angle_rad": 0.5 * math.pi - amplitude_rad}
    n = math.sqrt(3.986004418e14 / 6878e3**3)
    period_s = 4.0 * float(ellipk(math.sin(amplitude_rad) ** 2)) / (math.sqrt(3.0) * n)
    return chain_of(BODIES, chain, run={"duration_s": period_s, "samples": 5})


@pytest.mark.parametrize("amplitude_rad", [0.05, 0.6])
def test_a_dumbbell_librates_with_n_times_the_root_of_three(amplitude_rad: float) -> None:
    """At the amplitude a the period is 4 K(sin a)/(n sqrt 3); the field is linear to L/r."""
    scene = librating(amplitude_rad)
    seen = run(scene)
    assert seen.angle_rad is not None
    longitude = np.unwrap(np.arctan2(seen.com_m[:, 1], seen.com_m[:, 0]))
    off = seen.angle_rad - longitude[:, None]
    linear = 4.0 * scene.size_m / scene.radius0_m
    expected = -amplitude_rad * np.array([1.0, 0.0, -1.0, 0.0, 1.0])
    np.testing.assert_allclose(off, np.broadcast_to(expected[:, None], off.shape), rtol=0, atol=linear)


def test_the_pull_in_a_dumbbell_at_rest_is_three_n_squared_mu_l() -> None:
    """mu is the reduced mass, L the distance of the centres; the field is linear to L/r, the tether has 1e-5 of mu."""
    scene = librating(0.0)
    reaction = run(scene).reaction_N
    assert reaction is not None
    mass, n = scene.chain.mass_kg, scene.mean_motion_rad_s
    distance = 0.8 + 200.0 + 0.5
    pull = 3.0 * n**2 * mass[0] * mass[2] / (mass[0] + mass[2]) * distance
    np.testing.assert_allclose(
        np.linalg.norm(reaction[0], axis=1), pull, rtol=4.0 * scene.size_m / scene.radius0_m + 2e-5
    )


def test_the_base_of_a_free_flyer_turns_by_momentum_alone() -> None:
    scene = load_scene("effects/free_flyer")
    seen, model = run(scene, 1e-12), chain_model(scene)
    assert seen.angle_rad is not None
    assert seen.rate_rad_s is not None
    assert np.abs(seen.rate_rad_s[0]).max() == 0.0
    assert np.ptp(seen.angle_rad[:, 0]) > 0.05
    largest = np.abs(seen.rate_rad_s * model.inertia_kg_m2).max()
    for angle, rate in zip(seen.angle_rad, seen.rate_rad_s, strict=True):
        place, velocity = relative_positions(model, angle), relative_velocities(model, angle, rate)
        momentum = rate @ model.inertia_kg_m2 + model.mass_kg @ cross(place, velocity)
        assert abs(momentum) <= 1e-9 * largest  # a thousand steps of 1e-12


DRAG = {"density_kg_m3": 1e-12, "altitude_m": 5e5, "scale_height_m": 6e4, "width_m": 0.1}
THRUST = {"bar": 1, "end": "left", "direction_deg": 0.0, "force_N": 1.0}
IMPULSE = {"bar": 4, "direction_deg": 0.0, "impulse_N_s": 1.0, "at_s": 0.5}
FAULTS = [
    (BODIES, {"bars": 2}, {}, "at least one bar besides, 3"),
    ([BODIES[0], BODIES[0]], {}, {}, 'two end bodies at = "first"'),
    ([BODIES[0] | {"joint_m": 0.0}], {}, {}, "chain.end_body[1].joint_m: 0.0 given"),
    ([BODIES[0] | {"at": "middle"}], {}, {}, "chain.end_body[1].at: 'middle' given, allowed: 'first' or 'last'"),
    ([{"at": "first", "mass_kg": 1.0, "joint_m": 1.0}], {}, {}, "chain.end_body[1].inertia_kg_m2: missing"),
    ([BODIES[0] | {"com_m": 0.1}], {"mass_kg": [1.0, 2.0, 3.0]}, {}, "chain.end_body[1].com_m: unknown key"),
    (BODIES, {"length_m": [1.0, 2.0, 3.0, 4.0]}, {}, "one value per bar that is no end body: 2 of them"),
    (BODIES, {"angle_deg": [1.0, 2.0]}, {}, "a list needs one value per bar: 4 of them"),
    (BODIES, {}, {"gravity": "slender"}, 'effects.gravity: "slender" given, allowed with an end body'),
    (BODIES, {}, {"drag": DRAG}, "effects.drag: acts on bars, and the chain has an end body; allowed: a bar"),
    (BODIES, {}, {"solar_pressure": {"width_m": 0.1}}, "effects.solar_pressure"),
    (BODIES, {}, {"thrust": [THRUST]}, "effects.thrust[1].end: left"),
    (BODIES, {}, {"impulse": [IMPULSE]}, "allowed: left, its joint"),
]  # fmt: skip


@pytest.mark.parametrize(("bodies", "chain", "effects", "words"), FAULTS, ids=[words for *_, words in FAULTS])
def test_what_an_end_body_can_not_have_is_one_line(
    bodies: list[dict[str, Any]], chain: dict[str, Any], effects: dict[str, Any], words: str
) -> None:
    whole = {"bars": 4, "mass_kg": 5.0, "length_m": 0.3} | chain
    with pytest.raises(SceneError) as error:
        chain_of(bodies, whole, effects=effects)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_a_thrust_at_the_joint_of_a_body_is_taken() -> None:
    thrust = {"bar": 1, "end": "right", "direction_deg": 0.0, "force_N": 1.0}
    assert chain_of(BODIES, {"bars": 3, "mass_kg": 5.0, "length_m": 9.0}, effects={"thrust": [thrust]}).bars == 3
