"""Bars whose centre of mass is not midway between their ends, point masses at joints, and end bodies."""

import dataclasses
import functools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipk

from adapters.common.initial_state import initial_state
from adapters.common.reference_model import chain_model
from adapters.engine import AccuracyParameter, Setting
from adapters.reference.numpy_engines import Reference, ReferenceAbsolute
from adapters.registry import find_engine
from adapters.trajectory import ENDED, Array, Trajectory
from reference_impl.model.kinematics import cross, directions, relative_positions, relative_velocities
from reports.plotting.chain import Geometry, joints
from scenarios import Scene, SceneError, change_scene, load_scene, make_scene
from tests.support.kernel import needs_kernel
from tests.support.slow import slow_but
from tests.support.solutions import REFERENCE

EPS = float(np.finfo(float).eps)
CHAIN = {
    "bars": 4, "mass_kg": [4.0, 9.0, 6.0, 5.0], "length_m": [10.0, 14.0, 8.0, 12.0],
    "inertia_kg_m2": [40.0, 120.0, 30.0, 70.0], "com_share": [0.4, 0.2, 0.85, 0.6],
    "angle_deg": [10.0, 70.0, -35.0, 120.0], "rate_rad_s": [0.4, -0.3, 0.2, -0.1],
}  # fmt: skip


def scene_with(chain: dict[str, Any], gravity: str = "none", **tables: Any) -> Scene:
    """Chain in low orbit for a minute."""
    given = {
        "title": "t", "source": "s", "orbit": {"altitude_m": 500e3}, "run": {"duration_s": 20.0, "samples": 11},
        "effects": {"gravity": gravity},
    }  # fmt: skip
    return make_scene(given | {"chain": chain} | tables)


@functools.lru_cache
def run(scene: Scene, engine: type = REFERENCE, rtol: float = 1e-12) -> Trajectory:
    """Run of the reference."""
    found: Trajectory = engine().run(scene, Setting(AccuracyParameter.RTOL, rtol))
    return found


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


def test_reactions_are_those_of_bodies_with_joints_at_these_places() -> None:
    """50 random chains without forces; rounding of a system of some condition decides how far they agree."""
    rng = np.random.default_rng(11)
    worst = 0.0
    for _ in range(50):
        bars = int(rng.integers(2, 7))
        mass, length, inertia = (10.0 ** rng.uniform(-1, 1, bars) for _ in range(3))
        share = rng.uniform(0.0, 1.0, bars)
        chain = {
            "bars": bars, "mass_kg": mass.tolist(), "length_m": length.tolist(), "inertia_kg_m2": inertia.tolist(),
            "com_share": share.tolist(), "angle_deg": rng.uniform(-180.0, 180.0, bars).tolist(),
            "rate_rad_s": rng.uniform(-1.0, 1.0, bars).tolist(),
        }  # fmt: skip
        scene = scene_with(chain, run={"duration_s": 1e-3, "samples": 2})
        state = initial_state(scene)
        expected = reactions_with_multipliers(
            share * length, (1.0 - share) * length, mass, inertia, state.angle_rad, state.rate_rad_s
        )
        for engine in (Reference, ReferenceAbsolute):
            found = run(scene, engine).reaction_N
            loss = 1.0 if engine is Reference else scene.radius0_m / length.min()
            worst = max(worst, float(np.abs(found[0] - expected).max() / np.abs(expected).max()) / loss)
    assert worst <= 1e4 * EPS


def from_the_other_end(chain: dict[str, Any]) -> dict[str, Any]:
    """The same chain, its bars counted from its other end and pointing the other way."""
    turned = {key: value[::-1] if isinstance(value, list) else value for key, value in chain.items()}
    turned["com_share"] = [1.0 - share for share in turned["com_share"]]
    turned["angle_deg"] = [angle + 180.0 for angle in turned["angle_deg"]]
    return turned


