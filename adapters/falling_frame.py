"""A frame that falls freely with the chain's centre of mass at first, its axes fixed in direction."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.kepler import propagate
from scenarios import Gravity

if TYPE_CHECKING:
    from adapters.engine import Array
    from adapters.initial_state import InitialState
    from scenarios import Scene


def falling(scene: Scene, start: InitialState, t_s: Array) -> tuple[Array, Array]:
    """Origin of the frame and its velocity at `t_s` (n,), each (n, 2), m and m/s.

    Kepler's orbit of a particle started as the centre of mass is; uniform motion without gravity.
    """
    if scene.effects.gravity is Gravity.NONE:
        drift = np.tile(start.com_velocity_m_s, (len(t_s), 1))
        return start.com_m + t_s[:, None] * drift, drift
    return propagate(scene.central_body.mu_m3_s2, start.com_m, start.com_velocity_m_s, t_s)
