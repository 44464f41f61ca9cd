"""What acts on a bar by a scene's gravity and effects, in fifty digits, as the judge of effects has it.

Accelerations are pairs: of the bar's centre, a complex number in m/s², and angular in rad/s².
"""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import mpmath as mp
import numpy as np

from adapters.common.reference_model import chain_model
from reference_impl.effects.oblateness import OblatenessEffect
from tests.effects.effect_judge import DIGITS, Bar, on_bar, second_moment

if TYPE_CHECKING:
    from collections.abc import Sequence

    from reference_impl.model.effect import ChainEffect
    from scenarios import Scene


def exact_bar(scene: Scene, j: int, place: Any, motion: Any, angle: Any, rate: Any) -> Bar:
    """Bar `j` of a scene at a place from the centre of the body, with the widths of its air or its light."""
    chain, e = scene.chain, scene.effects
    surface = e.drag or e.solar_pressure
    sizes = (chain.mass_kg[j], chain.length_m[j], chain.inertia_kg_m2[j])
    width = mp.mpf(surface.width_m[j]) if surface else None
    return Bar(*map(mp.mpf, sizes), mp.mpc(place), mp.mpc(motion), mp.mpf(angle), mp.mpf(rate), width)


def exact_effects(scene: Scene, bars: Sequence[Bar], j: int, t_s: float) -> tuple[Any, Any]:
    """Accelerations of bar `j` of some bars by all but the point mass and the gradient of the central body."""
    model = chain_model(scene)
    mass = sum(bar.mass for bar in bars)
    com = sum((bar.mass * bar.place for bar in bars), mp.mpc(0)) / mass
    state = SimpleNamespace(
        com_m=(com.real, com.imag),
        angle_rad=[bar.angle for bar in bars],
        rate_rad_s=[bar.rate for bar in bars],
    )
    pull, spin = mp.mpc(0), mp.mpf(0)
    with mp.workdps(DIGITS):
        for effect in model.effects:
            more, turn = on_bar(unrounded(effect, scene), model, state, t_s, j, bars[j])  # type: ignore[arg-type]
            pull, spin = pull + more, spin + turn
    return pull, spin


def unrounded(effect: ChainEffect, scene: Scene) -> ChainEffect:
    """An effect whose strength is not rounded to double."""
    flat = scene.effects.oblateness
    if not isinstance(effect, OblatenessEffect) or flat is None:
        return effect
    strength = mp.mpf(scene.central_body.mu_m3_s2) * mp.mpf(flat.j2) * mp.mpf(flat.radius_m) ** 2 / 2
    return dataclasses.replace(effect, strength_m5_s2=strength)


def exact_accelerations(scene: Scene, bars: Sequence[Bar], j: int, t_s: float) -> tuple[Any, Any]:
    """Accelerations of bar `j` by all that acts in a scene."""
    gravity, mu = chain_model(scene).gravity, mp.mpf(scene.central_body.mu_m3_s2)
    pull, spin = exact_effects(scene, bars, j, t_s)
    if gravity != "none":
        pull += point_pull(mu, bars[j].place)
    if gravity == "gradient":
        with mp.workdps(DIGITS):
            spin += second_moment(lambda z: -mu / abs(z), bars[j])[1]
    return pull, spin


def point_pull(mu: Any, place: Any) -> Any:
    """Acceleration of a point by the central body."""
    return -mu * place / abs(place) ** 3


def vector(pull: Any) -> np.ndarray:
    """A complex number as two floats."""
    return np.array([float(pull.real), float(pull.imag)])
