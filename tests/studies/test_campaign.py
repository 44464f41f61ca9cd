"""The random campaign: its scenes are files, its faults change what they say, its rates and its findings are right."""

from __future__ import annotations

import dataclasses
import math
import time
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import pytest

from adapters.engine import AccuracyParameter, Coordinates, Setting
from adapters.exudyn.adapter import Exudyn
from adapters.pymunk.adapter import Pymunk
from adapters.reference.numpy_engines import Reference
from adapters.registry import find_engine
from barchain.cli.campaign_summary import finding_words, rate_words, show_campaign
from barchain.cli.main import run as command
from barchain.judge.comparison.verdict import no_verdict
from barchain.record.study_store import StudyStore
from barchain.run.job import Role
from barchain.studies.selftest.campaign import rating
from barchain.studies.selftest.campaign.cells import CampaignCell
from barchain.studies.selftest.campaign.faults.catalogue import FAULTS, find
from barchain.studies.selftest.campaign.faults.garbage import LEAST, SHARES
from barchain.studies.selftest.campaign.findings import kept_findings, kinds, search
from barchain.studies.selftest.campaign.judging import judge_serially
from barchain.studies.selftest.campaign.rates import Rate, passed, rates
from barchain.studies.selftest.campaign.runs import RunCache, campaign_registration, in_this_process
from barchain.studies.selftest.campaign.scenes.draw import draw
from barchain.studies.selftest.campaign.scenes.scene_file import UnwrittenError, in_degrees, scene_toml
from barchain.studies.selftest.campaign.scenes.shrink import alike, simplest
from barchain.studies.selftest.campaign.scenes.simpler import Form, effects_of, simplified, whole
from barchain.studies.selftest.campaign.sizes import sizes
from barchain.studies.selftest.campaign.store import CampaignStore
from barchain.studies.selftest.campaign.study import Campaign, CampaignPlan, CampaignStudy
from barchain.studies.selftest.campaign.trial import CampaignTrial
from barchain.studies.selftest.campaign.trial_runner import TrialRunner, thinned
from barchain.studies.selftest.faults.catalogue import UnknownFaultError
from barchain.studies.selftest.faults.faulty_engine import engine_with_fault
from barchain.studies.study import run_study
from reports.chapters.campaign.view import size_rows
from reports.chapters.registry import CHAPTERS
from reports.render import render_all
from reports.tables.faults.campaign import COLUMNS, FILES, RATE_COLUMNS, CellClass
from reports.tables.outcome import Outcome
from scenarios import Gravity, load_scene

if TYPE_CHECKING:
    from pathlib import Path

    from adapters.engine import Engine
    from adapters.trajectory import Trajectory
    from scenarios import Scene

SEED = 8  # three bars in a point's pull, for a third of an orbit
FREE = 6  # two bars without gravity
EVENTS = 2  # an impulse, a thrust and a slew
MAIN, FINER = Setting(AccuracyParameter.RTOL, 1e-10), Setting(AccuracyParameter.RTOL, 1e-11)
TURNED_DEG = 57.29577951308232


# Scenes and their files


@pytest.mark.parametrize("first", range(0, 400, 100))
def test_every_scene_is_read_back_from_its_file_digit_for_digit(first: int, tmp_path: Path) -> None:
    for seed in range(first, first + 100):
        scene = draw(seed)
        path = tmp_path / f"{seed}.toml"
        path.write_text(scene_toml(scene), encoding="utf-8")
        assert load_scene(path).digest == scene.digest


def test_a_scene_is_the_same_for_ever() -> None:
    assert draw(7) == draw(7)
    assert draw(7).digest != draw(8).digest
    assert {draw(seed).effects.gravity for seed in range(100)} == set(Gravity)


def test_shipped_scenes_can_be_written_too() -> None:
    for name in ("paper/fig17", "effects/everything", "effects/solar_shadow", "basics/libration"):
        assert scene_toml(load_scene(name)).startswith("title")


def test_degrees_are_found_where_there_are_such() -> None:
    for deg in np.random.default_rng(1).uniform(-400.0, 400.0, 300).tolist():
        assert math.radians(in_degrees(math.radians(deg))) == math.radians(deg)
    assert in_degrees(1.0) == pytest.approx(TURNED_DEG)
    assert in_degrees(math.radians(30.0)) == 30.0


