"""Checks that concern several tables of a scene file. Each is made here only.

A check yields a line for each fault, so that a file's faults are told all at once; of several bars with one fault
the first is named.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from scenarios.effect_types import Gravity
from scenarios.scene import CentralBody, is_bound
from scenarios.size_limits import VALUES, LimitError
from scenarios.toml.effect_tables import each, slender_inertia
from scenarios.toml.orbit_forms import orbit_of
from scenarios.toml.scene_tables import MIDWAY
from scenarios.toml.start import start_faults

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenarios.scene import Orbit
    from scenarios.toml.effect_tables import PrescribedRotationTable
    from scenarios.toml.scene_tables import ChainTable, SceneTables

SLENDER_SLACK = 1e-9  # of m l²/12: a moment of inertia written with nine digits is that of a slender bar
MOST_SCALE_HEIGHTS = 30.0  # between the density's height and the chain: e^30 times the density is a mistaken unit


def check_all(scene: SceneTables) -> Iterator[str]:
    """Faults between the tables of a file, one line each."""
    for check in CHECKS:
        yield from check(scene)


def check_prescriptions(scene: SceneTables) -> Iterator[str]:
    """Check that the turns of a bar make one law, and that it has a neighbour if a motor in a joint drives it."""
    seen: dict[int, list[PrescribedRotationTable]] = {}
    for i, p in enumerate(scene.effects.prescribed_rotation, start=1):
        where, others = f"effects.prescribed_rotation[{i}]", seen.setdefault(p.bar, [])
        if others and (p.frame, p.actuator) != (others[0].frame, others[0].actuator):
            yield (
                f'{where}: bar {p.bar} has a law already, with frame = "{others[0].frame}" and actuator = '
                f'"{others[0].actuator}"; "{p.frame}" and "{p.actuator}" given, allowed: the same'
            )
        start_s, end_s = p.ends_s
        beside = next((o.ends_s for o in others if o.ends_s[0] < end_s and start_s < o.ends_s[1]), None)
        if beside is not None:
            yield (
                f"{where}.{'start_s' if p.times_s is None else 'times_s'}: bar {p.bar} is turned by another table from "
                f"{beside[0]:g} to {beside[1]:g} s; allowed: one turn after the other"
            )
        if p.actuator == "joint" and scene.chain.bars == 1:
            yield f'{where}.bar: actuator "joint" needs a neighbouring bar, and the chain has one bar'
        others.append(p)
    motors = {p.bar for p in scene.effects.prescribed_rotation if p.actuator == "joint"}
    joints = [joint_of_motor(bar) for bar in sorted(motors)]
    for joint in sorted(set(joints)):
        if joints.count(joint) > 1:
            yield (
                f"effects.prescribed_rotation: joint {joint} would carry two motors (bar 1's motor is in joint 1); "
                "allowed: one motor for each joint"
            )


def joint_of_motor(bar: int) -> int:
    """Joint (from 1) whose motor turns `bar`: the one before it, and joint 1 for bar 1."""
    return max(bar - 1, 1)


def check_bars(scene: SceneTables) -> Iterator[str]:
    """Check that prescribed rotations, thrusts and impulses are on bars of the chain, and motors in its joints."""
    for name in ("prescribed_rotation", "thrust", "impulse"):
        for i, p in enumerate(getattr(scene.effects, name), start=1):
            if p.bar > scene.chain.bars:
                yield f"effects.{name}[{i}].bar: {p.bar} given, allowed: 1 to {scene.chain.bars}"
    springs, joints = scene.effects.joint_spring_damper, scene.chain.bars - 1
    driven = [motor.joint for motor in scene.effects.joint_torque]
    moved = [point.joint for point in springs.set_point] if springs and joints else []
    for name, numbers in (("joint_torque", driven), ("joint_spring_damper.set_point", moved)):
        for i, joint in enumerate(numbers, start=1):
            if joint > joints:
                allowed = f"1 to {joints}" if joints else "two bars or more; the chain has one and no joint"
                yield f"effects.{name}[{i}].joint: {joint} given, allowed: {allowed}"
    for i, joint in enumerate(moved, start=1):
        if joint in moved[: i - 1]:
            yield (
                f"effects.joint_spring_damper.set_point[{i}].joint: {joint} has a set point already; "
                "allowed: one for each joint"
            )


def check_lists(scene: SceneTables) -> Iterator[str]:
    """Check that lists have one value per bar, or per joint."""
    effects, bars = scene.effects, scene.chain.bars
    for name in ("drag", "solar_pressure"):
        table = getattr(effects, name)
        if table and isinstance(table.width_m, list) and len(table.width_m) != bars:
            yield (
                f"effects.{name}.width_m: {len(table.width_m)} values given, allowed: one number, "
                f"or one value per bar: {bars}"
            )
    springs = effects.joint_spring_damper
    if springs is None:
        return
    if bars == 1:
        yield "effects.joint_spring_damper: the chain has one bar and no joint; allowed: two bars or more"
        return
    for key in ("stiffness_N_m_rad", "damping_N_m_s_rad", "rest_deg"):
        value = getattr(springs, key)
        if isinstance(value, list) and len(value) != bars - 1:
            yield (
                f"effects.joint_spring_damper.{key}: {len(value)} values given, allowed: one number, "
                f"or one value per joint: {bars - 1}"
            )


def check_widths(scene: SceneTables) -> Iterator[str]:
    """Check that no bar is wider than long."""
    chain = scene.chain
    _, length, *_ = chain.material()
    for name in ("drag", "solar_pressure"):
        table = getattr(scene.effects, name)
        width = each(table.width_m, chain.bars) if table else ()
        for j, (wide, long) in enumerate(zip(width, length, strict=False), start=1):  # check_lists tells of lengths
            if wide > long:
                yield f"effects.{name}.width_m: {wide:g} given for bar {j}, allowed: at most its length, {long:g} m"
                break


def check_air(scene: SceneTables) -> Iterator[str]:
    """Check that the chain starts within :data:`MOST_SCALE_HEIGHTS` of the height of the given density."""
    air, orbit = scene.effects.drag, start_of(scene)
    if air is None or orbit is None:
        return
    start_m = orbit.altitude_m
    heights = (start_m - air.altitude_m) / air.scale_height_m
    if abs(heights) > MOST_SCALE_HEIGHTS:
        yield (
            f"effects.drag: density_kg_m3 is that at altitude_m = {air.altitude_m:g} m and the chain starts at "
            f"{start_m:g} m, {abs(heights):.3g} times scale_height_m = {air.scale_height_m:g} m "
            f"{'above' if heights > 0.0 else 'below'} it; allowed: at most {MOST_SCALE_HEIGHTS:g} times"
        )


def check_fields(scene: SceneTables) -> Iterator[str]:
    """Check that oblateness and third bodies come with a central body that attracts."""
    effects = scene.effects
    for name in ("oblateness", "third_body"):
        if getattr(effects, name) and effects.gravity == "none":
            yield f'effects.{name}: the central body does not pull (gravity = "none"); allowed: with gravity'


def check_places(scene: SceneTables) -> Iterator[str]:
    """Check the bars' places at the start."""
    yield from start_faults(scene.chain)


