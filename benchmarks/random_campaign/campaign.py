"""Engines and faults on random scenes: trials, their ratings, and the rates of wrong verdicts."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import binomtest

from adapters.registry import find_engine
from barchain.runs.asking import declarations_of
from barchain.runs.cases import Known, Shared, run_cases
from barchain.runs.job import TIME_LIMIT_S
from barchain.solutions.reference import closely_sampled
from barchain.studies.selftest.faults import declarations, samples
from barchain.studies.selftest.faults.catalogue import CATALOGUE
from barchain.studies.selftest.trial import SceneRuns, Trial
from reports.results.comparison import JUDGING_SOLUTION
from reports.results.outcome import Outcome

from .rating import RatedTrial, Rating, rated
from .scenes import draw

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from barchain.runs.cases import Case
    from barchain.runs.executors import Executor
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

FAULTS = {
    name: CATALOGUE[name]
    for name in (
        *(fault.name for fault in (*samples.GARBAGE, *samples.FAULTS)), "sign-reaction", "damped-rate",
        "gravity-model", "impulse-late-millisecond", "impulse-late", "thrust-late-millisecond", "thrust-late", "sloppy",
        "mass", "mass-stuck", "mu", "clock-fast", *(fault.name for fault in declarations.FAULTS),
    )
}  # fmt: skip
"""Faults that a verdict on any scene detects, or that are smaller than its own detection limit"""
HOSTS = ("reference", "exudyn", "exudyn-tree", "pymunk")
"""Steps that are chosen; multipliers of second order; a tree of sixth order; impulses"""
CHUNK = 8  # scenes at a time: their runs are held until all of them are judged
MOST_RERUNS = 3
RAN = (Rating.PASS, Rating.LIMITED, Rating.FALSE_ALARM)
"""Ratings of unmodified engines that ran"""
DETECTABLE = (Rating.CAUGHT, Rating.MISSED)
"""Ratings of faults that a verdict has to detect"""
CONFIDENCE = 0.95
MOST_FALSE_ALARMS = 0.005
"""Share of verdicts on unmodified engines that may be false alarms"""


def on_random_scenes(
    numbers: range,
    engines: Sequence[str],
    hosts: Sequence[str],
    faults: Sequence[str],
    most_reruns: int,
    executor: Executor,
    done: Callable[[int], None],
) -> list[RatedTrial]:
    """Try engines and faults on the scenes of some numbers; arguments are those of :func:`on_scene`.

    `done` is called with 1 after each scene.
    """
    trials = list[RatedTrial]()
    for start in range(0, len(numbers), CHUNK):
        chunk, found = numbers[start : start + CHUNK], dict[int, list[RatedTrial]]()
        cases = ((k, on_scene(draw(k), engines, hosts, faults, most_reruns)) for k in chunk)
        for k, its_trials in run_cases(cases, executor):
            found[k] = its_trials
            done(1)
        trials += [trial for k in chunk for trial in found[k]]
    return trials


def on_scene(
    drawn: Scene,
    engines: Sequence[str],
    hosts: Sequence[str] = (),
    faults: Sequence[str] = (),
    most_reruns: int = MOST_RERUNS,
    limit_s: float = TIME_LIMIT_S,
) -> Case[list[RatedTrial]]:
    """Try engines as they are on a scene, sampled as a comparison samples it, then faults in the hosts that pass.

    Parameters
    ----------
    drawn : Scene
    engines : sequence of str
        The hosts among them.
    hosts, faults : sequence of str
    most_reruns : int
        Faults in one host that need runs of their own, of all that there are; the scene chooses them.
    limit_s : float
        Wall time of a run, s.
    """
    scene = SceneRuns(closely_sampled(drawn), limit_s=limit_s)
    name = scene.scene.name
    (solution,) = yield [scene.solution]
    if isinstance(solution, str):
        failed = str(Outcome.FAILED)
        return [RatedTrial(name, JUDGING_SOLUTION, "", failed, Rating.FALSE_ALARM, reason=solution)]
    unmodified: list[RatedTrial] = yield [unmodified_engine(scene, engine, solution) for engine in engines]
    before = dict(zip(engines, unmodified, strict=True))
    able = [host for host in hosts if before[host].rating in (Rating.PASS, Rating.LIMITED)]
    inserted: list[RatedTrial] = yield [
        one for host in able for one in faulty_engine(scene, host, faults, most_reruns, solution, before[host])
    ]
    return [*unmodified, *inserted]


def unmodified_engine(scene: SceneRuns, name: str, solution: ReferenceSolution) -> Known | Shared:
    """Rating of an engine as it is, or that it does not support the scene."""
    engine = declarations_of(find_engine(name))
    reason = engine.unsupported(scene.scene) or engine.unsupported_motion(solution.scene, solution.fine)
    if reason is None:
        return Shared(rated(scene, Trial(scene.scene, name), solution))
    unsupported = str(Outcome.UNSUPPORTED), Rating.UNSUPPORTED
    return Known(RatedTrial(scene.scene.name, name, "", *unsupported, reason=reason))


def faulty_engine(
    scene: SceneRuns,
    host: str,
    faults: Sequence[str],
    most_reruns: int,
    solution: ReferenceSolution,
    before: RatedTrial,
) -> list[Known | Shared]:
    """Ratings of faults in a host: first those that can't be inserted, then trials."""
    trials = [Trial(scene.scene, host, fault) for fault in faults]
    reasons = {trial.fault: trial.left_out(solution) for trial in trials}
    left_out = [Known(RatedTrial(scene.scene.name, host, fault, reason=why)) for fault, why in reasons.items() if why]
    wanted = thinned([trial for trial in trials if not reasons[trial.fault]], most_reruns)
    return [*left_out, *(Shared(rated(scene, trial, solution, before)) for trial in wanted)]