def test_an_angle_that_no_degrees_give_is_refused() -> None:
    """From 1/4 to 1/2 radians are spaced more closely than the degrees that they are."""
    scene = draw(SEED)
    angles = [0.39567 + k * 2.0**-54 for k in range(40)]
    without = [a for a in angles if math.radians(in_degrees(a)) != a]
    assert without
    odd = dataclasses.replace(scene, orbit=dataclasses.replace(scene.orbit, longitude_rad=without[0]))
    with pytest.raises(UnwrittenError, match="no number of degrees"):
        scene_toml(odd)


# Faults


def seen(scene: Scene, setting: Setting = MAIN) -> Trajectory:
    """Run of the reference."""
    return Reference().run(scene, setting)


@pytest.fixture(scope="module")
def scene() -> Scene:
    """Drawn scene, at a fixed number of samples."""
    drawn = draw(SEED)
    return dataclasses.replace(drawn, run=dataclasses.replace(drawn.run, samples=41))


@pytest.fixture(scope="module")
def unmodified(scene: Scene) -> Trajectory:
    """Run of it."""
    return seen(scene)


def with_fault(name: str, run: Trajectory, scene: Scene, setting: Setting = MAIN) -> Trajectory:
    """What a run shows with a fault in it."""
    fault = FAULTS[name]
    return fault.output_of(run, scene, setting, fault.natural)


def test_names_are_unique_and_words_are_there() -> None:
    assert len(FAULTS) > 45
    for name, fault in FAULTS.items():
        assert fault.name == name
        assert fault.words
        assert fault.stands_for
        assert fault.scene or fault.setting or fault.output or fault.fresh or fault.declares
    with pytest.raises(UnknownFaultError, match="did you mean mass"):
        find("maas")


@pytest.mark.parametrize("begins", SHARES)
def test_garbage_begins_where_it_says(begins: str, scene: Scene, unmodified: Trajectory) -> None:
    at = SHARES[begins] * scene.run.duration_s
    before = unmodified.t_s < at
    for how in ("sudden", "growing"):
        found = with_fault(f"garbage-{how}-{begins}-all", unmodified, scene)
        for name in ("com_m", "angle_rad", "reaction_N"):
            off = np.abs(getattr(found, name) - getattr(unmodified, name)).reshape(len(before), -1).max(axis=1)
            assert not off[before].any()
            assert off[~before].all()
        assert np.array_equal(found.rate_rad_s, unmodified.rate_rad_s)
    off_m = np.linalg.norm(
        with_fault(f"garbage-sudden-{begins}-all", unmodified, scene).com_m - unmodified.com_m, axis=1
    )
    assert 0.7e6 <= off_m[-1] <= 2.1e6
    assert off_m[~before] == pytest.approx(off_m[-1])
    grown_m = np.linalg.norm(
        with_fault(f"garbage-growing-{begins}-all", unmodified, scene).com_m - unmodified.com_m, axis=1
    )
    assert grown_m[-1] == pytest.approx(off_m[-1])
    share = np.log(grown_m[-2] / grown_m[-1]) / np.log(LEAST)
    assert share == pytest.approx((unmodified.t_s[-1] - unmodified.t_s[-2]) / (unmodified.t_s[-1] - at), rel=1e-6)


def test_garbage_is_put_into_the_runs_that_it_says_and_differs_from_run_to_run(
    scene: Scene, unmodified: Trajectory
) -> None:
    assert FAULTS["garbage-sudden-25-main"].acts_in(Role.MAIN)
    assert not FAULTS["garbage-sudden-25-main"].acts_in(Role.FINER)
    assert not FAULTS["garbage-sudden-25-finer"].acts_in(Role.ROUNDOFF_1)
    assert all(FAULTS["garbage-sudden-25-all"].acts_in(role) for role in Role)
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


def staged(name: str, scene: Scene) -> Scene:
    """Scene that an engine with a fault in it is given."""
    return FAULTS[name].staged(scene, FAULTS[name].natural)


