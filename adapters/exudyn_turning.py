"""Bars that turn their other face to the wind or to the Sun: equal steps pass over that instant."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.exudyn_frames import perpendicular

if TYPE_CHECKING:
    from adapters.engine import Array
    from adapters.exudyn_frames import Axes
    from adapters.exudyn_readout import Seen
    from scenarios import Scene


def turned_over(scene: Scene, axes: Axes, seen: Seen, t_s: Array) -> str:
    """Say which bar turned over, and between which samples; empty if none did.

    Forces of air and light have a jump or a kink there. A bar that turns over and back between two samples is not
    seen.
    """
    for towards, of in ((wind, "the wind"), (sunlight, "the Sun")):
        facing = towards(scene, axes, seen, t_s)
        if facing is None:
            continue
        changed = np.argwhere(np.sign(facing[1:]) != np.sign(facing[:-1]))
        if len(changed):
            k, bar = changed[0]
            return (
                f"bar {bar + 1} turned its other face to {of} between t = {t_s[k]:.6g} s and {t_s[k + 1]:.6g} s: "
                "equal steps pass over that instant"
            )
    return ""


def wind(scene: Scene, axes: Axes, seen: Seen, _t_s: Array) -> Array | None:
    """Speed of the bars across themselves against the air, (n, N) m/s; None without air."""
    drag = scene.effects.drag
    if drag is None:
        return None
    place = axes.origin_m[:, None] + axes.to_inertial(seen.position_m)
    motion = axes.origin_velocity_m_s[:, None] + axes.carried(seen.position_m, seen.velocity_m_s)
    speed: Array = np.sum(across(axes, seen) * (motion - drag.rotation_rad_s * perpendicular(place)), axis=-1)
    return speed


def sunlight(scene: Scene, axes: Axes, seen: Seen, t_s: Array) -> Array | None:
    """Cosine between the bars' normals and the direction to the Sun, (n, N); None without light."""
    light = scene.effects.solar_pressure
    if light is None:
        return None
    angle = light.sun_longitude_rad + light.sun_rate_rad_s * t_s
    sun = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    cosine: Array = np.sum(across(axes, seen) * sun[:, None], axis=-1)
    return cosine


def across(axes: Axes, seen: Seen) -> Array:
    """Normals of the bars, (n, N, 2), in inertial axes."""
    angle = seen.angle_rad + axes.turn_rad[:, None]
    return np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
