"""From a valid scene file to a complete scene: one value per bar, SI units and radians, defaults filled in."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

from scenarios.effect import (
    Actuator,
    Axes,
    Drag,
    Effects,
    End,
    Frame,
    Gravity,
    Impulse,
    JointSpringDamper,
    Oblateness,
    PrescribedRotation,
    SolarPressure,
    ThirdBody,
    Thrust,
)
from scenarios.effect_tables import THIRD_BODIES
from scenarios.scene import CentralBody, Chain, Orbit, Run, Scene
from scenarios.start import each, start_note

if TYPE_CHECKING:
    from scenarios.effect_tables import (
        DragTable,
        EffectsTable,
        ImpulseTable,
        JointSpringDamperTable,
        PrescribedRotationTable,
        SolarPressureTable,
        ThirdBodyTable,
        ThrustTable,
    )
    from scenarios.schema import ChainTable, SceneFile


class IncompleteError(ValueError):
    """Tables that are valid by themselves don't make a scene together."""


def resolve(file: SceneFile, name: str) -> Scene:
    """Complete scene of a valid file.

    Raises
    ------
    IncompleteError
        If a thrust or an impulse is not within the run.
    """
    scene = Scene(
        name=name,
        title=file.title,
        source=file.source,
        description=" ".join(f"{file.description} {start_note(file.chain)}".split()),
        tags=tuple(file.tags),
        central_body=CentralBody(file.central_body.mu_m3_s2, file.central_body.radius_m),
        orbit=Orbit(file.orbit.altitude_m, file.orbit.speed_factor, math.radians(file.orbit.longitude_deg)),
        chain=resolve_chain(file.chain),
        effects=Effects(Gravity(file.effects.gravity)),
        run=Run(file.run.duration_s or 0.0, file.run.samples),
    )
    if file.run.orbits is not None:
        scene = dataclasses.replace(scene, run=Run(file.run.orbits * scene.period_s, file.run.samples))
    return dataclasses.replace(scene, effects=resolve_effects(file.effects, scene))


def resolve_chain(table: ChainTable) -> Chain:
    """Chain with one value per bar."""
    mass, length = each(table.mass_kg, table.bars), each(table.length_m, table.bars)
    slender = tuple(m * size * size / 12.0 for m, size in zip(mass, length, strict=True))
    return Chain(
        mass_kg=mass,
        length_m=length,
        inertia_kg_m2=slender if table.inertia_kg_m2 is None else each(table.inertia_kg_m2, table.bars),
        angle_rad=tuple(map(math.radians, each(table.angle_deg, table.bars))),
        angle_from=table.angle_from,
        rate_factor=each(table.rate_factor, table.bars),
    )


def resolve_effects(table: EffectsTable, scene: Scene) -> Effects:
    """Effects of a scene that has everything else."""
    bars = scene.bars
    oblate, light, springs = table.oblateness, table.solar_pressure, table.joint_spring_damper
    return Effects(
        gravity=Gravity(table.gravity),
        prescribed_rotation=tuple(resolve_rotation(p) for p in table.prescribed_rotation),
        oblateness=None if oblate is None else Oblateness(oblate.j2, oblate.radius_m or scene.central_body.radius_m),
        third_body=tuple(resolve_third_body(b, scene) for b in table.third_body),
        drag=None if table.drag is None else resolve_drag(table.drag, bars),
        solar_pressure=None if light is None else resolve_solar_pressure(light, bars),
        joint_spring_damper=None if springs is None else resolve_springs(springs, bars - 1),
        thrust=tuple(resolve_thrust(i, t, scene.run.duration_s) for i, t in enumerate(table.thrust)),
        impulse=tuple(resolve_impulse(i, p, scene.run.duration_s) for i, p in enumerate(table.impulse)),
    )


def resolve_rotation(p: PrescribedRotationTable) -> PrescribedRotation:
    """Prescribed rotation in radians."""
    return PrescribedRotation(
        p.bar, math.radians(p.amplitude_deg), p.duration_s, p.start_s, Frame(p.frame), Actuator(p.actuator)
    )


def resolve_third_body(table: ThirdBodyTable, scene: Scene) -> ThirdBody:
    """Third body with the rate of its circular orbit about the centre, by Kepler's third law of two bodies.

    Raises
    ------
    IncompleteError
        If the chain is not inside its orbit.
    """
    known = THIRD_BODIES.get(table.body, (0.0, 0.0))
    mu, distance = table.mu_m3_s2 or known[0], table.distance_m or known[1]
    if distance <= scene.radius0_m:
        raise IncompleteError(
            f"effects.third_body: the chain starts {scene.radius0_m:g} m from the centre, "
            f"allowed: less than the distance of the {table.body}, {distance:g} m"
        )
    rate = math.sqrt((scene.central_body.mu_m3_s2 + mu) / distance**3)
    return ThirdBody(table.body, mu, distance, math.radians(table.longitude_deg), rate)


def resolve_drag(table: DragTable, bars: int) -> Drag:
    """Drag with one width per bar."""
    return Drag(
        table.density_kg_m3,
        table.altitude_m,
        table.scale_height_m,
        table.rotation_rad_s,
        each(table.width_m, bars),
        table.normal_coefficient,
        table.tangential_coefficient,
    )


def resolve_solar_pressure(table: SolarPressureTable, bars: int) -> SolarPressure:
    """Solar pressure with one width per bar."""
    return SolarPressure(
        table.pressure_Pa,
        math.radians(table.sun_longitude_deg),
        table.sun_rate_rad_s,
        each(table.width_m, bars),
        table.reflectivity,
        table.shadow,
    )


def resolve_springs(table: JointSpringDamperTable, joints: int) -> JointSpringDamper:
    """Springs and dampers, one for each joint."""
    return JointSpringDamper(
        each(table.stiffness_N_m_rad, joints),
        each(table.damping_N_m_s_rad, joints),
        tuple(map(math.radians, each(table.rest_deg, joints))),
    )


def resolve_thrust(index: int, table: ThrustTable, run_s: float) -> Thrust:
    """Thrust as a table in time; a constant one has two equal entries.

    Raises
    ------
    IncompleteError
        If it does not begin before the end of the run.
    """
    times: tuple[float, ...]
    begins = table.times_s[0] if table.times_s is not None else table.start_s or 0.0
    if begins >= run_s:
        key = "start_s" if table.times_s is None else "times_s"
        raise IncompleteError(
            f"effects.thrust[{index}].{key}: begins at {begins:g} s, allowed: before the end of the run, {run_s:g} s"
        )
    if table.times_s is not None:
        times, force = tuple(map(float, table.times_s)), each(table.force_N, len(table.times_s))
    else:
        start = table.start_s or 0.0
        end = start + table.duration_s if table.duration_s is not None else run_s
        times, force = (start, end), each(table.force_N, 2)
    return Thrust(table.bar, End(table.end), Axes(table.axes), math.radians(table.direction_deg), times, force)


def resolve_impulse(index: int, table: ImpulseTable, run_s: float) -> Impulse:
    """Impulse in radians.

    Raises
    ------
    IncompleteError
        If it is not before the end of the run.
    """
    if table.at_s >= run_s:
        raise IncompleteError(
            f"effects.impulse[{index}].at_s: {table.at_s:g} given, allowed: before the end of the run, {run_s:g} s"
        )
    where: dict[str, Any] = {"bar": table.bar, "end": End(table.end), "axes": Axes(table.axes)}
    return Impulse(
        **where, direction_rad=math.radians(table.direction_deg), impulse_N_s=table.impulse_N_s, at_s=table.at_s
    )