def test_wrong_scenes_are_wrong_in_one_thing(scene: Scene) -> None:
    heavy, strong = staged("mass", scene), staged("mu", scene)
    assert heavy.chain.mass_kg[-1] == pytest.approx(1.01 * scene.chain.mass_kg[-1])
    assert heavy.chain.inertia_kg_m2 == scene.chain.inertia_kg_m2
    assert strong.central_body.mu_m3_s2 == pytest.approx(scene.central_body.mu_m3_s2 * (1.0 + 1e-6), rel=1e-12)
    assert strong.speed0_m_s == pytest.approx(scene.speed0_m_s, rel=1e-15)
    exact = dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, gravity=Gravity.SLENDER))
    assert staged("gravity-model", exact).effects.gravity is Gravity.QUADRUPOLE


def test_late_and_stretched_events(scene: Scene) -> None:
    busy = draw(EVENTS)
    (blow,), (thrust,) = busy.effects.impulse, busy.effects.thrust
    assert staged("impulse-late-millisecond", busy).effects.impulse[0].at_s == pytest.approx(
        blow.at_s + 1e-3, rel=1e-15
    )
    assert staged("thrust-late-second", busy).effects.thrust[0].times_s[0] == thrust.times_s[0] + 1.0
    slow = staged("clock-fast", busy)
    assert slow.run.duration_s / busy.run.duration_s == pytest.approx(1.0 + 1e-7, rel=1e-12)
    assert slow.effects.impulse[0].at_s / blow.at_s == pytest.approx(1.0 + 1e-7, rel=1e-12)
    found = with_fault("clock-fast", seen(staged("clock-fast", scene)), scene)
    assert np.array_equal(found.t_s, scene.times_s)


def test_a_stuck_engine_gives_the_same_bits_at_all_settings(scene: Scene) -> None:
    engine = campaign_registration("reference", "mass-stuck").load()
    runs = [engine().run(scene, s) for s in (MAIN, FINER)]
    assert all(np.array_equal(getattr(runs[0], n), getattr(runs[1], n)) for n in ("angle_rad", "com_m", "reaction_N"))
    assert not np.array_equal(runs[0].reaction_N, seen(scene).reaction_N)


def test_a_sloppy_engine_claims_many_steps(scene: Scene) -> None:
    sloppy = campaign_registration("reference", "sloppy").load()().run(scene, MAIN)
    assert sloppy.info["steps"] == 1e9
    assert np.array_equal(sloppy.angle_rad, seen(scene, Setting(AccuracyParameter.RTOL, 1e3 * MAIN.value)).angle_rad)


def test_false_declarations_are_those_of_the_class(scene: Scene, unmodified: Trajectory) -> None:
    def said(name: str, host: type[Engine]) -> type[Engine]:
        return engine_with_fault(FAULTS[name], 1.0, host, main=unmodified)

    noise = said("declares-noise", Reference).noise(scene, MAIN, unmodified.t_s)
    assert noise["attitude"] == 1.0
    assert noise["reaction"] == pytest.approx(np.linalg.norm(unmodified.reaction_N, axis=-1).max())
    assert said("declares-order", Exudyn).order == 1.0
    assert said("declares-absolute", Pymunk).coordinates is Coordinates.ABSOLUTE
    assert not said("declares-track", find_engine("reference-absolute").load()).track_by_length
    assert "chooses its steps" in FAULTS["declares-order"].foreign(Reference)
    assert "rightly" in FAULTS["declares-track"].foreign(Reference)
    assert "equal steps" in FAULTS["sloppy"].foreign(Exudyn)
    assert "no gaps" in FAULTS["joints-torn"].foreign(find_engine("exudyn-tree").load())


# Sizes and rates


def test_sizes_are_shares_of_scales(scene: Scene, unmodified: Trajectory) -> None:
    scale = {
        "com": 1e6,
        "com_velocity": 1.0,
        "attitude": 1.0,
        "rate": 1.0,
        "reaction": 2.0,
        "gap": 1.0,
        "com_residual": 1.0,
    }
    angle, reaction = unmodified.angle_rad.copy(), unmodified.reaction_N.copy()
    angle[30, 1] += 1e-3
    reaction[10, 0] += (3.0, 4.0)
    wrong = unmodified.replace(angle_rad=angle, reaction_N=reaction)
    found = sizes(unmodified, wrong, scale)
    assert found["attitude"] == pytest.approx(1e-3)
    assert found["reaction"] == pytest.approx(2.5)
    assert found["com"] == found["rate"] == found["gap"] == 0.0
    until = {"attitude": float(unmodified.t_s[29])}
    assert sizes(unmodified, wrong, scale, until)["attitude"] == 0.0
    assert sizes(unmodified, with_fault("invented-end", unmodified, scene), scale)["com"] == 1.0