@pytest.mark.parametrize("gravity", slow_but(["none", "point", "gradient", "quadrupole"], ["none", "quadrupole"]))
def test_a_chain_described_from_its_other_end_moves_alike(gravity: str) -> None:
    one, other = scene_with(CHAIN, gravity), scene_with(from_the_other_end(CHAIN), gravity)
    a, b = run(one), run(other)
    np.testing.assert_allclose(b.angle_rad[:, ::-1] - math.pi, a.angle_rad, rtol=0, atol=1e-9)
    np.testing.assert_allclose(-b.reaction_N[:, ::-1], a.reaction_N, rtol=0, atol=1e-9 * np.abs(a.reaction_N).max())


def test_midway_is_the_chain_without_shares() -> None:
    equal = {key: value for key, value in CHAIN.items() if key != "com_share"}
    scene = scene_with(CHAIN | {"com_share": 0.5})
    assert scene == scene_with(equal)
    assert scene.digest == scene_with(equal).digest
    assert scene.chain.com_share == ()


def given_to(bar: int, mass_kg: float) -> dict[str, Any]:
    """The chain with a point mass at joint 2 as a part of bar 2 or 3."""
    k, left = bar - 1, bar == 3
    chain = {key: list(value) if isinstance(value, list) else value for key, value in CHAIN.items()}
    m, length = chain["mass_kg"][k], chain["length_m"][k]
    centre, place = chain["com_share"][k] * length, 0.0 if left else length
    moved = (m * centre + mass_kg * place) / (m + mass_kg)
    chain["inertia_kg_m2"][k] += m * (moved - centre) ** 2 + mass_kg * (moved - place) ** 2
    chain["mass_kg"][k], chain["com_share"][k] = m + mass_kg, moved / length
    return chain


def test_a_point_mass_at_a_joint_moves_alike_as_part_of_either_bar() -> None:
    before, after = (run(scene_with(given_to(bar, 3.0))) for bar in (2, 3))
    named = run(scene_with(CHAIN | {"joint_mass": [{"joint": 2, "mass_kg": 3.0}]}))
    for seen in (after, named):
        np.testing.assert_allclose(seen.angle_rad, before.angle_rad, rtol=0, atol=1e-9)
    size = np.abs(before.reaction_N).max()
    np.testing.assert_allclose(named.reaction_N, before.reaction_N, rtol=0, atol=1e-9 * size)
    np.testing.assert_allclose(after.reaction_N[:, [0, 2]], before.reaction_N[:, [0, 2]], rtol=0, atol=1e-9 * size)
    assert np.abs(after.reaction_N[:, 1] - before.reaction_N[:, 1]).max() > 0.1 * size  # the mass's own inertia


def test_a_mass_at_the_joint_of_an_end_body_leaves_it_a_body() -> None:
    body = {"at": "first", "mass_kg": 50.0, "inertia_kg_m2": 12.0, "joint_m": 0.8}
    chain = {
        "bars": 3,
        "mass_kg": 5.0,
        "length_m": 9.0,
        "end_body": [body],
        "joint_mass": [{"joint": 1, "mass_kg": 30.0}],
    }
    found = scene_with(chain, "gradient").chain
    assert found.com_share == ()
    assert found.mass_kg[0] == 80.0
    assert found.length_m[0] == pytest.approx(2.0 * 0.5)  # 0.8 · 50/80
    assert found.inertia_kg_m2[0] == pytest.approx(12.0 + 50.0 * 0.3**2 + 30.0 * 0.5**2)


