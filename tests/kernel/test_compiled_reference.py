"""The compiled reference against the other: the same accelerations, the same steps, the same words where it fails."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from adapters.reference.compiled_engine import ReferenceFast
from adapters.reference.numpy_engines import Reference
from adapters.registry import ENGINES
from reference_impl.integrate.simulate import Simulation
from reference_impl.kernel.simulate import KernelSimulation
from reference_impl.model import relative
from scenarios import load_scene
from tests.reference.laws import LAWS
from tests.support.arbiter import judge
from tests.support.changed import lasting, on_orbit, under
from tests.support.compiled_evaluation import compiled_accelerations, with_angles
from tests.support.generic_scenes import generic, steep
from tests.support.joint_roundoff import C, Case, U, case, forward, joint_bound, magnitudes, sums
from tests.support.kernel import needs_kernel
from tests.support.scene_lists import TAME

if TYPE_CHECKING:
    from scenarios import Scene


pytestmark = needs_kernel


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    bars=st.integers(1, 40),
    gravity=st.sampled_from(["none", "point", "gradient"]),
    decades=st.sampled_from([0.0, 2.0, 6.0]),
    turned=st.sampled_from([0.0, 1e5, 1e8]),
    compact=st.sampled_from([1.0, 1e-1, 1e-2, 1e-4]),
)
def test_one_evaluation_is_the_references_to_round_off(seed, bars, gravity, decades, turned, compact) -> None:
    """Both keep a joint's residual within `joint_bound`: their reactions differ by twice that through the joints."""
    c = case(seed, bars, gravity, decades)
    model = replace(c.model, inertia_kg_m2=c.model.inertia_kg_m2 * compact)
    c = Case(model, with_angles(model, c.state, c.state.angle_rad + turned))
    a, b = relative.accelerations(model, 25.0, c.state), compiled_accelerations(model, 25.0, c.state)
    assert (
        np.linalg.norm(a.com_m_s2 - b.com_m_s2) <= C * U * np.linalg.norm(a.com_m_s2) + bars * U * magnitudes(c, a).tide
    )
    # unit vectors two units in the last place apart, 4 u each, on both sides of the system
    allowed = forward(c, 2.0 * 4.0 * joint_bound(c, a)) if bars > 1 else np.zeros(0)
    assert np.all(np.linalg.norm(a.reaction_N - b.reaction_N, axis=1) <= allowed)
    levers = sums(np.repeat(allowed[:, None], 2, axis=1))[0][:, 0] * model.half_m / model.inertia_kg_m2
    assert np.all(np.abs(a.angle_rad_s2 - b.angle_rad_s2) <= levers + 4.0 * C * U * magnitudes(c, a).angular)


@pytest.mark.parametrize("compact", [1.0, 1e-2, 1e-4, 1e-8])
@pytest.mark.parametrize("bars", [3, 8])
def test_compact_bars_lose_no_more_than_their_compactness_takes(bars: int, compact: float) -> None:
    """Against fifty digits: u c/w for each bar, not its square, which sweeps alone would lose."""
    c = case(7, bars, "gradient", 0.0)
    model = replace(c.model, inertia_kg_m2=c.model.mass_kg * c.model.length_m**2 / 12.0 * compact)
    solution, found = judge(model, 25.0, c.state), compiled_accelerations(model, 25.0, c.state)
    error = np.abs(found.angle_rad_s2 - solution.angle_rad_s2).max() / np.abs(solution.angle_rad_s2).max()
    assert error <= C * bars * U * 3.0 / compact


@pytest.mark.parametrize("ratio", [1e6, 1e-6])
def test_alternating_masses_cost_no_more_digits_than_their_ratio(ratio: float) -> None:
    c = alternating(ratio)
    solution, found = judge(c.model, 25.0, c.state), compiled_accelerations(c.model, 25.0, c.state)
    error = np.abs(found.reaction_N - solution.reaction_N).max() / np.abs(solution.reaction_N).max()
    assert error <= C * U * 1e6


def short(scene: Scene) -> Scene:
    return lasting(scene, scene.run.duration_s / 20.0, 7)


def both(scene: Scene, rtol: float = 1e-9):
    setting = Reference.sweep.setting(rtol)
    return Reference().run(scene, setting), ReferenceFast().run(scene, setting)


@pytest.mark.parametrize("name", [n for n in TAME if not n.startswith(("effects/", "published/"))])
def test_it_takes_the_references_steps(name: str) -> None:
    """It evaluates once less: the other looks at the start before SciPy does."""
    scene = short(load_scene(name))
    theirs, mine = both(scene)
    assert mine.info == theirs.info | {"evaluations": theirs.info["evaluations"] - 1}
    # C roundings of each step, grown like gravity's fastest instability, e^(sqrt 3 n t)
    amplification = np.exp(np.sqrt(3.0) * scene.mean_motion_rad_s * scene.run.duration_s)
    allowed = C * U * theirs.info["steps"] * np.abs(theirs.angle_rad).max() * amplification
    assert np.abs(mine.angle_rad - theirs.angle_rad).max() <= allowed


