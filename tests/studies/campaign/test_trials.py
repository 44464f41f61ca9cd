"""Trials of faults and of unmodified engines."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import pytest

from barchain.judge.verdict import no_verdict
from barchain.runs.cases import Known
from barchain.solutions.reference import closely_sampled
from barchain.studies.selftest import trial
from barchain.studies.selftest.campaign import faulty_engine, on_scene, thinned
from barchain.studies.selftest.faults.catalogue import RANDOM_SCENES
from barchain.studies.selftest.rating import CampaignCell, rated
from barchain.studies.selftest.scenes import draw
from barchain.studies.selftest.trial import SceneRuns, Trial
from reports.results.faults.campaign import CellClass
from reports.results.outcome import Outcome
from tests.studies.campaign.drawn import FREE, SEED
from tests.support.here import result_of

if TYPE_CHECKING:
    from barchain.runs.cases import Case
    from barchain.solutions.reference import ReferenceSolution

SOUND = ("reference", "pymunk")


@functools.cache
def drawn(seed: int) -> tuple[SceneRuns, ReferenceSolution, dict[str, CampaignCell]]:
    """A scene with its unmodified engines judged; its runs are made once."""
    scene = SceneRuns(closely_sampled(draw(seed)))

    def unmodified() -> Case[tuple[ReferenceSolution, dict[str, CampaignCell]]]:
        (solution,) = yield [scene.solution]
        found = {}
        for name in SOUND:
            found[name] = yield from rated(scene, Trial(scene.scene, name), solution)
        return solution, found

    solution, found = result_of(unmodified())
    assert {one.kind for one in found.values()} == {CellClass.PASS}
    return scene, solution, found


def inserted(seed: int, host: str, names: tuple[str, ...]) -> list[CampaignCell]:
    """Cells of faults in a host: first those that can't be inserted."""
    scene, solution, before = drawn(seed)

    def faults() -> Case[list[CampaignCell]]:
        found: list[CampaignCell] = yield list(faulty_engine(scene, host, names, 10, solution, before[host]))
        return found

    return result_of(faults())


@pytest.mark.parametrize(("seed", "host"), [(FREE, "pymunk"), pytest.param(SEED, "reference", marks=pytest.mark.slow)])
def test_gross_faults_are_caught(seed: int, host: str) -> None:
    gross = [name for name in RANDOM_SCENES if name.startswith("garbage")]
    names = (*gross, "noise-reactions-large", "sign-reaction", "damped-rate", "interpolated-2000", "mass-stuck")
    scene, solution, before = drawn(seed)
    assert not any(isinstance(one, Known) for one in faulty_engine(scene, host, names, 10, solution, before[host]))
    found = inserted(seed, host, names)
    assert {c.fault: c.kind for c in found if c.kind is not CellClass.CAUGHT} == {}
    assert all(c.seconds > 0.0 for c in found if c.fault == "mass-stuck")
    assert all(c.seconds == 0.0 for c in found if c.fault != "mass-stuck")


def test_a_judge_that_sees_nothing_misses_what_it_says_it_would_see(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn(SEED)

    def blind(of, results, solution, main):  # type: ignore[no-untyped-def]
        return no_verdict(of.scene.name, of.engine, of.setting, Outcome.PASS, "")

    monkeypatch.setattr(trial, "verdict_of", blind)
    names = ("sign-reaction", "attitude-creeps", "thrust-late")
    found = {c.fault: c for c in inserted(SEED, "reference", names)}
    missed = found["sign-reaction"]
    assert (missed.kind, missed.quantity) == (CellClass.MISSED, "reaction")
    assert missed.size is not None
    assert missed.size > 0.1
    assert missed.limit is not None
    assert missed.limit < 1e-6
    assert found["thrust-late"].kind is CellClass.NOTHING
    small = found["attitude-creeps"]
    assert small.size is not None
    assert small.limit is not None
    assert (small.kind is CellClass.BELOW) == (small.size <= small.limit)


def test_a_fault_in_an_engine_that_is_refused_as_it_is_is_not_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    def strict(of, results, solution, main):  # type: ignore[no-untyped-def]
        return no_verdict(of.scene.name, of.engine, of.setting, Outcome.INCONSISTENT, "")

    monkeypatch.setattr(trial, "verdict_of", strict)
    found = result_of(on_scene(draw(FREE), ["reference"], ["reference"], ["mu", "sign-reaction"]))
    assert [(c.fault, c.kind) for c in found] == [("", CellClass.FALSE_ALARM)]


def test_runs_of_their_own_are_chosen_by_the_scene() -> None:
    def own(seed: int) -> tuple[str, ...]:
        trials = thinned([Trial(draw(seed), "reference", name) for name in RANDOM_SCENES], 3)
        assert {t.fault for t in trials if t.replays} == {
            name for name, fault in RANDOM_SCENES.items() if fault.replays
        }
        return tuple(t.fault for t in trials if not t.replays)

    assert len(own(SEED)) == 3
    assert own(SEED) == own(SEED)
    assert len({own(seed) for seed in range(5)}) > 1
