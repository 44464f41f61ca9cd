"""Trials of faults and of unmodified engines."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from barchain.faults.catalogue import RANDOM_SCENES
from barchain.judge.verdict import no_verdict
from barchain.studies.selftest.campaign.judging import judge_serially
from barchain.studies.selftest.campaign.scenes.draw import draw
from barchain.studies.selftest.campaign.trial_runner import CampaignRunner, thinned
from barchain.studies.selftest.runs import RunCache, in_this_process
from barchain.studies.selftest.trial import Trial, TrialCase
from reports.tables.faults.campaign import CellClass
from reports.tables.outcome import Outcome
from tests.studies.campaign.drawn import FREE, SEED

if TYPE_CHECKING:
    from scenarios import Scene


@pytest.fixture(scope="module")
def runners() -> dict[int, tuple[CampaignRunner, Scene]]:
    """Scenes with their unmodified engines judged."""
    found = {}
    for seed in (SEED, FREE):
        runner = CampaignRunner(RunCache(in_this_process), judge_serially)
        (sampled,) = runner.establish([draw(seed)])
        _, trials = runner.unmodified_trials(sampled, ("reference", "pymunk"))
        assert {cell.kind for cell in runner.judge_trials(trials)} == {CellClass.PASS}
        found[seed] = runner, sampled
    return found


@pytest.mark.parametrize(("seed", "host"), [(FREE, "pymunk"), pytest.param(SEED, "reference", marks=pytest.mark.slow)])
def test_gross_faults_are_caught(runners, seed: int, host: str) -> None:  # type: ignore[no-untyped-def]
    runner, sampled = runners[seed]
    gross = [name for name in RANDOM_SCENES if name.startswith("garbage")]
    names = (*gross, "noise-reactions-large", "sign-reaction", "damped-rate", "interpolated-2000", "mass-stuck")
    left_out, trials = runner.fault_trials(sampled, host, names, 10)
    assert not left_out
    found = runner.judge_trials(trials)
    assert {c.fault: c.kind for c in found if c.kind is not CellClass.CAUGHT} == {}
    assert all(c.seconds > 0.0 for c in found if c.fault == "mass-stuck")
    assert all(c.seconds == 0.0 for c in found if c.fault != "mass-stuck")


def test_a_judge_that_sees_nothing_misses_what_it_says_it_would_see(runners, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    runner, sampled = runners[SEED]

    def blind(case, results):  # type: ignore[no-untyped-def]
        return no_verdict(sampled.name, case.trial.engine, case.trial.setting, Outcome.PASS, "")

    monkeypatch.setattr(TrialCase, "verdict", blind)
    left_out, trials = runner.fault_trials(
        sampled, "reference", ("sign-reaction", "attitude-creeps", "thrust-late"), 10
    )
    found = {c.fault: c for c in (*left_out, *runner.judge_trials(trials))}
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


def test_a_fault_in_an_engine_that_is_refused_as_it_is_is_not_tried(runners) -> None:  # type: ignore[no-untyped-def]
    runner, sampled = runners[SEED]
    assert runner.fault_trials(sampled, "exudyn", ["mu"], 10) == ([], [])


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
