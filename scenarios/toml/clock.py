"""Effects of a scene that starts later than the clock of their instants: `start_s` of its `[run]`.

In a scene every instant counts from its start. What is over by then is gone; a bar that was turned is held.
"""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, TypeVar

import numpy as np

if TYPE_CHECKING:
    from scenarios.effect_types import Effects
    from scenarios.toml.effect_tables import (
        EffectsTable,
        ImpulseTable,
        JointSpringDamperTable,
        JointTorqueTable,
        PrescribedRotationTable,
        ThrustTable,
    )

    Sizes = TypeVar("Sizes", ThrustTable, JointTorqueTable)


def later(table: EffectsTable, start_s: float) -> EffectsTable:
    """Tables whose instants count from a later start.

    Raises
    ------
    ValueError
        If a bar is being turned at the start, or an impulse acts just then: a run's row shows the state before it.
    """
    if not start_s:
        return table
    thrusts = [later_sizes(one, "force_N", start_s) for one in table.thrust]
    motors = [later_sizes(one, "torque_N_m", start_s) for one in table.joint_torque]
    springs = table.joint_spring_damper
    for i, impulse in enumerate(table.impulse, start=1):
        if math.isclose(impulse.at_s, start_s, rel_tol=1e-9):
            raise ValueError(
                f"effects.impulse[{i}].at_s: {impulse.at_s:g} given, the instant of the start, run.start_s; allowed: "
                "before it or after it"
            )
    laws = [later_turn(i, law, start_s) for i, law in enumerate(table.prescribed_rotation, start=1)]
    moving = {law.bar for law in laws if law.amplitude_deg != 0.0}
    return table.model_copy(update={
        "prescribed_rotation": [law for law in laws if law.amplitude_deg != 0.0 or law.bar not in moving],
        "joint_spring_damper": springs and later_set_points(springs, start_s),
        "joint_torque": [one for one in motors if one is not None],
        "thrust": [one for one in thrusts if one is not None],
        "impulse": [later_impulse(one, start_s) for one in table.impulse if one.at_s > start_s],
    })  # fmt: skip


def later_impulse(impulse: ImpulseTable, start_s: float) -> ImpulseTable:
    """Impulse whose instant counts from a later start."""
    return impulse.model_copy(update={"at_s": impulse.at_s - start_s})


def later_turn(number: int, law: PrescribedRotationTable, start_s: float) -> PrescribedRotationTable:
    """Prescribed rotation that begins after the start, or one that is over and holds its bar."""
    begins_s, ends_s = law.ends_s
    if begins_s >= start_s:
        times = law.times_s and [t - start_s for t in law.times_s]
        return law.model_copy(update={"times_s": times} if times else {"start_s": begins_s - start_s})
    if ends_s > start_s and law.amplitude_deg != 0.0:  # one that holds its bar goes on to hold it
        raise ValueError(
            f"effects.prescribed_rotation[{number}]: bar {law.bar} is being turned at the start, run.start_s = "
            f"{start_s:g} s; allowed: up to {begins_s:g} s, or from {ends_s:g} s on"
        )
    held = {"start_s": 0.0, "duration_s": ends_s - begins_s, "amplitude_deg": 0.0, "times_s": None, "angle_deg": None}
    return law.model_copy(update=held)


def later_set_points(springs: JointSpringDamperTable, start_s: float) -> JointSpringDamperTable:
    """Springs whose set points count from a later start; instants before it stay, as negative numbers."""
    moved = [one.model_copy(update={"times_s": [t - start_s for t in one.times_s]}) for one in springs.set_point]
    return springs.model_copy(update={"set_point": moved})


def later_sizes(table: Sizes, key: str, start_s: float) -> Sizes | None:
    """Sizes `key` of a thrust or a joint's torque from a later start on; None if it is over."""
    if table.times_s is None:
        begins_s = (table.start_s or 0.0) - start_s
        if table.duration_s is None:
            return table.model_copy(update={"start_s": max(begins_s, 0.0)})
        ends_s = begins_s + table.duration_s
        first_s = max(begins_s, 0.0)
        return table.model_copy(update={"start_s": first_s, "duration_s": ends_s - first_s}) if ends_s > 0.0 else None
    times = [t - start_s for t in table.times_s]
    if times[-1] <= 0.0:
        return None
    sizes = np.asarray(getattr(table, key), dtype=float).tolist()
    after = [(t, f) for t, f in zip(times, sizes, strict=True) if t > 0.0]
    if times[0] <= 0.0:
        after.insert(0, (0.0, float(np.interp(0.0, times, sizes))))
    return table.model_copy(update={"times_s": [t for t, _ in after], key: [f for _, f in after]})


def turned(effects: Effects, start_s: float) -> Effects:
    """Effects whose third bodies and Sun have gone on up to a later start, to numbers of degrees as in a file."""
    if not start_s:
        return effects

    def gone_on(longitude_rad: float, rate_rad_s: float) -> float:
        return math.radians(math.degrees(math.remainder(longitude_rad + rate_rad_s * start_s, 2.0 * math.pi)))

    bodies, light = effects.third_body, effects.solar_pressure
    return dataclasses.replace(
        effects,
        third_body=tuple(dataclasses.replace(b, longitude_rad=gone_on(b.longitude_rad, b.rate_rad_s)) for b in bodies),
        solar_pressure=light
        and dataclasses.replace(light, sun_longitude_rad=gone_on(light.sun_longitude_rad, light.sun_rate_rad_s)),
    )
