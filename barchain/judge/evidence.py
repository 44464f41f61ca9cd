"""Runs of one engine in one scene that its verdict rests on, and further runs that can decide the verdict.

Two runs are made of every engine: at the setting that is judged, and at the next finer setting. Where these runs do not
settle the verdict, it requests more: a still finer run, and runs at the same setting whose rounding differs. For the
latter the scene is turned by a small angle, and the start is perturbed in its last digits. The differences of these
runs are the round-off of the main run. A large angle would show more than round-off: an engine that mistakes a
direction in inertial axes, as that of the Sun, gives another result in each frame, and that would excuse its mistake.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from adapters.common.equal_steps import finer_setting
from barchain.runs.job import ROUNDOFF_ROLES, Job, Role, RunResult
from reports.results.outcome import Outcome
from scenarios import Axes, Impulse, Thrust

if TYPE_CHECKING:
    from collections.abc import Iterable

    from adapters.engine import Declarations, Setting
    from adapters.registry import Registration
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

Push = TypeVar("Push", Thrust, Impulse)
TURNED_RAD = (7.390851332151607e-6, 2e-5, -1.1e-5)
"""Angles, none a multiple of another: every coordinate in inertial axes gets other digits, and a result that depends on
the direction of the axes changes by a hundred-thousandth of that dependence at most"""
LAST_DIGITS = 4.0 * float(np.finfo(float).eps)
"""Relative change of the initial angles and rates: a few units in the last place"""


@dataclass(frozen=True)
class Evidence:
    """Results of the runs of one engine in one scene."""

    main: RunResult
    """At the setting that the engine is judged at"""
    finer: RunResult
    """At the next finer setting"""
    finest: RunResult | None = None
    """Finer again; None unless requested"""
    perturbed: tuple[Trajectory, ...] = ()
    """Runs at the main setting with other rounding, turned back; empty unless requested"""


def gathered(runs: dict[Role, RunResult]) -> Evidence:
    """Evidence of results by role, the main and the finer run among them; perturbed runs turned back."""
    turned = [(runs[role], angle) for role, angle in zip(ROUNDOFF_ROLES, TURNED_RAD, strict=True) if role in runs]
    complete = [(r.trajectory, angle) for r, angle in turned if r.outcome is Outcome.PASS and r.trajectory is not None]
    back = tuple(turned_back(trajectory, angle) for trajectory, angle in complete)
    return Evidence(runs[Role.MAIN], runs[Role.FINER], runs.get(Role.FINEST), back)


def follow_up_jobs(
    scene: Scene,
    name: str,
    registration: Registration,
    engine: Declarations,
    setting: Setting,
    further_runs: Iterable[Role],
) -> list[Job]:
    """Jobs of the further runs that a verdict requests.

    Parameters
    ----------
    scene : Scene
    name : str
        Of the engine.
    registration : Registration
    engine : Declarations
        Its accuracy sweep counts.
    setting : Setting
        At which the engine is judged.
    further_runs : iterable of Role
    """
    finer = finer_setting(scene, engine.sweep, setting)
    jobs = []
    for role in further_runs:
        if role is Role.FINEST:
            jobs.append(Job(scene, name, registration, finer_setting(scene, engine.sweep, finer), role))
        else:
            number = ROUNDOFF_ROLES.index(role)
            jobs.append(Job(perturbed(scene, number), name, registration, setting, role))
    return jobs


def perturbed(scene: Scene, number: int) -> Scene:
    """`scene` turned by a small angle, its initial angles and rates perturbed in their last digits."""
    chain = scene.chain
    rng = np.random.default_rng([number, 17])  # the same perturbations in every run

    def moved(values: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(float(v) for v in np.array(values) * (1.0 + LAST_DIGITS * rng.uniform(-1.0, 1.0, len(values))))

    other = dataclasses.replace(chain, angle_rad=moved(chain.angle_rad), rate_factor=moved(chain.rate_factor))
    return dataclasses.replace(turned(scene, TURNED_RAD[number]), chain=other)


def turned(scene: Scene, turn: float) -> Scene:
    """`scene` turned by an angle, rad, with all its directions in inertial axes."""
    before, light = scene.effects, scene.effects.solar_pressure
    effects = dataclasses.replace(
        before,
        third_body=tuple(dataclasses.replace(b, longitude_rad=b.longitude_rad + turn) for b in before.third_body),
        solar_pressure=light and dataclasses.replace(light, sun_longitude_rad=light.sun_longitude_rad + turn),
        thrust=tuple(turned_push(p, turn) for p in before.thrust),
        impulse=tuple(turned_push(p, turn) for p in before.impulse),
    )
    orbit = dataclasses.replace(scene.orbit, longitude_rad=scene.orbit.longitude_rad + turn)
    return dataclasses.replace(scene, orbit=orbit, effects=effects)


def turned_push(push: Push, turn: float) -> Push:
    """Thrust or impulse whose direction, if it is given in inertial axes, is turned by an angle, rad."""
    if push.axes is not Axes.INERTIAL:
        return push
    return dataclasses.replace(push, direction_rad=push.direction_rad + turn)


def turned_back(trajectory: Trajectory, turn: float) -> Trajectory:
    """Trajectory of a turned scene in the axes of the scene itself."""
    c, s = math.cos(turn), math.sin(turn)
    back = np.array([[c, -s], [s, c]])  # rows times this: turned by -turn

    def vectors(values: Array | None) -> Array | None:
        return None if values is None else values @ back

    return trajectory.replace(
        com_m=vectors(trajectory.com_m),
        com_velocity_m_s=vectors(trajectory.com_velocity_m_s),
        angle_rad=None if trajectory.angle_rad is None else trajectory.angle_rad - turn,
        reaction_N=vectors(trajectory.reaction_N),
        impulse_N_s=vectors(trajectory.impulse_N_s),
    )
