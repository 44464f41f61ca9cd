"""Wrong terms in the equations, which no scene describes; NumPy's reference simulates them."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, final

import numpy as np

from barchain.judge.diagnosis.altered_scenes.gravity import SECTION as GRAVITY
from barchain.judge.diagnosis.altered_scenes.gravity import AddedGradientTorque, with_effect
from barchain.judge.diagnosis.altered_scenes.loads import SECTION as LOADS
from barchain.judge.diagnosis.mistake import SceneMistake
from reference_impl.effects.drag import DragEffect
from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect, turned_by
from reference_impl.effects.oblateness import OblatenessEffect
from reference_impl.effects.third_body import ThirdBodyEffect
from reference_impl.model.effect import ChainEffect, EffectAccelerations
from reference_impl.model.gravity import gradient_angular_accelerations
from scenarios.toml.effect_tables import slender_inertia

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.judge.diagnosis.mistake import ModelChange
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.effect import EffectState

TURN = 2.0 * math.pi
KINDS: tuple[tuple[str, str, type[ChainEffect]], ...] = (
    ("drag", "drag", DragEffect),
    ("oblateness", "oblateness", OblatenessEffect),
    ("third-body", "third body", ThirdBodyEffect),
)


@final
@dataclass(frozen=True)
class SpringJumps(ChainEffect):
    """Torques that springs lose where the angle between two bars is wrapped to half a turn either way."""

    springs: JointSpringDamperEffect
    from_rest: bool
    """Whether the angle from the rest angle is wrapped, not the angle between the bars"""
    name = "wrapped springs"

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Torques of the whole turns that are lost."""
        del mode
        between = np.diff(at.state.angle_rad) - (self.springs.rest_rad if self.from_rest else 0.0)
        torque = -self.springs.stiffness_N_m_rad * TURN * np.round(between / TURN)
        return turned_by(torque, at)


@final
@dataclass(frozen=True)
class CancelledPart(ChainEffect):
    """Cancels the torque of an effect, and with `differences` also what its forces differ from those at the centre."""

    effect: ChainEffect
    differences: bool
    share: float = 1.0
    """Share that is cancelled"""
    name = "cancelled part of an effect"

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """The part with the opposite sign."""
        del mode
        whole = self.effect.accelerations(at, None)
        difference = -self.share * whole.difference if self.differences else at.zero_acceleration
        return EffectAccelerations(0j, difference, -self.share * whole.angular)


@final
@dataclass(frozen=True)
class GradientAtCentre(ChainEffect):
    """Difference of the gravity gradient's torque at the chain's centre of mass from that at each bar."""

    name = "gradient at the centre of mass"

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Torque over moment of inertia; no force."""
        del mode
        bars, centre = at.position_from_body, np.full(at.model.bars, at.com)
        there, here = (gradient_angular_accelerations(at.model, place, at.unit) for place in (centre, bars))  # type: ignore[arg-type]
        return EffectAccelerations(0j, at.zero_acceleration, there - here)


@final
@dataclass(frozen=True)
class OneSidedSprings(ChainEffect):
    """Cancels the torque of springs and dampers on the bars before the joints (0) or after them (1)."""

    springs: JointSpringDamperEffect
    side: int
    name = "one-sided springs"

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Torque over moment of inertia; no force."""
        del mode
        torque = self.springs.torque(at.state.angle_rad, at.rate)
        on_bars = np.zeros(at.model.bars)
        if self.side:
            on_bars[1:] = torque
        else:
            on_bars[:-1] = -torque
        return EffectAccelerations(0j, at.zero_acceleration, on_bars / at.model.inertia_kg_m2)


@final
@dataclass(frozen=True)
class AddedIndirectPull(ChainEffect):
    """Acceleration of the central body by a third body, added a number of times: once cancels its subtraction."""

    body: ThirdBodyEffect
    times: float
    name = "added indirect pull"

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Acceleration common to all bars."""
        del mode
        pull = self.times * self.body.mu_m3_s2 * self.body.body_position(at.t_s) / self.body.distance_m**3
        return EffectAccelerations(pull, at.zero_acceleration, at.zero_angular)


def beside(kind: type[ChainEffect], added: Callable[[Any], ChainEffect]) -> ModelChange:
    """Model with one more effect for each of its effects of a kind; a model without any stays as it is."""

    def change(model: ChainModel) -> ChainModel:
        more = tuple(added(effect) for effect in model.effects if isinstance(effect, kind))
        return dataclasses.replace(model, effects=(*model.effects, *more)) if more else model

    return change


def without_part(kind: type[ChainEffect], *, differences: bool = False, share: float = 1.0) -> ModelChange:
    """Model in which effects of a kind have no torque, or act on all bars as at the centre of mass."""
    return beside(kind, lambda effect: CancelledPart(effect, differences, share))


def slender_gradient(model: ChainModel) -> ChainModel:
    """Model whose gravity gradient turns slender bars of the same masses and lengths."""
    slender = np.array([slender_inertia(m, size) for m, size in zip(model.mass_kg, model.length_m, strict=True)])
    share = slender / model.inertia_kg_m2 - 1.0
    if not np.any(np.abs(share) > np.finfo(float).eps):
        return model
    return with_effect(AddedGradientTorque(share), gradient=True)(model)


MISTAKES = (
    *(
        SceneMistake(
            f"springs-wrapped{name}",
            f"the springs' angles {words}are wrapped to half a turn either way",
            LOADS,
            model=beside(JointSpringDamperEffect, partial(SpringJumps, from_rest=rest)),
        )
        for name, words, rest in (("", "", False), ("-from-rest", "from their rest ", True))
    ),
    *(
        SceneMistake(f"{name}-without-torque", f"the torque of the {words} is missing", LOADS, model=without_part(kind))
        for name, words, kind in KINDS
    ),
    *(
        SceneMistake(
            f"{name}-at-centre-of-mass",
            f"the {words} acts on all bars as at the chain's centre of mass",
            LOADS,
            model=without_part(kind, differences=True),
        )
        for name, words, kind in KINDS[1:]
    ),
    *(
        SceneMistake(
            f"third-body-indirect-{name}",
            f"the third body's pull on the central body {words}",
            LOADS,
            model=beside(ThirdBodyEffect, partial(AddedIndirectPull, times=times)),
        )
        for name, words, times in (("missing", "is missing", 1.0), ("opposite", "has the opposite sign", 2.0))
    ),
    *(
        SceneMistake(
            f"springs-without-bar-{words}",
            f"the springs and dampers have no torque on the bar {words} the joint",
            LOADS,
            model=beside(JointSpringDamperEffect, partial(OneSidedSprings, side=side)),
        )
        for side, words in ((0, "before"), (1, "after"))
    ),
    SceneMistake(
        "gradient-at-centre-of-mass",
        "the torque of the gravity gradient is that at the chain's centre of mass",
        GRAVITY,
        model=with_effect(GradientAtCentre(), gradient=True),
    ),
    SceneMistake(
        "gradient-of-slender-bars",
        "the torque of the gravity gradient is that of slender bars, without the given moments of inertia",
        GRAVITY,
        model=slender_gradient,
    ),
)
