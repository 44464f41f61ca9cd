"""Two mistakes, or several in different quantities, are named together."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from barchain.judge.diagnosis.diagnose import Diagnosis, diagnose
from barchain.judge.diagnosis.motion.others import others
from barchain.judge.diagnosis.reading import Reading
from barchain.judge.diagnosis.readings import READINGS
from barchain.judge.diagnosis.starts import STARTS
from barchain.judge.diagnosis.verdicts import verdict_tolerance
from tests.diagnosis.planting import RTOL, planted, unequal_chain, verdict_on
from tests.support.slow import one_in, rows
from tests.support.solutions import run, solution_of

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from scenarios import Scene

SCENE = unequal_chain()
READING = {m.name: m for m in READINGS}
PAIRS = (
    ("reaction-sign", "angles-in-degrees"),
    ("reactions-in-axes-of-bar-before", "reactions-in-kn"),
    ("angles-relative-to-previous", "angles-in-degrees"),
    ("axes-turned-90", "reaction-sign"),
    ("angles-wrapped", "rates-in-degrees"),
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
            read = planted(scene, READING[name], rtol, motion)
            assert read is not None
            motion = read
        return motion

    solved, (main, finer) = solution_of(SCENE), (made(SCENE, rtol) for rtol in (RTOL, 0.1 * RTOL))
    tolerance = verdict_tolerance(verdict_on(main, finer, solved))
    return diagnose(SCENE, main, solved, tolerance, lambda one, two: (made(one, RTOL), made(two, 0.1 * RTOL)))


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


@pytest.mark.exhaustive
def test_a_known_mistake_beside_an_unknown_one_explains_its_own_quantity_alone() -> None:
    made = []
    for rtol in (RTOL, 0.1 * RTOL):
        right = run(SCENE, rtol)
        assert right.reaction_N is not None
        made.append(right.replace(reaction_N=-right.reaction_N, com_m=right.com_m + np.sin(right.t_s)[:, None]))
    solved = solution_of(SCENE)
    found = diagnose(SCENE, made[0], solved, verdict_tolerance(verdict_on(made[0], made[1], solved)))
    assert not found.explanations
    assert [e.names for e in found.parts] == [("reaction-sign",)]
    assert "reactions alone: the reactions have the opposite sign" in str(found)


SAME_FACTOR = ", or the masses of all bars are, in the moments of inertia too"


FACTORS = [
    ("reaction_N", 1.37, "the reactions are 1.37 times the right values" + SAME_FACTOR),
    ("rate_rad_s", 1.0 + 1e-6, "the rates are (1 + 1e-06) times the right values"),
    ("com_velocity_m_s", 1.0 - 1e-6, "the velocities of the centre of mass are (1 - 1e-06) times the right values"),
]


@pytest.mark.parametrize(("field", "factor", "words"), one_in(3, rows(FACTORS)))
def test_an_unknown_factor_is_fitted(field: str, factor: float, words: str) -> None:
    made = [right.replace(**{field: factor * getattr(right, field)}) for right in (run(SCENE, RTOL), run(SCENE, 1e-10))]
    solved = solution_of(SCENE)
    found = diagnose(SCENE, made[0], solved, verdict_tolerance(verdict_on(made[0], made[1], solved)))
    assert [e.words for e in found.explanations] == [words], str(found)


@pytest.mark.slow
def test_an_unknown_constant_angle_is_fitted() -> None:
    made = [right.replace(angle_rad=right.angle_rad + 0.3) for right in (run(SCENE, RTOL), run(SCENE, 1e-10))]
    solved = solution_of(SCENE)
    found = diagnose(SCENE, made[0], solved, verdict_tolerance(verdict_on(made[0], made[1], solved)))
    assert [e.words for e in found.explanations] == ["the angles are off by a constant 17.1887 degrees"], str(found)


@pytest.mark.slow
def test_every_mistake_of_a_named_pair_is_needed() -> None:
    found = diagnosis_of(("reaction-sign",))
    assert found.names == {("reaction-sign",)}
    assert isinstance(found.explanations[0].mistakes[0], Reading)
