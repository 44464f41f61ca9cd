"""Hard scenes: what each says must hold, by closed forms and limits; stiff springs, which make one bar of a chain."""

import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from adapters.common.initial_state import initial_state
from adapters.common.kepler import propagate
from adapters.common.reference_model import chain_model
from adapters.reference.compiled_engine import ReferenceFast
from adapters.reference.numpy_engines import Reference
from barchain.metrics.quantities import differences, drifts
from reference_impl.model.kinematics import consistent_state
from reference_impl.model.relative import accelerations
from scenarios import Gravity, Scene, load_scene
from scenarios.scene import Chain
from tests.support.kernel import needs_kernel
from tests.support.slow import one_in

BOTH = [Reference, ReferenceFast]
EPS = float(np.finfo(float).eps)


def run(engine: type, scene: Scene | str, rtol: float = 1e-10):
    scene = load_scene(scene) if isinstance(scene, str) else scene
    return engine().run(scene, engine.sweep.setting(rtol))


@pytest.mark.parametrize("engine", BOTH)
@pytest.mark.parametrize("name", ["parabolic", "hyperbolic", "perigee_099"])
def test_the_centre_of_mass_follows_its_conic(name: str, engine: type) -> None:
    """Kepler's closed form, by universal variables; the chain departs from a particle by (L/r)² of the way."""
    scene = load_scene(f"hard/{name}")
    if engine is Reference:  # a chain that perigee has spun up takes thousands of steps
        scene = replace(scene, run=replace(scene.run, duration_s=0.9 * scene.run.duration_s))
    seen = run(engine, scene)
    start = initial_state(scene)
    com, _ = propagate(scene.central_body.mu_m3_s2, start.com_m, start.com_velocity_m_s, seen.t_s)
    nearest = np.linalg.norm(com, axis=1).min()
    away = np.linalg.norm(com, axis=1) + np.linalg.norm(start.com_velocity_m_s) * seen.t_s
    pulled = 10.0 * (scene.size_m / nearest) ** 2 + 1e-10 * float(seen.info["steps"]) * scene.radius0_m / nearest
    assert (np.linalg.norm(seen.com_m - com, axis=1) <= pulled * away).all()


@pytest.mark.parametrize("speed_factor", [0.0, 1e-9, 1e-4, 0.03])
def test_a_fall_from_rest_or_nearly_has_drifts_in_units_of_what_it_gains(speed_factor: float) -> None:
    scene = load_scene("hard/vertical_fall")
    orbit = replace(scene.orbit, speed_factor=speed_factor)
    scene = replace(scene, orbit=orbit, effects=replace(scene.effects, gravity=Gravity.POINT))
    found = drifts(scene, run(Reference, scene, 1e-12))
    assert (found["energy"] < 1e-10).all()  # a hundred times the request: samples are interpolated, the units differ
    assert (found["angular_momentum"] < 1e-10).all()  # of M |Z| |Z'|


@pytest.mark.parametrize("engine", BOTH)
def test_grazing_by_five_metres_goes_on_and_touching_by_five_ends(engine: type) -> None:
    assert run(engine, "hard/grazing").ended == ""
    assert "surface" in run(engine, "hard/grazing_touch").ended


@pytest.mark.parametrize("engine", BOTH)
def test_nothing_depends_on_the_size_but_its_unit(engine: type) -> None:
    """Bars of 6.4 um and of 6.4 mm: what is left of the size is (l/r), 1e-9, and rounding."""
    small = load_scene("hard/size_6um")
    chain = small.chain
    larger = replace(
        small,
        chain=replace(
            chain,
            length_m=tuple(1e3 * v for v in chain.length_m),
            inertia_kg_m2=tuple(1e6 * v for v in chain.inertia_kg_m2),
        ),
    )
    a, b = run(engine, small), run(engine, larger)
    assert np.abs(a.angle_rad - b.angle_rad).max() < 1e-7
    assert np.abs(1e3 * a.reaction_N - b.reaction_N).max() < 1e-7 * np.abs(b.reaction_N).max()


