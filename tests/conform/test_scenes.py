"""Scenes of conformance: unequal bars, past a full turn, every effect alone, each with a certified solution."""

from __future__ import annotations

import copy
import dataclasses
import itertools
import math
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.integrate import DOP853

from adapters.registry import ENGINES
from barchain.conform.scenes import STAGES, TOGETHER, scene_of, solved, without
from barchain.judge.error_model import ErrorModel
from barchain.metrics.quantities import differences
from reference_impl.effects.drag import DragEffect
from reference_impl.effects.oblateness import OblatenessEffect
from reference_impl.effects.quadrupole import QuadrupoleEffect
from reference_impl.effects.third_body import ThirdBodyEffect
from scenarios import Actuator, Axes, End, Frame, SceneFile, scene_names
from scenarios.effect_types import all_effect_names
from scenarios.toml.key_tables import HEAD, key_tables
from scenarios.toml.orbit_keys import ELEMENTS, STATE
from scenarios.toml.resolve import resolve
from tests.diagnosis.planting import run
from tests.support.slow import one_in

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.reference import ReferenceSolution
    from reference_impl.model.effect import EffectAccelerations, EffectState
    from scenarios import Scene

SCENARIOS = Path(__file__).parents[2] / "scenarios"
SCENES = [name for scenes in STAGES.values() for name in scenes]
APART = [name for name in SCENES if name not in STAGES[TOGETHER]]
"""Scenes of one effect at most: what they show, they show alone"""
SLOW_ON_PURPOSE = {"conform/prescribed_orbital_joint", "conform/joint_angle"}
"""A scene with a motor after an inner bar: fast bars come near positions in which it can't hold its law"""
FOURTH_ORDER_ERROR_RAD = 1e-5
"""Error of the classical Runge-Kutta method with a thousand steps an orbit, 3e-6 rad, with slack"""
PLAIN = {"gravity.none", "gravity.point", "gravity.gradient"}
NO_PHYSICS = {"title", "source", "description", "tags", "orbits", "samples"}
OTHER_WAY = {
    "centre_m", "start", "end_body", "joint_mass", "angle_rad", "rate_deg_s", "rate_rad_s", *STATE, *ELEMENTS,
}  # fmt: skip
"""Keys that give numbers of other keys in another way: an engine sees no difference"""
OTHER_TABLES = {"`[start]`", "`[[chain.end_body]]`", "`[[chain.joint_mass]]`"}
"""Tables of such keys"""
WITH_ANOTHER = {"times_s", "amplitude_deg", "duration_s", "angle_deg"}
"""Keys that may be left out with another one only"""


def scene_file(name: str) -> dict[str, Any]:
    """Content of a scene's file."""
    return tomllib.loads((SCENARIOS / f"{name}.toml").read_text(encoding="utf-8"))


def entries(data: dict[str, Any], table: str) -> list[dict[str, Any]]:
    """Tables of a name in a scene's file."""
    found: list[dict[str, Any]] = [data]
    for part in filter(None, table.strip("`[]").split(".") if table != "Top level" else []):
        inner = [each[part] for each in found if part in each]
        found = [entry for each in inner for entry in (each if isinstance(each, list) else [each])]
    return found


def as_in_the_reference(value: object) -> str:
    """Value of a key as the reference page writes a default."""
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    return f'`"{value}"`' if isinstance(value, str) else f"{value:.12g}" if isinstance(value, float) else str(value)


def keys_of_scenes() -> list[tuple[str, str, str]]:
    """Table, key and default of each key that is physics."""
    return [
        (table, key, row[HEAD.index("default")])
        for table, _, rows in key_tables()
        for row in rows
        if (key := row[0].strip("`")) not in NO_PHYSICS | OTHER_WAY
        and table not in OTHER_TABLES
        and (table, key) != ("`[run]`", "start_s")
    ]


def test_the_stages_hold_every_scene_of_its_folder_once() -> None:
    assert sorted(SCENES) == sorted(name for name in scene_names() if name.startswith("conform/"))


def test_every_effect_that_an_engine_can_declare_stands_in_a_scene() -> None:
    assert frozenset().union(*(scene_of(name).needs for name in SCENES)) == all_effect_names()


@pytest.mark.parametrize(("table", "key", "default"), keys_of_scenes(), ids=lambda value: str(value).strip("`"))
def test_every_key_has_another_value_than_its_default_in_some_scene(table: str, key: str, default: str) -> None:
    """An engine that ignores a key must fail somewhere."""
    values = [entry[key] for name in APART for entry in entries(scene_file(name), table) if key in entry]
    assert values
    assert {as_in_the_reference(value) for value in values} - {default}


