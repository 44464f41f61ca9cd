"""Two mistakes, or several in different quantities, are named together."""

from __future__ import annotations

import numpy as np
import pytest

from barchain.judge.diagnosis.altered_scenes.catalogue import SCENES
from barchain.judge.diagnosis.diagnose import Diagnosis, diagnose
from barchain.judge.diagnosis.mistake import ReadingMistake, SceneMistake
from barchain.judge.diagnosis.readings.catalogue import READINGS
from barchain.judge.diagnosis.search import BRIEF, FULL
from barchain.judge.diagnosis.verdicts import verdict_tolerance
from tests.diagnosis.planting import RTOL, planted, run, solution, unequal_chain, verdict_on
from tests.support.slow import one_in

SCENE = unequal_chain()
BY_NAME = {m.name: m for m in (*READINGS, *SCENES)}
PAIRS = (
    ("reaction-sign", "angles-in-degrees"),
    ("reactions-in-axes-of-bar-before", "reactions-in-kn"),
    ("angles-relative-to-previous", "angles-in-degrees"),
    ("axes-turned-90", "reaction-sign"),
    ("angles-wrapped", "rates-in-degrees"),
    ("track-in-km", "reactions-of-next-joint"),
    ("masses-in-reversed-order", "reaction-sign"),
    ("inertia-about-end", "angles-and-rates-in-degrees"),
    ("gradient-missing", "rates-less-orbit"),
)
SCENE_PAIRS = (
    ("initial-rates-missing-orbital", "masses-in-reversed-order"),
    ("gradient-missing", "mu-km3"),
    ("inertia-half", "initial-angles-opposite"),
)


def diagnosis_of(names: tuple[str, ...], effort: object = BRIEF) -> Diagnosis:
    """Diagnosis of a result with several mistakes, of the scene first, then of reading."""
    made = []
    for rtol in (RTOL, 0.1 * RTOL):
        altered, readings = SCENE, []
        for mistake in (BY_NAME[name] for name in names):
            if isinstance(mistake, SceneMistake):
                assert mistake.scene is not None
                altered = mistake.scene(altered)
            else:
                readings.append(mistake)
        motion = run(altered, rtol)
        for reading in readings:
            read = planted(SCENE, reading, rtol, motion)
            assert read is not None
            motion = read
        made.append(motion)
    solved = solution(SCENE)
    return diagnose(SCENE, made[0], solved, verdict_tolerance(verdict_on(*made, solved)), effort)  # type: ignore[arg-type]


@pytest.mark.parametrize("names", one_in(3, PAIRS), ids="+".join)
def test_a_pair_of_mistakes_is_named(names: tuple[str, str]) -> None:
    found = diagnosis_of(names)
    assert set(names) in [set(each) for each in found.names], str(found)


@pytest.mark.parametrize("names", SCENE_PAIRS, ids="+".join)
@pytest.mark.slow
def test_a_pair_of_mistakes_in_the_scene_is_named(names: tuple[str, str]) -> None:
    found = diagnosis_of(names, FULL)
    assert [set(each) for each in found.names] == [set(names)], str(found)


def test_a_mistake_in_the_scene_is_named_beside_reactions_that_are_late() -> None:
    missing, made = BY_NAME["gradient-missing"], []
    for rtol in (RTOL, 0.1 * RTOL):
        motion = planted(SCENE, missing, rtol)
        assert motion is not None
        assert motion.reaction_N is not None
        made.append(motion.replace(reaction_N=np.concatenate([motion.reaction_N[:1], motion.reaction_N[:-1]])))
    found = diagnose(SCENE, made[0], solution(SCENE), verdict_tolerance(verdict_on(*made, solution(SCENE))), BRIEF)
    assert found.names == {("gradient-missing", "reactions-a-whole-sample-late")}, str(found)


def test_four_mistakes_in_different_quantities_are_named_together() -> None:
    names = ("reactions-in-kn", "angles-in-degrees", "rates-less-orbit", "centre-of-mass-in-km")
    found = diagnosis_of(names)
    assert [set(each) for each in found.names] == [set(names)], str(found)


def test_a_known_mistake_beside_an_unknown_one_explains_its_own_quantity_alone() -> None:
    made = []
    for rtol in (RTOL, 0.1 * RTOL):
        right = run(SCENE, rtol)
        assert right.reaction_N is not None
        made.append(right.replace(reaction_N=-right.reaction_N, com_m=right.com_m + np.sin(right.t_s)[:, None]))
    solved = solution(SCENE)
    found = diagnose(SCENE, made[0], solved, verdict_tolerance(verdict_on(made[0], made[1], solved)), BRIEF)
    assert not found.explanations
    assert [e.names for e in found.parts] == [("reaction-sign",)]
    assert "reactions alone: the reactions have the opposite sign" in str(found)


SAME_FACTOR = ", or the masses of all bars are, in the moments of inertia too"


@pytest.mark.parametrize(
    ("field", "factor", "words"),
    [
        ("reaction_N", 1.37, "the reactions are 1.37 times the right values" + SAME_FACTOR),
        ("rate_rad_s", 1.0 + 1e-6, "the rates are (1 + 1e-06) times the right values"),
        ("com_velocity_m_s", 1.0 - 1e-6, "the velocities of the centre of mass are (1 - 1e-06) times the right values"),
    ],
)
def test_an_unknown_factor_is_fitted(field: str, factor: float, words: str) -> None:
    made = [right.replace(**{field: factor * getattr(right, field)}) for right in (run(SCENE, RTOL), run(SCENE, 1e-10))]
    solved = solution(SCENE)
    found = diagnose(SCENE, made[0], solved, verdict_tolerance(verdict_on(made[0], made[1], solved)), BRIEF)
    assert [e.words for e in found.explanations] == [words], str(found)


@pytest.mark.slow
def test_an_unknown_constant_angle_is_fitted() -> None:
    made = [right.replace(angle_rad=right.angle_rad + 0.3) for right in (run(SCENE, RTOL), run(SCENE, 1e-10))]
    solved = solution(SCENE)
    found = diagnose(SCENE, made[0], solved, verdict_tolerance(verdict_on(made[0], made[1], solved)), BRIEF)
    assert [e.words for e in found.explanations] == ["the angles are off by a constant 17.1887 degrees"], str(found)


@pytest.mark.slow
def test_every_mistake_of_a_named_pair_is_needed() -> None:
    found = diagnosis_of(("reaction-sign",))
    assert found.names == {("reaction-sign",)}
    assert isinstance(found.explanations[0].mistakes[0], ReadingMistake)
