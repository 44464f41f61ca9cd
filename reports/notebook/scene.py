"""A scene in a notebook: the chain at the start on its osculating orbit, and the physics."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from reports.chapters.comparison.scene import facts
from reports.notebook.card import card, facts_table, picture
from reports.plotting.chain import SHARE, Geometry, draw_chains, joints, square_chart
from reports.plotting.palette import COLOURS
from reports.text.record import SceneRecord
from scenarios.effect_types import Gravity

if TYPE_CHECKING:
    from markupsafe import Markup

    from reports.plotting.series import Array
    from scenarios.scene import Scene

WIDTH_PX = 320.0
POINTS = 241
RADIAL = 1e-12  # (horizontal over circular speed)²: below it the path is drawn as a line
FARTHEST = 4.0  # initial radii: an open path is drawn up to there
INSTANTS = 12
"""The chain is as long as the distance between so many instants of a circular orbit"""


def html(scene: Scene) -> Markup:
    """HTML of a scene: picture and physics, no run."""
    pairs = facts(recorded(scene), of_track=False)
    about = ", ".join(filter(None, [scene.name, scene.source]))
    return card(scene.title, about, [picture(drawing(scene), WIDTH_PX), facts_table(pairs)])


def recorded(scene: Scene) -> SceneRecord:
    """Scene as a record has it, as far as it is known before a run."""
    basic = {"gravity", "prescribed_rotation"}
    data = {
        "title": scene.title,
        "length_m": list(scene.chain.length_m),
        "mass_kg": list(scene.chain.mass_kg),
        "period_s": scene.period_s,
        "speed_factor": scene.orbit.speed_factor,
        "flight_path_deg": math.degrees(scene.orbit.flight_path_rad),
        "eccentricity": scene.orbit.eccentricity,
        "end_bodies": list(scene.chain.bodies),
        "duration_s": scene.run.duration_s,
        "samples": scene.run.samples,
        "gravity": str(scene.effects.gravity),
        "effects": [name.replace("_", " ") for name in sorted(scene.effects.names) if name.split(".")[0] not in basic],
        "radius0_m": scene.radius0_m,
        "body_radius_m": scene.central_body.radius_m,
        "prescribed": [
            {"bar": p.bar, "amplitude_deg": math.degrees(turn.amplitude_rad), "duration_s": turn.duration_s}
            | {"start_s": turn.start_s, "frame": str(p.frame), "actuator": str(p.actuator)}
            for p in scene.effects.prescribed_rotation
            for turn in p.turns
        ],
    }
    return SceneRecord(scene.name, data)


def drawing(scene: Scene) -> Markup:
    """Chain at the start on the osculating orbit, enlarged as in a report."""
    attracted = scene.effects.gravity is not Gravity.NONE
    radius_m = scene.central_body.radius_m if attracted else 0.0
    geometry = Geometry(
        np.array(scene.chain.length_m),
        np.array(scene.chain.mass_kg),
        radius_m,
        scene.period_s,
        scene.bound,
        scene.chain.bodies,
        scene.chain.com_share,
    )
    path, start = osculating(scene), polar(scene.radius0_m, scene.orbit.longitude_rad)
    factor = SHARE * 2.0 * math.pi * scene.radius0_m / INSTANTS / scene.size_m
    chain = start + factor * joints(geometry, initial_angles(scene))
    drawn = square_chart(np.concatenate([path, chain[0]]), radius_m)
    drawn.line(path[:, 0], path[:, 1], COLOURS["rule"], 1.0)
    draw_chains(drawn, chain, scene.chain.bodies)
    return drawn.svg(f"{scene.title}: chain at the start, enlarged, on its osculating orbit")


def initial_angles(scene: Scene) -> Array:
    """Angles of the bars from the z1 axis at the start, rad, shape (1, N).

    The horizontal is the radial direction turned by -90 degrees. The chain is a point beside the orbit here: its
    horizontal is that of each bar.
    """
    horizontal = scene.orbit.longitude_rad - 0.5 * math.pi
    return np.array([scene.chain.angle_rad]) + horizontal


def osculating(scene: Scene) -> Array:
    """Osculating path at the start, (n, 2) m: a conic; a line without gravity or without horizontal velocity."""
    orbit = scene.orbit
    if scene.effects.gravity is Gravity.NONE:
        along = np.linspace(-1.0, 1.0, POINTS)[:, None] * scene.radius0_m
        tangent = polar(1.0, orbit.longitude_rad + 0.5 * math.pi - orbit.flight_path_rad)
        line: Array = polar(scene.radius0_m, orbit.longitude_rad) + along * tangent
        return line
    square = orbit.onward**2
    if square < RADIAL:
        return polar(scene.radius0_m * np.linspace(0.0, 1.0, POINTS), np.full(POINTS, orbit.longitude_rad))
    turned = np.linspace(-math.pi, math.pi, POINTS)  # from the start
    share = 1.0 + (square - 1.0) * np.cos(turned) - orbit.onward * orbit.upward * np.sin(turned)
    near = share * FARTHEST > square if not scene.bound else np.ones(POINTS, dtype=bool)
    return polar(scene.radius0_m * square / share[near], orbit.longitude_rad + turned[near])


def polar(radius_m: Array | float, angle_rad: Array | float) -> Array:
    """Plane points (n, 2) from polar coordinates."""
    return np.stack([radius_m * np.cos(angle_rad), radius_m * np.sin(angle_rad)], axis=-1)
