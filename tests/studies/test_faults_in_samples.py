"""Each fault in samples, declarations or settings changes what it says, by as much as it says."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Coordinates, Setting
from adapters.exudyn.adapter import Exudyn
from adapters.pymunk.adapter import Pymunk
from adapters.reference.numpy_engines import Reference
from adapters.registry import find_engine
from barchain.runs.job import Role
from barchain.studies.selftest.faults.catalogue import CATALOGUE, fault_registration
from barchain.studies.selftest.faults.samples import LEAST, SHARES
from benchmarks.random_campaign.scenes import draw
from scenarios import Gravity

if TYPE_CHECKING:
    from adapters.engine import Declarations, Engine
    from adapters.trajectory import Trajectory
    from scenarios import Scene


BUSY = 2
"""Random scene with an impulse, a thrust and a slew"""
MAIN, FINER = Setting(AccuracyParameter.RTOL, 1e-10), Setting(AccuracyParameter.RTOL, 1e-11)


@pytest.fixture(scope="module")
def scene() -> Scene:
    """Three bars in a point's pull, for a third of an orbit."""
    drawn = draw(8)
    return dataclasses.replace(drawn, run=dataclasses.replace(drawn.run, samples=41))


@pytest.fixture(scope="module")
def unmodified(scene: Scene) -> Trajectory:
    """Run of it."""
    return seen(scene)


def seen(scene: Scene, setting: Setting = MAIN) -> Trajectory:
    """Run of the reference."""
    return Reference().run(scene, setting)


def with_fault(name: str, run: Trajectory, scene: Scene, setting: Setting = MAIN) -> Trajectory:
    """What a run shows with a fault in it."""
    return CATALOGUE[name].output_of(run, scene, setting, CATALOGUE[name].natural)


def staged(name: str, scene: Scene) -> Scene:
    """Scene that an engine with a fault in it is given."""
    return CATALOGUE[name].staged(scene, CATALOGUE[name].natural)


def run_of(fault: str, scene: Scene, setting: Setting) -> Trajectory:
    """Run of the reference with a fault as the self-test registers it."""
    engine = fault_registration("reference", fault).engine()
    engine.build(scene, setting)
    engine.simulate()
    return engine.read()


@pytest.mark.parametrize("begins", SHARES)
def test_garbage_begins_where_it_says(begins: str, scene: Scene, unmodified: Trajectory) -> None:
    at = SHARES[begins] * scene.run.duration_s
    before, off_m = unmodified.t_s < at, {}
    for how in ("sudden", "growing"):
        found = with_fault(f"garbage-{how}-{begins}-all", unmodified, scene)
        for name in ("com_m", "angle_rad", "reaction_N"):
            off = np.abs(getattr(found, name) - getattr(unmodified, name)).reshape(len(before), -1).max(axis=1)
            assert not off[before].any()
            assert off[~before].all()
        assert np.array_equal(found.rate_rad_s, unmodified.rate_rad_s)
        off_m[how] = np.linalg.norm(found.com_m - unmodified.com_m, axis=1)
    last = off_m["sudden"][-1]
    assert 0.7e6 <= last <= 2.1e6
    assert off_m["sudden"][~before] == pytest.approx(last)
    assert off_m["growing"][-1] == pytest.approx(last)
    share = np.log(off_m["growing"][-2] / last) / np.log(LEAST)
    assert share == pytest.approx((unmodified.t_s[-1] - unmodified.t_s[-2]) / (unmodified.t_s[-1] - at), rel=1e-6)


def test_garbage_is_put_into_the_runs_that_it_says_and_differs_from_run_to_run(
    scene: Scene, unmodified: Trajectory
) -> None:
    assert CATALOGUE["garbage-sudden-25-main"].acts_in(Role.MAIN)
    assert not CATALOGUE["garbage-sudden-25-main"].acts_in(Role.FINER)
    assert not CATALOGUE["garbage-sudden-25-finer"].acts_in(Role.ROUNDOFF_1)
    assert all(CATALOGUE["garbage-sudden-25-all"].acts_in(role) for role in Role)
    amounts = [
        with_fault("garbage-com", unmodified, scene, s).com_m[-1] - unmodified.com_m[-1] for s in (MAIN, FINER, MAIN)
    ]
    assert np.array_equal(amounts[0], amounts[2])
    assert np.linalg.norm(amounts[0]) != pytest.approx(np.linalg.norm(amounts[1]), rel=1e-3)