@pytest.mark.parametrize("effect", ["thrust", "impulse"])
def test_thrusts_and_impulses_act_at_both_ends_in_both_axes(effect: str) -> None:
    pushes = [push for name in SCENES for push in getattr(scene_of(name).effects, effect)]
    assert {(push.end, push.axes) for push in pushes} == set(itertools.product(End, Axes))


def test_prescribed_rotations_have_every_frame_with_every_actuator_that_it_can_have() -> None:
    laws = [law for name in SCENES for law in scene_of(name).effects.prescribed_rotation]
    of_bars = set(itertools.product([frame for frame in Frame if frame.of_bar], Actuator))
    assert {(law.frame, law.actuator) for law in laws} == of_bars | {(Frame.PREVIOUS_BAR, Actuator.JOINT)}


def test_some_bars_turn_clockwise_and_some_numbers_of_bars_have_two_digits() -> None:
    assert min(min(scene_of(name).chain.rate_factor) for name in APART) < 0.0
    assert {1, 2, 3, 5} <= {scene_of(name).bars for name in APART}
    assert max(scene_of(name).bars for name in SCENES) >= 10


def levels_of(scene: Scene) -> dict[str, str]:
    """Level of each factor of a scene, read off the scene itself."""
    e, chain = scene.effects, scene.chain
    uniform = [m * size**2 / 12.0 for m, size in zip(chain.mass_kg, chain.length_m, strict=True)]
    springs, impulses = e.joint_spring_damper, e.impulse
    ends = {t.times_s[-1] for t in e.thrust}
    return {
        "gravity": e.gravity,
        "bars": str(scene.bars),
        "length": "long" if max(chain.length_m) > 1e4 else "short",
        "inertia": "uniform" if np.allclose(uniform, chain.inertia_kg_m2) else "given",
        "orbit": "open" if scene.orbit.speed_factor**2 > 2.0 else "slow" if scene.orbit.speed_factor < 1.0 else "",
        "samples": "many" if scene.run.samples > 128 else "few",
        "mu": f"{scene.central_body.mu_m3_s2:g}",
        "oblateness": "some" if e.oblateness else "",
        "third bodies": str(len(e.third_body) or ""),
        "joints": "" if springs is None else "springs" if all(springs.stiffness_N_m_rad) else "dampers",
        "thrusts": "negative" if len(e.thrust) == 1 and e.thrust[0].force_N[0] < 0.0 else str(len(e.thrust) or ""),
        "impulses": "end" if {i.at_s for i in impulses} <= ends else "same" if len(impulses) > 1 else "",
        "faces": "some" if e.drag and e.solar_pressure else "none",
        "rotations": "some" if e.prescribed_rotation else "none",
    }


IMPOSSIBLE = {
    (("gravity", "slender"), ("inertia", "given")),
    *((("gravity", "none"), (field, level)) for field, level in
      (("oblateness", "some"), ("third bodies", "1"), ("third bodies", "3"))),
}  # fmt: skip
"""Exact gravity is that of uniform bars, and other fields presuppose gravity"""


def test_any_two_levels_of_two_factors_stand_together_in_a_scene() -> None:
    rows = [levels_of(scene_of(name)) for name in STAGES[TOGETHER] if name.startswith("conform/together_")]
    levels = {factor: {row[factor] for row in rows} - {""} for factor in rows[0]}
    assert {factor: len(found) for factor, found in levels.items()} == dict.fromkeys(levels, 2) | {
        "gravity": 5, "oblateness": 1,
    }  # fmt: skip
    every = {
        ((a, x), (b, y))
        for a, b in itertools.combinations(levels, 2)
        for x, y in itertools.product(levels[a], levels[b])
    }
    assert every - IMPOSSIBLE == {pair for row in rows for pair in itertools.combinations(row.items(), 2)} & every


def test_between_few_samples_a_bar_turns_by_more_than_half_a_turn() -> None:
    sparse = [name for name in STAGES[TOGETHER] if scene_of(name).run.samples < 8]
    turns = [np.abs(np.diff(solved(scene_of(name)).trajectory.angle_rad, axis=0)).max() for name in sparse]
    assert min(turns) > math.pi


