"""A wrong term of an effect, planted into the NumPy reference, is named from the motion that it gives."""

from __future__ import annotations

import cmath
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from barchain.judge.diagnosis.own_motion import OwnMotion
from barchain.solutions.reference import closely_sampled
from reference_impl.effects import second_moment
from reference_impl.effects.drag import DragEffect, RelativeWind
from reference_impl.effects.solar_pressure import SolarPressureEffect
from reference_impl.effects.thrust import ThrustEffect
from reference_impl.model.effect import EffectAccelerations
from scenarios import load_scene
from tests.support.slow import one_in

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from reference_impl.model.effect import EffectState
    from scenarios import Scene

REFERENCE = ENGINES["reference"].load()


def wind_at_centre(drag: DragEffect, at: EffectState) -> RelativeWind:
    """Velocity of the centre of mass relative to the air at each bar."""
    velocity = complex(*at.state.com_velocity_m_s) - 1j * drag.rotation_rad_s * at.position_from_body
    seen = at.unit.conj() * velocity
    return RelativeWind(seen.real, seen.imag, at.rate - drag.rotation_rad_s)


def drag_in_level_air(drag: DragEffect, at: EffectState, mode: Any) -> EffectAccelerations:
    """Drag whose density does not fall along a bar."""
    m, wind, length = at.model, drag.wind(at), at.model.length_m
    density = drag.density(at, np.abs(at.position_from_body))
    strength = -0.5 * drag.width_m * density * (np.sign(wind.across) if mode is None else mode)
    across = strength * drag.normal_coefficient * (length * wind.across**2 + length**3 / 12.0 * wind.turning**2)
    along = strength * drag.tangential_coefficient * wind.along * length * wind.across
    torque = strength * drag.normal_coefficient * length**3 / 6.0 * wind.across * wind.turning
    return EffectAccelerations(0j, (along + 1j * across) * at.unit / m.mass_kg, torque / m.inertia_kg_m2)


def one_sided_light(light: SolarPressureEffect, at: EffectState, mode: Any) -> EffectAccelerations:
    """Light that is reflected to the left of each bar, whichever side faces the Sun."""
    held = light.mode(at) if mode is None else mode
    s, size = light.sun_direction(at.t_s), light.pressure_Pa * light.width_m * at.model.length_m / at.model.mass_kg
    k = held[:1] * held[1:] * (at.unit.conj() * s).imag
    force = (1.0 - light.reflectivity) * s + 2.0 * light.reflectivity * k * 1j * at.unit
    return EffectAccelerations(0j, -size * k * force, at.zero_angular)


def without_axis_term(mu_m3_s2: float, z_m: Any, along: Any, gyration2_m2: Any) -> Any:
    """Force on second moments without its part along the bars' axes."""
    r = np.abs(z_m)
    c = (along.conj() * z_m).real / r
    return 1.5 * mu_m3_s2 * gyration2_m2 / r**5 * (1.0 - 5.0 * c**2) * z_m


def thrust_along_first_bar(thrust: ThrustEffect, at: EffectState, mode: Any) -> EffectAccelerations:
    """Thrust whose direction counts from the first bar."""
    segment = thrust.segment_at(at.t_s) if mode is None else mode
    difference, spin, k = np.zeros(at.model.bars, complex), np.zeros(at.model.bars), thrust.bar
    way = cmath.rect(1.0, thrust.direction_rad) * (1.0 if thrust.inertial else at.unit[0])
    force = float(thrust.interpolated(segment, at.t_s)[0]) * way
    difference[k] = force / at.model.mass_kg[k]
    spin[k] = thrust.side * at.model.lever[k] * (at.unit[k].conjugate() * force).imag
    return EffectAccelerations(0j, difference, spin)


def unturned_drag(drag: DragEffect, at: EffectState, mode: Any) -> EffectAccelerations:
    """Drag on the left faces of all bars."""
    return RIGHT_DRAG(drag, at, np.ones(at.model.bars))


def light_on_left_faces(light: SolarPressureEffect, at: EffectState, mode: Any) -> EffectAccelerations:
    """Light on one face of each bar."""
    held = light.mode(at) if mode is None else mode
    found = RIGHT_LIGHT(light, at, mode)
    return found._replace(difference=found.difference * (held[1:] > 0.0))


RIGHT_DRAG, RIGHT_LIGHT = DragEffect.accelerations, SolarPressureEffect.accelerations
PLANTED = (
    ("drag_alone", DragEffect, "accelerations", unturned_drag, "drag-face-left"),
    ("solar_pressure_alone", SolarPressureEffect, "accelerations", light_on_left_faces, "sunlight-on-left-faces"),
    ("thrust_body", ThrustEffect, "accelerations", thrust_along_first_bar, "thrusts-in-axes-of-first-bar"),
    ("drag_alone", DragEffect, "wind", wind_at_centre, "drag-of-centre"),
    ("quadrupole_alone", second_moment, "accelerations", without_axis_term, "second-moment-axis"),
    ("drag_alone", DragEffect, "accelerations", drag_in_level_air, "drag-fall-along-bars"),
    ("solar_pressure_alone", SolarPressureEffect, "accelerations", one_sided_light, "sunlight-one-sided"),
)


@pytest.mark.parametrize("case", one_in(7, PLANTED, lambda case: case[-1]))
def test_a_wrong_term_of_an_effect_is_named(case: tuple[Any, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    name, where, what, wrong, expected = case
    scene = closely_sampled(load_scene(f"conform/{name}"))

    def run(scene: Scene, rtol: float) -> Trajectory:
        with monkeypatch.context() as planted:
            planted.setattr(where, what, wrong)
            found: Trajectory = REFERENCE().run(scene, Setting(AccuracyParameter.RTOL, rtol))
            return found

    own = OwnMotion(scene, run(scene, 1e-9), lambda one, two: (run(one, 1e-9), run(two, 1e-10)))
    assert [explanation.names for explanation in own.explaining][:1] == [(expected,)]
