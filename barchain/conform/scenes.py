"""Scenes of the examination, as an engine is given them, their judging solutions, and the setting on each.

The scenes come in stages that presuppose each other: from one free bar to each effect alone, and then effects
together. The scenes of the last stage are a covering array: any two levels of two factors (models, numbers, signs,
orbits, samples) stand together in one. An engine that lacks effects is given these scenes without them, which leaves
the other pairs.
"""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import TYPE_CHECKING, Any

from adapters.engine import AccuracyParameter
from barchain.judge.error_model import ErrorModel
from barchain.runs.job import RunResult
from barchain.solutions.certified_file import shipped_solution
from barchain.solutions.judging import solution_jobs, solution_of
from barchain.solutions.reference import at_own_samples, closely_sampled
from reports.results.outcome import Outcome
from scenarios import Gravity, load_scene
from scenarios.effect_types import COM_SHARE, SINGLE_NAME_EFFECTS, all_effect_names, forms_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.engine import Declarations, Setting
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

MOST_FINER = 10.0
"""Largest ratio of the steps, or of the requested errors, to the default: finer runs take too long"""
FINER = {AccuracyParameter.RTOL: 0.1, AccuracyParameter.STEPS_PER_ORBIT: 2.0}
"""Factor from a setting to the next finer one; `AccuracySweep.finer_rtol` is that of a second run beside the first"""
LASTING = 0.9
"""Least share of a scene in which right runs agree; the rest is judged in restarts"""
FOLDER = "conform/"
TOGETHER = "with effects together"


def in_folder(names: str) -> tuple[str, ...]:
    """Full names of scenes of the examination."""
    return tuple(f"{FOLDER}{name}" for name in names.split())


STAGES = {
    "without forces": in_folder("one_bar_free two_bars_free three_bars_free"),
    "in gravity": in_folder(
        "one_bar_point one_bar_gradient three_bars_point three_bars_gradient eccentric mid_orbit bar_angles "
        "one_bar_eccentric com_share_alone"
    ),
    "with one effect": in_folder(
        "slender_alone quadrupole_alone oblateness_alone third_body_alone drag_alone solar_pressure_alone "
        "solar_shadow_alone joint_springs_alone joint_torque_alone joint_set_point thrust_body thrust_inertial "
        "impulse_alone prescribed_orbital prescribed_inertial prescribed_orbital_joint "
        "prescribed_inertial_external joint_angle prescribed_turns prescribed_table"
    ),
    TOGETHER: in_folder(
        "one_bar_law one_bar_loads eleven_bars_loads prescribed_neighbours second_moments com_share_loads "
        + " ".join(f"together_{number}" for number in range(1, 11))
    ),
}
"""Scenes from one free bar to effects together; those of a stage presuppose the stages before"""
FIRST = in_folder("two_bars_free three_bars_gradient one_bar_free one_bar_point")
"""Scenes of the conventions: the first that the engine supports"""
REPEATED = in_folder("three_bars_gradient three_bars_point three_bars_free one_bar_point")
"""Scenes of accuracy and behaviour: the first that the engine supports"""
PARTICLE = in_folder("one_bar_point one_bar_free")
"""The same for an engine without attitude: on one bar in point gravity it has no difference of model"""
FACES = frozenset({"drag", "solar_pressure", "solar_pressure.shadow"})
ROTATIONS = frozenset(name for name in all_effect_names() if name.startswith("prescribed_rotation."))
LEFT_OUT = (frozenset[str](), FACES, ROTATIONS, FACES | ROTATIONS, FACES | ROTATIONS | {"impulse"})
"""Effects without which an engine may support a scene of the last stage that it rejects: equal steps straddle the
instants at which bars turn their other faces, some support laws of rotation beside few effects, and a particle has no
impulse along a bar"""
EXACT_FIRST = (Gravity.SLENDER, Gravity.QUADRUPOLE, Gravity.GRADIENT, Gravity.POINT, Gravity.NONE)


@cache
def scene_of(name: str) -> Scene:
    """Scene of a name."""
    return load_scene(name)


@cache
def solved(scene: Scene) -> ReferenceSolution:
    """Certified solution of a scene at its own samples; of a scene without some of its effects the reference's.

    Raises
    ------
    FileNotFoundError
        If barchain comes without the solution of a scene of the examination.
    """
    dense = closely_sampled(scene)
    found = shipped_solution(dense)
    if found is None and scene == scene_of(scene.name):
        raise FileNotFoundError(f"{scene.name}: this installation lacks the certified solution; install barchain again")
    return at_own_samples(found or reference_solution(dense), scene)


