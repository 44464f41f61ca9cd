"""Words of a mistake: never the scene's own value, and no digits that a fit does not determine."""

import dataclasses

import numpy as np
import pytest

from barchain.judge.diagnosis.motion.candidate import Candidate
from barchain.judge.diagnosis.motion.numbers import Number
from barchain.judge.diagnosis.motion.search import Fitted, slip_near
from barchain.judge.diagnosis.motion.words import nice_factor
from barchain.judge.diagnosis.verdicts import diagnosis_of_verdict
from scenarios import Scene, load_scene
from tests.diagnosis.planting import verdict_on
from tests.support.solutions import run, solution_of

MU = (("central_body", "mu_m3_s2"),)


def of_mu(value: float) -> Number:
    """The gravitational parameter of a scene that has a value."""
    scene = load_scene("basics/kepler_circular")
    body = dataclasses.replace(scene.central_body, mu_m3_s2=value)
    return Number("mu", "the gravitational parameter", "orbit", dataclasses.replace(scene, central_body=body), MU)


@pytest.mark.parametrize("right", [3.986004415e14, 3.986004418e14, 3.986e14])
def test_a_name_is_never_that_of_the_value_of_the_scene(right: float) -> None:
    for amount in (1e-12, 1e-10, -1e-8, 2e-7):
        assert of_mu(right).known(amount) == ""


def test_a_known_value_beside_the_scene_s_is_named_with_the_factor() -> None:
    said = of_mu(3.986004418e14).words(3.986004415 / 3.986004418 - 1.0)
    assert "EGM2008" in said
    assert "0.999999999247 times" in said


def of_factor(amount: float, share: float) -> float:
    """Amount of a factor that is told, of a fit that leaves a share."""
    nice = lambda a: bool(nice_factor(1.0 + float(a[0])))  # noqa: E731
    candidate = Candidate("x", "loads", lambda: np.zeros((1, 1)), lambda _: "", nice=nice)
    return float(slip_near(candidate, np.array([amount]), share)[0])


def test_a_factor_that_is_not_told_from_zero_is_missing() -> None:
    assert of_factor(-0.9982, 0.008) == -1.0
    assert of_factor(-0.9982, 1e-5) == -0.9982


def test_samples_after_an_impulse_are_told_and_a_wrong_first_row_alone_is_not() -> None:
    scene: Scene = load_scene("effects/impulse")
    solved = solution_of(scene)
    main, finer = (run(scene, rtol) for rtol in (1e-9, 1e-10))
    off = [t.replace(rate_rad_s=np.concatenate([t.rate_rad_s[:1] + 1e-3, t.rate_rad_s[1:]]))  # type: ignore[index]
           for t in (main, finer)]  # fmt: skip
    found = diagnosis_of_verdict(verdict_on(off[0], off[1], solved), off[0], solved)
    assert not found.inside_tolerances
    assert "impulse" not in str(found)


@pytest.mark.parametrize(("amounts", "held", "tells"), [(2, 2, False), (2, 9, True), (1, 1, False), (1, 2, True)])
def test_a_fit_of_as_many_numbers_as_the_residual_holds_explains_nothing(amounts: int, held: int, tells: bool) -> None:
    candidate = Candidate("x", "loads", lambda: np.zeros((1, 1)), lambda _: "")
    fitted = Fitted((candidate,) * amounts, (np.array([0.3]),) * amounts, left=0.1, share=1e-5, held=held)
    assert fitted.explains is tells
