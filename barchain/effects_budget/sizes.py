"""How large an effect is at a state, beside the gravity-gradient force.

An effect pushes bar j by an acceleration p_j and turns it by a torque K_j. With the mean p over the chain's mass,

    between  largest |p_j - mean p| over the largest |g_j - mean g|: what the joints feel, over the tide's own
    torque   largest |K_j|/J_j over 3 n², the scale of the gravity-gradient torque
    common   |mean p| over g: what moves the centre of mass, over gravity

where g is the pull of the central body as of a point, and n² = mu/r³ at the centre of mass. Of another model of
gravity, the push is what it adds to the scene's own. What is told is exact to rounding of the effect's own parts:
large common parts are never subtracted.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from adapters.initial_state import chain_model
from adapters.scene_effects import effects_of
from reference_impl.effect import Push, Situation, pushed
from reference_impl.gravity import differences
from reference_impl.kinematics import joined_state
from reference_impl.plane import along, squared
from reference_impl.relative import external
from reports.effects_tables import Kind

if TYPE_CHECKING:
    from adapters.engine import Array, Trajectory
    from barchain.effects_budget.switches import Switch
    from reference_impl.chain import ChainModel
    from reference_impl.plane import ComplexArray
    from scenarios import Effects, Scene

MOST_STATES = 201  # of a run at which an effect is looked at


class Sizes(NamedTuple):
    """Sizes of an effect; NaN where there is nothing to compare with."""

    between: float
    torque: float
    common: float


def sizes_over(scene: Scene, switch: Switch, seen: Trajectory) -> tuple[Sizes, Sizes] | None:
    """Sizes at the first sample of the scene's own run, and the largest over it; None of what pushes nothing."""
    if switch.part is None or seen.angle_rad is None or seen.rate_rad_s is None:
        return None
    every = max(1, len(seen.t_s) // MOST_STATES)
    found = np.array([sizes_at(scene, switch, situation(scene, seen, k)) for k in range(0, len(seen.t_s), every)])
    return Sizes(*found[0].tolist()), Sizes(*found.max(axis=0).tolist())


def situation(scene: Scene, seen: Trajectory, k: int) -> Situation:
    """Sample of a run as effects see it."""
    model = chain_model(scene)
    assert seen.angle_rad is not None
    assert seen.rate_rad_s is not None
    angle = seen.angle_rad[k]
    state = joined_state(model, seen.com_m[k], seen.com_velocity_m_s[k], angle, seen.rate_rad_s[k])
    return Situation(model, float(seen.t_s[k]), state, along(angle))


def sizes_at(scene: Scene, switch: Switch, at: Situation) -> Sizes:
    """Sizes of an effect at a state."""
    assert switch.part is not None
    parts = gravity_parts if switch.kind is Kind.GRAVITY else effect_parts
    push = parts(scene, switch.part, at)
    mean = complex(push.difference @ at.model.weight)
    mu, r2 = scene.central_body.mu_m3_s2, float(squared(np.array(at.com)))
    n2 = mu / (r2 * np.sqrt(r2))
    tide = relative_tide(mu, at)
    between = largest(push.difference - mean) / largest(tide) if at.model.bars > 1 else float("nan")
    return Sizes(between, largest(push.spin) / (3.0 * n2), abs(push.common + mean) * r2 / mu)


def largest(values: Array | ComplexArray) -> float:
    """Largest size over the bars."""
    return float(np.abs(values).max())


def relative_tide(mu_m3_s2: float, at: Situation) -> ComplexArray:
    """(N,) m/s², what the central body's point pull on each bar differs from the mean's."""
    difference = differences(mu_m3_s2, np.array(at.com), at.position)
    relative: ComplexArray = difference - difference @ at.model.weight
    return relative


def effect_parts(scene: Scene, part: Effects, at: Situation) -> Push:
    """Push of an effect that comes to the scene's gravity."""
    gravity = dataclasses.replace(scene, effects=type(part)(part.gravity))
    whole = dataclasses.replace(scene, effects=part)
    model = dataclasses.replace(at.model, effects=effects_of(whole)[len(effects_of(gravity)) :])
    return push_of(model, at)


def gravity_parts(scene: Scene, part: Effects, at: Situation) -> Push:
    """Push of another model of gravity less that of the scene's own, part by part."""
    other, own = (gravity_pushes(scene, effects, at) for effects in (part, type(part)(scene.effects.gravity)))
    less = [minus(a, b) for a, b in zip(other, own, strict=True)]
    return Push(*(a + b for a, b in zip(*less, strict=True)))


def gravity_pushes(scene: Scene, gravity: Effects, at: Situation) -> tuple[Push, Push]:
    """What a model of gravity does to points, with the gradient's torque, and what it does beyond."""
    model = chain_model(dataclasses.replace(scene, effects=gravity))
    field, tide, spin = external(model, at.state, at.unit)
    return Push(complex(field[0], field[1]), tide, spin), push_of(model, at)


def push_of(model: ChainModel, at: Situation) -> Push:
    """Sum of a model's effects at a state of the same chain."""
    return pushed(Situation(model, at.t_s, at.state, at.unit), (None,) * len(model.effects))[0]


def minus(a: Push, b: Push) -> Push:
    """Difference of two pushes."""
    return Push(a.common - b.common, a.difference - b.difference, a.spin - b.spin)
