"""Joints are looked at from outside, by the bars' places, wherever an engine has places of its own."""

import dataclasses
import functools

import numpy as np
import pytest

from adapters.common.initial_state import initial_state
from adapters.common.reference_model import chain_model
from adapters.engine import AccuracyParameter, Engine, Setting
from adapters.exudyn.adapter import Exudyn, ExudynAbsolute, ExudynAbsoluteIndex3, ExudynIndex3, ExudynTree
from adapters.pymunk.adapter import Pymunk, PymunkAbsolute
from adapters.reference.numpy_engines import Reference, ReferenceAbsolute
from adapters.trajectory import Trajectory
from barchain.metrics.joint_gaps import centre_of_mass_residual, gaps, measured
from barchain.metrics.quantities import drifts
from barchain.runs.trajectory_checks import fault
from reference_impl.integrate.simulate import Simulation
from reports.results.outcome import Outcome
from scenarios import Scene, load_scene
from tests.support.slow import one_in

WITH_PLACES = (
    ReferenceAbsolute, Exudyn, ExudynIndex3, ExudynAbsolute, ExudynAbsoluteIndex3, Pymunk, PymunkAbsolute,
)  # fmt: skip
UNIT = float(np.finfo(float).eps)
OPENED = 3.1e-6  # m
LONG_TURNED = 1e6  # revolutions


@functools.cache
def scene_of(name: str = "paper/fig13") -> Scene:
    scene = load_scene(name)
    run = dataclasses.replace(scene.run, duration_s=0.05 * scene.period_s, samples=7)
    return dataclasses.replace(scene, run=run)


@functools.cache
def run(engine: type[Engine], name: str = "paper/fig13") -> Trajectory:
    value = 1e-9 if engine.sweep.parameter is AccuracyParameter.RTOL else 2000.0
    return engine().run(scene_of(name), Setting(engine.sweep.parameter, value))


def opened(trajectory: Trajectory, by_m: float, *, after: int, sample: int = 0) -> Trajectory:
    """Bars beyond joint `after` (from 1) displaced from `sample` on; gaps and residual as they were reported."""
    place = trajectory.position_m.copy()
    place[sample:, after:] += np.array([0.0, by_m])
    return trajectory.replace(position_m=place)


def nothing_amiss(trajectory: Trajectory) -> Trajectory:
    """What an engine says that never looks at its joints."""
    n, bars = trajectory.angle_rad.shape
    return trajectory.replace(gap_m=np.zeros((n, bars - 1)), com_residual_m=np.zeros(n))


# what unmodified engines give


@pytest.mark.parametrize("name", one_in(3, ["paper/fig13", "effects/drag", "effects/tip_masses"]))
@pytest.mark.parametrize("engine", WITH_PLACES)
def test_places_give_the_gaps_reported_the_centre_of_mass_and_the_start(engine: type[Engine], name: str) -> None:
    """Differences of near places are exact: only lengths and angles are rounded, in any coordinates.

    The centre of mass is a weighted mean of the engine's own coordinates, and rounded as these are.
    """
    scene, seen = scene_of(name), run(engine, name)
    turned = 1.0 + np.abs(seen.angle_rad).max()
    assert np.abs(gaps(scene, seen) - seen.gap_m).max() <= 4.0 * UNIT * scene.size_m * turned
    assert fault(scene, engine, seen) is None
    coordinate = scene.radius0_m if engine.coordinates.absolute else scene.size_m
    assert centre_of_mass_residual(scene, seen).max() <= 2.0 * UNIT * scene.bars * coordinate
    off = np.linalg.norm(seen.position_m[0] - initial_state(scene).position_m, axis=1)
    assert off.max() <= seen.gap_m[0].sum() + 8.0 * np.spacing(scene.radius0_m)


@pytest.mark.parametrize("coordinates", ["redundant", "projected", "absolute"])
def test_every_coordinate_set_with_places_shows_its_drift_by_them(coordinates: str) -> None:
    scene = scene_of()
    start = initial_state(scene)
    state = (start.com_m, start.com_velocity_m_s, start.angle_rad, start.rate_rad_s)
    simulation = Simulation(chain_model(scene), *state, rtol=1e-5, coordinates=coordinates)
    h = simulation.history(simulation.integrate(scene.times_s))
    seen = Trajectory(h.t_s, h.com_m, h.com_velocity_m_s, angle_rad=h.angle_rad, position_m=h.position_m)
    computed, residual = gaps(scene, seen), centre_of_mass_residual(scene, seen)
    np.testing.assert_allclose(computed, h.gap_m, rtol=0.0, atol=8.0 * UNIT * scene.size_m)
    np.testing.assert_allclose(residual, h.com_residual_m, rtol=0.0, atol=8.0 * UNIT * scene.size_m)
    assert computed.max() > 100.0 * UNIT * scene.size_m  # there is something to see


@pytest.mark.parametrize("engine", [Reference, ExudynTree])
def test_an_engine_whose_places_follow_from_the_angles_gives_none(engine: type[Engine]) -> None:
    scene, seen = scene_of(), run(engine)
    assert seen.position_m is None
    assert gaps(scene, seen) is None
    assert centre_of_mass_residual(scene, seen) is None
    assert measured(scene, seen) is seen


# what is rejected


@pytest.mark.parametrize("engine", [Exudyn, PymunkAbsolute])
def test_an_engine_that_reports_closed_joints_is_refused_where_its_places_leave_gaps(engine: type[Engine]) -> None:
    scene = scene_of("effects/tip_masses")
    lying = nothing_amiss(opened(run(engine, "effects/tip_masses"), OPENED, after=1, sample=3))
    found = fault(scene, engine, lying)
    assert found[0] is Outcome.INCOMPLETE
    assert found[1].startswith("reports a gap of 0 m at joint 1 at t = ")


