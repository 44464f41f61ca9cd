"""A number of the scene that is wrong by an unknown amount, and values that are wrong at one joint or bar only."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from barchain.judge.diagnosis.altered_scenes.amounts import amounts
from barchain.judge.diagnosis.altered_scenes.equation_amounts import equation_amounts
from barchain.judge.diagnosis.diagnose import diagnose
from barchain.judge.diagnosis.search import ONE_ENGINE
from barchain.judge.diagnosis.verdicts import verdict_tolerance
from scenarios import Scene, load_scene
from tests.diagnosis.planting import RTOL, planted, run, solution, unequal_chain, verdict_on
from tests.support.kernel import needs_kernel
from tests.support.slow import one_in, slow_but, thinned

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from barchain.judge.diagnosis.altered_scenes.amounts import Amount
    from barchain.judge.diagnosis.diagnose import Diagnosis


pytestmark = needs_kernel
SCENE = unequal_chain()
LOADED = ("effects/thrust_table", "effects/drag", "effects/impulse", "effects/oblateness", "effects/joint_springs")
"""Scenes with effects whose sizes and instants are fitted"""
LITTLE = 0.013
"""A departure that no entry of a catalogue has"""


def diagnosis_of(scene: Scene, main: Trajectory, finer: Trajectory) -> Diagnosis:
    """Diagnosis of two runs of an engine."""
    solved = solution(scene)
    return diagnose(scene, main, solved, verdict_tolerance(verdict_on(main, finer, solved)), ONE_ENGINE)


def diagnosis_with(scene: Scene, amount: Amount, size: float) -> Diagnosis:
    """Diagnosis of a result with an amount in its scene."""
    change = amount.mistake(size).scene
    assert change is not None
    return diagnosis_of(scene, run(change(scene), RTOL), run(change(scene), 0.1 * RTOL))


@pytest.mark.parametrize("amount", thinned(4, one_in(12, amounts(SCENE), lambda a: a.name)))
@pytest.mark.parametrize("size", one_in(2, [LITTLE, -2e-3]))
def test_a_wrong_number_of_the_scene_is_named_with_its_amount(amount: Amount, size: float) -> None:
    possible = abs(size) if amount.range[0] == 0.0 else size
    found = diagnosis_with(SCENE, amount, possible)
    assert found.explanations[0].words == amount.words(possible)


@pytest.mark.parametrize("amount", one_in(3, equation_amounts(SCENE), lambda a: a.name))
def test_a_wrong_or_added_term_of_the_equations_is_named_with_its_amount(amount: Amount) -> None:
    size = LITTLE * amount.range[1]
    main, finer = (planted(SCENE, amount.mistake(size), rtol) for rtol in (RTOL, 0.1 * RTOL))
    assert main is not None
    assert finer is not None
    assert diagnosis_of(SCENE, main, finer).explanations[0].words == amount.words(size)


@pytest.mark.parametrize("name", thinned(3, slow_but(LOADED, ())))
def test_a_wrong_number_of_an_effect_is_named_or_indistinguishable(name: str) -> None:
    scene = load_scene(name)
    kinds = name.partition("/")[2].split("_")[0]
    for amount in (a for a in amounts(scene) if a.name.startswith(kinds)):
        found = diagnosis_with(scene, amount, LITTLE * amount.range[1])
        if not found.inside_tolerances:
            assert (amount.name,) in found.names, f"{amount.name}: {found}"


@pytest.mark.parametrize(
    ("field", "constant", "words"),
    [
        ("reaction_N", (3e-3, 0.0), "reactions are off by a constant (0.003, 0) N"),
        ("rate_rad_s", 2e-5, "rates are off by a constant 2e-05 rad/s"),
        ("com_m", (0.0, -120.0), "positions of the centre of mass are off by a constant (0, -120) m"),
        ("com_velocity_m_s", (0.25, 0.5), "velocities of the centre of mass are off by a constant (0.25, 0.5) m/s"),
    ],
)
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


@pytest.mark.parametrize("rtol", one_in(4, [1e-3, 1e-4, 1e-5, 1e-6]))
def test_a_coarse_run_is_no_wrong_number(rtol: float) -> None:
    found = diagnosis_of(SCENE, run(SCENE, rtol), run(SCENE, 0.999 * rtol))
    assert found.wrong
    assert not found.explanations, str(found)


def test_two_wrong_numbers_are_not_named_as_one() -> None:
    first, second = amounts(SCENE)[0], amounts(SCENE)[-1]
    scene = SCENE
    for amount in (first, second):
        change = amount.mistake(LITTLE).scene
        assert change is not None
        scene = change(scene)
    found = diagnosis_of(SCENE, run(scene, RTOL), run(scene, 0.1 * RTOL))
    assert found.wrong
    assert not found.explanations
    assert np.isfinite(found.wrong[0].difference)
