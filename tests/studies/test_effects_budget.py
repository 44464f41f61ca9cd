"""What an effect budget switches, how large it finds effects, and what it calls resolved; times are never asserted."""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import pytest

from adapters.common.initial_state import initial_state
from adapters.reference.numpy_engines import Reference
from barchain.runs.executors import LocalProcesses
from barchain.runs.message import read_message
from barchain.runs.other_settings import compiled_can
from barchain.runs.pool import Slot
from barchain.studies.defaults import FAST, SLOW
from barchain.studies.effects.default_air import (
    LAYERS,
    Heights,
    caveat,
    density_kg_m3,
    expected_heights,
    heights_of,
    layer_at,
)
from barchain.studies.effects.sizes import RunPair, change, situation, sizes_over
from barchain.studies.effects.study import EffectsStudy, effects_study
from barchain.studies.effects.switches import switches
from barchain.studies.effects.timing import (
    BATCH_S,
    BATCHES,
    Timed,
    price_columns,
    shortened,
    timed_evaluations,
    timed_span_s,
)
from barchain.studies.study import Reporter, run_study
from reports.results.effects import FILES, EffectKind
from scenarios import Gravity, Scene, load_scene
from tests.support import solutions
from tests.support.scene_lists import TAME
from tests.support.slow import one_in

if TYPE_CHECKING:
    from pathlib import Path

    from adapters.trajectory import Trajectory
    from barchain.studies.effects.switches import Switch

DRAG = "effects/drag"
SHARE = 0.03
"""Orbits of the small budget"""


def brief(scene: Scene, orbits: float = 0.1, samples: int = 11) -> Scene:
    """Scene over a share of its run."""
    return dataclasses.replace(
        scene, run=dataclasses.replace(scene.run, duration_s=orbits * scene.period_s, samples=samples)
    )


def one_of(scene: Scene, effect: str, heights: Heights | None = None, width_m: float | None = None) -> Switch:
    """Switch of one effect."""
    return next(s for s in switches(scene, heights, width_m) if s.effect == effect)


def motion(scene: Scene, rtol: float = 1e-10) -> Trajectory:
    """Run of the reference."""
    return solutions.run(scene, rtol)


@pytest.mark.parametrize("name", one_in(4, TAME))
def test_every_switch_changes_its_effect_and_nothing_else(name: str) -> None:
    scene = load_scene(name)
    for s in switches(scene):
        assert (s.scene is None) == bool(s.reason), s.effect
        if s.scene is None:
            continue
        field = s.effect.partition(".")[0]
        same = {f.name for f in dataclasses.fields(scene.effects)} - {field}
        assert dataclasses.replace(s.scene, effects=scene.effects) == scene
        assert all(getattr(s.scene.effects, f) == getattr(scene.effects, f) for f in same)
        assert getattr(s.scene.effects, field) != getattr(scene.effects, field)
        assert Reference.unsupported(s.scene) is None


def test_nature_is_offered_by_default_and_the_design_only_where_it_is() -> None:
    bound = load_scene("paper/fig13")
    plain = {s.effect for s in switches(bound)}
    nature = {"oblateness", "third_body.moon", "third_body.sun", "drag", "solar_pressure"}
    assert plain == nature | {"gravity.point", "gravity.quadrupole", "gravity.slender"}
    full = {s.effect: s for s in switches(load_scene("effects/everything"))}
    design = {"joint_spring_damper", "thrust", "impulse"}
    assert design == {e for e, s in full.items() if s.on and s.kind is EffectKind.DESIGN}
    assert all(full[e].on for e in nature | {"solar_pressure.shadow"})
    away = dataclasses.replace(bound, orbit=dataclasses.replace(bound.orbit, speed_factor=1.5))
    assert "gravity.none" in {s.effect for s in switches(away)}, "only to what is not bound"


@pytest.mark.parametrize(
    ("name", "effect", "words"),
    [
        ("effects/tip_masses", "gravity.slender", "not uniform"),
        ("effects/solar_pressure", "drag", "no air at the run's lowest height of 35786 km"),
        ("basics/two_bars_free", "oblateness", "does not pull"),
        ("paper/fig13", "solar_pressure", "give it by --width"),
    ],
)
def test_what_can_not_be_switched_says_why(name: str, effect: str, words: str) -> None:
    assert words in one_of(load_scene(name), effect).reason


