"""From a valid scene file to a complete scene: one value per bar, SI units and radians, defaults filled in."""

from __future__ import annotations

import math
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from scenarios.effect_types import (
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
from scenarios.scene import CentralBody, Chain, Orbit, Run, Scene, period_s, start_radius_m
from scenarios.toml.alignment import NEAR, on_sample, table_on_samples, turn_on_samples
from scenarios.toml.effect_tables import THIRD_BODIES, each, slender_inertia
from scenarios.toml.start import start_note

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenarios.scene import Array
    from scenarios.toml.effect_tables import (
        DragTable,
        EffectsTable,
        ImpulseTable,
        JointSpringDamperTable,
        PrescribedRotationTable,
        SolarPressureTable,
        ThirdBodyTable,
        ThrustTable,
    )
    from scenarios.toml.file import SceneFile
    from scenarios.toml.scene_tables import ChainTable, RunTable


class IncompleteError(ValueError):
    """Tables that are valid by themselves, but make no scene together."""


@contextmanager
def located(key: str) -> Iterator[None]:
    """Name the key of a fault that is found inside."""
    try:
        yield
    except ValueError as error:
        raise IncompleteError(f"{key}: {error}") from None


def resolve(file: SceneFile, name: str) -> Scene:
    """Complete scene of a valid file.

    Raises
    ------
    IncompleteError
        If a third body is inside the chain's orbit, a thrust or an impulse is not within the run, or two instants of an
        effect are next to one sample.
    """
    body = CentralBody(file.central_body.mu_m3_s2, file.central_body.radius_m)
    orbit = Orbit(file.orbit.altitude_m, file.orbit.speed_factor, math.radians(file.orbit.longitude_deg))
    run = resolve_run(file.run, body, orbit, Gravity(file.effects.gravity))
    return Scene(
        name=name,
        title=file.title,
        source=file.source,
        description=" ".join(f"{file.description} {start_note(file.chain)}".split()),
        tags=tuple(file.tags),
        central_body=body,
        orbit=orbit,
        chain=resolve_chain(file.chain),
        effects=resolve_effects(file.effects, body, start_radius_m(body, orbit), file.chain.bars, run.times_s),
        run=run,
    )


def resolve_run(table: RunTable, body: CentralBody, orbit: Orbit, gravity: Gravity) -> Run:
    """Run whose duration is in seconds; the table gives either seconds or periods of the orbit."""
    if table.duration_s is not None:
        return Run(table.duration_s, table.samples)
    assert table.orbits is not None
    return Run(table.orbits * period_s(body, orbit, gravity), table.samples)


def resolve_chain(table: ChainTable) -> Chain:
    """Chain with one value per bar."""
    mass, length = each(table.mass_kg, table.bars), each(table.length_m, table.bars)
    slender = tuple(map(slender_inertia, mass, length))
    return Chain(
        mass_kg=mass,
        length_m=length,
        inertia_kg_m2=slender if table.inertia_kg_m2 is None else each(table.inertia_kg_m2, table.bars),
        angle_rad=tuple(map(math.radians, each(table.angle_deg, table.bars))),
        angle_from=table.angle_from,
        rate_factor=each(table.rate_factor, table.bars),
    )


def resolve_effects(table: EffectsTable, body: CentralBody, radius0_m: float, bars: int, times_s: Array) -> Effects:
    """Effects on a chain of some bars that starts `radius0_m` from the centre and is sampled at `times_s`, (n,)."""
    oblate, light, springs = table.oblateness, table.solar_pressure, table.joint_spring_damper
    return Effects(
        gravity=Gravity(table.gravity),
        prescribed_rotation=tuple(resolve_rotation(i, p, times_s) for i, p in enumerate(table.prescribed_rotation)),
        oblateness=None if oblate is None else Oblateness(oblate.j2, oblate.radius_m or body.radius_m),
        third_body=resolve_third_bodies(table.third_body, body, radius0_m),
        drag=None if table.drag is None else resolve_drag(table.drag, bars),
        solar_pressure=None if light is None else resolve_solar_pressure(light, bars),
        joint_spring_damper=None if springs is None else resolve_springs(springs, bars - 1),
        thrust=tuple(resolve_thrust(i, t, times_s) for i, t in enumerate(table.thrust)),
        impulse=tuple(resolve_impulse(i, p, times_s) for i, p in enumerate(table.impulse)),
    )


def resolve_rotation(index: int, p: PrescribedRotationTable, times_s: Array) -> PrescribedRotation:
    """Prescribed rotation in radians; its ends are moved to samples next to them.

    Raises
    ------
    IncompleteError
        If both ends are next to one sample.
    """
    with located(f"effects.prescribed_rotation[{index}]"):
        start_s, duration_s = turn_on_samples(p.start_s, p.duration_s, times_s)
    return PrescribedRotation(
        p.bar, math.radians(p.amplitude_deg), duration_s, start_s, Frame(p.frame), Actuator(p.actuator)
    )


def resolve_third_bodies(tables: list[ThirdBodyTable], central: CentralBody, radius0_m: float) -> tuple[ThirdBody, ...]:
    """Third bodies in the order of their tables.

    Raises
    ------
    IncompleteError
        If the chain starts outside the orbit of one of them.
    """
    bodies = []
    for i, table in enumerate(tables):
        with located(f"effects.third_body[{i}].distance_m"):
            bodies.append(resolve_third_body(table, central, radius0_m))
    return tuple(bodies)


def resolve_third_body(table: ThirdBodyTable, central: CentralBody, radius0_m: float) -> ThirdBody:
    """Third body with the rate of its circular orbit about the centre, by Kepler's third law of two bodies.

    Raises
    ------
    ValueError
        If the chain, which starts `radius0_m` from the centre, is not inside that orbit.
    """
    known = THIRD_BODIES.get(table.body, (0.0, 0.0))
    mu, distance = table.mu_m3_s2 or known[0], table.distance_m or known[1]
    if distance <= radius0_m:
        own = f"{distance:g} given" if table.distance_m else f"the {table.body} is {distance:g} m from the centre"
        raise ValueError(f"{own}, allowed: more than the chain's own initial distance, {radius0_m:g} m")
    rate = math.sqrt((central.mu_m3_s2 + mu) / distance**3)
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
    """Thrust as a table in time; its instants are moved to samples next to them.

    Raises
    ------
    IncompleteError
        If the thrust does not begin before the end of the run, or two instants are next to one sample.
    """
    where, run_s = f"effects.thrust[{index}]", float(times_s[-1])
    given, force = thrust_table(table, run_s)
    begins = on_sample(given[0], times_s)
    if begins >= run_s:
        key = "start_s" if table.times_s is None else "times_s"
        raise IncompleteError(f"{where}.{key}: begins at {begins:g} s, allowed: before the end of the run, {run_s:g} s")
    with located(where):
        instants_s = table_on_samples(given, times_s)
    return Thrust(table.bar, End(table.end), Axes(table.axes), math.radians(table.direction_deg), instants_s, force)


def thrust_table(table: ThrustTable, run_s: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Instants (s) and sizes (N) of a thrust; a constant thrust has two equal sizes."""
    if table.times_s is not None:
        return tuple(map(float, table.times_s)), each(table.force_N, len(table.times_s))
    start = table.start_s or 0.0
    end = start + table.duration_s if table.duration_s is not None else run_s
    return (start, end), each(table.force_N, 2)


def resolve_impulse(index: int, table: ImpulseTable, times_s: Array) -> Impulse:
    """Impulse in radians; its instant is moved to a sample next to it.

    Raises
    ------
    IncompleteError
        If the impulse is not between the start and the end of the run: at the start it is another initial state.
    """
    at_s, run_s = on_sample(table.at_s, times_s), float(times_s[-1])
    if not 0.0 < at_s < run_s:
        raise IncompleteError(
            f"effects.impulse[{index}].at_s: {table.at_s:g} given, allowed: after the start and before the end of the "
            f"run, {run_s:g} s, by more than {NEAR:g} of it"
        )
    where: dict[str, Any] = {"bar": table.bar, "end": End(table.end), "axes": Axes(table.axes)}
    return Impulse(**where, direction_rad=math.radians(table.direction_deg), impulse_N_s=table.impulse_N_s, at_s=at_s)
