"""Start of a scene's motion as balls, by the meaning of its keys (docs/reference/scene_keys.md)."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

from flint import arb

from barchain.solutions.enclosure.equations import Equations, State
from barchain.solutions.enclosure.forces import cross, dot, number
from barchain.solutions.enclosure.series import Balls, TooWideError
from scenarios import Frame

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenarios import Scene

FIRST = 0.01
"""Radius of the balls that fixed points are sought in, radians, and of rates over the orbit's"""
ITERATIONS = 30


def start_balls(scene: Scene) -> list[arb]:
    """State of a scene at t = 0, (4 + 2 N,), of its numbers in double precision."""
    orbit, equations = scene.orbit, Equations(scene, 0.0)
    longitude, rise = number(orbit.longitude_rad), number(orbit.flight_path_rad)
    radius = number(scene.central_body.radius_m) + number(orbit.altitude_m)
    speed = number(orbit.speed_factor) * (number(scene.central_body.mu_m3_s2) / radius).sqrt()
    heading = longitude + arb.pi() / 2 - rise
    turning = speed * rise.cos() / radius
    horizontal = longitude - arb.pi() / 2
    s = State.of(
        arb(0),
        [
            *(radius * longitude.cos(), radius * longitude.sin(), speed * heading.cos(), speed * heading.sin()),
            *(number(x) + horizontal for x in scene.chain.angle_rad),
            *(number(a) * turning for a in scene.chain.rate_factor),
        ],
    )
    if scene.chain.angle_from == "bar":

        def angles(angle: list[arb]) -> list[arb]:
            bars = equations.geometry(Balls(), dataclasses.replace(s, angle=angle))
            apart = [(cross(bar.centre, bar.place) / dot(bar.centre, bar.place)).atan() for bar in bars]
            return [x + difference for x, difference in zip(s.angle, apart, strict=True)]

        s = dataclasses.replace(s, angle=fixed_point(angles, s.angle, arb(FIRST)))
    laws = {law.bar - 1: law.frame for law in scene.effects.prescribed_rotation}

    def rates(rate: list[arb]) -> list[arb]:
        bars = equations.geometry(Balls(), dataclasses.replace(s, rate=rate))
        own = [cross(bar.place, bar.velocity) / dot(bar.place, bar.place) for bar in bars]
        given = {Frame.INERTIAL: [arb(0)] * len(own), Frame.LOCAL_HORIZONTAL: own, Frame.PREVIOUS_BAR: [arb(0), *rate]}
        return [given[laws[j]][j] if j in laws else x for j, x in enumerate(s.rate)]

    found = fixed_point(rates, rates(s.rate), turning * FIRST) if laws else s.rate
    return [*s.place, *s.velocity, *s.angle, *found]


def fixed_point(step: Callable[[list[arb]], list[arb]], near: list[arb], radius: arb) -> list[arb]:
    """Balls that contain the fixed point of a map, which takes the first balls into themselves.

    Raises
    ------
    TooWideError
        If the map does not.
    """
    for _ in range(ITERATIONS):  # a rate that is another bar's needs one more for each bar
        near = step(near)
    balls = [x + arb(0, abs(radius).upper()) for x in near]
    for _ in range(ITERATIONS):
        inside = step(balls)
        if not all(x.contains(y) for x, y in zip(balls, inside, strict=True)):
            raise TooWideError("the start is not contained in a ball")
        balls = inside
    return balls