def test_the_width_of_the_bars_is_the_given_one_or_the_scenes_and_never_guessed() -> None:
    plain, draggy = load_scene("paper/fig13"), load_scene(DRAG)
    for effect in ("drag", "solar_pressure"):
        given = one_of(plain, effect, width_m=2e-3)
        assert getattr(given.scene.effects, effect).width_m == given.width_m == (2e-3,) * plain.bars
    own_m = draggy.effects.drag.width_m
    assert one_of(draggy, "solar_pressure").scene.effects.solar_pressure.width_m == own_m
    assert one_of(draggy, "drag", width_m=7.0).width_m == own_m


def test_a_chain_of_more_bars_of_the_same_width_gets_the_same_drag() -> None:
    """A tether told as one bar or as twenty has one width: the push on its centre of mass is that of its face."""
    whole = load_scene("paper/fig13")
    chain = whole.chain
    split = dataclasses.replace(
        chain, mass_kg=tuple(0.5 * m for m in chain.mass_kg for _ in "ab"),
        length_m=tuple(0.5 * x for x in chain.length_m for _ in "ab"),
        inertia_kg_m2=tuple(0.125 * x for x in chain.inertia_kg_m2 for _ in "ab"),
        angle_rad=tuple(x for x in chain.angle_rad for _ in "ab"),
        rate_factor=tuple(x for x in chain.rate_factor for _ in "ab"),
    )  # fmt: skip
    pushes = []
    for scene in (whole, dataclasses.replace(whole, chain=split)):
        brief_run = brief(scene, 0.01, 3)
        found = sizes_over(brief_run, one_of(brief_run, "drag", width_m=2e-3), motion(brief_run))
        pushes.append(found[0].common)
    assert pushes[0] == pytest.approx(pushes[1], rel=1e-3)  # the chain's height over the scale height squared


def test_another_planet_gets_none_of_the_earths_defaults() -> None:
    scene = load_scene("paper/fig13")
    body = dataclasses.replace(scene.central_body, mu_m3_s2=4.28e13, radius_m=3396e3)
    found = [s for s in switches(dataclasses.replace(scene, central_body=body)) if s.kind is EffectKind.NATURE]
    assert len(found) == 5
    assert all("another body" in s.reason for s in found)


def test_the_standard_air_is_nearly_continuous_from_entry_to_entry() -> None:
    """Each entry's exponential ends within 1.5 % of where the next begins, as a table of three digits lets it."""
    for below, above in itertools.pairwise(LAYERS):
        end = below.density_kg_m3 * math.exp(-(above.base_km - below.base_km) / below.scale_height_km)
        assert end == pytest.approx(above.density_kg_m3, rel=1.5e-2), above
    assert layer_at(349.999e3).base_km == 300
    assert layer_at(350e3).base_km == 350
    assert layer_at(5000e3).base_km == 1000


def transfer(samples: int = 41, orbits: float = 1.0) -> Scene:
    """Scene that starts 1000 km up and comes down to 180 km half an orbit later."""
    scene = load_scene("paper/fig13")
    high = scene.central_body.radius_m + 1000e3
    low = scene.central_body.radius_m + 180e3
    start = dataclasses.replace(scene.orbit, altitude_m=1000e3, speed_factor=math.sqrt(2.0 * low / (low + high)))
    point = dataclasses.replace(scene.effects, gravity=Gravity.POINT)
    return brief(dataclasses.replace(scene, orbit=start, effects=point), orbits, samples)


@pytest.mark.parametrize("samples", [12, 2])
def test_a_perigee_is_found_between_samples(samples: int) -> None:
    """Of a point's pull on bars of 100 m the orbit is that of two bodies to (l/r)², 1e-10: 1 m is plenty."""
    scene = transfer(samples)
    run = motion(scene)
    found = heights_of(scene, run)
    assert found.lowest_m == pytest.approx(180e3, abs=1.0)
    assert found.highest_m == pytest.approx(1000e3, abs=1.0)
    assert expected_heights(scene) == pytest.approx(found, abs=1.0)
    before = transfer(orbits=0.25)
    assert heights_of(before, motion(before)).lowest_m > 500e3  # perigee is still to come
    assert expected_heights(before) == (1000e3, 1000e3)