def test_a_file_of_the_scene_is_read_back_as_the_same_one(tmp_path: Path) -> None:
    body = {"at": "first", "mass_kg": 50.0, "inertia_kg_m2": 12.0, "joint_m": 0.8}
    chain = CHAIN | {"bars": 5, "end_body": [body], "joint_mass": [{"joint": 3, "mass_kg": 1.5}], "rate_rad_s": 0.1}
    scene = scene_with(chain | {"angle_deg": [0.0, *CHAIN["angle_deg"]]}, "gradient")
    scene.to_toml(tmp_path / "again.toml")
    assert load_scene(tmp_path / "again.toml").chain == scene.chain
    assert change_scene(scene, {"chain": {"joint_mass": []}}).chain.com_share == (0.5, *CHAIN["com_share"])
    other = dataclasses.replace(scene, chain=dataclasses.replace(scene.chain, com_share=()))
    assert load_scene(tmp_path / "again.toml").digest != other.digest


def test_a_drawing_has_the_ends_where_the_chain_has_them() -> None:
    scene = scene_with(CHAIN)
    model, angle = chain_model(scene), np.radians([CHAIN["angle_deg"]])
    shown = Geometry(model.length_m, model.mass_kg, 0.0, 1.0, closed=True, com_share=scene.chain.com_share)
    centres, along = relative_positions(model, angle), directions(angle)[0]
    first, rest = (centres - model.left_m[:, None] * along)[:, :1], centres + model.right_m[:, None] * along
    np.testing.assert_allclose(joints(shown, angle), np.concatenate([first, rest], axis=1), rtol=0, atol=1e-12)


def test_momentum_and_energy_stay_without_forces() -> None:
    scene = scene_with(CHAIN, run={"duration_s": 60.0, "samples": 31})
    seen, model = run(scene), chain_model(scene)
    momenta, kinetic = [], []
    for angle, rate in zip(seen.angle_rad, seen.rate_rad_s, strict=True):
        place, velocity = relative_positions(model, angle), relative_velocities(model, angle, rate)
        momenta.append(rate @ model.inertia_kg_m2 + model.mass_kg @ cross(place, velocity))
        kinetic.append(rate**2 @ model.inertia_kg_m2 + model.mass_kg @ (velocity**2).sum(axis=1))
    assert np.ptp(seen.angle_rad) > 2.0 * math.pi
    np.testing.assert_allclose(momenta, momenta[0], rtol=1e-10)
    np.testing.assert_allclose(kinetic, kinetic[0], rtol=1e-10)


LOADS = {
    "gravity": "quadrupole",
    "thrust": [{"bar": 2, "end": "left", "axes": "body", "direction_deg": 70.0, "force_N": 1.0},
               {"bar": 3, "end": "right", "axes": "inertial", "direction_deg": 20.0, "force_N": 1.0}],
    "impulse": [{"bar": 3, "end": "left", "axes": "body", "direction_deg": 80.0, "impulse_N_s": 2.0, "at_s": 10.0}],
    "prescribed_rotation": [{"bar": 4, "frame": "local_horizontal", "actuator": "joint", "amplitude_deg": 40.0,
                             "start_s": 2.0, "duration_s": 10.0}],
}  # fmt: skip