def check_slender(scene: SceneTables) -> Iterator[str]:
    """Check that a bar under the exact gravity of slender bars has a uniform bar's moment of inertia."""
    chain = scene.chain
    if scene.effects.gravity != "slender" or chain.inertia_kg_m2 is None or unequal(chain):
        return
    for j, (mass, length, inertia, _) in enumerate(zip(*chain.material(), strict=True), start=1):
        slender = slender_inertia(mass, length)
        if abs(inertia - slender) > SLENDER_SLACK * slender:
            yield (
                f'chain.inertia_kg_m2: {inertia:g} given for bar {j}, allowed with gravity = "slender": {slender:.10g} '
                "(uniform), or leave it out"
            )
            return


def check_end_bodies(scene: SceneTables) -> Iterator[str]:
    """Check that nothing acts on end bodies as on bars: along their line, or on the end that they do not have."""
    ends = {body.at for body in scene.chain.end_body}
    if not ends:
        return
    effects, outer = scene.effects, {"first": (1, "left"), "last": (scene.chain.bars, "right")}
    for name in ("drag", "solar_pressure"):
        if getattr(effects, name):
            yield (
                f"effects.{name}: acts on bars, and the chain has an end body; allowed: a bar in its place, twice "
                "joint_m long, of the same mass_kg and inertia_kg_m2"
            )
    if effects.gravity == "slender":
        yield 'effects.gravity: "slender" given, allowed with an end body: none, point, gradient, quadrupole'
    for name in ("thrust", "impulse"):
        for i, push in enumerate(getattr(effects, name), start=1):
            if any((push.bar, push.end) == outer[end] for end in ends):
                yield (
                    f"effects.{name}[{i}].end: {push.end} given, the end that end body {push.bar} does not have; "
                    f"allowed: {'right' if push.end == 'left' else 'left'}, its joint"
                )


