"""How large an effect is at a state beside the gravity-gradient force, and what switching it changes in a run.

An effect pushes bar j by an acceleration p_j and turns it by a torque K_j. With the mean p over the chain's mass,

    between  largest |p_j - mean p| over the largest |g_j - mean g|: what the joints feel, over the tide's own
    torque   largest |K_j|/J_j over 3 n², the scale of the gravity-gradient torque
    common   |mean p| over g: what moves the centre of mass, over gravity

where g is the pull of the central body as of a point, and n² = mu/r³ at the centre of mass. Of another model of
gravity, the push is what it adds to the scene's own. What is told is exact to rounding of the effect's own parts:
large common parts are never subtracted.

An effect is evaluated at the samples of the scene's own run, and at both ends of each segment between its events: a
thrust that comes and goes between two samples is largest at one of them. The state there is the cubic through its
neighbours.

For the change of a run both scenes are run at a tolerance and at one ten times looser. As in
:mod:`barchain.solutions.reference`, the difference of the two bounds the tighter run's own error; so the difference of
two scenes is off by at most the sum of both scenes' bounds, and a change below that sum is not resolved. Nothing is
compared after either scene's two runs have parted.
"""

from __future__ import annotations

import dataclasses
import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from adapters.common.reference_effects import effects_of
from adapters.common.reference_model import chain_model
from barchain.metrics.quantities import differences
from barchain.solutions.reference import divergence_instant_s
from reference_impl.model.complex_vectors import squared_norm, unit_along
from reference_impl.model.effect import EffectAccelerations, EffectState, total_accelerations
from reference_impl.model.gravity import complex_field_differences
from reference_impl.model.kinematics import consistent_state
from reference_impl.model.relative import external_accelerations
from reports.results.effects import CHANGED, EffectKind

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.trajectory import Array, Trajectory
    from barchain.studies.effects.switches import Switch
    from reference_impl.model.arrays import ComplexArray
    from reference_impl.model.chain import ChainModel
    from scenarios import Effects, Scene

MOST_STATES = 201  # of a run at which an effect is looked at
LOOSER = 10.0  # tolerance of the second run of each scene, relative to the first
ROUNDING = 4.0 * float(np.finfo(float).eps)  # two roundings of each run, that even equal runs may hide
JUST = 1e-11  # of the run after a break: more than what effects take as the same instant, 1e-12 of its time


class Sizes(NamedTuple):
    """Sizes of an effect; NaN where there is nothing to compare with."""

    between: float
    torque: float
    common: float