@pytest.mark.parametrize(("name", "channel"), [
    ("garbage-com", "com_m"), ("garbage-attitude", "angle_rad"), ("garbage-reactions", "reaction_N"),
    ("com-millimetres", "com_m"), ("attitude-decimals", "angle_rad"), ("attitude-creeps", "angle_rad"),
    ("noise-reactions-large", "reaction_N"), ("noise-rates", "rate_rad_s"), ("interpolated-2000", "angle_rad"),
    ("sign-reaction", "reaction_N"), ("damped-rate", "rate_rad_s"),
])  # fmt: skip
def test_a_fault_changes_its_channel_alone(name: str, channel: str, scene: Scene, unmodified: Trajectory) -> None:
    found = with_fault(name, unmodified, scene)
    for other, value in vars(unmodified).items():
        if isinstance(value, np.ndarray):
            assert np.array_equal(getattr(found, other), value) == (other != channel), other


def test_what_is_written_with_few_digits_has_few(scene: Scene, unmodified: Trajectory) -> None:
    written = with_fault("com-millimetres", unmodified, scene).com_m
    assert np.abs(1e3 * written - np.round(1e3 * written)).max() < 1e-5
    assert np.abs(written - unmodified.com_m).max() <= 0.5001e-3
    degrees = np.rad2deg(with_fault("attitude-decimals", unmodified, scene).angle_rad)
    assert np.abs(1e6 * degrees - np.round(1e6 * degrees)).max() < 1e-6


def test_small_faults_are_as_small_as_they_say(scene: Scene, unmodified: Trajectory) -> None:
    off = with_fault("attitude-creeps", unmodified, scene).angle_rad - unmodified.angle_rad
    assert not off[:, :-1].any()
    assert off[:, -1] == pytest.approx(1e-7 * (unmodified.t_s / scene.period_s) ** 2, abs=1e-14)
    reactions = with_fault("noise-reactions-small", unmodified, scene).reaction_N - unmodified.reaction_N
    scale = np.linalg.norm(unmodified.reaction_N, axis=-1).max()
    assert not reactions[0].any()
    assert np.std(reactions[1:]) == pytest.approx(1e-6 * scale, rel=0.3)
    lost = 1.0 - with_fault("damped-rate", unmodified, scene).rate_rad_s[-1] / unmodified.rate_rad_s[-1]
    assert lost == pytest.approx(1e-4, rel=1e-6)


def test_lines_between_steps_leave_at_most_an_eighth_of_the_second_difference(
    scene: Scene, unmodified: Trajectory
) -> None:
    curved = np.abs(np.gradient(unmodified.rate_rad_s, unmodified.t_s, axis=0)).max()
    for steps in (20000, 2000):
        off = np.abs(with_fault(f"interpolated-{steps}", unmodified, scene).angle_rad - unmodified.angle_rad).max()
        largest = curved * (scene.period_s / steps) ** 2 / 8.0
        assert 0.1 * largest < off < 1.5 * largest


def test_torn_joints_are_said_to_be_closed(scene: Scene, unmodified: Trajectory) -> None:
    found = with_fault("joints-torn", unmodified, scene)
    late = unmodified.t_s > 0.5 * scene.run.duration_s
    assert not found.gap_m.any()
    assert not found.com_residual_m.any()
    assert not found.reaction_N[late].any()
    assert np.ptp(found.rate_rad_s[late], axis=0) == pytest.approx(0.0)
    assert np.array_equal(found.angle_rad[~late], unmodified.angle_rad[~late])


def test_places_part_about_their_centre_where_there_are_such(scene: Scene, unmodified: Trajectory) -> None:
    assert with_fault("joints-parted", unmodified, scene) is unmodified
    placed = unmodified.replace(
        position_m=np.zeros((len(unmodified.t_s), scene.bars, 2)), gap_m=np.ones_like(unmodified.gap_m)
    )
    found = with_fault("joints-parted", placed, scene)
    assert not found.gap_m.any()
    assert np.abs(np.einsum("j,njk", scene.chain.mass_kg, found.position_m)).max() < 1e-9
    apart = np.diff(found.position_m[-1, :, 0])
    assert apart == pytest.approx(1e-3 * min(scene.chain.length_m))