def check_centres(scene: SceneTables) -> Iterator[str]:
    """Check that no load is that of a uniform bar where a centre of mass is not midway between the ends."""
    if not unequal(scene.chain):
        return
    for name in ("drag", "solar_pressure"):
        if getattr(scene.effects, name):
            yield (
                f"effects.{name}: its formula has each bar's centre of mass midway; allowed: com_share = 0.5, no "
                "joint_mass"
            )
    if scene.effects.gravity == "slender":
        allowed = "none, point, gradient, quadrupole"
        yield f'effects.gravity: "slender" given, allowed with com_share or joint_mass: {allowed}'


def unequal(chain: ChainTable) -> bool:
    """Whether the centre of mass of any bar is not midway between its ends."""
    return set(chain.material()[3]) != {MIDWAY}


def check_run_is_bound(scene: SceneTables) -> Iterator[str]:
    """Check that a duration in orbits comes with a bound orbit, which has a period."""
    gravity, orbit = Gravity(scene.effects.gravity), start_of(scene)
    if scene.run.orbits is None or orbit is None or is_bound(orbit.speed_factor, gravity):
        return
    factor = orbit.speed_factor
    if gravity is Gravity.NONE:
        yield "run.orbits: without gravity the orbit has no period; give duration_s"
    else:
        yield (
            f"run.orbits: the orbit is not bound (speed_factor = {factor:g}, allowed below sqrt(2)); give duration_s"
        )


def check_size(scene: SceneTables) -> Iterator[str]:
    """Check that a trajectory of the scene fits into memory."""
    try:
        VALUES.check(scene.chain.bars * scene.run.samples)
    except LimitError as error:
        yield f"run.samples: {scene.chain.bars} bars at {scene.run.samples} samples: {error}"


def check_orbit(scene: SceneTables) -> Iterator[str]:
    """Check that the numbers of the orbit are a start outside the body."""
    try:
        orbit_of(scene.orbit, body_of(scene))
    except ValueError as error:
        yield f"orbit: {error}"


def start_of(scene: SceneTables) -> Orbit | None:
    """Start of the centre of mass; None where :func:`check_orbit` tells a fault."""
    try:
        return orbit_of(scene.orbit, body_of(scene))
    except ValueError:
        return None


def body_of(scene: SceneTables) -> CentralBody:
    """Central body of the tables."""
    return CentralBody(scene.central_body.mu_m3_s2, scene.central_body.radius_m)


def check_above_surface(scene: SceneTables) -> Iterator[str]:
    """Check that the whole chain, stretched towards the centre, starts above the surface."""
    length, orbit = scene.chain.length_m, start_of(scene)
    size_m = math.fsum(scene.chain.material()[1])
    if not isinstance(length, list) and not scene.chain.end_body:
        size_m = scene.chain.bars * length
    if orbit is not None and size_m >= orbit.altitude_m:
        yield (
            f"orbit.altitude_m: {orbit.altitude_m:g} lets a chain of {size_m:g} m reach the surface; "
            "allowed: more than the length of the chain"
        )


CHECKS = (
    check_size,
    check_orbit,
    check_run_is_bound,
    check_above_surface,
    check_places,
    check_bars,
    check_prescriptions,
    check_lists,
    check_widths,
    check_air,
    check_fields,
    check_slender,
    check_end_bodies,
    check_centres,
)