def sizes_over(scene: Scene, switch: Switch, trajectory: Trajectory) -> tuple[Sizes, Sizes] | None:
    """Sizes at the first sample of the scene's own run, and the largest over it; None of what pushes nothing."""
    if switch.part is None or trajectory.angle_rad is None or trajectory.rate_rad_s is None:
        return None
    every = max(1, len(trajectory.t_s) // MOST_STATES)
    between = inside_stretches_s(switch.part.breaks_s, float(trajectory.t_s[-1]))
    looked_at = (*trajectory.t_s[::every].tolist(), *between)
    found = np.array([sizes_at(scene, switch, situation(scene, trajectory, t)) for t in looked_at])
    return Sizes(*found[0].tolist()), Sizes(*found.max(axis=0).tolist())


def inside_stretches_s(breaks_s: tuple[float, ...], end_s: float) -> Iterator[float]:
    """Instants just inside each segment between two known instants: an effect has the value just before its event."""
    for start, until in itertools.pairwise(sorted({min(t, end_s) for t in breaks_s})):
        yield min(start + JUST * end_s, 0.5 * (start + until))
        yield until


def situation(scene: Scene, trajectory: Trajectory, t_s: float) -> EffectState:
    """State of a run as effects see it: a sample's own, or between two by the cubics through both."""
    model = chain_model(scene)
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    k = int(np.searchsorted(trajectory.t_s, t_s))
    if t_s == trajectory.t_s[k]:
        com, velocity, angle, rate = (
            x[k] for x in (trajectory.com_m, trajectory.com_velocity_m_s, trajectory.angle_rad, trajectory.rate_rad_s)
        )
    else:
        pair = slice(k - 1, k + 1)
        place = CubicHermiteSpline(trajectory.t_s[pair], trajectory.com_m[pair], trajectory.com_velocity_m_s[pair])
        turn = CubicHermiteSpline(trajectory.t_s[pair], trajectory.angle_rad[pair], trajectory.rate_rad_s[pair])
        com, velocity, angle, rate = place(t_s), place(t_s, 1), turn(t_s), turn(t_s, 1)
    return EffectState(model, t_s, consistent_state(model, com, velocity, angle, rate), unit_along(angle))


def sizes_at(scene: Scene, switch: Switch, at: EffectState) -> Sizes:
    """Sizes of an effect at a state."""
    assert switch.part is not None
    parts = gravity_parts if switch.kind is EffectKind.GRAVITY else effect_parts
    push = parts(scene, switch.part, at)
    mean = complex(push.difference @ at.model.weight)
    mu, r2 = scene.central_body.mu_m3_s2, float(squared_norm(np.array(at.com)))
    n2 = mu / (r2 * np.sqrt(r2))
    tide = relative_tide(mu, at)
    between = largest(push.difference - mean) / largest(tide) if at.model.bars > 1 else float("nan")
    return Sizes(between, largest(push.angular) / (3.0 * n2), abs(push.common + mean) * r2 / mu)


def largest(values: Array | ComplexArray) -> float:
    """Largest size over the bars."""
    return float(np.abs(values).max())


def relative_tide(mu_m3_s2: float, at: EffectState) -> ComplexArray:
    """(N,) m/s², what the central body's point pull on each bar differs from the mean's."""
    difference = complex_field_differences(mu_m3_s2, np.array(at.com), at.position)
    relative: ComplexArray = difference - difference @ at.model.weight
    return relative


def effect_parts(scene: Scene, part: Effects, at: EffectState) -> EffectAccelerations:
    """Push of an effect that comes to the scene's gravity."""
    gravity = dataclasses.replace(scene, effects=type(part)(part.gravity))
    whole = dataclasses.replace(scene, effects=part)
    model = dataclasses.replace(cast("ChainModel", at.model), effects=effects_of(whole)[len(effects_of(gravity)) :])
    return push_of(model, at)


def gravity_parts(scene: Scene, part: Effects, at: EffectState) -> EffectAccelerations:
    """Push of another model of gravity less that of the scene's own, part by part."""
    other, own = (gravity_pushes(scene, effects, at) for effects in (part, type(part)(scene.effects.gravity)))
    less = [minus(a, b) for a, b in zip(other, own, strict=True)]
    return EffectAccelerations(*(a + b for a, b in zip(*less, strict=True)))


def gravity_pushes(scene: Scene, gravity: Effects, at: EffectState) -> tuple[EffectAccelerations, EffectAccelerations]:
    """Push of a model of gravity on points, with the gradient's torque, and what it does beyond."""
    model = chain_model(dataclasses.replace(scene, effects=gravity))
    field, tide, spin = external_accelerations(model, at.state, at.unit)
    return EffectAccelerations(complex(field[0], field[1]), tide, spin), push_of(model, at)


def push_of(model: ChainModel, at: EffectState) -> EffectAccelerations:
    """Sum of a model's effects at a state of the same chain."""
    return total_accelerations(EffectState(model, at.t_s, at.state, at.unit), (None,) * len(model.effects))[0]


def minus(a: EffectAccelerations, b: EffectAccelerations) -> EffectAccelerations:
    """Difference of two pushes."""
    return EffectAccelerations(a.common - b.common, a.difference - b.difference, a.angular - b.angular)


@dataclass(frozen=True)
class RunPair:
    """One scene at two tolerances."""

    tight: Trajectory
    loose: Trajectory

    @property
    def limit_s(self) -> float:
        """Last instant before the two part."""
        return divergence_instant_s(self.tight, self.loose)


@dataclass(frozen=True)
class SwitchResponse:
    """Changes that a switch causes; a quantity that either scene lacks is left out."""

    largest: dict[str, float]
    """``com`` (m), ``attitude`` (rad), ``reaction`` (N), the largest over what was compared"""
    noise: dict[str, float]
    """Numerical error of each change, by the same names"""
    compared_s: float
    """Until when"""


def change(scene: RunPair, switched: RunPair) -> SwitchResponse:
    """Largest differences of two scenes over their common samples."""
    until = min(scene.limit_s, switched.limit_s)
    apart = upto(until, scene.tight, switched.tight)
    own, other = (upto(until, runs.tight, runs.loose) for runs in (scene, switched))
    size = scales(scene.tight, until)
    noise = {name: own[name] + other[name] + ROUNDING * size[name] for name in apart}
    return SwitchResponse(apart, noise, until)


def upto(until_s: float, a: Trajectory, b: Trajectory) -> dict[str, float]:
    """Largest difference of two runs until an instant, for each quantity."""
    inside = slice(0, int(np.searchsorted(a.t_s, until_s, side="right")))
    apart = differences(a, b, [channel.name for channel in CHANGED])
    return {name: float(off[inside].max()) for name, off in apart.items()}


def scales(trajectory: Trajectory, until_s: float) -> dict[str, float]:
    """Largest size of each quantity until an instant: the scale of its round-off."""
    inside = trajectory.t_s <= until_s
    found = {"com": longest(trajectory.com_m[inside]), "attitude": 1.0}
    if trajectory.reaction_N is not None and trajectory.reaction_N.shape[1]:
        found["reaction"] = longest(trajectory.reaction_N[inside])
    return found


def longest(vectors: Array) -> float:
    """Length of the longest plane vector."""
    return float(np.linalg.norm(vectors, axis=-1).max())