@pytest.mark.parametrize("speed", [0.0, 0.5, 0.9])
def test_a_fall_ends_where_and_in_the_words_the_reference_ends_it(speed: float) -> None:
    theirs, mine = both(steep(1.0, speed_factor=speed) if speed else steep(1.0, speed_factor=1e-3))
    assert theirs.ended
    assert mine.ended.split("=")[0] == theirs.ended.split("=")[0]
    at, there = (float(t.ended.split("=")[1].split()[0]) for t in (mine, theirs))
    assert at == pytest.approx(there, rel=1e-9, abs=2e-6)  # printed to the microsecond
    assert len(mine.t_s) == len(theirs.t_s)


def outcome(kind, c: Case, t_s) -> str:
    s = c.state
    with np.errstate(all="ignore"), pytest.raises((ArithmeticError, np.linalg.LinAlgError)) as caught:
        kind(c.model, s.com_m, s.com_velocity_m_s, s.angle_rad, s.rate_rad_s, rtol=1e-9).integrate(t_s)
    return f"{caught.type.__name__}: {caught.value}"


@pytest.mark.parametrize("laws", [(), LAWS["joint, inertial"]], ids=["free", "motor"])
@pytest.mark.parametrize("what", ["angle_rad", "rate_rad_s", "com_m", "com_velocity_m_s"])
def test_a_start_that_is_no_number_is_refused_in_the_references_words(what: str, laws) -> None:
    c = case(11, 5, "point", 0.5, laws)
    bad = Case(c.model, replace(c.state, **{what: getattr(c.state, what) * np.nan}))
    assert outcome(KernelSimulation, bad, np.linspace(0.0, 100.0, 3)) == outcome(
        Simulation, bad, np.linspace(0.0, 100.0, 3)
    )


def alternating(ratio: float) -> Case:
    """Five slender bars, every other one `ratio` times heavier."""
    c = case(12, 5, "gradient", 0.0)
    mass = 100.0 * np.where(np.arange(5) % 2, ratio, 1.0)
    model = replace(c.model, mass_kg=mass, inertia_kg_m2=mass * c.model.length_m**2 / 12.0)
    return Case(model, with_angles(model, c.state, c.state.angle_rad))


def test_a_joint_lost_in_round_off_is_reported_in_the_references_words() -> None:
    lost, t_s = alternating(1e20), np.linspace(0.0, 1.0, 3)
    assert outcome(KernelSimulation, lost, t_s) == outcome(Simulation, lost, t_s)


def test_it_solves_a_chain_that_a_factorization_cannot_tell_apart() -> None:
    """A bar 1e20 times lighter than its neighbours that no lever turns: NumPy rejects it, the sweeps lose nothing."""
    c = case(3, 3, "none", 0.0)
    model = replace(c.model, mass_kg=np.array([1e20, 1.0, 1e20]), inertia_kg_m2=np.full(3, 1e40))
    solution, found = judge(model, 0.0, c.state), compiled_accelerations(model, 0.0, c.state)
    assert np.abs(found.reaction_N - solution.reaction_N).max() <= C * U * np.abs(solution.reaction_N).max()
    with pytest.raises(np.linalg.LinAlgError, match="not positive definite"):
        relative.accelerations(model, 0.0, c.state)


def test_samples_may_begin_at_any_instant() -> None:
    c = case(11, 5, "point", 0.5)
    s, t_s = c.state, np.linspace(50.0, 150.0, 3)
    a, b = (
        k(c.model, s.com_m, s.com_velocity_m_s, s.angle_rad, s.rate_rad_s, rtol=1e-9).integrate(t_s)
        for k in (Simulation, KernelSimulation)
    )
    assert (a.steps, a.evaluations) == (b.steps, b.evaluations + 1)


def test_two_threads_at_once_change_no_bit() -> None:
    scenes = [short(generic(1)), short(generic(2))]
    alone = [ReferenceFast().run(s) for s in scenes]
    with ThreadPoolExecutor(2) as pool:
        together = list(pool.map(lambda s: ReferenceFast().run(s), scenes * 4))
    for i, seen in enumerate(together):
        assert np.array_equal(seen.angle_rad, alone[i % 2].angle_rad)


def test_without_a_kernel_it_is_missing_with_advice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("adapters.registry.why_missing", lambda: "no compiled kernel: try a compiler")
    assert ENGINES["reference-fast"].missing == ENGINES["scipy-dop853"].missing == "no compiled kernel: try a compiler"
    assert ENGINES["reference"].missing is None


def test_laws_of_motion_begin_and_end_with_a_step_as_in_the_reference() -> None:
    """A slew inside the run, between two samples: three segments, the same steps in each."""
    scene = load_scene("paper/fig17")
    law = replace(scene.effects.prescribed_rotation[0], start_s=37.0)
    theirs, mine = both(lasting(under(scene, prescribed_rotation=(law,)), 300.0, 8), 1e-10)
    assert mine.info["steps"] == theirs.info["steps"]
    assert np.abs(mine.angle_rad - theirs.angle_rad).max() <= C * U * theirs.info["steps"] * 10.0
    assert np.abs(mine.torque_N_m - theirs.torque_N_m).max() <= 1e-12 * np.abs(theirs.torque_N_m).max()


def test_a_start_on_the_surface_ends_at_once_and_free_flight_ends_where_it_meets_it() -> None:
    theirs, mine = both(on_orbit(load_scene("paper/fig13"), altitude_m=100.0))
    assert mine.ended == theirs.ended == "a bar reached the surface at t = 0.000000 s"
    assert len(mine.t_s) == len(theirs.t_s) == 1