def test_an_engine_that_lacks_effects_is_given_the_scenes_without_them() -> None:
    lacking = frozenset({"drag", "impulse", "gravity.slender", "thrust.body", "solar_pressure.shadow"})
    names = frozenset().union(*(without(scene_of(name), lacking).needs for name in STAGES[TOGETHER]))
    assert not names & lacking
    assert names >= {"solar_pressure", "thrust.inertial", "gravity.quadrupole"}
    shorter = without(scene_of("conform/together_3"), lacking)
    found, certified = solved(shorter).trajectory, solved(scene_of("conform/together_3")).trajectory
    assert differences(found, certified)["attitude"].max() > FOURTH_ORDER_ERROR_RAD


def test_some_scene_lasts_more_than_an_orbit_with_both_signs_of_the_radial_velocity() -> None:
    scene, motion = scene_of("conform/one_bar_eccentric"), solved(scene_of("conform/one_bar_eccentric")).trajectory
    radius = np.linalg.norm(motion.com_m, axis=1)
    assert np.argmax(radius) not in (0, len(radius) - 1)  # apogee
    assert np.argmin(radius[len(radius) // 2 :]) not in (0, len(radius) // 2)  # and perigee again
    assert scene.run.duration_s > 2.0 * 1200.0


def test_each_scene_of_the_last_stage_adds_one_effect() -> None:
    for name in STAGES["with one effect"]:
        tables = set(scene_file(name)["effects"]) - {"gravity"}
        assert len(tables) == (1 if f"gravity.{scene_of(name).effects.gravity}" in PLAIN else 0), name


@pytest.mark.parametrize("name", one_in(5, (name for name in APART if name not in SLOW_ON_PURPOSE)))
def test_bars_differ_and_turn_past_a_full_turn_from_a_longitude_of_30_degrees(name: str) -> None:
    scene, motion = scene_of(name), solved(scene_of(name)).trajectory
    for values in (scene.chain.mass_kg, scene.chain.length_m, scene.chain.angle_rad, scene.chain.rate_factor):
        assert len(set(values)) == scene.bars
    assert math.isclose(scene.orbit.longitude_rad, math.radians(30.0))
    assert motion.angle_rad is not None
    turned = np.abs(motion.angle_rad - motion.angle_rad[0]).max()
    assert turned > 2.0 * math.pi


@pytest.mark.parametrize("name", STAGES["with one effect"])
def test_an_effect_alone_turns_the_bars_by_more_than_the_error_of_most_methods(name: str) -> None:
    """A missing effect must show, whatever the method."""
    with_effect = solved(scene_of(name)).trajectory
    without = dataclasses.replace(scene_of(name), effects=scene_of("conform/three_bars_gradient").effects)
    assert differences(with_effect, run(without, 1e-12))["attitude"].max() > FOURTH_ORDER_ERROR_RAD


def keys_with_default() -> list[tuple[str, str]]:
    """Table and name of each key that is physics and may be left out alone."""
    keys = ((table, key) for table, key, default in keys_of_scenes() if not default.startswith("required"))
    return [(table, key) for table, key in keys if key not in WITH_ANOTHER]


def without_key(data: dict[str, Any], table: str, key: str) -> dict[str, Any]:
    """Content of a scene's file without a key, so that its default holds."""
    altered = copy.deepcopy(data)
    for entry in entries(altered, table):
        entry.pop(key, None)
    return altered


@pytest.mark.parametrize(("table", "key"), keys_with_default(), ids=str)
def test_an_engine_that_ignores_a_key_is_off_by_more_than_the_error_of_most_methods(table: str, key: str) -> None:
    """Some scene shows the default in the place of the given value."""
    shown = []
    for name in (name for name in APART if any(key in entry for entry in entries(scene_file(name), table))):
        try:
            altered = resolve(SceneFile.model_validate(without_key(scene_file(name), table, key)), name)
        except ValidationError:  # turns of one bar, which would all begin at t = 0
            continue
        if altered.bars == scene_of(name).bars:
            run_of = dataclasses.replace(altered, run=scene_of(name).run)
            shown.append(differences(solved(scene_of(name)).trajectory, run(run_of, 1e-12))["attitude"].max())
    assert max(shown) > FOURTH_ORDER_ERROR_RAD


def without_second_moments(effect: Any) -> Callable[..., EffectAccelerations]:
    """Accelerations of an effect without its force on the bars' second moments."""
    right = effect.accelerations
    return lambda self, at, mode: right(dataclasses.replace(self, second_moment=False), at, mode)


def with_sixtieth(effect: Any) -> Callable[..., EffectAccelerations]:
    """Drag with l^5/60 in place of l^5/80."""
    right = effect.accelerations

    def wrong(self: DragEffect, at: EffectState, mode: Array | None) -> EffectAccelerations:
        found, wind = right(self, at, mode), self.wind(at)
        r = np.abs(at.position_from_body)
        fall = (at.unit.conj() * at.position_from_body).real / (r * self.scale_height_m)
        face = np.sign(wind.across) if mode is None else mode
        strength = 0.5 * self.width_m * self.density(at, r) * face * self.normal_coefficient
        more = strength * fall * at.model.length_m**5 * (1.0 / 60.0 - 1.0 / 80.0) * wind.turning**2
        return found._replace(angular=found.angular + more / at.model.inertia_kg_m2)

    return wrong


def slender(effect: Any) -> Callable[..., EffectAccelerations]:
    """Force on the second moments of slender bars."""
    right = effect.accelerations

    def wrong(self: QuadrupoleEffect, at: EffectState, mode: Array | None) -> EffectAccelerations:
        found = right(self, at, mode)
        ratio = at.model.mass_kg * at.model.length_m**2 / 12.0 / at.model.inertia_kg_m2
        return found._replace(difference=found.difference * ratio)

    return wrong


@pytest.mark.parametrize(
    ("name", "effect", "wrong"),
    [
        ("quadrupole_alone", QuadrupoleEffect, slender),
        ("second_moments", OblatenessEffect, without_second_moments),
        ("second_moments", ThirdBodyEffect, without_second_moments),
        ("second_moments", DragEffect, with_sixtieth),
    ],
    ids=["m l^2/12", "J2", "third body", "l^5/60"],
)
def test_a_small_term_is_worth_a_hundred_allowances_of_an_engine(
    name: str, effect: type, wrong: Callable[..., object], monkeypatch: pytest.MonkeyPatch
) -> None:
    solution = solved(scene_of(f"conform/{name}"))
    monkeypatch.setattr(effect, "accelerations", wrong(effect))
    assert allowances(by_reference(solution), solution) > 100.0


def by_reference(solution: ReferenceSolution) -> Trajectory:
    """Run of the reference at its default setting."""
    engine = ENGINES["reference"].load()
    found: Trajectory = engine().run(solution.scene, engine.sweep.setting())
    return found


def allowances(found: Trajectory, solution: ReferenceSolution) -> float:
    """Largest error of a run over what is allowed to the reference at its default setting."""
    engine = ENGINES["reference"].load()
    allowed = ErrorModel(engine, engine.sweep.setting(), solution, solution.trajectory).bound
    apart = differences(found, solution.trajectory)
    return max(float(np.nanmax(apart[q][1:] / allowed[q][1:])) for q in ("attitude", "rate", "com"))


@pytest.mark.parametrize(
    ("table", "place"),
    [pytest.param("A", (6, 5), marks=pytest.mark.slow, id="-0.0176"), pytest.param("B", 8, id="0.311")],
)
def test_one_coefficient_of_dop853_off_by_a_ten_thousandth_is_worth_a_hundred_allowances(
    table: str, place: int | tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The rate of a bar that follows the local horizontal shows what the track has gathered in two orbits.

    A first-order error of a stage makes steps so short that each keeps its request, and all of them go one way.
    """
    wrong = getattr(DOP853, table).copy()
    wrong[place] *= 1.0 + 1e-4
    monkeypatch.setattr(DOP853, table, wrong)
    solution = solved(scene_of("conform/one_bar_law"))
    assert allowances(by_reference(solution), solution) > 100.0


def test_angles_that_are_unwrapped_by_asin_are_worth_a_hundred_allowances() -> None:
    """Of a turn past 90 degrees the sine is that of a smaller one; up to 90 degrees asin and atan2 are the same."""
    solution = solved(scene_of("conform/one_bar_free"))
    right = solution.trajectory
    assert right.angle_rad is not None
    turns = np.arcsin(np.sin(np.diff(right.angle_rad, axis=0)))
    wrong = right.angle_rad[0] + np.concatenate([np.zeros((1, 1)), np.cumsum(turns, axis=0)])
    assert allowances(right.replace(angle_rad=wrong), solution) > 100.0


def test_between_two_samples_of_a_free_bar_it_turns_past_90_degrees_and_not_past_180() -> None:
    angle = solved(scene_of("conform/one_bar_free")).trajectory.angle_rad
    assert angle is not None
    turns = np.diff(angle[:, 0])
    assert math.pi / 2.0 < turns.min() <= turns.max() < math.pi
