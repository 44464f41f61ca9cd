"""The track of the centre of mass beyond the predictability limit of the attitude: bounded, and not chaotic."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.common.initial_state import chain_model
from barchain.judge.local_errors import kepler_growth, orbit_rate_bound
from barchain.metrics.model_difference import SECOND_MOMENT_ACCELERATION, displacement_bound
from scenarios import Gravity

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from barchain.solutions.reference import ReferenceSolution

EITHER_WAY = 2.0
"""Factor of two parted attitudes, which may accelerate the track in opposite directions"""


def parted_track_bound(solution: ReferenceSolution, t_s: Array, limit_s: float) -> dict[str, Array]:
    """Largest effect on the track of attitudes that part at the limit, (n,): ``com`` (m), ``com_velocity`` (m/s).

    The pull on a chain differs from that on a particle by mu I/(M r⁴) at most, and forces on the chain itself (drag,
    sunlight, thrusts) differ by their whole strength. A constant acceleration a moves the track by 3/2 a t² along the
    orbit, and swings by 8 a/n² beside it.
    """
    scene = solution.scene
    since = np.maximum(t_s - limit_s, 0.0)
    if not since.any():
        return {}
    n = len(t_s)
    found = {"com": np.zeros(n), "com_velocity": np.zeros(n)}
    if scene.effects.gravity is not Gravity.NONE and scene.bound:
        for name, moved in displacement_bound(scene, since, EITHER_WAY * SECOND_MOMENT_ACCELERATION).items():
            found[name] = np.where(since > 0.0, moved, 0.0)
    model = chain_model(scene)
    push = sum(effect.largest_acceleration_m_s2(model) for effect in model.effects)
    impulse = sum(abs(b.impulse_N_s) for b in scene.effects.impulse) / scene.mass_kg
    grown = kepler_growth(scene, since)
    found["com"] += EITHER_WAY * (0.5 * push * since + impulse) * since * grown
    found["com_velocity"] += EITHER_WAY * (push * since + impulse * (since > 0.0)) * grown
    rate = orbit_rate_bound(scene, solution.trajectory)
    found["com_velocity"] += rate * EITHER_WAY * (0.5 * push * since + impulse) * since * grown
    return found