def cells(kind: CellClass, number: int, fault: str = "", outcome: str = "") -> list[CampaignCell]:
    """So many equal cells."""
    return [CampaignCell(f"random/{k}", "pymunk", fault, kind, outcome) for k in range(number)]


def test_rates_have_the_intervals_of_the_textbook() -> None:
    """Wilson's: (p + z²/2n ± z sqrt(p (1 - p)/n + z²/4n²)) / (1 + z²/n)."""
    for n, k in ((200, 0), (200, 3), (7, 7)):
        z, p = 1.959963984540054, k / n
        centre, half = p + z**2 / (2 * n), z * math.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
        expected = [(centre + s * half) / (1 + z**2 / n) for s in (-1.0, 1.0)]
        assert Rate("missed", "all", "all", n, k).interval == pytest.approx(expected, abs=1e-12)
    assert Rate("missed", "all", "all", 0, 0).interval == (0.0, 1.0)
    assert list(Rate("missed", "all", "all", 2, 1).row()) == list(RATE_COLUMNS)


def test_rates_count_what_could_have_happened() -> None:
    alarm = str(Outcome.INCONSISTENT)
    found = [
        *cells(CellClass.PASS, 6), *cells(CellClass.UNSUPPORTED, 5), *cells(CellClass.LIMITED, 1),
        *cells(CellClass.FALSE_ALARM, 1, "", alarm),
        *cells(CellClass.CAUGHT, 3, "mu"), *cells(CellClass.MISSED, 1, "mu"), *cells(CellClass.BELOW, 4, "mu"),
        *cells(CellClass.NOTHING, 9, "mu"), *cells(CellClass.BROKEN, 2, "mu"), *cells(CellClass.BEYOND, 2, "mu"),
    ]  # fmt: skip
    by = {(r.what, r.by, r.name): (r.count, r.n) for r in rates(found)}
    assert by["false alarm", "all", "all"] == (1, 8)
    assert by["false alarm", "outcome", "inconsistent"] == (1, 8)
    assert by["limited", "engine", "pymunk"] == (1, 8)
    assert by["missed", "all", "all"] == by["missed", "fault", "mu"] == by["missed", "engine", "pymunk"] == (1, 4)
    assert by["below the limit", "fault", "mu"] == (4, 10)
    assert by["beyond the predictability limit", "fault", "mu"] == (2, 10)


def test_one_missed_fault_fails_and_false_alarms_may_be_half_a_percent() -> None:
    assert passed([*cells(CellClass.PASS, 5), *cells(CellClass.BELOW, 5, "mu"), *cells(CellClass.BEYOND, 1, "mu")])
    assert not passed([*cells(CellClass.PASS, 5), *cells(CellClass.MISSED, 1, "mu")])
    assert passed([*cells(CellClass.PASS, 150), *cells(CellClass.FALSE_ALARM, 1)])
    assert not passed([*cells(CellClass.PASS, 150), *cells(CellClass.FALSE_ALARM, 2)])
    assert passed([*cells(CellClass.PASS, 399), *cells(CellClass.FALSE_ALARM, 2)])


# Simpler scenes


def test_a_simpler_form_is_a_valid_scene_with_less_in_it() -> None:
    busy = draw(EVENTS)
    effects = effects_of(busy)
    assert {name for name, _ in effects} == {"drag", "impulse", "thrust", "prescribed_rotation"}
    kept = tuple(name in ("impulse", "drag") for name, _ in effects)
    found = simplified(busy, Form(kept, 2, 11, 0.5, 3))
    assert found is not None
    assert found.bars == 2
    assert found.run.samples == 11
    assert found.run.duration_s == pytest.approx(0.5 * busy.run.duration_s, rel=0.01)
    assert not found.effects.thrust
    assert found.effects.drag is not None
    assert len(found.effects.drag.width_m) == 2
    assert found.effects.impulse[0].at_s in found.times_s
    assert all(float(f"{m:.3g}") == m for m in found.chain.mass_kg)
    scene_toml(found)


