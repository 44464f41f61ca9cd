"""From a valid scene file to a complete scene: one value per bar, SI units and radians, defaults filled in.

A key of a table is a field of the frozen class of the same part (:func:`converted`); what follows from several keys, or
from the run, is computed here.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from scenarios.effect_types import (
    Actuator,
    Axes,
    Course,
    Drag,
    Effects,
    End,
    Frame,
    Gravity,
    Impulse,
    JointSpringDamper,
    JointTorque,
    Oblateness,
    PrescribedRotation,
    SolarPressure,
    ThirdBody,
    Thrust,
    Turn,
)
from scenarios.scene import ENDS, CentralBody, Chain, Run, Scene, orbital_rate_rad_s, period_s, start_radius_m
from scenarios.size_limits import MOST_MAGNITUDE
from scenarios.toml.alignment import NEAR, on_sample, span, table_on_samples, turn_on_samples
from scenarios.toml.clock import later, turned
from scenarios.toml.effect_tables import THIRD_BODIES, each
from scenarios.toml.orbit_forms import orbit_of
from scenarios.toml.scene_tables import MATERIAL_KEYS, MIDWAY
from scenarios.toml.start import start_note

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from scenarios.scene import Array, Orbit
    from scenarios.toml.effect_tables import (
        EffectsTable,
        JointSpringDamperTable,
        JointTorqueTable,
        PrescribedRotationTable,
        Table,
        ThirdBodyTable,
        ThrustTable,
    )
    from scenarios.toml.file import SceneFile
    from scenarios.toml.scene_tables import ChainTable, RunTable

T = TypeVar("T")
ANGLES = {
    "angle_rad", "longitude_rad", "flight_path_rad", "amplitude_rad", "direction_rad", "rest_rad", "sun_longitude_rad",
}  # fmt: skip
"""Fields whose keys are in degrees"""
WORDS = {kind.__name__: kind for kind in (Actuator, Axes, Course, End, Frame)}
"""Types of fields whose keys are words"""
EACH = "tuple[float, ...]"
"""Type of fields with a value for each bar or joint, whose keys may have one for all"""


class IncompleteError(ValueError):
    """Tables that are valid by themselves, but make no scene together."""


@contextmanager
def located(key: str) -> Iterator[None]:
    """Name the key of a fault that is found inside."""
    try:
        yield
    except ValueError as error:
        raise IncompleteError(f"{key}: {error}") from None


def converted(kind: type[T], table: Table, count: int = 0, **found: Any) -> T:
    """Part of a scene from its table.

    Parameters
    ----------
    kind : type
        Frozen class of the part.
    table : Table
    count : int
        Number of bars or joints, for fields with a value for each.
    **found : Any
        Fields that do not stand in the table as they are.
    """
    for field in dataclasses.fields(kind):  # type: ignore[arg-type]
        name = field.name
        if name in found:
            continue
        angle = name in ANGLES
        value = getattr(table, f"{name.removesuffix('_rad')}_deg" if angle else name)
        if field.type == EACH:
            value = tuple(map(math.radians, each(value, count))) if angle else each(value, count)
        elif angle:
            value = math.radians(value)
        found[name] = WORDS[str(field.type)](value) if field.type in WORDS else value
    return kind(**found)


def resolve(file: SceneFile, name: str) -> Scene:
    """Complete scene of a valid file.

    Raises
    ------
    IncompleteError
        If a third body is inside the chain's orbit, a thrust or an impulse is not within the run, two instants of an
        effect are next to one sample, or an effect can't start in its middle.
    """
    body = converted(CentralBody, file.central_body)
    orbit = orbit_of(file.orbit, body)
    run = resolve_run(file.run, body, orbit, Gravity(file.effects.gravity))
    try:
        effects = later(file.effects, file.run.start_s)
    except ValueError as error:
        raise IncompleteError(str(error)) from None
    return Scene(
        name=name,
        title=file.title,
        source=file.source,
        description=" ".join(f"{file.description} {start_note(file.chain)}".split()),
        tags=tuple(file.tags),
        central_body=body,
        orbit=orbit,
        chain=resolve_chain(file.chain, orbital_rate_rad_s(body, orbit), orbit.longitude_rad),
        effects=turned(
            resolve_effects(effects, body, start_radius_m(body, orbit), file.chain.bars, run.times_s), file.run.start_s
        ),
        run=run,
    )


def resolve_run(table: RunTable, body: CentralBody, orbit: Orbit, gravity: Gravity) -> Run:
    """Run whose duration is in seconds; the table gives either seconds or periods of the orbit."""
    if table.duration_s is not None:
        return Run(table.duration_s, table.samples)
    assert table.orbits is not None
    return Run(table.orbits * period_s(body, orbit, gravity), table.samples)


def resolve_chain(table: ChainTable, orbital_rad_s: float, longitude_rad: float) -> Chain:
    """Chain with one value per bar; absolute angles and rates become those relative to the orbit's start."""
    found: dict[str, Any] = dict(zip(MATERIAL_KEYS, table.material(), strict=True))
    if set(found["com_share"]) == {MIDWAY}:
        found["com_share"] = ()
    found["angle_rad"] = table.angles_rad
    if table.angle_from == "inertial":
        horizontal = longitude_rad - 0.5 * math.pi
        found |= {"angle_rad": tuple(angle - horizontal for angle in table.angles_rad), "angle_from": "chain"}
    rates = absolute_rates_rad_s(table)
    if rates is not None:
        found["rate_factor"] = rate_factors(rates, orbital_rad_s)
    bodies = {body.at for body in table.end_body}
    return converted(Chain, table, table.bars, end_bodies=tuple(end for end in ENDS if end in bodies), **found)


