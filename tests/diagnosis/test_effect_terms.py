"""A wrong term of an effect, planted into the NumPy reference, is named from the motion that it gives."""

from typing import Any

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from adapters.trajectory import Trajectory
from barchain.judge.diagnosis.own_motion import OwnMotion
from barchain.solutions.reference import closely_sampled
from reference_impl.effects import second_moment
from reference_impl.effects.drag import DragEffect, RelativeWind
from reference_impl.model.effect import EffectAccelerations, EffectState
from scenarios import Scene, load_scene
from tests.support.slow import one_in

REFERENCE = ENGINES["reference"].load()


def wind_at_centre(drag: DragEffect, at: EffectState) -> RelativeWind:
    """Velocity of the centre of mass relative to the air at each bar."""
    velocity = complex(*at.state.com_velocity_m_s) - 1j * drag.rotation_rad_s * at.position_from_body
    seen = at.unit.conj() * velocity
    return RelativeWind(seen.real, seen.imag, at.rate - drag.rotation_rad_s)


def without_axis_term(mu_m3_s2: float, z_m: Any, along: Any, gyration2_m2: Any) -> Any:
    """Force on second moments without its part along the bars' axes."""
    r = np.abs(z_m)
    c = (along.conj() * z_m).real / r
    return 1.5 * mu_m3_s2 * gyration2_m2 / r**5 * (1.0 - 5.0 * c**2) * z_m


def unturned_drag(drag: DragEffect, at: EffectState, mode: Any) -> EffectAccelerations:
    """Drag on the left faces of all bars."""
    return RIGHT_DRAG(drag, at, np.ones(at.model.bars))


RIGHT_DRAG = DragEffect.accelerations
PLANTED = (
    ("drag_alone", DragEffect, "accelerations", unturned_drag, "drag-face-left"),
    ("drag_alone", DragEffect, "wind", wind_at_centre, "drag-of-centre"),
    ("quadrupole_alone", second_moment, "accelerations", without_axis_term, "second-moment-axis"),
)


@pytest.mark.parametrize("case", one_in(3, PLANTED, lambda case: case[-1]))
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
