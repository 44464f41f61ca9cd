"""From a valid scene file to a complete scene: one value per bar, SI units and radians, defaults filled in."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

from scenarios.forces import (
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
from scenarios.scene import CentralBody, Chain, Orbit, Run, Scene
from scenarios.toml.alignment import NEAR, on_sample, table_on_samples, turn_on_samples
from scenarios.toml.start import start_note
from scenarios.toml.tables import THIRD_BODIES, each

if TYPE_CHECKING:
    from scenarios.scene import Array
    from scenarios.toml.file import SceneFile
    from scenarios.toml.schema import ChainTable
    from scenarios.toml.tables import (
        DragTable,
        EffectsTable,
        ImpulseTable,
        JointSpringDamperTable,
        PrescribedRotationTable,
        SolarPressureTable,
        ThirdBodyTable,
        ThrustTable,
    )


class IncompleteError(ValueError):
    """Tables that are valid by themselves don't make a scene together."""


def resolve(file: SceneFile, name: str) -> Scene:
    """Complete scene of a valid file.

    Raises
    ------
    IncompleteError
        If a thrust or an impulse is not within the run, or two of an effect's instants are next to one sample.
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
    bars, times_s = scene.bars, scene.times_s
    oblate, light, springs = table.oblateness, table.solar_pressure, table.joint_spring_damper
    return Effects(
        gravity=Gravity(table.gravity),
        prescribed_rotation=tuple(resolve_rotation(i, p, times_s) for i, p in enumerate(table.prescribed_rotation)),
        oblateness=None if oblate is None else Oblateness(oblate.j2, oblate.radius_m or scene.central_body.radius_m),
        third_body=tuple(resolve_third_body(b, scene) for b in table.third_body),
        drag=None if table.drag is None else resolve_drag(table.drag, bars),
        solar_pressure=None if light is None else resolve_solar_pressure(light, bars),
        joint_spring_damper=None if springs is None else resolve_springs(springs, bars - 1),
        thrust=tuple(resolve_thrust(i, t, times_s) for i, t in enumerate(table.thrust)),
        impulse=tuple(resolve_impulse(i, p, times_s) for i, p in enumerate(table.impulse)),
    )


def resolve_rotation(index: int, p: PrescribedRotationTable, times_s: Array) -> PrescribedRotation:
    """Prescribed rotation in radians, its ends on the samples that they are next to.

    Raises
    ------
    IncompleteError
        If both are next to one sample.
    """
    try:
        start_s, duration_s = turn_on_samples(p.start_s, p.duration_s, times_s)
    except ValueError as error:
        raise IncompleteError(f"effects.prescribed_rotation[{index}]: {error}") from None
    return PrescribedRotation(
        p.bar, math.radians(p.amplitude_deg), duration_s, start_s, Frame(p.frame), Actuator(p.actuator)
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


def resolve_thrust(index: int, table: ThrustTable, times_s: Array) -> Thrust:
    """Thrust as a table in time, its instants on the samples that they are next to.

    Raises
    ------
    IncompleteError
        If it does not begin before the end of the run, or two instants are next to one sample.
    """
    where, run_s = f"effects.thrust[{index}]", float(times_s[-1])
    given, force = thrust_table(table, run_s)
    begins = on_sample(given[0], times_s)
    if begins >= run_s:
        key = "start_s" if table.times_s is None else "times_s"
        raise IncompleteError(f"{where}.{key}: begins at {begins:g} s, allowed: before the end of the run, {run_s:g} s")
    try:
        instants_s = table_on_samples(given, times_s)
    except ValueError as error:
        raise IncompleteError(f"{where}: {error}") from None
    return Thrust(table.bar, End(table.end), Axes(table.axes), math.radians(table.direction_deg), instants_s, force)


def thrust_table(table: ThrustTable, run_s: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Instants (s) and sizes (N) of a thrust; a constant one has two equal entries."""
    if table.times_s is not None:
        return tuple(map(float, table.times_s)), each(table.force_N, len(table.times_s))
    start = table.start_s or 0.0
    end = start + table.duration_s if table.duration_s is not None else run_s
    return (start, end), each(table.force_N, 2)


def resolve_impulse(index: int, table: ImpulseTable, times_s: Array) -> Impulse:
    """Impulse in radians, on the sample that it is next to.

    Raises
    ------
    IncompleteError
        If it is not between the start and the end of the run: a blow at the start is another initial state.
    """
    at_s, run_s = on_sample(table.at_s, times_s), float(times_s[-1])
    if not 0.0 < at_s < run_s:
        raise IncompleteError(
            f"effects.impulse[{index}].at_s: {table.at_s:g} given, allowed: after the start and before the end of the "
            f"run, {run_s:g} s, by more than {NEAR:g} of it"
        )
    where: dict[str, Any] = {"bar": table.bar, "end": End(table.end), "axes": Axes(table.axes)}
    return Impulse(**where, direction_rad=math.radians(table.direction_deg), impulse_N_s=table.impulse_N_s, at_s=at_s)