def absolute_rates_rad_s(table: ChainTable) -> tuple[float, ...] | None:
    """Initial rates of the bars, rad/s; None where they are given relative to the orbit's."""
    if table.rate_rad_s is not None:
        return each(table.rate_rad_s, table.bars)
    return None if table.rate_deg_s is None else tuple(map(math.radians, each(table.rate_deg_s, table.bars)))


def rate_factors(rates_rad_s: tuple[float, ...], orbital_rad_s: float) -> tuple[float, ...]:
    """Rates of the bars over that of the centre of mass's longitude.

    Raises
    ------
    IncompleteError
        If the chain's centre of mass starts at rest or along the radius, so that there is no such unit.
    """
    if orbital_rad_s and max(map(abs, rates_rad_s)) <= MOST_MAGNITUDE * orbital_rad_s:
        return tuple(rate / orbital_rad_s for rate in rates_rad_s)
    if any(rates_rad_s):
        raise IncompleteError(
            "chain: rates in rad/s or deg/s are stored as multiples of the rate of the centre of mass's longitude, "
            "which is 0 here; allowed: with a horizontal velocity (without gravity the bars move alike at any velocity)"
        )
    return (0.0,) * len(rates_rad_s)


def resolve_effects(table: EffectsTable, body: CentralBody, radius0_m: float, bars: int, times_s: Array) -> Effects:
    """Effects on a chain of some bars that starts `radius0_m` from the centre and is sampled at `times_s`, (n,)."""
    oblate, springs = table.oblateness, table.joint_spring_damper
    laws: dict[int, list[PrescribedRotation]] = {}
    bodies, impulses = [], []
    run_s = float(times_s[-1])
    for i, law in enumerate(table.prescribed_rotation, start=1):
        with located(f"effects.prescribed_rotation[{i}]"):
            turns = turns_of(law, times_s)
        for turn in turns:
            one = converted(PrescribedRotation, law, **vars(turn), further=())
            laws.setdefault(law.bar, []).append(one)
    for i, third in enumerate(table.third_body, start=1):
        with located(f"effects.third_body[{i}].distance_m"):
            bodies.append(resolve_third_body(third, body, radius0_m))
    for i, impulse in enumerate(table.impulse, start=1):  # at the start it would be another initial state
        at_s = on_sample(impulse.at_s, times_s)
        if not 0.0 < at_s < run_s:
            raise IncompleteError(
                f"effects.impulse[{i}].at_s: {impulse.at_s:g} given, allowed: after the start and before the end of "
                f"the run, {run_s:g} s, by more than {NEAR:g} of it"
            )
        impulses.append(converted(Impulse, impulse, at_s=at_s))
    return Effects(
        gravity=Gravity(table.gravity),
        prescribed_rotation=tuple(map(one_law, laws.values())),
        oblateness=None if oblate is None else Oblateness(oblate.j2, oblate.radius_m or body.radius_m),
        third_body=tuple(bodies),
        drag=None if table.drag is None else converted(Drag, table.drag, bars),
        solar_pressure=None if table.solar_pressure is None else converted(SolarPressure, table.solar_pressure, bars),
        joint_spring_damper=None if springs is None else resolve_springs(springs, bars - 1),
        joint_torque=(
            *(() if springs is None else set_points(springs, bars - 1, times_s)),
            *(
                resolve_sizes(JointTorque, "joint_torque", i, t, times_s)
                for i, t in enumerate(table.joint_torque, start=1)
            ),
        ),
        thrust=tuple(resolve_sizes(Thrust, "thrust", i, t, times_s) for i, t in enumerate(table.thrust, start=1)),
        impulse=tuple(impulses),
    )


