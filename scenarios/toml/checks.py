"""Checks that concern several tables of a scene file."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from scenarios.toml.tables import each

if TYPE_CHECKING:
    from scenarios.toml.schema import SceneTables
    from scenarios.toml.tables import EffectsTable

SLENDER_SLACK = 1e-9  # of m l²/12: a moment of inertia written with nine digits is that of a slender bar
MOST_SCALE_HEIGHTS = 30.0  # between the density's height and the chain: e^30 times the density is a mistaken unit


def check_effects(scene: SceneTables) -> None:
    """Refuse effects that the chain, the gravity or another effect leaves no room for."""
    check_prescriptions(scene)
    check_ends(scene)
    check_lists(scene)
    check_widths(scene)
    check_air(scene)
    check_fields(scene)
    check_slender(scene)


def check_prescriptions(scene: SceneTables) -> None:
    """Each bar has at most one law, exists, and has a neighbour if a joint drives it."""
    seen: set[int] = set()
    for i, p in enumerate(scene.effects.prescribed_rotation):
        where = f"effects.prescribed_rotation[{i}].bar"
        if p.bar > scene.chain.bars:
            raise ValueError(f"{where}: {p.bar} given, allowed: 1 to {scene.chain.bars}")
        if p.bar in seen:
            raise ValueError(f"{where}: bar {p.bar} already has a prescribed rotation; allowed: one for each bar")
        if p.actuator == "joint" and scene.chain.bars == 1:
            raise ValueError(f'{where}: actuator "joint" needs a neighbouring bar, and the chain has one bar')
        seen.add(p.bar)
    joints = [joint_of_motor(p.bar) for p in scene.effects.prescribed_rotation if p.actuator == "joint"]
    for joint in joints:
        if joints.count(joint) > 1:
            raise ValueError(
                f"effects.prescribed_rotation: joint {joint} would carry two motors (bar 1's motor is in joint 1); "
                "allowed: one motor for each joint"
            )


def joint_of_motor(bar: int) -> int:
    """Joint (from 1) whose motor turns `bar`: the one before it, and joint 1 for bar 1."""
    return max(bar - 1, 1)


def check_ends(scene: SceneTables) -> None:
    """Thrusts and impulses are on bars that there are."""
    for name in ("thrust", "impulse"):
        for i, p in enumerate(getattr(scene.effects, name)):
            if p.bar > scene.chain.bars:
                raise ValueError(f"effects.{name}[{i}].bar: {p.bar} given, allowed: 1 to {scene.chain.bars}")


def check_lists(scene: SceneTables) -> None:
    """Lists have one value per bar, or per joint."""
    effects, bars = scene.effects, scene.chain.bars
    for name in ("drag", "solar_pressure"):
        table = getattr(effects, name)
        if table and isinstance(table.width_m, list) and len(table.width_m) != bars:
            raise ValueError(
                f"effects.{name}.width_m: {len(table.width_m)} values given, allowed: one number, "
                f"or one value per bar: {bars}"
            )
    springs = effects.joint_spring_damper
    if springs is None:
        return
    if bars == 1:
        raise ValueError("effects.joint_spring_damper: the chain has one bar and no joint; allowed: two bars or more")
    for key in ("stiffness_N_m_rad", "damping_N_m_s_rad", "rest_deg"):
        value = getattr(springs, key)
        if isinstance(value, list) and len(value) != bars - 1:
            raise ValueError(
                f"effects.joint_spring_damper.{key}: {len(value)} values given, allowed: one number, "
                f"or one value per joint: {bars - 1}"
            )


def check_widths(scene: SceneTables) -> None:
    """A bar is no wider than it is long."""
    chain = scene.chain
    length = each(chain.length_m, chain.bars)
    for name in ("drag", "solar_pressure"):
        table = getattr(scene.effects, name)
        if table is None:
            continue
        width = each(table.width_m, chain.bars)
        for j, (wide, long) in enumerate(zip(width, length, strict=True), start=1):
            if wide > long:
                raise ValueError(
                    f"effects.{name}.width_m: {wide:g} given for bar {j}, allowed: at most its length, {long:g} m"
                )


def check_air(scene: SceneTables) -> None:
    """The density is told near enough to the chain for its exponential to mean anything there."""
    air, start_m = scene.effects.drag, scene.orbit.altitude_m
    if air is None:
        return
    heights = (start_m - air.altitude_m) / air.scale_height_m
    if abs(heights) > MOST_SCALE_HEIGHTS:
        raise ValueError(
            f"effects.drag: density_kg_m3 is that at altitude_m = {air.altitude_m:g} m and the chain starts at "
            f"{start_m:g} m, {abs(heights):.3g} times scale_height_m = {air.scale_height_m:g} m "
            f"{'above' if heights > 0.0 else 'below'} it; allowed: at most {MOST_SCALE_HEIGHTS:g} times"
        )


def check_fields(scene: SceneTables) -> None:
    """Fields besides the central one need that; a third body is beyond the chain."""
    effects: EffectsTable = scene.effects
    for name in ("oblateness", "third_body"):
        if getattr(effects, name) and effects.gravity == "none":
            raise ValueError(
                f'effects.{name}: the central body does not pull (gravity = "none"); allowed: with gravity'
            )
    beyond = scene.central_body.radius_m + scene.orbit.altitude_m
    for i, body in enumerate(effects.third_body):
        if body.distance_m is not None and body.distance_m <= beyond:
            raise ValueError(
                f"effects.third_body[{i}].distance_m: {body.distance_m:g} given, "
                f"allowed: more than the chain's own distance, {beyond:g}"
            )


def check_slender(scene: SceneTables) -> None:
    """The exact slender bar is uniform: it has its own moment of inertia."""
    chain = scene.chain
    if scene.effects.gravity != "slender" or chain.inertia_kg_m2 is None:
        return
    columns = (chain.mass_kg, chain.length_m, chain.inertia_kg_m2)
    rows = zip(*(c if isinstance(c, list) else [c] * chain.bars for c in columns), strict=True)
    for j, (mass, length, inertia) in enumerate(rows, start=1):
        slender = mass * length * length / 12.0
        if abs(inertia - slender) > SLENDER_SLACK * slender:
            raise ValueError(
                f'chain.inertia_kg_m2: {inertia:g} given for bar {j}, allowed with gravity = "slender": {slender:.10g} '
                "(uniform), or leave it out"
            )


def check_run_is_bound(scene: SceneTables) -> None:
    """`orbits` counts periods, so it needs an orbit that has one."""
    if scene.run.orbits is None:
        return
    if scene.effects.gravity == "none":
        raise ValueError("run.orbits: without gravity there is no period to count in; give duration_s")
    if scene.orbit.speed_factor**2 >= 2.0:
        raise ValueError(
            f"run.orbits: the orbit is not bound (speed_factor = {scene.orbit.speed_factor:g}, allowed below sqrt(2)); "
            "give duration_s"
        )


def check_above_surface(scene: SceneTables) -> None:
    """The whole chain, stretched towards the centre, must start above the surface."""
    length = scene.chain.length_m
    size_m = math.fsum(length) if isinstance(length, list) else scene.chain.bars * length
    if size_m >= scene.orbit.altitude_m:
        raise ValueError(
            f"orbit.altitude_m: {scene.orbit.altitude_m:g} lets a chain of {size_m:g} m reach the surface; "
            "allowed: more than the length of the chain"
        )