def reference_solution(scene: Scene) -> ReferenceSolution:
    """Solution of a scene by the reference, run here."""
    runs = {}
    for job in solution_jobs(scene):
        trajectory = job.registration.engine(job.options).run(job.scene, job.setting)
        runs[job.role] = RunResult(Outcome.PASS, trajectory=trajectory)
    return solution_of(scene, runs)


def without(scene: Scene, lacking: frozenset[str]) -> Scene:
    """Scene without effects of some names, and with centres of mass midway where an engine has no others.

    A model of gravity is replaced by the next simpler one.
    """
    e = scene.effects
    kept: dict[str, Any] = {}
    for name in lacking & set(SINGLE_NAME_EFFECTS):
        kept[name] = () if isinstance(getattr(e, name), tuple) else None
    if e.solar_pressure and "solar_pressure.shadow" in lacking and "solar_pressure" not in lacking:
        kept["solar_pressure"] = dataclasses.replace(e.solar_pressure, shadow=False)
    laws = (p for p in e.prescribed_rotation
            if not lacking & {f"prescribed_rotation.{form}" for form in forms_of(p)})  # fmt: skip
    simpler = EXACT_FIRST[EXACT_FIRST.index(e.gravity) :]
    effects = dataclasses.replace(
        e,
        gravity=next((g for g in simpler if f"gravity.{g}" not in lacking), e.gravity),
        prescribed_rotation=tuple(laws),
        thrust=tuple(t for t in e.thrust if f"thrust.{t.axes}" not in lacking),
        **kept,
    )
    chain = dataclasses.replace(scene.chain, com_share=()) if COM_SHARE in lacking else scene.chain
    other = dataclasses.replace(scene, chain=chain, effects=effects)
    return scene if other == scene else other


def candidates(engine: Declarations, name: str) -> list[Scene]:
    """Forms of a scene that an engine may support, the whole one first; one form of a scene before the last stage."""
    scene = scene_of(name)
    if name not in STAGES[TOGETHER]:
        return [scene]
    lacking = all_effect_names().difference(engine.effects)
    return list(dict.fromkeys(without(scene, lacking | more) for more in LEFT_OUT))


@cache
def scene_for(engine: Declarations, name: str) -> Scene:
    """Scene as an engine is given it: the first form that it supports, or the scene itself.

    Raises
    ------
    EngineError
        If the engine can't be asked.
    """
    forms = candidates(engine, name)
    return next((form for form in forms if rejection(engine, form) is None), forms[0])


@cache
def rejection(engine: Declarations, scene: Scene) -> str | None:
    """Reason why an engine does not support a scene or its motion; None if it does. Errors as :func:`scene_for`."""
    reason = engine.unsupported(scene)
    if reason is None:
        reason = engine.unsupported_motion(solved(scene).scene, solved(scene).fine)
    return reason


def left_out(engine: Declarations, name: str) -> str:
    """Words on the effects without which an engine is given a scene; empty for all effects."""
    given = scene_for(engine, name).needs
    missing = sorted(scene_of(name).needs - given)
    return f", without {', '.join(missing)}" if missing else ""


@cache
def setting_of(engine: Declarations, scene: Scene) -> Setting:
    """Setting at which an engine is examined on a scene.

    The default, or the first of the next finer settings at which two right runs agree in most of the scene. Beyond
    the predictability limit only restarts, the track and invariants are judged, and a weak force that is missing may
    pass. Where no setting up to :data:`MOST_FINER` agrees so long, the finest of these.

    Parameters
    ----------
    engine : Declarations
    scene : Scene
        Of conformance.
    """
    tried = list(from_default_on(engine))
    return next((setting for setting in tried if lasts(engine, setting, scene)), tried[-1])


def from_default_on(engine: Declarations) -> Iterator[Setting]:
    """The default, and settings of twice the steps or a tenth of the requested error each, up to `MOST_FINER`."""
    setting = engine.sweep.setting()
    factor, finer = FINER[setting.parameter], 1.0
    while finer <= MOST_FINER * (1.0 + 1e-9):
        yield setting
        setting, finer = dataclasses.replace(setting, value=setting.value * factor), finer * max(factor, 1.0 / factor)


def lasts(engine: Declarations, setting: Setting, scene: Scene) -> bool:
    """Whether two right runs at a setting agree for :data:`LASTING` of a scene."""
    solution = solved(scene)
    errors = ErrorModel(engine, setting, solution, solution.trajectory)
    return bool(errors.limit_s >= LASTING * errors.t_s[-1])