def turns_of(table: PrescribedRotationTable, times_s: Array) -> list[Turn]:
    """Turn of a table, or the pieces of its spline; their ends are moved to samples next to them.

    Raises
    ------
    ValueError
        If two ends are next to the same sample.
    """
    if table.times_s is None or table.angle_deg is None:
        start_s, duration_s = turn_on_samples(table.start_s or 0.0, table.duration_s or 0.0, times_s)
        amplitude_rad = math.radians(table.amplitude_deg or 0.0)
        return [Turn(amplitude_rad, duration_s, start_s, Course(table.course or Course.PAPER))]
    knots = table_on_samples(table.times_s, times_s)
    lengths = [span(a, b) for a, b in itertools.pairwise(knots)]
    angles = [math.radians(b - a) for a, b in itertools.pairwise(table.angle_deg)]
    rates, accelerations = spline(lengths, angles)
    parts = zip(angles, lengths, knots, itertools.pairwise(rates), itertools.pairwise(accelerations), strict=False)
    return [Turn(angle, length, start, Course.SPLINE, *ends) for angle, length, start, *ends in parts]


def spline(lengths: Sequence[float], steps: Sequence[float]) -> tuple[list[float], list[float]]:
    """Rates and accelerations at the knots of a quintic spline with some lengths and steps, zero at both ends.

    The third and fourth derivatives are continuous at the inner knots: a banded system of two equations for each, in
    units of the mean length. It is solved here, in Python's own arithmetic: a library's last digits differ from machine
    to machine, and with them the digest of the scene.
    """
    unit = sum(lengths) / len(lengths)
    pieces = [(length / unit, step) for length, step in zip(lengths, steps, strict=True)]
    system = list[dict[int, float]]()
    right = list[float]()
    for k, ((h, d), (g, e)) in enumerate(itertools.pairwise(pieces)):
        before, here, after = 2 * k - 2, 2 * k, 2 * k + 2  # places of a rate; that of the acceleration is the next
        system.append({
            before: 14.0 / h**3, before + 1: 2.0 / h**2,
            here: 16.0 / h**3 + 16.0 / g**3, here + 1: 3.0 / g**2 - 3.0 / h**2,
            after: 14.0 / g**3, after + 1: -2.0 / g**2,
        })  # fmt: skip
        right.append(30.0 * (d / h**4 + e / g**4))
        system.append({
            before: -8.0 / h**2, before + 1: -1.0 / h,
            here: 12.0 / g**2 - 12.0 / h**2, here + 1: 3.0 / h + 3.0 / g,
            after: 8.0 / g**2, after + 1: -1.0 / g,
        })  # fmt: skip
        right.append(20.0 * (e / g**3 - d / h**3))
    found = solved(system, right)
    rates, accelerations = ([0.0, *found[i::2], 0.0] for i in (0, 1))
    return [rate / unit for rate in rates], [acceleration / unit**2 for acceleration in accelerations]


