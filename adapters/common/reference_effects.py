"""Effects of a scene for the reference; each module is imported only for a scene with the effect."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenarios import Axes, Gravity

if TYPE_CHECKING:
    from reference_impl.model.chain import BarImpulse
    from reference_impl.model.effect import ChainEffect
    from scenarios import Scene


def effects_of(scene: Scene) -> tuple[ChainEffect, ...]:
    """Effects besides point or gradient gravity and prescribed rotations, in a fixed order."""
    called = scene.effects
    found: list[ChainEffect] = []
    if called.gravity in (Gravity.QUADRUPOLE, Gravity.SLENDER):
        found.append(bar_shape(called.gravity))
    if called.oblateness:
        found.append(oblateness(scene))
    if called.third_body:
        found += third_bodies(scene)
    if called.drag:
        found.append(drag(scene))
    if called.solar_pressure:
        found.append(solar_pressure(scene))
    if called.joint_spring_damper:
        found.append(springs(scene))
    if called.thrust:
        found += thrusts(scene)
    return tuple(found)


def bar_shape(gravity: Gravity) -> ChainEffect:
    """Gravity on a bar beyond a point mass and the gradient's torque."""
    if gravity is Gravity.SLENDER:
        from reference_impl.effects.slender import SlenderBarEffect

        return SlenderBarEffect()
    from reference_impl.effects.quadrupole import QuadrupoleEffect

    return QuadrupoleEffect()


def second_moment(scene: Scene) -> bool:
    """Whether the gravity model includes the force on a bar's second moment."""
    return scene.effects.gravity in (Gravity.QUADRUPOLE, Gravity.SLENDER)


def oblateness(scene: Scene) -> ChainEffect:
    """Oblateness, J2."""
    from reference_impl.effects.oblateness import OblatenessEffect

    given = scene.effects.oblateness
    assert given is not None
    strength = 0.5 * scene.central_body.mu_m3_s2 * given.j2 * given.radius_m**2
    return OblatenessEffect(strength, scene.effects.gravity.turns, second_moment(scene))


def third_bodies(scene: Scene) -> list[ChainEffect]:
    """Third bodies: Moon, Sun, others."""
    from reference_impl.effects.third_body import ThirdBodyEffect

    return [
        ThirdBodyEffect(
            b.mu_m3_s2,
            b.distance_m,
            b.longitude_rad,
            b.rate_rad_s,
            scene.effects.gravity.turns,
            second_moment(scene),
        )
        for b in scene.effects.third_body
    ]


def drag(scene: Scene) -> ChainEffect:
    """Drag."""
    from reference_impl.effects.drag import DragEffect

    given = scene.effects.drag
    assert given is not None
    return DragEffect(
        given.density_kg_m3,
        scene.central_body.radius_m + given.altitude_m,
        given.scale_height_m,
        given.rotation_rad_s,
        np.array(given.width_m),
        given.normal_coefficient,
        given.tangential_coefficient,
    )


def solar_pressure(scene: Scene) -> ChainEffect:
    """Solar radiation pressure."""
    from reference_impl.effects.solar_pressure import SolarPressureEffect

    given = scene.effects.solar_pressure
    assert given is not None
    return SolarPressureEffect(
        given.pressure_Pa,
        given.sun_longitude_rad,
        given.sun_rate_rad_s,
        np.array(given.width_m),
        given.reflectivity,
        scene.central_body.radius_m if given.shadow else 0.0,
    )


def springs(scene: Scene) -> ChainEffect:
    """Joint springs and dampers."""
    from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect

    given = scene.effects.joint_spring_damper
    assert given is not None
    return JointSpringDamperEffect(
        np.array(given.stiffness_N_m_rad), np.array(given.damping_N_m_s_rad), np.array(given.rest_rad)
    )


def thrusts(scene: Scene) -> list[ChainEffect]:
    """Thrusts."""
    from reference_impl.effects.thrust import ThrustEffect

    return [
        ThrustEffect(
            t.bar - 1, t.end.sign, t.axes is Axes.INERTIAL, t.direction_rad, np.array(t.times_s), np.array(t.force_N)
        )
        for t in scene.effects.thrust
    ]


def impulses_of(scene: Scene) -> tuple[BarImpulse, ...]:
    """Impulses."""
    if not scene.effects.impulse:
        return ()
    from reference_impl.model.chain import BarImpulse

    return tuple(
        BarImpulse(p.bar - 1, p.end.sign, p.axes is Axes.INERTIAL, p.direction_rad, p.impulse_N_s, p.at_s)
        for p in scene.effects.impulse
    )