def test_drag_is_taken_in_the_air_of_the_lowest_height() -> None:
    """Within the 1.5 % by which entries of the table do not meet, it is the table's there."""
    scene = transfer()
    for heights in (None, Heights(180.1e3, 1000e3), Heights(179.9e3, 1000e3)):
        found = one_of(scene, "drag", heights, 1.0)
        air = found.scene.effects.drag
        there = air.density_kg_m3 * math.exp(-(180e3 - air.altitude_m) / air.scale_height_m)
        assert there == pytest.approx(5.464e-10, rel=1.5e-2)
        assert "lowest height of the run without drag, 1" in found.said
        assert "lower bound" in found.caveat


@pytest.mark.exhaustive
def test_the_budget_takes_the_heights_that_its_own_run_came_to(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A thrust that lifts the chain, or anything besides two bodies, is in them."""
    asked: list[Heights] = []

    def kept(_: Scene, heights: Heights, __: float | None) -> tuple[Switch, ...]:
        asked.append(heights)
        return ()

    scene = transfer(11)
    options: dict[str, Any] = {"rtol": 1e-8, "engine": SLOW, "repeats": 1, "seconds": 0.0}
    study = dataclasses.replace(effects_study(scene, executor=LocalProcesses(2), **options), switches=())
    monkeypatch.setattr("barchain.studies.effects.study.switches", kept)
    run_study(study, tmp_path)
    assert asked == [pytest.approx(Heights(180e3, 1000e3), abs=1.0)]


def test_one_exponential_says_on_which_side_it_is() -> None:
    assert caveat(layer_at(400e3), Heights(400e3, 500e3)) == ""  # 1.7 scale heights
    upper = 3.206e-4 * math.exp(-30.0 / 7.714) / 3.396e-6
    said = caveat(layer_at(60e3), Heights(60e3, 90e3))
    assert f"up to {upper:.2g} times the table's" in said
    assert "upper bound" in said
    assert "lower bound" in caveat(layer_at(200e3), Heights(200e3, 1000e3))
    assert "no bound" in caveat(layer_at(0.0), Heights(0.0, 1e9))  # the table ends at 2000 km
    assert density_kg_m3(250e3) == 7.248e-11


def test_sizes_are_those_of_closed_forms() -> None:
    """J2's pull over gravity is 3/2 J2 (R/r)²; its gradient over the tide's, radially, 2 times that."""
    scene = brief(load_scene("paper/fig13"))
    seen = motion(scene)
    found = sizes_over(scene, one_of(scene, "oblateness"), seen)
    expected = 1.5 * 1.08262668e-3 * (scene.central_body.radius_m / scene.radius0_m) ** 2
    assert found[0].common == pytest.approx(expected, rel=1e-3)  # (l/r)² and the chain's length over r besides
    assert found[0].between == pytest.approx(2.0 * expected, rel=0.03)  # 80°: 3 % of the square lie across
    point = sizes_over(scene, one_of(scene, "gravity.point"), seen)
    phi = initial_state(scene).angle_rad[0] + 0.5 * math.pi - scene.orbit.longitude_rad
    assert point[0].torque == pytest.approx(abs(math.sin(phi) * math.cos(phi)), rel=1e-3)
    assert (point[0].between, point[0].common) == (0.0, 0.0)


def test_what_gravity_adds_is_told_without_cancellation() -> None:
    """Quadrupole and slender agree to (l/r)² of their own small push: 1e-10 for bars of 100 m."""
    scene = brief(load_scene("paper/fig13"))
    seen = motion(scene)
    pair = [sizes_over(scene, one_of(scene, f"gravity.{g}"), seen) for g in ("quadrupole", "slender")]
    assert 0.0 < pair[0][0].common < 1e-9
    assert pair[0][0].common == pytest.approx(pair[1][0].common, rel=1e-8)


def test_a_thrust_between_two_samples_has_its_size_and_a_blow_has_none() -> None:
    """F over the chain's mass, over g, whichever way the bars have turned; steady, or a peak that lasts for nothing."""
    scene = load_scene("effects/thrust")
    own = scene.effects.thrust[0]
    start = 0.5 * float(scene.times_s[1])
    for times, force in (((start, start + 0.01), (1.0, 1.0)), ((start, start + 0.01, start + 0.02), (0.0, 1.0, 0.0))):
        pulse = dataclasses.replace(own, times_s=times, force_N=force)
        pulsed = dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, thrust=(pulse,)))
        found = sizes_over(pulsed, one_of(pulsed, "thrust"), motion(brief(pulsed, 0.1, 3)))
        assert found[0].common == 0.0  # it has yet to begin
        expected_m_s2 = 1.0 / scene.mass_kg
        gravity = scene.central_body.mu_m3_s2 / scene.radius0_m**2
        assert found[1].common == pytest.approx(expected_m_s2 / gravity, rel=1e-3)  # of r in so little an arc
    hit = load_scene("effects/impulse")
    assert sizes_over(hit, one_of(hit, "impulse"), motion(brief(hit, 0.1, 3))) is None