def test_the_whole_form_is_the_scene_itself_and_impossible_ones_are_none() -> None:
    busy = draw(EVENTS)
    same = simplified(busy, whole(busy))
    assert same is not None
    assert same.digest == busy.digest
    without_inside = dataclasses.replace(whole(busy), samples=2)
    assert simplified(busy, without_inside) is None


@pytest.mark.parametrize("seed", range(20, 60))
def test_any_form_of_any_scene_is_valid_or_none(seed: int) -> None:
    random, drawn = np.random.default_rng(seed), draw(seed)
    kept = tuple(bool(k) for k in random.integers(0, 2, len(effects_of(drawn))))
    found = simplified(drawn, Form(kept, int(random.integers(1, drawn.bars + 1)), 5, 0.2, 2))
    assert found is None or "[chain]" in scene_toml(found)


def test_shrinking_finds_what_matters() -> None:
    """An impulse on the third bar, seen at eleven samples."""
    busy, told = draw(EVENTS), []

    def shows(one: Scene) -> bool:
        return bool(one.effects.impulse) and one.bars >= 3 and one.run.samples >= 11

    found = simplest(busy, shows, 20.0, told.append)
    assert shows(found)
    assert found.bars == 3
    assert found.run.samples == 11
    assert found.effects.names == {f"gravity.{busy.effects.gravity}", "impulse"}
    assert all(float(f"{m:.1g}") == m for m in found.chain.mass_kg)
    assert told[-1] == found


def test_shrinking_ends_in_its_time_with_what_it_has() -> None:
    def slowly(one: Scene) -> bool:
        time.sleep(0.05)
        return one.bars >= 2

    busy, start = draw(EVENTS), time.monotonic()
    found = simplest(busy, slowly, 0.2)
    assert time.monotonic() - start < 10.0
    assert simplest(busy, lambda _: False, 5.0) is busy
    assert found.bars >= 2


def test_a_finding_is_alike_only_in_its_kind() -> None:
    (alarm,) = cells(CellClass.FALSE_ALARM, 1, "", "inconsistent")
    assert alike(dataclasses.replace(alarm, scene="random/9"), alarm)
    assert not alike(dataclasses.replace(alarm, outcome="failed"), alarm)
    assert not alike(dataclasses.replace(alarm, engine="exudyn"), alarm)
    assert not alike(None, alarm)
    assert [len(group) for group in kinds([alarm, alarm, *cells(CellClass.MISSED, 1, "mu")])] == [1, 2]


# Trials


@pytest.fixture(scope="module")
def runners() -> dict[int, tuple[TrialRunner, Scene]]:
    """Scenes with their unmodified engines judged."""
    found = {}
    for seed in (SEED, FREE):
        runner = TrialRunner(RunCache(in_this_process), judge_serially)
        (sampled,) = runner.establish([draw(seed)])
        _, trials = runner.unmodified_trials(sampled, ("reference", "pymunk"))
        assert {cell.kind for cell in runner.judge_trials(trials)} == {CellClass.PASS}
        found[seed] = runner, sampled
    return found


@pytest.mark.parametrize(("seed", "host"), [(SEED, "reference"), (FREE, "pymunk")])
def test_gross_faults_are_caught(runners, seed: int, host: str) -> None:  # type: ignore[no-untyped-def]
    runner, sampled = runners[seed]
    gross = [name for name in FAULTS if name.startswith("garbage")]
    names = (*gross, "noise-reactions-large", "sign-reaction", "damped-rate", "interpolated-2000", "mass-stuck")
    left_out, trials = runner.fault_trials(sampled, host, names, 10)
    assert not left_out
    found = runner.judge_trials(trials)
    assert {c.fault: c.kind for c in found if c.kind is not CellClass.CAUGHT} == {}
    assert all(c.seconds > 0.0 for c in found if c.fault == "mass-stuck")
    assert all(c.seconds == 0.0 for c in found if c.fault != "mass-stuck")


