"""Trials from runs to cells: sound engines first, then faults, each with the further runs that its verdict asks for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.registry import find_engine
from barchain.campaign.cells import Cell, Kind
from barchain.campaign.trial import FIRST, Case, Trial
from barchain.sampling import closely_sampled
from barchain.support import unsupported
from barchain.truth_runs import TruthFailedError, truth_jobs, truth_of
from reports.outcome import Outcome
from reports.tables import REFERENCE_SOLUTION

if TYPE_CHECKING:
    from collections.abc import Iterable

    from barchain.campaign.court import Judged
    from barchain.campaign.judging import Court
    from barchain.campaign.runs import Runs
    from barchain.job import Role
    from barchain.truth import Truth
    from scenarios import Scene


class Bench:
    """Scenes whose engines are tried, with their runs."""

    def __init__(self, runs: Runs, court: Court) -> None:
        self.runs, self.court = runs, court
        self.truths: dict[str, Truth] = {}
        self.failed: dict[str, str] = {}
        self.sound: dict[tuple[str, str], Judged] = {}

    def establish(self, drawn: Iterable[Scene]) -> list[Scene]:
        """Scenes as a comparison samples them, their reference solutions found."""
        scenes = list(map(closely_sampled, drawn))
        jobs = {scene.name: truth_jobs(scene) for scene in scenes}
        self.runs.make(job for each in jobs.values() for job in each)
        for scene in scenes:
            try:
                truth = truth_of(scene, {job.role: self.runs[job] for job in jobs[scene.name]})
            except TruthFailedError as error:
                self.failed[scene.name] = f"the reference solution could not be run ({error})"
                continue
            assert truth is not None  # all of its runs are there
            self.truths[scene.name] = truth
        return scenes

    def try_sound(self, scene: Scene, engines: Iterable[str]) -> tuple[list[Cell], list[Trial]]:
        """Cells of engines that are not run on a scene, and trials of those that are."""
        if scene.name in self.failed:
            why, failed = self.failed[scene.name], str(Outcome.FAILED)
            return [Cell(scene.name, REFERENCE_SOLUTION, "", Kind.FALSE_ALARM, failed, reason=why)], []
        cells, trials = [], []
        for name in engines:
            host = find_engine(name).load()
            reason = host.unsupported(scene) or unsupported(host, self.truths[scene.name])
            if reason is not None:
                cells.append(Cell(scene.name, name, "", Kind.UNSUPPORTED, str(Outcome.UNSUPPORTED), reason=reason))
            else:
                trials.append(Trial(scene, name))
        return cells, trials

    def plant(self, scene: Scene, host: str, faults: Iterable[str], most_reruns: int) -> tuple[list[Cell], list[Trial]]:
        """Cells of faults that can't be put into a host, and trials of those that can.

        Parameters
        ----------
        scene : Scene
        host : str
        faults : iterable of str
        most_reruns : int
            Faults that need runs of their own, of all that there are; the scene chooses them.
        """
        sound = self.sound.get((scene.name, host))
        if sound is None or sound.cell.kind not in (Kind.PASS, Kind.LIMITED):
            return [], []
        cells, trials = [], []
        for fault in faults:
            trial = Trial(scene, host, fault)
            left_out = trial.left_out(self.truths[scene.name])
            if left_out:
                cells.append(Cell(scene.name, host, fault, Kind.NOTHING, reason=left_out))
            else:
                trials.append(trial)
        return cells, thinned(trials, most_reruns)

    def settle(self, trials: list[Trial]) -> list[Cell]:
        """Cells of trials; where the first runs do not decide a verdict, after those that it asks for besides."""
        self.runs.make(job for trial in trials for job in trial.jobs())
        found = self.court([self.case(trial) for trial in trials])
        asking = [k for k, one in enumerate(found) if one.asks]
        self.runs.make(job for k in asking for job in trials[k].jobs(found[k].asks))
        again = self.court([self.case(trials[k], found[k].asks) for k in asking])
        for k, one in zip(asking, again, strict=True):
            found[k] = one
        for trial, one in zip(trials, found, strict=True):
            if not trial.fault:
                self.sound[trial.scene.name, trial.engine] = one
        return [one.cell for one in found]

    def case(self, trial: Trial, asked: tuple[Role, ...] = ()) -> Case:
        """A trial with its runs."""
        made = {job.role: (job, self.runs[job]) for job in trial.jobs((*FIRST, *asked))}
        if not trial.fault:
            return Case(trial, self.truths[trial.scene.name], made)
        sound = {job.role: self.runs[job] for job in Trial(trial.scene, trial.engine).jobs()}
        before = self.sound[trial.scene.name, trial.engine]
        return Case(trial, self.truths[trial.scene.name], made, sound, before.limits, before.cell.kind is Kind.PASS)


def thinned(trials: list[Trial], most_reruns: int) -> list[Trial]:
    """Trials of which no more than some need runs of their own, in the same order."""
    own = [k for k, trial in enumerate(trials) if not trial.replays]
    if len(own) <= most_reruns:
        return trials
    words = f"{trials[0].scene.digest}|{trials[0].engine}".encode()
    kept = set(np.random.default_rng(list(words)).permutation(own)[:most_reruns].tolist())
    return [trial for k, trial in enumerate(trials) if trial.replays or k in kept]