def test_between_samples_a_state_is_the_cubic_of_both() -> None:
    """Off by at most h⁴/384 of the fourth derivative, largest at perigee: (3 β² - 2) mu²/r⁵."""
    scene = brief(load_scene("paper/fig13"), 0.1, 21)
    coarse, fine = motion(brief(scene, 0.1, 6)), motion(scene)
    assert scene.orbit.speed_factor > 1.0  # it starts at perigee
    fourth = (3.0 * scene.orbit.speed_factor**2 - 2.0) * scene.central_body.mu_m3_s2**2 / scene.radius0_m**5
    most = float(coarse.t_s[1]) ** 4 / 384.0 * fourth
    off = [abs(complex(*fine.com_m[k]) - situation(scene, coarse, float(fine.t_s[k])).com) for k in range(21)]
    assert 0.5 * most < max(off) < most
    assert max(off[::4]) == 0.0


def test_a_change_below_the_numerics_is_not_resolved() -> None:
    """The same scene twice changes nothing, and that nothing has a bound above zero."""
    scene = brief(load_scene(DRAG))
    runs = RunPair(motion(scene, 1e-10), motion(scene, 1e-9))
    nothing = change(runs, runs)
    assert set(nothing.largest) == {"com", "attitude", "reaction"}
    for name, value in nothing.largest.items():
        assert value == 0.0
        assert nothing.noise[name] > 0.0
    other = one_of(scene, "drag").scene
    found = change(runs, RunPair(motion(other, 1e-10), motion(other, 1e-9)))
    assert found.compared_s == scene.run.duration_s
    assert found.largest["com"] > 1e3 * found.noise["com"]


def test_nothing_is_compared_after_the_horizon_of_either_scene() -> None:
    scene = brief(load_scene(DRAG))
    tight = motion(scene)
    parted = dataclasses.replace(tight, angle_rad=tight.angle_rad + np.linspace(0.0, 0.095, 11)[:, None])
    found = change(RunPair(tight, tight), RunPair(tight, parted))
    assert found.compared_s == tight.t_s[1]  # 0.0095 rad, and twice that in the next


def test_a_single_bar_has_no_reactions_to_change() -> None:
    scene = brief(load_scene("basics/libration"))
    assert scene.bars == 1
    runs = RunPair(motion(scene), motion(scene, 1e-9))
    assert set(change(runs, runs).largest) == {"com", "attitude"}
    found = sizes_over(scene, one_of(scene, "oblateness"), runs.tight)
    assert math.isnan(found[0].between)


def test_prices_are_medians_of_ratios_within_rounds() -> None:
    found = price_columns(Timed([2.0, 4.0, math.nan, 6.0], 20, [3e-6]), Timed([1.0, 2.0, 1.0, 2.0], 10, [2e-6]))
    assert found["rounds"] == 3
    ratios = [found[name] for name in ("time_ratio", "evaluation_ratio", "evaluations_ratio")]
    assert ratios == pytest.approx([2.0, 1.5, 2.0])
    assert price_columns(Timed([math.nan], 0), Timed([1.0], 10)) == {}


def test_a_run_too_long_for_three_rounds_is_timed_in_part() -> None:
    scene = load_scene(DRAG)
    assert timed_span_s(scene, 5.0, 20.0) == scene.run.duration_s
    assert timed_span_s(scene, 10.0, 20.0) == pytest.approx(0.5 * scene.run.duration_s)
    assert timed_span_s(scene, 10.0, 20.0, rounds=1) == scene.run.duration_s
    job = effects_study(scene, engine=SLOW).tight[0]
    assert shortened(job, scene.run.duration_s) is job
    part = shortened(job, 0.5 * scene.run.duration_s).scene.run
    assert part.duration_s / (part.samples - 1) == pytest.approx(scene.run.duration_s / (scene.run.samples - 1))
    pushed = load_scene("effects/thrust")
    assert timed_span_s(pushed, 1e3, 20.0) > max(t for t in pushed.effects.breaks_s if t < pushed.run.duration_s)


