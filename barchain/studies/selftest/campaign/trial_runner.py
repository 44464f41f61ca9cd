"""Trials from runs to cells: unmodified engines, then faults, each with the further runs of its verdict."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.registry import find_engine
from barchain.boundary.declared import engine_class
from barchain.solutions.reference_runs import SolutionFailedError, solution_jobs, solution_of
from barchain.solutions.sampling import closely_sampled
from barchain.studies.selftest.campaign.cells import CampaignCell
from barchain.studies.selftest.campaign.trial import FIRST, CampaignCase, CampaignTrial
from reports.tables.crossval import JUDGING_SOLUTION
from reports.tables.faults.campaign import CellClass
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterable

    from barchain.run.job import Role
    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.selftest.campaign.judging import JudgeCases
    from barchain.studies.selftest.campaign.rating import Judged
    from barchain.studies.selftest.campaign.runs import RunCache
    from scenarios import Scene


class TrialRunner:
    """Scenes whose engines are tried, with their runs."""

    def __init__(self, runs: RunCache, judge_cases: JudgeCases) -> None:
        self.runs, self.judge_cases = runs, judge_cases
        self.solutions: dict[str, ReferenceSolution] = {}
        self.failed: dict[str, str] = {}
        self.unmodified: dict[tuple[str, str], Judged] = {}

    def establish(self, drawn: Iterable[Scene]) -> list[Scene]:
        """Scenes as a comparison samples them, their reference solutions found."""
        scenes = list(map(closely_sampled, drawn))
        jobs = {scene.name: solution_jobs(scene) for scene in scenes}
        self.runs.make(job for each in jobs.values() for job in each)
        for scene in scenes:
            try:
                solution = solution_of(scene, {job.role: self.runs[job] for job in jobs[scene.name]})
            except SolutionFailedError as error:
                self.failed[scene.name] = f"the reference solution could not be run ({error})"
                continue
            assert solution is not None  # all of its runs are there
            self.solutions[scene.name] = solution
        return scenes

    def unmodified_trials(self, scene: Scene, engines: Iterable[str]) -> tuple[list[CampaignCell], list[CampaignTrial]]:
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
                trials.append(CampaignTrial(scene, name))
        return cells, trials

    def fault_trials(
        self, scene: Scene, host: str, faults: Iterable[str], most_reruns: int
    ) -> tuple[list[CampaignCell], list[CampaignTrial]]:
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
            trial = CampaignTrial(scene, host, fault)
            left_out = trial.left_out(self.solutions[scene.name])
            if left_out:
                cells.append(CampaignCell(scene.name, host, fault, CellClass.NOTHING, reason=left_out))
            else:
                trials.append(trial)
        return cells, thinned(trials, most_reruns)

    def judge_trials(self, trials: list[CampaignTrial]) -> list[CampaignCell]:
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

    def case(self, trial: CampaignTrial, asked: tuple[Role, ...] = ()) -> CampaignCase:
        """A trial with its runs."""
        made = {job.role: (job, self.runs[job]) for job in trial.jobs((*FIRST, *asked))}
        if not trial.fault:
            return CampaignCase(trial, self.solutions[trial.scene.name], made)
        unmodified = {job.role: self.runs[job] for job in CampaignTrial(trial.scene, trial.engine).jobs()}
        before = self.unmodified[trial.scene.name, trial.engine]
        passes = before.cell.kind is CellClass.PASS
        return CampaignCase(trial, self.solutions[trial.scene.name], made, unmodified, before.limits, passes)


def thinned(trials: list[CampaignTrial], most_reruns: int) -> list[CampaignTrial]:
    """Trials of which no more than some need runs of their own, in the same order."""
    own = [k for k, trial in enumerate(trials) if not trial.replays]
    if len(own) <= most_reruns:
        return trials
    words = f"{trials[0].scene.digest}|{trials[0].engine}".encode()
    kept = set(np.random.default_rng(list(words)).permutation(own)[:most_reruns].tolist())
    return [trial for k, trial in enumerate(trials) if trial.replays or k in kept]
