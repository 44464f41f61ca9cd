"""Effects of a scene for the reference; each module is imported only for a scene with the effect."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenarios import Axes, Gravity

if TYPE_CHECKING:
    from reference_impl.model.chain import Impulse
    from reference_impl.model.effect import Effect
    from scenarios import Scene


def effects_of(scene: Scene) -> tuple[Effect, ...]:
    """Effects besides point or gradient gravity and prescribed rotations, in a fixed order."""
    called = scene.effects
    found: list[Effect] = []
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


def bar_shape(gravity: Gravity) -> Effect:
    """Gravity on a bar beyond a point mass and the gradient's torque."""
    if gravity is Gravity.SLENDER:
        from reference_impl.effects.slender import Slender

        return Slender()
    from reference_impl.effects.quadrupole import Quadrupole

    return Quadrupole()


def second_moment(scene: Scene) -> bool:
    """Whether the gravity model includes the force on a bar's second moment."""
    return scene.effects.gravity in (Gravity.QUADRUPOLE, Gravity.SLENDER)


def oblateness(scene: Scene) -> Effect:
    """Oblateness, J2."""
    from reference_impl.effects.oblateness import Oblateness

    given = scene.effects.oblateness
    assert given is not None
    strength = 0.5 * scene.central_body.mu_m3_s2 * given.j2 * given.radius_m**2
    return Oblateness(strength, scene.effects.gravity.turns, second_moment(scene))


def third_bodies(scene: Scene) -> list[Effect]:
    """Third bodies: Moon, Sun, others."""
    from reference_impl.effects.third_body import ThirdBody

    return [
        ThirdBody(
            b.mu_m3_s2,
            b.distance_m,
            b.longitude_rad,
            b.rate_rad_s,
            scene.effects.gravity.turns,
            second_moment(scene),
        )
        for b in scene.effects.third_body
    ]


def drag(scene: Scene) -> Effect:
    """Drag."""
    from reference_impl.effects.drag import Drag

    given = scene.effects.drag
    assert given is not None
    return Drag(
        given.density_kg_m3,
        scene.central_body.radius_m + given.altitude_m,
        given.scale_height_m,
        given.rotation_rad_s,
        np.array(given.width_m),
        given.normal_coefficient,
        given.tangential_coefficient,
    )


def solar_pressure(scene: Scene) -> Effect:
    """Solar radiation pressure."""
    from reference_impl.effects.solar_pressure import SolarPressure

    given = scene.effects.solar_pressure
    assert given is not None
    return SolarPressure(
        given.pressure_Pa,
        given.sun_longitude_rad,
        given.sun_rate_rad_s,
        np.array(given.width_m),
        given.reflectivity,
        scene.central_body.radius_m if given.shadow else 0.0,
    )


def springs(scene: Scene) -> Effect:
    """Joint springs and dampers."""
    from reference_impl.effects.joint_spring_damper import JointSpringDamper

    given = scene.effects.joint_spring_damper
    assert given is not None
    return JointSpringDamper(
        np.array(given.stiffness_N_m_rad), np.array(given.damping_N_m_s_rad), np.array(given.rest_rad)
    )


def thrusts(scene: Scene) -> list[Effect]:
    """Thrusts."""
    from reference_impl.effects.thrust import Thrust

    return [
        Thrust(
            t.bar - 1, t.end.sign, t.axes is Axes.INERTIAL, t.direction_rad, np.array(t.times_s), np.array(t.force_N)
        )
        for t in scene.effects.thrust
    ]


def impulses_of(scene: Scene) -> tuple[Impulse, ...]:
    """Impulses."""
    if not scene.effects.impulse:
        return ()
    from reference_impl.model.chain import Impulse

    return tuple(
        Impulse(p.bar - 1, p.end.sign, p.axes is Axes.INERTIAL, p.direction_rad, p.impulse_N_s, p.at_s)
        for p in scene.effects.impulse
    )