def test_evaluations_are_timed_in_turn_for_long_enough() -> None:
    assert BATCHES * BATCH_S >= 0.02
    scene = brief(load_scene(DRAG))
    _, found = read_message(timed_evaluations([(SLOW, scene), (SLOW, scene)], 2, None))
    assert found["evaluation_s"].shape == (2, 2)
    assert (found["evaluation_s"] > 0.0).all()


def test_both_scenes_of_a_pair_run_in_one_engine() -> None:
    plan = effects_study(load_scene(DRAG))
    for s in plan.switches:
        if s.scene:
            engines = {job.engine for job in plan.pair(s)}
            assert engines == {FAST if compiled_can([plan.scene, s.scene]) else SLOW}
    assert len({job.key for job in plan.runs}) == len(plan.runs) == 2 * len(plan.tight)
    assert {job.engine for job in effects_study(load_scene(DRAG), engine=SLOW).runs} == {SLOW}


def test_light_on_bars_that_cross_its_edge_together_does_not_stop_the_run() -> None:
    """Five parallel bars turn through the Sun's direction within microseconds: each face turns round once."""
    scene = one_of(load_scene("effects/oblateness"), "solar_pressure", width_m=0.1).scene
    assert motion(brief(scene, 0.6), 1e-11).t_s[-1] == pytest.approx(0.6 * scene.period_s)


def small() -> EffectsStudy:
    """A small real budget."""
    options: dict[str, Any] = {"rtol": 1e-9, "engine": SLOW, "repeats": 1, "seconds": 0.0}
    return effects_study(brief(load_scene(DRAG), SHARE), executor=LocalProcesses(1), **options)


@pytest.fixture(scope="module")
def budget(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a small real budget."""
    folder, told, noted = tmp_path_factory.mktemp("budget"), [], []
    plan = small()
    reporter = Reporter(lambda *a: told.append(a), noted.append)
    run_study(plan, folder, command="barchain effects", reporter=reporter)
    assert len(told) == plan.turns
    assert [note.startswith(f"timing {len(plan.tight)} runs in turn") for note in noted] == [True]
    return folder


@pytest.mark.slow
def test_every_effect_has_a_row_with_all_that_was_asked_for(budget: Path) -> None:
    tables = FILES.contents(budget)
    rows = tables.effects.set_index("effect")
    assert list(rows.index) == [s.effect for s in switches(load_scene(DRAG))]
    assert (rows.reason == "").all()
    for column in ("com_m", "attitude_rad", "reaction_N", "time_ratio", "evaluation_ratio", "evaluation_s"):
        assert (rows[column] > 0.0).all(), column
    assert rows.on.sum() == 1
    assert rows.loc["oblateness", "com_m"] > 1e4 * rows.loc["third_body.sun", "com_m"] > 0.0
    # a change is off by no more than what the tolerance leaves, whichever way it is asked for
    assert (rows.com_noise_m > 0.0).all()
    assert tables.record["finished"]
    assert tables.record["scene"]["limit_s"] == tables.record["scene"]["end_s"]
    assert tables.record["scene"]["largest_reaction_N"] > 0.0


@pytest.mark.slow
def test_a_budget_that_goes_on_makes_nothing_that_is_there(budget: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def made(*_: object) -> None:
        raise AssertionError("a run or a time is made again")

    before = FILES.contents(budget).effects
    monkeypatch.setattr(Slot, "run", made)
    run_study(small(), budget, resume=True)
    pd.testing.assert_frame_equal(FILES.contents(budget).effects, before)


@pytest.mark.slow
def test_j2_moves_the_centre_of_mass_as_its_closed_form_says(budget: Path) -> None:
    """To first order 3/4 J2 (R/r)² g t² at first, less what the orbit's own turning makes of it: (n t)²/4 at most."""
    scene = brief(load_scene(DRAG), SHARE)
    rows = FILES.contents(budget).effects.set_index("effect")
    t, r = scene.run.duration_s, scene.radius0_m
    g = scene.central_body.mu_m3_s2 / r**2
    fall = 0.75 * 1.08262668e-3 * (scene.central_body.radius_m / r) ** 2 * g * t * t
    assert rows.loc["oblateness", "com_m"] == pytest.approx(fall, rel=(scene.orbital_rate_rad_s * t) ** 2 / 4.0)