def test_the_reason_names_the_joint_the_instant_and_both_gaps() -> None:
    scene = scene_of()
    found = fault(scene, ReferenceAbsolute, opened(nothing_amiss(run(ReferenceAbsolute)), OPENED, after=2, sample=3))
    at = f"{scene.times_s[3]:.6g}"
    assert found[1] == f"reports a gap of 0 m at joint 2 at t = {at} s, its bars' places leave 3.1e-06 m"


def test_a_centre_of_mass_beside_the_bars_is_refused_if_it_is_reported_to_be_among_them() -> None:
    scene, seen = scene_of(), run(ReferenceAbsolute)
    found = fault(
        scene, ReferenceAbsolute, nothing_amiss(seen).replace(position_m=seen.position_m + np.array([0.0, OPENED]))
    )
    assert found[0] is Outcome.INCOMPLETE
    assert "weighted centre 0 m from the centre of mass at t = 0 s, their places leave 3.1e-06 m" in found[1]


@pytest.mark.parametrize("reported", [True, False])
def test_joints_that_do_not_hold_are_seen_by_the_places(reported: bool) -> None:
    """Whether the engine says so or has nothing to say."""
    scene = scene_of()
    broken = opened(run(Exudyn), 30.0, after=2)
    assert fault(scene, Exudyn, broken.replace(gap_m=gaps(scene, broken) if reported else None)) == (
        (Outcome.JOINTS_IGNORED, "joint 2 is open by 30 m at t = 0 s")
        if reported
        else (Outcome.INCOMPLETE, "declares but does not return: gap")
    )


def test_places_of_another_shape_or_not_finite_are_refused() -> None:
    scene, seen = scene_of(), run(Exudyn)
    short = fault(scene, Exudyn, seen.replace(position_m=seen.position_m[:, 1:]))
    assert short[1].startswith("position_m has shape")
    lost = fault(scene, Exudyn, seen.replace(position_m=np.full_like(seen.position_m, np.nan)))
    assert lost[0] is Outcome.NOT_FINITE


# what rounding explains


def test_places_in_absolute_coordinates_may_carry_the_rounding_of_the_radius() -> None:
    scene = scene_of()
    grain = float(np.spacing(scene.radius0_m))
    for engine, allowed in ((ExudynAbsolute, True), (Exudyn, False)):
        seen = run(engine)
        assert (fault(scene, engine, seen.replace(gap_m=seen.gap_m + grain)) is None) is allowed


def test_places_in_a_frame_may_carry_the_rounding_of_how_far_the_chain_is_driven_off_it() -> None:
    """Air drives the chain kilometres off the frame's Kepler orbit in the course of this run."""
    grain = float(np.spacing(1000.0))
    for name, allowed in (("effects/drag", True), ("paper/fig13", False)):
        scene = load_scene(name)
        scene = dataclasses.replace(scene, run=dataclasses.replace(scene.run, samples=7))
        seen = Exudyn().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, 500.0))
        assert (fault(scene, Exudyn, seen.replace(gap_m=seen.gap_m + 50.0 * grain)) is None) is allowed


def test_the_digits_that_a_bar_loses_by_turning_often_are_no_gap() -> None:
    """The engine knows its own angle better than the one it tells, of a million turns more."""
    scene, seen = scene_of(), run(ExudynIndex3)
    often = seen.replace(angle_rad=seen.angle_rad + 2.0 * np.pi * LONG_TURNED)
    assert fault(scene, ExudynIndex3, often) is None
    assert drifts(scene, often)["gap"].max() == drifts(scene, seen)["gap"].max()


# what is judged


def test_opened_places_are_judged_even_if_the_gap_channel_says_closed() -> None:
    scene = scene_of()
    seen = nothing_amiss(opened(run(ReferenceAbsolute), OPENED, after=2, sample=3))
    found = drifts(scene, seen)
    assert found["gap"][:3].max() <= 8.0 * np.spacing(scene.radius0_m)
    assert found["gap"][3:] == pytest.approx(OPENED, rel=1e-2)
    assert found["com_residual"][3:].min() > 0.1 * OPENED


def test_a_joint_is_ignored_where_it_is_open_by_a_tenth_of_its_shorter_bar() -> None:
    scene = scene_of("basics/two_bars_free")
    lengths = sorted(scene.chain.length_m)
    assert 0.13 * lengths[0] < 0.1 * lengths[1], "a tenth of the longer bar is more"
    undeclared = type("Undeclared", (Exudyn,), {"observables": Exudyn.observables - {"gap"}})
    seen = run(Exudyn, "basics/two_bars_free").replace(gap_m=None)
    assert fault(scene, undeclared, opened(seen, 0.09 * lengths[0], after=1)) is None
    found = fault(scene, undeclared, opened(seen, 0.13 * lengths[0], after=1))
    assert found[0] is Outcome.JOINTS_IGNORED


@pytest.mark.parametrize(("late", "refused"), [(0.5e-9, False), (3e-9, True)])
def test_samples_are_at_the_instants_asked_for_to_a_billionth_of_the_run(late: float, refused: bool) -> None:
    scene, seen = scene_of(), run(Reference)
    found = fault(scene, Reference, seen.replace(t_s=seen.t_s + late * scene.run.duration_s))
    assert (found is not None) is refused
