"""Values that are wrong by a constant or a factor, and several mistakes at once."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from adapters.trajectory import Trajectory
from barchain.judge.diagnosis.diagnose import Diagnosis
from barchain.judge.diagnosis.motion.others import others
from barchain.judge.diagnosis.readings import READINGS
from barchain.judge.diagnosis.starts import STARTS
from scenarios import Scene
from tests.diagnosis.planting import RTOL, diagnosis_of_runs, planted, unequal_chain
from tests.support.slow import one_in, rows
from tests.support.solutions import run

SCENE = unequal_chain()
READING = {m.name: m for m in READINGS}
PAIRS = (
    ("reaction-sign", "angles-in-degrees"),
    ("reactions-in-axes-of-bar-before", "reactions-in-kn"),
    ("axes-turned-90", "reaction-sign"),
    ("track-in-km", "reactions-of-next-joint"),
)
SCENE_CHANGES = {m.name: m.change for m in STARTS} | {a.name: (lambda s, n=a.name: other(s, n)) for a in others(SCENE)}
"""Wrong starts and other scenes, by name"""
SCENE_PAIRS = (
    ("initial-rates-missing-orbital", "reaction-sign"),
    ("initial-angles-opposite", "reactions-in-kn"),
    ("masses-in-reversed-order", "reactions-in-axes-of-bar-before"),
    ("gravity-point", "rates-in-degrees"),
)


def other(scene: Scene, name: str) -> Scene:
    """Another scene of a name."""
    return next(a.scene for a in others(scene) if a.name == name)


def diagnosis_of(names: tuple[str, ...]) -> Diagnosis:
    """Diagnosis of a result with several mistakes, of the scene first, then of reading."""

    def made(scene: Scene, rtol: float) -> Trajectory:
        for name in (n for n in names if n in SCENE_CHANGES):
            scene = SCENE_CHANGES[name](scene)
        motion = run(scene, rtol)
        for name in (n for n in names if n in READING):
            motion = planted(scene, READING[name], rtol, motion)
        return motion

    main, finer = (made(SCENE, rtol) for rtol in (RTOL, 0.1 * RTOL))
    return diagnosis_of_runs(SCENE, main, finer, lambda one, two: (made(one, RTOL), made(two, 0.1 * RTOL)))


@pytest.mark.parametrize("names", one_in(3, PAIRS), ids="+".join)
def test_a_pair_of_mistakes_is_named(names: tuple[str, str]) -> None:
    found = diagnosis_of(names)
    assert set(names) in [set(each) for each in found.names], str(found)


@pytest.mark.parametrize("names", one_in(4, SCENE_PAIRS), ids="+".join)
def test_a_wrong_start_or_scene_beside_a_mistake_of_reading_is_named(names: tuple[str, str]) -> None:
    found = diagnosis_of(names)
    assert any(set(names) <= set(each) for each in found.names), str(found)


def test_four_mistakes_in_different_quantities_are_named_together() -> None:
    names = ("reactions-in-kn", "angles-in-degrees", "rates-less-orbit", "centre-of-mass-in-km")
    found = diagnosis_of(names)
    assert [set(each) for each in found.names] == [set(names)], str(found)


def test_a_known_mistake_beside_an_unknown_one_explains_its_own_quantity_alone() -> None:
    made = []
    for rtol in (RTOL, 0.1 * RTOL):
        right = run(SCENE, rtol)
        made.append(right.replace(reaction_N=-right.reaction_N, com_m=right.com_m + np.sin(right.t_s)[:, None]))
    found = diagnosis_of_runs(SCENE, *made)
    assert not found.explanations
    assert [e.names for e in found.parts] == [("reaction-sign",)]
    assert "reactions alone: the reactions have the opposite sign" in str(found)


def at_second(change: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Change of the values of the second bar or joint alone."""

    def changed(values: Any) -> Any:
        found = values.copy()
        found[:, 1] = change(values[:, 1])
        return found

    return changed


VALUES = [
    ("reaction_N", lambda v: v + np.array([3e-3, 0.0]), "reactions are off by a constant (0.003, 0) N"),
    ("reaction_N", lambda v: 1.37 * v, "reactions are 1.37 times the right values, or the masses of all bars are"),
    ("reaction_N", at_second(lambda v: -v), "reactions at joint 2 have the opposite sign"),
    ("angle_rad", at_second(np.degrees), "angles of bar 2 are in degrees"),
    ("rate_rad_s", lambda v: (1.0 + 1e-6) * v, "rates are (1 + 1e-06) times the right values"),
    ("rate_rad_s", lambda v: v + 2e-5, "rates are off by a constant 2e-05 rad/s"),
    ("rate_rad_s", at_second(lambda v: -v), "rates of bar 2 have the opposite sign"),
    ("angle_rad", at_second(lambda v: v + 0.3), "angles of bar 2 are off by a constant 17.1887 degrees"),
    (
        "com_m",
        lambda v: v + np.array([0.0, -120.0]),
        "positions of the centre of mass are off by a constant (0, -120) m",
    ),
    ("reaction_N", at_second(lambda v: v[:, ::-1]), "reactions at joint 2 have exchanged axes"),
    ("reaction_N", at_second(lambda v: 1.3 * v), "reactions at joint 2 are 1.3 times the right values"),
]


@pytest.mark.parametrize(("field", "change", "words"), one_in(3, rows(VALUES)))
def test_values_that_are_wrong_everywhere_or_at_one_place_are_named(
    field: str, change: Callable[[Any], Any], words: str
) -> None:
    right = [run(SCENE, rtol) for rtol in (RTOL, 0.1 * RTOL)]
    found = diagnosis_of_runs(SCENE, *(each.replace(**{field: change(getattr(each, field))}) for each in right))
    assert str(found).startswith(f"Your {words}"), str(found)
