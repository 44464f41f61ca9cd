"""Stiff joint springs: an implicit method is chosen by itself, says so, and finds the motion of one rigid bar."""

from dataclasses import replace

import numpy as np
import pytest

from adapters.reference.compiled_engine import ReferenceFast
from adapters.reference.numpy_engines import Reference
from barchain.metrics.quantities import differences
from scenarios import Scene, load_scene
from scenarios.scene import Chain
from tests.support.slow import one_in

BOTH = [Reference, ReferenceFast]
STIFF, DAMPED = "hard/springs_stiff", "hard/damping_heavy"


def run(engine: type, scene: Scene, rtol: float = 1e-10):
    return engine().run(scene, engine.sweep.setting(rtol))


@pytest.mark.parametrize("rtol", one_in(3, [1e-10, 1e-13]))
@pytest.mark.parametrize("name", [STIFF, DAMPED])
@pytest.mark.parametrize("engine", BOTH)
def test_the_implicit_method_is_chosen_and_said(engine: type, name: str, rtol: float) -> None:
    """Also in a reference solution: rounding would hold explicit steps so short that none looks stiff."""
    scene = load_scene(name)
    scene = replace(scene, run=replace(scene.run, duration_s=0.2 * scene.run.duration_s))
    seen = run(engine, scene, rtol)
    assert "Radau" in str(seen.info["method"])
    assert "stiff" in str(seen.info["method"])
    assert float(seen.info["steps"]) < 2000  # explicit: 8e4, and 1e7 with dampers


@pytest.mark.parametrize("name", ["hard/springs_zero", "effects/joint_springs", "paper/fig13", "hard/compact"])
def test_other_scenes_keep_the_explicit_method(name: str) -> None:
    scene = load_scene(name)
    short = replace(scene, run=replace(scene.run, duration_s=0.02 * scene.run.duration_s, samples=3))
    assert run(ReferenceFast, short).info["method"] == "DOP853"


def one_bar(scene: Scene) -> Scene:
    """The straight chain of `scene` as a single rigid bar."""
    c = scene.chain
    mass, length = sum(c.mass_kg), sum(c.length_m)
    bar = Chain((mass,), (length,), (mass * length**2 / 12.0,), c.angle_rad[:1], c.angle_from, c.rate_factor[:1])
    return replace(scene, chain=bar, effects=replace(scene.effects, joint_spring_damper=None))


@pytest.mark.parametrize("engine", BOTH)
def test_stiff_springs_make_one_bar_of_the_chain(engine: type) -> None:
    """Up to their bending, torque over stiffness: 0.2 N m in 1e9 N m/rad, and to what differs by (l/r)² in the pull."""
    scene = load_scene(STIFF)
    seen, alone = run(engine, scene), run(engine, one_bar(scene))
    assert np.ptp(seen.angle_rad, axis=1).max() < 1e-9
    size_m = scene.size_m
    assert np.abs(seen.angle_rad[:, :1] - alone.angle_rad).max() < (size_m / scene.radius0_m) ** 2 + 1e-8


@pytest.mark.parametrize("name", one_in(2, [STIFF, DAMPED]))
def test_both_forms_agree_and_the_error_falls_with_the_tolerance(name: str) -> None:
    scene = load_scene(name)
    fine = run(ReferenceFast, scene, 1e-12)
    coarse, other = run(ReferenceFast, scene, 1e-9), run(Reference, scene, 1e-9)
    steps = float(coarse.info["steps"])
    for seen in (coarse, other):
        assert differences(seen, fine)["attitude"].max() < 1e-9 * steps
    fall = differences(run(ReferenceFast, scene, 1e-7), fine)["attitude"].max()
    assert differences(coarse, fine)["attitude"].max() < max(0.2 * fall, 1e-10)


def test_a_spring_that_visibly_swings_is_followed_swing_by_swing() -> None:
    """Bent by a milliradian it oscillates 20 times a second: to step over that would be wrong, however cheap."""
    scene = load_scene(STIFF)
    bent = replace(
        scene.chain, angle_rad=tuple(a + d for a, d in zip(scene.chain.angle_rad, (0.0, 1e-3, 0.0), strict=True))
    )
    rest = tuple(np.zeros(2))
    springs = replace(scene.effects.joint_spring_damper, rest_rad=rest)
    swung = replace(scene, chain=bent, effects=replace(scene.effects, joint_spring_damper=springs))
    seen = run(ReferenceFast, replace(swung, run=replace(scene.run, duration_s=60.0, samples=601)))
    assert seen.info["method"] == "DOP853"
    early, late = (np.abs(np.diff(seen.angle_rad, axis=1)[rows]).max() for rows in (slice(0, 300), slice(300, None)))
    assert late == pytest.approx(early, rel=0.02)  # samples at other phases of it; nothing damps it