def thinned(trials: list[Trial], most_reruns: int) -> list[Trial]:
    """Trials of which no more than some need runs of their own, in the same order."""
    own = [k for k, trial in enumerate(trials) if not trial.replays]
    if len(own) <= most_reruns:
        return trials
    words = f"{trials[0].scene.digest}|{trials[0].engine}".encode()
    kept = set(np.random.default_rng(list(words)).permutation(own)[:most_reruns].tolist())
    return [trial for k, trial in enumerate(trials) if trial.replays or k in kept]


def again(scene: Scene, finding: RatedTrial, limit_s: float) -> Case[RatedTrial | None]:
    """Try a finding's engine, or its fault in it, on another scene; None where it can't be tried."""
    engines = [] if finding.engine == JUDGING_SOLUTION else [finding.engine]
    faults = [finding.fault] if finding.fault else []
    found = yield from on_scene(scene, engines, engines if faults else [], faults, len(faults), limit_s)
    return next((one for one in found if (one.engine, one.fault) == (finding.engine, finding.fault)), None)


@dataclass(frozen=True)
class Rate:
    """Share of verdicts that are wrong in one way."""

    what: str
    count: int
    tried: int

    def __str__(self) -> str:
        """``false alarm: 2 of 400, 0.50 % (0.14 % to 1.80 %)``: the rate with Wilson's score interval of 95 %.

        The interval covers its confidence on average, and holds for counts of zero.
        """
        if not self.tried:
            return f"{self.what}: none tried"
        low, high = binomtest(self.count, self.tried).proportion_ci(CONFIDENCE, method="wilson")
        interval = f"{100.0 * low:.2f} % to {100.0 * high:.2f} %"
        return f"{self.what}: {self.count} of {self.tried}, {100.0 * self.count / self.tried:.2f} % ({interval})"


def rates(trials: list[RatedTrial]) -> list[Rate]:
    """Rates of false alarms and of missed faults, then those of false alarms by outcome."""
    ran = [one for one in trials if not one.fault and one.rating in RAN]
    detectable = [one for one in trials if one.fault and one.rating in DETECTABLE]
    alarms = Counter(one.outcome for one in ran if one.rating is Rating.FALSE_ALARM)
    missed = sum(one.rating is Rating.MISSED for one in detectable)
    return [
        Rate("false alarm", alarms.total(), len(ran)),
        Rate("missed", missed, len(detectable)),
        *(Rate(f"false alarm, {outcome}", count, len(ran)) for outcome, count in alarms.items()),
    ]


def passed(trials: list[RatedTrial]) -> bool:
    """Whether no fault above its detection limit is missed, and false alarms are as rare as they have to be."""
    alarms, missed = rates(trials)[:2]
    return missed.count == 0 and alarms.count <= math.ceil(MOST_FALSE_ALARMS * alarms.tried)
