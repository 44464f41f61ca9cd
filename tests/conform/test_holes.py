"""Mistakes that hide: beside other effects, in rare numbers and samples, behind declared noise. None conforms."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import pytest

from adapters.engine import AccuracyParameter, Setting
from barchain.conform import conform, physics
from barchain.conform.accuracy import falling_check
from barchain.conform.checks import Check, CheckState, Group
from barchain.conform.errors_at_settings import setting_error
from barchain.conform.physics import main_and_finer, scene_check
from barchain.conform.scenes import STAGES, TOGETHER, scene_of
from barchain.conform.target import examined, extent_of
from barchain.runs.job import RunResult
from reports.results.outcome import Outcome
from tests.conform import hiding_engines
from tests.support.kernel import needs_kernel
from tests.support.slow import exhaustive_but, slow_but

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.trajectory import Array
    from barchain.runs.job import Job

pytestmark = needs_kernel
HERE = "tests.conform.hiding_engines"
BESIDE_OTHERS = {
    "SpringsOffInThrust": 1,
    "ThirdBodyOverwritesOblateness": 2,
    "ImpulseAtEndOfThrust": 1,
    "OneImpulseAtATime": 3,
    "LoadsNeedGravity": 3,
    "DragElseSunlight": 3,
    "OblatenessWithoutMoment": 8,
    "OblatenessOnUniformBars": 2,
    "OblatenessOfEarth": 2,
    "ThirdBodyWithoutMoment": 8,
    "ThirdBodyOnUniformBars": 2,
    "SixthBarWithoutTorque": 1,
    "TwoSprings": 1,
    "TwoThrusts": 4,
    "TwoThirdBodies": 6,
    "ThrustsArePositive": 1,
    "DampersNeedSprings": 2,
    "ReactionsInABuffer": 3,
    "SlowStartsClipped": 1,
    "ClosedOrbitsOnly": 8,
    "UnwrapsAtSamples": 5,
    "TrackOfAFrame": 2,
    "RightAtTheFinest": 2,
    "TideToFirstOrder": 2,
}
"""Mistakes, each with the number of a scene of effects together that shows it"""


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs in this process, and no search for the mistake."""

    def made(_: object, jobs: Sequence[Job], t_s: Sequence[Array], *limits: float) -> list[RunResult]:
        del t_s, limits
        engines = [getattr(hiding_engines, job.engine) for job in jobs]
        return [
            RunResult(Outcome.PASS, trajectory=e().run(job.scene, job.setting))
            for e, job in zip(engines, jobs, strict=True)
        ]

    monkeypatch.setattr(physics, "results", made)
    monkeypatch.setattr(physics, "diagnosis_of_verdict", lambda *_: None)


def check_of(engine: str, scene: str) -> Check:
    """Check of a scene; declarations are read here, too."""
    given = dataclasses.replace(examined(f"{HERE}:{engine}"), name=engine)
    name = f"conform/{scene}"
    return scene_check(given, name, main_and_finer(given, [name])[name])


@pytest.mark.parametrize("mistake", slow_but(BESIDE_OTHERS, ["TrackOfAFrame"]))
def test_a_mistake_that_no_effect_alone_shows_fails_where_effects_stand_together(here: None, mistake: str) -> None:
    del here
    check = check_of(mistake, f"together_{BESIDE_OTHERS[mistake]}")
    assert check.state is CheckState.FAILED, check.words


@pytest.mark.slow
@pytest.mark.parametrize("name", exhaustive_but(STAGES[TOGETHER], STAGES[TOGETHER][:1]))
def test_the_same_engine_without_a_mistake_passes(here: None, name: str) -> None:
    del here
    assert check_of("Right", name.removeprefix("conform/")).state is CheckState.PASSED


@pytest.mark.exhaustive
def test_an_error_that_two_settings_share_is_no_noise_whatever_is_declared(here: None) -> None:
    del here
    check = check_of("NoiseHidesThrust", "thrust_inertial")
    assert check.state is CheckState.FAILED
    assert "such an error is no noise, though noise is declared, 9e-06 rad of the angles" in check.words


@pytest.mark.slow
def test_a_scene_of_declared_effects_that_noise_makes_unjudgeable_is_a_failure(here: None) -> None:
    del here
    check = check_of("NoiseEndsJudgement", "thrust_inertial")
    assert check.state is CheckState.FAILED
    assert "leave 0.0001 rad of the attitude uncertain" in check.words


@pytest.mark.exhaustive
def test_honest_noise_is_told_with_the_error_and_fails_nothing(here: None) -> None:
    del here
    check = check_of("HonestNoise", "thrust_inertial")
    assert check.state is CheckState.WARNING
    assert "passes by its declared noise alone" in check.words
    assert check.words.endswith("declared are 3e-06 rad of the angles")


def falling(engine: str) -> Check:
    """Check of the fall of errors, of runs in this process."""
    kind, scene = getattr(hiding_engines, engine), scene_of("conform/three_bars_gradient")
    settings = [Setting(AccuracyParameter.RTOL, value) for value in (1e-7, 1e-9, 1e-11, 1e-12)]
    declared = kind.declarations()
    return falling_check([setting_error(declared, scene, s, kind().run(scene, s)) for s in settings], None, scene.name)


def test_a_constant_error_that_noise_hides_does_not_fall() -> None:
    check = falling("NoiseHidesConstant")
    assert check.state is CheckState.FAILED
    assert check.words.startswith("the error of the angles does not follow the setting")
    assert "is no reason, as the two runs differ by" in check.words


def test_honest_noise_stays_and_is_a_warning() -> None:
    check = falling("HonestNoise")
    assert check.state is CheckState.WARNING
    assert check.words.startswith("angles stay within declared noise of ")


@pytest.mark.slow
def test_the_quantity_that_stops_falling_is_named() -> None:
    check = falling("TrackOfAFrame")
    assert check.state is CheckState.FAILED
    assert check.words.startswith("the error of the velocity of the centre of mass does not follow the setting")


@pytest.mark.exhaustive
@pytest.mark.parametrize("mistake", ["Right", "FaintNoise"])
def test_right_variants_conform(mistake: str) -> None:
    report = conform(f"{HERE}:{mistake}")
    assert report.passed, [c.words for c in report.failures]


@pytest.mark.exhaustive
def test_an_engine_that_is_right_at_its_finest_setting_alone_does_not_conform() -> None:
    report = conform(f"{HERE}:RightAtTheFinest", extent=extent_of(["together_2", "three_bars_gradient"]))
    assert any(c.group is Group.PHYSICS for c in report.failures)
