"""Values that are wrong by a constant or a factor, at all places or at one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from barchain.judge.diagnosis.diagnose import diagnose
from barchain.judge.diagnosis.verdicts import verdict_tolerance
from tests.diagnosis.planting import RTOL, unequal_chain, verdict_on
from tests.support.slow import one_in, rows
from tests.support.solutions import run, solution_of

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from barchain.judge.diagnosis.diagnose import Diagnosis
    from scenarios import Scene

SCENE = unequal_chain()


def diagnosis_of(scene: Scene, main: Trajectory, finer: Trajectory) -> Diagnosis:
    """Diagnosis of two runs of an engine."""
    solved = solution_of(scene)
    return diagnose(scene, main, solved, verdict_tolerance(verdict_on(main, finer, solved)))


CONSTANTS = [
    ("reaction_N", (3e-3, 0.0), "reactions are off by a constant (0.003, 0) N"),
    ("rate_rad_s", 2e-5, "rates are off by a constant 2e-05 rad/s"),
    ("com_m", (0.0, -120.0), "positions of the centre of mass are off by a constant (0, -120) m"),
    ("com_velocity_m_s", (0.25, 0.5), "velocities of the centre of mass are off by a constant (0.25, 0.5) m/s"),
]


@pytest.mark.parametrize(("field", "constant", "words"), one_in(4, rows(CONSTANTS)))
def test_a_constant_that_is_added_is_named(field: str, constant: object, words: str) -> None:
    def wrong(rtol: float) -> Trajectory:
        right = run(SCENE, rtol)
        return right.replace(**{field: getattr(right, field) + constant})

    found = diagnosis_of(SCENE, wrong(RTOL), wrong(0.1 * RTOL))
    assert str(found).startswith(f"Your {words} (explained to "), str(found)


@pytest.mark.parametrize(("field", "words"), [("reaction_N", "reactions at joint 2"), ("rate_rad_s", "rates of bar 2")])
def test_a_sign_that_is_wrong_at_one_place_is_named_with_the_place(field: str, words: str) -> None:
    def wrong(rtol: float) -> Trajectory:
        right = run(SCENE, rtol)
        values = getattr(right, field).copy()
        values[:, 1] *= -1.0
        return right.replace(**{field: values})

    found = diagnosis_of(SCENE, wrong(RTOL), wrong(0.1 * RTOL))
    assert str(found).startswith(f"Your {words} have the opposite sign (explained to ")


AT_ONE_PLACE = [
    ("angle_rad", np.degrees, "angles of bar 2 are in degrees"),
    ("angle_rad", lambda v: v + 0.3, "angles of bar 2 are off by a constant 17.1887 degrees"),
    ("reaction_N", lambda v: v[:, ::-1], "reactions at joint 2 have exchanged axes"),
    ("reaction_N", lambda v: 1.3 * v, "reactions at joint 2 are 1.3 times the right values"),
]


@pytest.mark.parametrize(("field", "change", "words"), one_in(4, rows(AT_ONE_PLACE)))
def test_a_mistake_at_one_place_is_named_with_the_place(field: str, change: Any, words: str) -> None:
    def wrong(rtol: float) -> Trajectory:
        right = run(SCENE, rtol)
        values = getattr(right, field).copy()
        values[:, 1] = change(values[:, 1])
        return right.replace(**{field: values})

    found = diagnosis_of(SCENE, wrong(RTOL), wrong(0.1 * RTOL))
    assert str(found).startswith(f"Your {words} (explained to "), str(found)


@pytest.mark.parametrize("rtol", one_in(4, [1e-3, 1e-4, 1e-5, 1e-6]))
def test_a_coarse_run_is_no_wrong_number(rtol: float) -> None:
    found = diagnosis_of(SCENE, run(SCENE, rtol), run(SCENE, 0.999 * rtol))
    assert found.wrong
    assert not found.explanations, str(found)
