"""Effects of a scene for the reference; imported only for a scene that has any."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.effects.drag import DragEffect
from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect
from reference_impl.effects.joint_torque import JointTorqueEffect
from reference_impl.effects.oblateness import OblatenessEffect
from reference_impl.effects.quadrupole import QuadrupoleEffect
from reference_impl.effects.slender import SlenderBarEffect
from reference_impl.effects.solar_pressure import SolarPressureEffect
from reference_impl.effects.third_body import ThirdBodyEffect
from reference_impl.effects.thrust import ThrustEffect
from reference_impl.model.chain import BarImpulse
from scenarios import Axes, End, Gravity

if TYPE_CHECKING:
    from collections.abc import Iterator

    from reference_impl.model.effect import ChainEffect
    from scenarios import Impulse, Scene, Thrust
    from scenarios.scene import Chain


def effects_of(scene: Scene) -> tuple[ChainEffect, ...]:
    """Effects besides point or gradient gravity and prescribed rotations, in a fixed order."""
    return tuple(found_effects(scene))


def found_effects(scene: Scene) -> Iterator[ChainEffect]:
    """Effects in the order of their evaluation."""
    e, body = scene.effects, scene.central_body
    turns, second_moment = e.gravity.turns, e.gravity in (Gravity.QUADRUPOLE, Gravity.SLENDER)
    if e.gravity is Gravity.SLENDER:
        yield SlenderBarEffect()
    if e.gravity is Gravity.QUADRUPOLE:
        yield QuadrupoleEffect()
    if e.oblateness:
        strength = 0.5 * body.mu_m3_s2 * e.oblateness.j2 * e.oblateness.radius_m**2
        yield OblatenessEffect(strength, turns, second_moment)
    for b in e.third_body:
        yield ThirdBodyEffect(b.mu_m3_s2, b.distance_m, b.longitude_rad, b.rate_rad_s, turns, second_moment)
    if e.drag:
        yield DragEffect(
            e.drag.density_kg_m3,
            body.radius_m + e.drag.altitude_m,
            e.drag.scale_height_m,
            e.drag.rotation_rad_s,
            np.array(e.drag.width_m),
            e.drag.normal_coefficient,
            e.drag.tangential_coefficient,
        )
    if e.solar_pressure:
        light = e.solar_pressure
        yield SolarPressureEffect(
            light.pressure_Pa,
            light.sun_longitude_rad,
            light.sun_rate_rad_s,
            np.array(light.width_m),
            light.reflectivity,
            body.radius_m if light.shadow else 0.0,
        )
    if e.joint_spring_damper:
        s = e.joint_spring_damper
        yield JointSpringDamperEffect(
            np.array(s.stiffness_N_m_rad), np.array(s.damping_N_m_s_rad), np.array(s.rest_rad)
        )
    for motor in e.joint_torque:
        yield JointTorqueEffect(np.array(motor.times_s), np.array(motor.torque_N_m), motor.joint - 1)
    for t in e.thrust:
        inertial = t.axes is Axes.INERTIAL
        side = side_of(scene.chain, t)
        yield ThrustEffect(np.array(t.times_s), np.array(t.force_N), t.bar - 1, side, inertial, t.direction_rad)


def impulses_of(scene: Scene) -> tuple[BarImpulse, ...]:
    """Impulses."""
    return tuple(
        BarImpulse(p.bar - 1, side_of(scene.chain, p), p.axes is Axes.INERTIAL, p.direction_rad, p.impulse_N_s, p.at_s)
        for p in scene.effects.impulse
    )


def side_of(chain: Chain, push: Thrust | Impulse) -> float:
    """Place of a bar's end along the bar from its centre of mass, over half of its length."""
    share = chain.com_share[push.bar - 1] if chain.com_share else 0.5
    return 2.0 * (1.0 - share) if push.end is End.RIGHT else -2.0 * share