@needs_kernel
@pytest.mark.parametrize(
    ("name", "coordinates"),
    [("reference-fast", ""), ("reference-wide", ""), ("reference", "redundant"), ("reference", "projected"),
     ("cvode-adams", ""), ("heyoka", "")],
)  # fmt: skip
def test_formulations_and_derivations_move_alike(name: str, coordinates: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """heyoka has equations of its own; the reference makes some dozens of steps with errors of 1e-13 each."""
    scene = scene_with(CHAIN, effects=LOADS)
    pytest.importorskip({"heyoka": "heyoka", "cvode-adams": "sksundae"}.get(name, "numpy"))
    wanted, engine = run(scene, Reference, 1e-13), find_engine(name)
    if coordinates:
        monkeypatch.setattr(Reference, "coordinate_set", coordinates)
    finest = Setting(AccuracyParameter.RTOL, 1e-14 if name == "heyoka" else 1e-13)
    seen = engine.engine().run(scene, finest)
    slack = {"heyoka": 5e-12, "cvode-adams": 1e-8}.get(name, 1e-10)
    for channel in ("angle_rad", "reaction_N", "impulse_N_s", "torque_N_m"):
        expected = getattr(wanted, channel)
        scale = 10.0 if channel == "angle_rad" else np.abs(expected).max()
        np.testing.assert_allclose(getattr(seen, channel), expected, rtol=0, atol=slack * scale, err_msg=channel)


def test_a_bar_lands_with_its_own_ends() -> None:
    """Chain at rest that falls upright: its lower end is the right one of its last bar."""
    chain = {"bars": 2, "mass_kg": 5.0, "length_m": 40.0, "inertia_kg_m2": 500.0, "com_share": [0.5, 0.2],
             "angle_deg": -90.0, "rate_factor": 0.0}  # fmt: skip
    scene = scene_with(
        chain, "point", orbit={"altitude_m": 200.0, "speed_factor": 0.0}, run={"duration_s": 9.0, "samples": 10}
    )
    seen, model = run(scene), chain_model(scene)
    assert seen.ended
    height = scene.orbit.altitude_m + relative_positions(model, np.full(2, -0.5 * math.pi))[1, 1] - 32.0
    fall_m_s2 = scene.central_body.mu_m3_s2 / scene.central_body.radius_m**2
    assert float(seen.info[ENDED]) == pytest.approx(math.sqrt(2.0 * height / fall_m_s2), rel=1e-4)


# end bodies

BODIES = [
    {"at": "first", "mass_kg": 500.0, "inertia_kg_m2": 120.0, "joint_m": 0.8},
    {"at": "last", "mass_kg": 200.0, "inertia_kg_m2": 40.0, "joint_m": 0.5},
]


def test_a_scene_with_bodies_is_the_scene_of_these_bars() -> None:
    thrust = {"bar": 1, "end": "right", "direction_deg": 0.0, "force_N": 1.0}  # at the joint of a body
    given = {"bars": 4, "mass_kg": 5.0, "length_m": [10.0, 20.0], "angle_deg": 80.0, "end_body": BODIES}
    scene = scene_with(given, effects={"thrust": [thrust]})
    chain = {"bars": 4, "mass_kg": [500.0, 5.0, 5.0, 200.0], "length_m": [1.6, 10.0, 20.0, 1.0], "angle_deg": 80.0,
             "inertia_kg_m2": [120.0, 500.0 / 12.0, 2000.0 / 12.0, 40.0]}  # fmt: skip
    assert scene.digest == scene_with(chain, effects={"thrust": [thrust]}).digest
    assert scene.chain.bodies == (1, 4)
    assert change_scene(scene, {"chain": {"end_body": BODIES[:1], "bars": 3}}).chain.bodies == (1,)


def librating(amplitude_rad: float) -> Scene:
    """Dumbbell at rest in the rotating axes, off the radius by an amplitude."""
    chain = {"bars": 3, "mass_kg": 1e-3, "length_m": 200.0, "angle_rad": 0.5 * math.pi - amplitude_rad}
    n = math.sqrt(3.986004418e14 / 6878e3**3)
    period_s = 4.0 * float(ellipk(math.sin(amplitude_rad) ** 2)) / (math.sqrt(3.0) * n)
    return scene_with(chain | {"end_body": BODIES}, "gradient", run={"duration_s": period_s, "samples": 5})


@pytest.mark.parametrize("amplitude_rad", [0.05, 0.6])
def test_a_dumbbell_librates_with_n_times_the_root_of_three(amplitude_rad: float) -> None:
    """At the amplitude a the period is 4 K(sin a)/(n sqrt 3); the field is linear to L/r."""
    scene = librating(amplitude_rad)
    seen = run(scene, rtol=1e-10)
    longitude = np.unwrap(np.arctan2(seen.com_m[:, 1], seen.com_m[:, 0]))
    off = seen.angle_rad - longitude[:, None]
    linear = 4.0 * scene.size_m / scene.radius0_m
    expected = -amplitude_rad * np.array([1.0, 0.0, -1.0, 0.0, 1.0])
    np.testing.assert_allclose(off, np.broadcast_to(expected[:, None], off.shape), rtol=0, atol=linear)


def test_the_pull_in_a_dumbbell_at_rest_is_three_n_squared_mu_l() -> None:
    """mu is the reduced mass, L the distance of the centres; the field is linear to L/r, the tether has 1e-5 of mu."""
    scene = librating(0.0)
    reaction = run(scene, rtol=1e-10).reaction_N
    mass, n = scene.chain.mass_kg, scene.mean_motion_rad_s
    distance = 0.8 + 200.0 + 0.5
    pull = 3.0 * n**2 * mass[0] * mass[2] / (mass[0] + mass[2]) * distance
    np.testing.assert_allclose(
        np.linalg.norm(reaction[0], axis=1), pull, rtol=4.0 * scene.size_m / scene.radius0_m + 2e-5
    )


DRAG = {"density_kg_m3": 1e-12, "altitude_m": 5e5, "scale_height_m": 6e4, "width_m": 0.1}
THRUST = {"bar": 1, "end": "left", "direction_deg": 0.0, "force_N": 1.0}
IMPULSE = {"bar": 4, "direction_deg": 0.0, "impulse_N_s": 1.0, "at_s": 0.5}
ENDS = {"mass_kg": 5.0, "length_m": 0.3, "end_body": BODIES}
SHARES = {key: CHAIN[key] for key in ("mass_kg", "length_m", "inertia_kg_m2", "com_share")}
FAULTS = [
    (SHARES | {"com_share": [0.5, 0.4]}, {}, "a list needs one value per bar: 4 of them"),
    (SHARES | {"inertia_kg_m2": None}, {}, "com_share is given without inertia_kg_m2"),
    (SHARES | {"joint_mass": [{"joint": 4, "mass_kg": 1.0}]}, {}, "joint_mass[1].joint: 4 given, allowed: 1 to 3"),
    (SHARES, {"gravity": "slender"}, 'effects.gravity: "slender" given, allowed with com_share'),
    (SHARES, {"solar_pressure": {"width_m": 0.1}}, "effects.solar_pressure"),
    (ENDS | {"bars": 2}, {}, "at least one bar besides, 3"),
    (ENDS | {"end_body": [BODIES[0], BODIES[0]]}, {}, 'two end bodies at = "first"'),
    (ENDS | {"end_body": [BODIES[0] | {"joint_m": 0.0}]}, {}, "chain.end_body[1].joint_m: 0.0 given"),
    (ENDS | {"length_m": [1.0, 2.0, 3.0, 4.0]}, {}, "one value per bar that is no end body: 2 of them"),
    (ENDS | {"angle_deg": [1.0, 2.0]}, {}, "a list needs one value per bar: 4 of them"),
    (ENDS, {"gravity": "slender"}, 'effects.gravity: "slender" given, allowed with an end body'),
    (ENDS, {"drag": DRAG}, "effects.drag: acts on bars, and the chain has an end body; allowed: a bar"),
    (ENDS, {"thrust": [THRUST]}, "effects.thrust[1].end: left"),
    (ENDS, {"impulse": [IMPULSE]}, "allowed: left, its joint"),
]  # fmt: skip


@pytest.mark.parametrize(("chain", "effects", "words"), FAULTS, ids=[words for *_, words in FAULTS])
def test_what_is_not_allowed_is_one_line(chain: dict[str, Any], effects: dict[str, Any], words: str) -> None:
    whole = {key: value for key, value in ({"bars": 4} | chain).items() if value is not None}
    with pytest.raises(SceneError) as error:
        scene_with(whole, effects=effects)
    assert words in str(error.value)
    assert "\n" not in str(error.value)