def test_an_invented_end_is_at_a_quarter_of_the_run(scene: Scene, unmodified: Trajectory) -> None:
    found = with_fault("invented-end", unmodified, scene)
    assert "a bar reached the surface" in found.ended
    assert found.t_s[-1] == pytest.approx(0.25 * scene.run.duration_s)
    assert len(found.angle_rad) == len(found.t_s) == 11


def test_wrong_scenes_are_wrong_in_one_thing(scene: Scene) -> None:
    heavy, strong = staged("mass", scene), staged("mu", scene)
    assert heavy.chain.mass_kg[-1] == pytest.approx(1.01 * scene.chain.mass_kg[-1])
    assert heavy.chain.inertia_kg_m2 == scene.chain.inertia_kg_m2
    assert strong.central_body.mu_m3_s2 == pytest.approx(scene.central_body.mu_m3_s2 * (1.0 + 1e-6), rel=1e-12)
    assert strong.speed0_m_s == pytest.approx(scene.speed0_m_s, rel=1e-15)
    exact = dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, gravity=Gravity.SLENDER))
    assert staged("gravity-model", exact).effects.gravity is Gravity.QUADRUPOLE


def test_late_and_stretched_events(scene: Scene) -> None:
    busy = draw(BUSY)
    (blow,), (thrust,) = busy.effects.impulse, busy.effects.thrust
    late = staged("impulse-late-millisecond", busy).effects.impulse[0]
    assert late.at_s == pytest.approx(blow.at_s + 1e-3, rel=1e-15)
    assert staged("thrust-late", busy).effects.thrust[0].times_s[0] == thrust.times_s[0] + 1.0
    slow = staged("clock-fast", busy)
    assert slow.run.duration_s / busy.run.duration_s == pytest.approx(1.0 + 1e-7, rel=1e-12)
    assert slow.effects.impulse[0].at_s / blow.at_s == pytest.approx(1.0 + 1e-7, rel=1e-12)
    found = with_fault("clock-fast", seen(staged("clock-fast", scene)), scene)
    assert np.array_equal(found.t_s, scene.times_s)


def test_a_stuck_engine_gives_the_same_bits_at_all_settings(scene: Scene) -> None:
    runs = [run_of("mass-stuck", scene, s) for s in (MAIN, FINER)]
    assert all(np.array_equal(getattr(runs[0], n), getattr(runs[1], n)) for n in ("angle_rad", "com_m", "reaction_N"))
    assert not np.array_equal(runs[0].reaction_N, seen(scene).reaction_N)


def test_a_sloppy_engine_claims_many_steps(scene: Scene) -> None:
    sloppy = run_of("sloppy", scene, MAIN)
    assert sloppy.info["steps"] == 1e9
    assert np.array_equal(sloppy.angle_rad, seen(scene, Setting(AccuracyParameter.RTOL, 1e3 * MAIN.value)).angle_rad)


def test_false_declarations_are_those_that_judge(scene: Scene, unmodified: Trajectory) -> None:
    def said(name: str, host: type[Engine]) -> Declarations:
        return CATALOGUE[name].declares(host.declarations(), unmodified)

    noise = said("declares-noise", Reference).noise(scene, MAIN, unmodified.t_s)
    assert noise["attitude"] == 1.0
    assert noise["reaction"] == pytest.approx(np.linalg.norm(unmodified.reaction_N, axis=-1).max())
    assert said("declares-order", Exudyn).order == 1.0
    assert said("declares-absolute", Pymunk).coordinates is Coordinates.ABSOLUTE
    assert not said("declares-track", find_engine("reference-absolute").load()).track_by_length
    assert "chooses its steps" in CATALOGUE["declares-order"].foreign(Reference.declarations())
    assert "rightly" in CATALOGUE["declares-track"].foreign(Reference.declarations())
    assert "equal steps" in CATALOGUE["sloppy"].foreign(Exudyn.declarations())
    assert "no gaps" in CATALOGUE["joints-torn"].foreign(find_engine("exudyn-tree").declarations())
