"""Trials from runs to cells: unmodified engines, then faults, each with the further runs of its verdict."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from adapters.registry import find_engine
from barchain.runs.declared import engine_class
from barchain.solutions.sampling import closely_sampled
from barchain.studies.selftest.campaign.cells import CampaignCell
from barchain.studies.selftest.trial import Trial, TrialCase
from barchain.studies.selftest.trial_runner import TrialRunner
from reports.tables.crossval import JUDGING_SOLUTION
from reports.tables.faults.campaign import CellClass
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterable

    from barchain.runs.job import Role
    from barchain.studies.selftest.campaign.judging import JudgeCases
    from barchain.studies.selftest.campaign.rating import Judged
    from barchain.studies.selftest.runs import RunCache
    from scenarios import Scene


class CampaignRunner(TrialRunner):
    """Random scenes on which engines are tried as they are, then with faults."""

    def __init__(self, runs: RunCache, judge_cases: JudgeCases) -> None:
        super().__init__(runs)
        self.judge_cases = judge_cases
        self.unmodified: dict[tuple[str, str], Judged] = {}

    def establish(self, drawn: Iterable[Scene]) -> list[Scene]:
        """Scenes as a comparison samples them, their reference solutions found."""
        scenes = list(map(closely_sampled, drawn))
        self.solve(scenes)
        return scenes

    def unmodified_trials(self, scene: Scene, engines: Iterable[str]) -> tuple[list[CampaignCell], list[Trial]]:
        """Cells of engines that are not run on a scene, and trials of those that are."""
        if scene.name in self.failed:
            why, failed = self.failed[scene.name], str(Outcome.FAILED)
            return [CampaignCell(scene.name, JUDGING_SOLUTION, "", CellClass.FALSE_ALARM, failed, reason=why)], []
        cells, trials = [], []
        for name in engines:
            host = engine_class(find_engine(name))
            solution = self.solutions[scene.name]
            reason = host.unsupported(scene) or host.unsupported_motion(solution.scene, solution.fine)
            if reason is not None:
                cells.append(
                    CampaignCell(scene.name, name, "", CellClass.UNSUPPORTED, str(Outcome.UNSUPPORTED), reason=reason)
                )
            else:
                trials.append(Trial(scene, name))
        return cells, trials

    def fault_trials(
        self, scene: Scene, host: str, faults: Iterable[str], most_reruns: int
    ) -> tuple[list[CampaignCell], list[Trial]]:
        """Cells of faults that can't be inserted into a host, and trials of those that can.

        Parameters
        ----------
        scene : Scene
        host : str
        faults : iterable of str
        most_reruns : int
            Faults that need runs of their own, of all that there are; the scene chooses them.
        """
        unmodified = self.unmodified.get((scene.name, host))
        if unmodified is None or unmodified.cell.kind not in (CellClass.PASS, CellClass.LIMITED):
            return [], []
        cells, trials = [], []
        for fault in faults:
            trial = Trial(scene, host, fault)
            left_out = trial.left_out(self.solutions[scene.name])
            if left_out:
                cells.append(CampaignCell(scene.name, host, fault, CellClass.NOTHING, reason=left_out))
            else:
                trials.append(trial)
        return cells, thinned(trials, most_reruns)

    def judge_trials(self, trials: list[Trial]) -> list[CampaignCell]:
        """Cells of trials; where the first runs do not decide a verdict, after those that it asks for besides."""
        self.runs.make(job for trial in trials for job in trial.jobs())
        found = self.judge_cases([self.case(trial) for trial in trials])
        asking = [k for k, one in enumerate(found) if one.further_runs]
        self.runs.make(job for k in asking for job in trials[k].jobs(found[k].further_runs))
        again = self.judge_cases([self.case(trials[k], found[k].further_runs) for k in asking])
        for k, one in zip(asking, again, strict=True):
            found[k] = one
        for trial, one in zip(trials, found, strict=True):
            if not trial.fault:
                self.unmodified[trial.scene.name, trial.engine] = one
        return [one.cell for one in found]

    def case(self, trial: Trial, further_runs: tuple[Role, ...] = ()) -> TrialCase:
        """A trial with its runs; of a fault, with what is known of the unmodified engine."""
        case = super().case(trial, further_runs)
        if not trial.fault:
            return case
        unmodified = {job.role: self.runs[job] for job in Trial(trial.scene, trial.engine).jobs()}
        before = self.unmodified[trial.scene.name, trial.engine]
        passes = before.cell.kind is CellClass.PASS
        return replace(case, unmodified_runs=unmodified, limits=before.limits, passes=passes)


def thinned(trials: list[Trial], most_reruns: int) -> list[Trial]:
    """Trials of which no more than some need runs of their own, in the same order."""
    own = [k for k, trial in enumerate(trials) if not trial.replays]
    if len(own) <= most_reruns:
        return trials
    words = f"{trials[0].scene.digest}|{trials[0].engine}".encode()
    kept = set(np.random.default_rng(list(words)).permutation(own)[:most_reruns].tolist())
    return [trial for k, trial in enumerate(trials) if trial.replays or k in kept]
