"""Terms of the equations that an engine may have wrong or too many by an unknown amount, which a fit finds."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

from barchain.judge.diagnosis.altered_scenes.amounts import RELATIVE, Amount
from barchain.judge.diagnosis.altered_scenes.equations import KINDS, without_part
from barchain.judge.diagnosis.altered_scenes.gravity import SECTION as GRAVITY
from barchain.judge.diagnosis.altered_scenes.gravity import AddedGradientTorque, with_effect
from barchain.judge.diagnosis.altered_scenes.loads import SECTION as LOADS
from barchain.judge.diagnosis.readings.fitted import factor_words
from reference_impl.model.effect import ChainEffect, EffectAccelerations
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.judge.diagnosis.mistake import ModelChange
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.effect import EffectState
    from scenarios import Scene

MOST_DAMPING = 0.9
"""Largest damping over the fastest rate of the scene"""


@final
@dataclass(frozen=True)
class BodyDamping(ChainEffect):
    """Damping of each body's velocities, as engines for games add: a share of the velocity in a second."""

    angular_1_s: float
    linear_1_s: float
    """Of the velocity relative to the centre of mass"""
    name = "body damping"

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Accelerations against the velocities."""
        del mode
        drift = complex(at.model.weight @ at.velocity)
        return EffectAccelerations(0j, -self.linear_1_s * (at.velocity - drift), -self.angular_1_s * at.rate)


def equation_amounts(scene: Scene) -> tuple[Amount, ...]:
    """All terms of a scene's equations that are fitted; their runs are NumPy's."""
    gradient = scene.effects.gravity is Gravity.GRADIENT
    torques = (effect_torque(*kind) for kind in KINDS if getattr(scene.effects, kind[0].replace("-", "_")))
    return (*((GRADIENT_TORQUE,) if gradient else ()), *torques, damping(scene, 0.0), damping(scene, 1.0))


def effect_torque(name: str, words: str, kind: type[ChainEffect]) -> Amount:
    """Torque of an effect, times 1 + amount."""
    subject = f"the torque of the {words} is"
    return Amount(
        f"{name}-torque", LOADS, None, lambda a: f"{subject} {factor_words(1.0 + a)} times the right value", 1e-5,
        RELATIVE, lambda a: without_part(kind, share=-a),
    )  # fmt: skip


def damping(scene: Scene, linear: float) -> Amount:
    """Damping of rates, and of velocities `linear` times as much."""
    name, subject = ("body-damping", "rates and velocities are") if linear else ("angular-damping", "rates are")
    most = MOST_DAMPING * scene.fastest_rate_rad_s
    return Amount(name, LOADS, None, damping_words(subject), 1e-5 * most, (0.0, most), damped(linear))


def gradient_words(amount: float) -> str:
    """Sentence of a factor of the gravity gradient's torque."""
    return f"the torque of the gravity gradient is {factor_words(1.0 + amount)} times the right value"


def times_gradient_torque(amount: float) -> ModelChange:
    """Gravity gradient's torque times 1 + amount."""
    return with_effect(AddedGradientTorque(amount), gradient=True)


GRADIENT_TORQUE = Amount("gradient-torque", GRAVITY, None, gradient_words, 1e-5, RELATIVE, times_gradient_torque)


def damping_words(subject: str) -> Callable[[float], str]:
    """Sentence of a damping."""
    return lambda amount: f"the bars' {subject} damped by a share of {amount:.4g} in a second"


def damped(linear: float) -> Callable[[float], ModelChange]:
    """Damping of rates, and of velocities `linear` times as much."""

    def of(amount: float) -> ModelChange:
        def change(model: ChainModel) -> ChainModel:
            return dataclasses.replace(model, effects=(*model.effects, BodyDamping(amount, linear * amount)))

        return change

    return of
