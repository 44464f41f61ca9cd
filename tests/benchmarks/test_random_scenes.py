"""Faults and engines on random scenes: ratings of verdicts, the rates of wrong ones, and the benchmark as a whole."""

from __future__ import annotations

import functools
import math
import re
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.reference.numpy_engines import Reference
from barchain.judge.verdict import no_verdict
from barchain.runs.cases import Known
from barchain.runs.executors import ALL_CORES
from barchain.solutions.reference import closely_sampled
from barchain.studies.selftest import trial
from barchain.studies.selftest.trial import SceneRuns, Trial
from benchmarks.random_campaign.campaign import FAULTS, Rate, faulty_engine, on_random_scenes, on_scene, passed, rates
from benchmarks.random_campaign.rating import RatedTrial, Rating, rated, sizes
from benchmarks.random_campaign.scenes import draw
from reports.results.outcome import Outcome
from tests.structure.product import ROOT
from tests.support.here import result_of

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.runs.cases import Case
    from barchain.solutions.reference import ReferenceSolution

FREE = 6
"""Two bars without gravity"""
HEAVY = 8
"""Three bars in a point's pull, for a third of an orbit"""
SOUND = ("reference", "pymunk")


@functools.cache
def drawn(seed: int) -> tuple[SceneRuns, ReferenceSolution, dict[str, RatedTrial]]:
    """A scene with its unmodified engines judged; its runs are made once."""
    scene = SceneRuns(closely_sampled(draw(seed)))

    def unmodified() -> Case[tuple[ReferenceSolution, dict[str, RatedTrial]]]:
        (solution,) = yield [scene.solution]
        found = {}
        for name in SOUND:
            found[name] = yield from rated(scene, Trial(scene.scene, name), solution)
        return solution, found

    solution, found = result_of(unmodified())
    assert {one.rating for one in found.values()} == {Rating.PASS}
    return scene, solution, found


def inserted(seed: int, host: str, names: tuple[str, ...]) -> list[RatedTrial]:
    """Ratings of faults in a host: first those that can't be inserted."""
    scene, solution, before = drawn(seed)

    def faults() -> Case[list[RatedTrial]]:
        found: list[RatedTrial] = yield list(faulty_engine(scene, host, names, 10, solution, before[host]))
        return found

    return result_of(faults())


@pytest.mark.parametrize(("seed", "host"), [(FREE, "pymunk"), pytest.param(HEAVY, "reference", marks=pytest.mark.slow)])
def test_gross_faults_are_caught(seed: int, host: str) -> None:
    gross = [name for name in FAULTS if name.startswith("garbage")]
    names = (*gross, "noise-reactions-large", "sign-reaction", "damped-rate", "interpolated-2000", "mass-stuck")
    scene, solution, before = drawn(seed)
    assert not any(isinstance(one, Known) for one in faulty_engine(scene, host, names, 10, solution, before[host]))
    found = inserted(seed, host, names)
    assert {one.fault: one.rating for one in found if one.rating is not Rating.CAUGHT} == {}