def test_a_judge_that_sees_nothing_misses_what_it_says_it_would_see(runners, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    runner, sampled = runners[SEED]

    def blind(case, results):  # type: ignore[no-untyped-def]
        return no_verdict(sampled.name, case.trial.engine, case.trial.setting, Outcome.PASS, "")

    monkeypatch.setattr(rating, "verdict_of", blind)
    left_out, trials = runner.fault_trials(
        sampled, "reference", ("sign-reaction", "attitude-creeps", "thrust-late-second"), 10
    )
    found = {c.fault: c for c in (*left_out, *runner.judge_trials(trials))}
    missed = found["sign-reaction"]
    assert (missed.kind, missed.quantity) == (CellClass.MISSED, "reaction")
    assert missed.size is not None
    assert missed.size > 0.1
    assert missed.limit is not None
    assert missed.limit < 1e-6
    assert found["thrust-late-second"].kind is CellClass.NOTHING
    small = found["attitude-creeps"]
    assert small.size is not None
    assert small.limit is not None
    assert (small.kind is CellClass.BELOW) == (small.size <= small.limit)


def test_a_fault_in_an_engine_that_is_refused_as_it_is_is_not_tried(runners) -> None:  # type: ignore[no-untyped-def]
    runner, sampled = runners[SEED]
    assert runner.fault_trials(sampled, "exudyn", ["mu"], 10) == ([], [])


def test_runs_of_their_own_are_chosen_by_the_scene() -> None:
    def own(seed: int) -> tuple[str, ...]:
        trials = thinned([CampaignTrial(draw(seed), "reference", name) for name in FAULTS], 3)
        assert {t.fault for t in trials if t.replays} == {name for name, fault in FAULTS.items() if fault.replays}
        return tuple(t.fault for t in trials if not t.replays)

    assert len(own(SEED)) == 3
    assert own(SEED) == own(SEED)
    assert len({own(seed) for seed in range(5)}) > 1


# The whole


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> tuple[Campaign, Path]:
    """Two scenes, three engines, some faults in one of them."""
    out = tmp_path_factory.mktemp("campaign")
    faults = ("garbage-growing-90-finer", "garbage-sudden-50-all", "com-millimetres", "mass", "mu", "declares-order")
    plan = CampaignPlan(1, FREE, ("reference", "exudyn"), ("pymunk",), faults, 1, 0.0)
    other = dataclasses.replace(plan, seed=SEED)
    found = [run_study(CampaignStudy(in_this_process, judge_serially), p, out, overwrite=True) for p in (plan, other)]
    both = [c for f in found for c in f.cells]
    return Campaign(other, both, rates(both), []), out


@pytest.mark.slow
def test_a_small_campaign_passes(small: tuple[Campaign, Path]) -> None:
    found, _ = small
    assert found.passed, [c for c in found.cells if c.is_finding]
    assert {c.engine for c in found.cells} == {"reference", "exudyn", "pymunk"}
    assert not [c for c in found.cells if c.kind is CellClass.BROKEN]


def test_its_tables_hold_its_cells(small: tuple[Campaign, Path]) -> None:
    found, out = small
    table = pd.read_csv(out / "campaign" / "campaign.csv", keep_default_na=False)
    last = [c for c in found.cells if c.scene == f"random/{SEED}"]
    assert tuple(table.columns) == COLUMNS
    assert list(table["class"]) == [str(c.kind) for c in last]
    assert tuple(pd.read_csv(out / "campaign" / "rates.csv").columns) == RATE_COLUMNS
    assert '"passed": true' in (out / "campaign" / "record.json").read_text(encoding="utf-8")


def test_its_page_is_rendered_from_its_tables_alone(small: tuple[Campaign, Path]) -> None:
    _, out = small
    (page,) = [p for p in render_all(out) if p.name == "campaign.html"]
    said = page.read_text(encoding="utf-8")
    assert "0 of 3 verdicts on unmodified engines are false alarms" in said
    table = pd.read_csv(out / "campaign" / "campaign.csv", keep_default_na=False)
    caught = sum(table["class"] == "caught")
    assert f"{caught} of {caught} faults above the detection limit are caught" in said
    assert all(name in said for name in ("reference", "exudyn", "pymunk", "garbage-sudden-50-all"))


def test_sizes_are_counted_against_the_detection_limit() -> None:
    table = pd.DataFrame(
        [("caught", 50.0, 1.0), ("below the limit", 0.5, 1.0), ("missed", 2.0, 1.0), ("caught", 3.0, None)],
        columns=["class", "size", "detection_limit"],
    )
    rows = [(row.name, row.counts) for row in size_rows(table)]
    assert rows == [
        ("0.1 to 1", (0, 0, 1, 0)),
        ("1 to 10", (0, 1, 0, 0)),
        ("10 to 100", (1, 0, 0, 0)),
        ("not stated", (1, 0, 0, 0)),
    ]


def test_a_folder_of_no_study_is_answered_by_the_studies(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["report", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert all(chapter.name in said for chapter in CHAPTERS)


def test_what_is_printed(small: tuple[Campaign, Path], capsys: pytest.CaptureFixture[str]) -> None:
    show_campaign(small[0], kept=True)
    said = capsys.readouterr().out
    for word in ("pymunk", "garbage-sudden-50-all", "false alarm: 0 of 6", "missed: 0 of", "passed"):
        assert word in said, word
    assert rate_words(Rate("missed", "all", "all", 400, 2)) == "missed: 2 of 400, 0.50 % (0.14 % to 1.80 %)"


@pytest.mark.slow
def test_the_command_runs_in_worker_processes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = "--engine reference --host reference --fault sign-reaction --fault declares-noise --workers 1"
    asked = f"selftest --random 1 --seed {SEED} {options} --out {tmp_path} --shrink-seconds 0"
    assert command(asked.split()) == 0
    said = capsys.readouterr().out
    assert "missed: 0 of 1" in said
    assert (tmp_path / "campaign" / "campaign.csv").is_file()


def test_a_findings_scene_is_written_simpler_and_simpler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a judge that sees nothing, two bars and three samples are enough to miss a sign."""

    def blind(case, results):  # type: ignore[no-untyped-def]
        limit = {"quantity": "reaction", "metric": "detection_limit", "value": 1e-9, "limit_s": None}
        verdict = no_verdict(case.trial.scene.name, case.trial.engine, case.trial.setting, Outcome.PASS, "")
        return dataclasses.replace(verdict, rows=[*verdict.rows, verdict.rows[0] | limit])

    monkeypatch.setattr(rating, "verdict_of", blind)
    cell = CampaignCell(f"random/{SEED}", "reference", "sign-reaction", CellClass.MISSED, "pass", "reaction")
    tables = CampaignStore(StudyStore(FILES, tmp_path))
    (kept,) = kept_findings([[cell, cell]], tables, 0.0, lambda _: None)
    assert kept.path == tmp_path / "campaign" / "scenes" / f"{SEED}-reference-sign-reaction.toml"
    assert load_scene(kept.path).digest == draw(SEED).digest
    search(draw(SEED), cell, kept.path, 20.0)
    found = load_scene(kept.path)
    assert (found.bars, found.run.samples) < (draw(SEED).bars, 3)
    assert "sign-reaction" in found.description
    assert str(kept.path) in finding_words(kept, kept=True)
    assert "(2 times)" in finding_words(kept, kept=False)


@pytest.mark.exhaustive
def test_a_campaign_passes(tmp_path: Path) -> None:
    plan = CampaignPlan(6, 100, ("reference-absolute", "exudyn-index3", "rebound", "pymunk-absolute"), shrink_s=0.0)
    found = run_study(CampaignStudy(in_this_process, judge_serially), plan, tmp_path)
    assert found.passed, [c for c in found.cells if c.is_finding]
    assert not [c for c in found.cells if c.kind is CellClass.BROKEN]


@pytest.mark.parametrize(("line", "word"), [
    ("--seed 3", "--seed goes with --random"), ("--host pymunk", "--host goes with --random"),
    ("--shrink-seconds 3", "--shrink-seconds goes with --random"), ("--random 1 --smallest", "leave out SCENE"),
    ("--random 1 --host pymnk", "did you mean pymunk"), ("--random 1 --fault maas", "did you mean mass"),
    ("--random 0", "--random"), ("--engine exudyn --engine pymunk", "faults are inserted into one engine"),
])  # fmt: skip
def test_bad_usage(line: str, word: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["selftest", *line.split()]) == 2
    assert word in capsys.readouterr().err


def test_its_faults_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["selftest", "--random", "1", "--list"]) == 0
    said = capsys.readouterr().out
    assert all(name in said for name in FAULTS)