def solved(system: list[dict[int, float]], right: list[float]) -> list[float]:
    """Solution of a banded system by elimination: rows as coefficients by column; what is outside the system is 0."""
    n = len(right)
    for i, row in enumerate(system):
        for below in range(i + 1, min(i + 4, n)):
            factor = system[below].get(i, 0.0) / row[i]
            for column, value in row.items():
                if column > i:
                    system[below][column] = system[below].get(column, 0.0) - factor * value
            right[below] -= factor * right[i]
    found = [0.0] * n
    for i in reversed(range(n)):
        known = sum(value * found[column] for column, value in system[i].items() if i < column < n)
        found[i] = (right[i] - known) / system[i][i]
    return found


def one_law(turns: list[PrescribedRotation]) -> PrescribedRotation:
    """Law of one bar from those of its single turns."""
    first, *others = sorted(turns, key=lambda one: one.start_s)
    further = (o.turns[0] for o in others)
    return dataclasses.replace(first, further=tuple(further))


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


def resolve_springs(table: JointSpringDamperTable, joints: int) -> JointSpringDamper:
    """Springs and dampers; the rest angle of a joint with a set point is the point's first angle."""
    found = converted(JointSpringDamper, table, joints)
    rest_rad = list(found.rest_rad)
    for point in table.set_point:
        rest_rad[point.joint - 1] = math.radians(point.angle_deg[0])
    return dataclasses.replace(found, rest_rad=tuple(rest_rad))


def set_points(table: JointSpringDamperTable, joints: int, times_s: Array) -> Iterator[JointTorque]:
    """Torques k (s - rest) + c s' that move the rest angles of springs and dampers along their set points s(t).

    Where the slope of s changes, a damper's torque jumps.
    """
    springs, run_s = resolve_springs(table, joints), float(times_s[-1])
    for i, point in enumerate(table.set_point, start=1):
        with located(f"effects.joint_spring_damper.set_point[{i}]"):
            instants = table_on_samples(point.times_s, times_s)
        k = point.joint - 1
        stiffness, damping, rest = (
            each[k] for each in (springs.stiffness_N_m_rad, springs.damping_N_m_s_rad, springs.rest_rad)
        )
        angles = np.radians(point.angle_deg)
        knots = [0.0, *(t for t in instants if 0.0 < t < run_s), run_s]
        times, torques = [], []
        for (t0, s0), (t1, s1) in itertools.pairwise(zip(knots, np.interp(knots, instants, angles), strict=True)):
            moving = damping * (s1 - s0) / (t1 - t0)
            times += [t0, t1]
            torques += [float(stiffness * (s - rest) + moving) for s in (s0, s1)]
        if any(torques):
            yield JointTorque(point.joint, tuple(times), tuple(torques))


def resolve_sizes(kind: type[T], name: str, i: int, table: ThrustTable | JointTorqueTable, times_s: Array) -> T:
    """Table in time of an effect, a constant one with two equal sizes; its instants are moved to samples next to them.

    Raises
    ------
    IncompleteError
        If it does not begin before the end of the run, or two instants are next to one sample.
    """
    where, size = f"effects.{name}[{i}]", {"thrust": "force_N", "joint_torque": "torque_N_m"}[name]
    run_s, start_s = float(times_s[-1]), table.start_s or 0.0
    end_s = run_s if table.duration_s is None else start_s + table.duration_s
    instants_s = (start_s, end_s) if table.times_s is None else tuple(map(float, table.times_s))
    begins_s = on_sample(instants_s[0], times_s)
    if begins_s >= run_s:
        key = "start_s" if table.times_s is None else "times_s"
        raise IncompleteError(
            f"{where}.{key}: begins at {begins_s:g} s, allowed: before the end of the run, {run_s:g} s"
        )
    with located(where):
        aligned_s = table_on_samples(instants_s, times_s)
    found: dict[str, Any] = {"times_s": aligned_s, size: each(getattr(table, size), len(instants_s))}
    return converted(kind, table, **found)