def test_a_judge_that_sees_nothing_misses_what_it_says_it_would_see(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn(HEAVY)

    def blind(of, results, solution, main):  # type: ignore[no-untyped-def]
        return no_verdict(of.scene.name, of.engine, of.setting, Outcome.PASS, "")

    monkeypatch.setattr(trial, "verdict_of", blind)
    names = ("sign-reaction", "attitude-creeps", "thrust-late")
    found = {one.fault: one for one in inserted(HEAVY, "reference", names)}
    missed = found["sign-reaction"]
    assert (missed.rating, missed.quantity) == (Rating.MISSED, "reaction")
    assert missed.size is not None
    assert missed.size > 0.1
    assert missed.limit is not None
    assert missed.limit < 1e-6
    assert found["thrust-late"].rating is Rating.NOTHING
    small = found["attitude-creeps"]
    assert small.size is not None
    assert small.limit is not None
    assert (small.rating is Rating.BELOW) == (small.size <= small.limit)


def test_a_fault_in_an_engine_that_is_refused_as_it_is_is_not_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    def strict(of, results, solution, main):  # type: ignore[no-untyped-def]
        return no_verdict(of.scene.name, of.engine, of.setting, Outcome.INCONSISTENT, "")

    monkeypatch.setattr(trial, "verdict_of", strict)
    found = result_of(on_scene(draw(FREE), ["reference"], ["reference"], ["mu", "sign-reaction"]))
    assert [(one.fault, one.rating) for one in found] == [("", Rating.FALSE_ALARM)]


def test_sizes_are_shares_of_scales() -> None:
    scene = draw(FREE)
    unmodified = Reference().run(scene, Setting(AccuracyParameter.RTOL, 1e-10))
    names = ("com", "com_velocity", "attitude", "rate", "reaction", "gap", "com_residual")
    scale = dict.fromkeys(names, 1.0) | {"com": 1e6, "reaction": 2.0}
    angle, reaction = unmodified.angle_rad.copy(), unmodified.reaction_N.copy()
    angle[-1, 1] += 1e-3
    reaction[1, 0] += (3.0, 4.0)
    wrong = unmodified.replace(angle_rad=angle, reaction_N=reaction)
    found = sizes(unmodified, wrong, scale)
    assert found["attitude"] == pytest.approx(1e-3)
    assert found["reaction"] == pytest.approx(2.5)
    assert found["com"] == found["rate"] == found["gap"] == 0.0
    until = {"attitude": float(unmodified.t_s[-2])}
    assert sizes(unmodified, wrong, scale, until)["attitude"] == 0.0
    assert sizes(unmodified, unmodified.samples(slice(0, -1)), scale)["com"] == 1.0


def test_rates_have_the_intervals_of_the_textbook() -> None:
    """Wilson's: (p + z²/2n ± z sqrt(p (1 - p)/n + z²/4n²)) / (1 + z²/n)."""
    for n, k in ((200, 0), (200, 3), (7, 7)):
        z, p = 1.959963984540054, k / n
        centre, half = p + z**2 / (2 * n), z * math.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
        low, high = (100.0 * (centre + s * half) / (1 + z**2 / n) for s in (-1.0, 1.0))
        assert str(Rate("missed", k, n)).endswith(f"{100.0 * p:.2f} % ({abs(low):.2f} % to {high:.2f} %)")
    assert str(Rate("missed", 0, 0)) == "missed: none tried"


def several(rating: Rating, number: int, fault: str = "", outcome: str = "") -> list[RatedTrial]:
    """So many equal trials."""
    return [RatedTrial(f"random/{k}", "pymunk", fault, outcome, rating) for k in range(number)]


def test_rates_count_what_could_have_happened() -> None:
    found = [
        *several(Rating.PASS, 6), *several(Rating.UNSUPPORTED, 5), *several(Rating.LIMITED, 1),
        *several(Rating.FALSE_ALARM, 1, "", "inconsistent"),
        *several(Rating.CAUGHT, 3, "mu"), *several(Rating.MISSED, 1, "mu"), *several(Rating.BELOW, 4, "mu"),
        *several(Rating.NOTHING, 9, "mu"), *several(Rating.BROKEN, 2, "mu"), *several(Rating.BEYOND, 2, "mu"),
    ]  # fmt: skip
    assert rates(found) == [Rate("false alarm", 1, 8), Rate("missed", 1, 4), Rate("false alarm, inconsistent", 1, 8)]


def test_one_missed_fault_fails_and_false_alarms_may_be_half_a_percent() -> None:
    right = several(Rating.PASS, 150)
    assert passed([*right, *several(Rating.FALSE_ALARM, 1), *several(Rating.BELOW, 5, "mu")])
    assert not passed([*right, *several(Rating.FALSE_ALARM, 2)])
    assert not passed([*right, *several(Rating.MISSED, 1, "mu")])


@pytest.mark.exhaustive
def test_the_benchmark_prints_ratings_and_rates_and_goes_on_from_its_runs(tmp_path: Path) -> None:
    """Of a fault that wrong declarations alone are, and of one that a verdict detects."""
    words = f"1 --seed {FREE} --engine exudyn --host reference --fault sign-reaction --fault declares-noise"
    line = [sys.executable, ROOT / "benchmarks/random_scenes.py", *words.split(), "--out", tmp_path]
    said, again = (subprocess.run(line, capture_output=True, text=True, check=True).stdout for _ in range(2))
    assert again == said
    assert len(list((tmp_path / "answers").iterdir())) > 4
    assert re.search(r"^ *reference +1 *$", said, re.MULTILINE)
    assert "false alarm: 0 of 2" in said
    assert "missed: 0 of 1" in said
    assert said.endswith("passed\n")


@pytest.mark.exhaustive
def test_no_engine_is_accused_and_no_fault_missed_on_some_scenes() -> None:
    engines = ("reference-absolute", "exudyn-index3", "rebound", "pymunk-absolute")
    hosts = ("reference", "exudyn", "exudyn-tree", "pymunk")
    numbers = range(100, 106)
    found = on_random_scenes(numbers, (*engines, *hosts), hosts, tuple(FAULTS), 3, ALL_CORES, lambda _: None)
    assert passed(found), [one for one in found if one.is_finding]
    assert not [one for one in found if one.rating is Rating.BROKEN]