@pytest.mark.parametrize("engine", BOTH)
@pytest.mark.parametrize("name", ["straight_horizontal", "inverted_chain"])
def test_an_unstable_equilibrium_is_left_no_faster_than_linear_growth_of_rounding(name: str, engine: type) -> None:
    """All that may be there at t is what each step's rounding has grown to by then: u steps exp(λ t) of a few."""
    scene = load_scene(f"hard/{name}")
    seen = run(engine, scene, 1e-12)
    local = seen.angle_rad - np.unwrap(np.arctan2(seen.com_m[:, 1], seen.com_m[:, 0]))[:, None]
    off = np.abs(local - local[0]).max(axis=1)
    rate = growth_rate(scene)
    assert rate >= 0.99 * math.sqrt(3.0) * scene.mean_motion_rad_s  # a single bar's; a chain's is larger
    bent = scene.size_m / scene.radius0_m if scene.bars > 1 else 0.0  # a straight chain is none along a circle
    assert (off <= (64.0 * EPS * float(seen.info["steps"]) + bent) * np.exp(rate * seen.t_s)).all()


def growth_rate(scene: Scene) -> float:
    """Largest rate of linear growth at the start, rad/s, in axes that turn with the orbit: by differences."""
    model, s = chain_model(scene), initial_state(scene)

    def angular(turned: np.ndarray) -> np.ndarray:
        state = consistent_state(model, s.com_m, s.com_velocity_m_s, s.angle_rad + turned, s.rate_rad_s)
        return accelerations(model, 0.0, state).angle_rad_s2

    step = 1e-6
    stiffness = np.array([(angular(step * e) - angular(-step * e)) / (2.0 * step) for e in np.eye(scene.bars)]).T
    return math.sqrt(max(np.linalg.eigvals(stiffness).real.max(), 0.0))


@pytest.mark.parametrize("engine", BOTH)
@pytest.mark.parametrize("name", ["straight_radial", "folded"])
def test_a_stable_equilibrium_is_left_by_rounding_only(name: str, engine: type) -> None:
    scene = load_scene(f"hard/{name}")
    seen = run(engine, scene, 1e-12)
    local = seen.angle_rad - np.unwrap(np.arctan2(seen.com_m[:, 1], seen.com_m[:, 0]))[:, None]
    assert np.abs(local - local[0]).max() < 1e-12 * float(seen.info["steps"]) * 10.0


def test_compensated_steps_keep_the_energy_of_a_thousand_orbits_ten_times_better() -> None:
    """Coefficients rounded to doubles err to the same side in every step, whatever the tolerance."""
    scene = load_scene("hard/long_1000")
    plain, exact = (drifts(scene, run(ReferenceFast, scene, rtol))["energy"] for rtol in (1e-13, 1e-14))
    assert plain[-1] > 1e-12
    assert exact.max() < 5e-13


PEAK = """
import sys
from dataclasses import replace
from pathlib import Path
from adapters.reference.compiled_engine import ReferenceFast
from scenarios import load_scene
scene = load_scene("hard/bars_10000")
scene = replace(scene, run=replace(scene.run, duration_s=float(sys.argv[1]) * scene.run.duration_s))
seen = ReferenceFast().run(scene, ReferenceFast.sweep.setting(1e-6))
status = dict(line.split(":", 1) for line in open("/proc/self/status"))
print(status["VmHWM"].split()[0], seen.info["steps"])
"""


@pytest.mark.slow
@needs_kernel
@pytest.mark.skipif(not Path("/proc/self/status").is_file(), reason="no /proc to read the peak of a process from")
def test_ten_thousand_bars_fit_in_a_gibibyte() -> None:
    """Peak of a process of their own, in KiB, over the first steps; later ones need no more.

    `getrusage` would not do: its peak passes from the process that starts another to that one.
    """
    told = subprocess.run([sys.executable, "-c", PEAK, "0.3"], capture_output=True, text=True, check=True)
    peak_KiB, steps = map(float, told.stdout.split())
    assert steps > 5
    assert peak_KiB < 2**20


STIFF, DAMPED = "hard/springs_stiff", "hard/damping_heavy"


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
