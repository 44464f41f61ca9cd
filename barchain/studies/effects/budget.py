"""The effect budget from runs and times to the rows of its table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.runs.pool import run_jobs
from barchain.studies.effects.altitude_range import seen
from barchain.studies.effects.cost_ratio import (
    LEAST_ROUNDS,
    Timed,
    price,
    shortened,
    time_evaluations,
    timed_rounds,
    timed_span_s,
)
from barchain.studies.effects.default_options import TIME_LIMIT_S
from barchain.studies.effects.sensitivity import RunPair, SwitchResponse, change, sizes
from barchain.studies.effects.sizes import sizes_over
from reports.tables.effects import COLUMNS, UNITS
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterable

    from barchain.record.study_store import StudyStore
    from barchain.runs.job import Job, RunResult
    from barchain.runs.timing.statistics import Interval
    from barchain.studies.effects.effect_toggles import Switch
    from barchain.studies.effects.plan import EffectsPlan
    from barchain.studies.study import Reporter


@dataclass(frozen=True)
class EffectsResult:
    """Findings of a study beside its table."""

    failures: tuple[str, ...]
    """Runs that failed, one line each"""

    @property
    def passed(self) -> bool:
        """Whether all runs ended well or are declared unsupported, the scene's own among them."""
        return not self.failures


class EffectsBudget:
    """One budget being measured."""

    def __init__(self, plan: EffectsPlan, store: StudyStore, reporter: Reporter) -> None:
        """Prepare; `reporter` gets scene, run and outcome after each step."""
        self.plan, self.store, self.report, self.note = plan, store, reporter.step, reporter.note
        self.results: dict[str, RunResult] = {}
        self.times: dict[str, Timed] = {}

    def run(self) -> EffectsResult:
        """Run everything and write the table after the runs and after the times."""
        try:
            self.run_all(self.plan.whole)
            self.settle()
            self.run_all(job for job in self.plan.runs if job.key not in self.results)
            self.write()
            self.time()
        finally:
            self.write()
        return EffectsResult(self.failures())

    def failures(self) -> tuple[str, ...]:
        """Runs that failed, one line each; nothing is measured without the run of the scene as it is."""
        whole, runs = self.plan.whole, (*self.plan.whole, *self.plan.runs)
        failed = [j for j in {job.key: job for job in runs}.values() if not self.ended_well(j, needed=j in whole)]
        return tuple(f"{self.said(j)}: {self.results[j.key].outcome}: {self.results[j.key].reason}" for j in failed)

    def ended_well(self, job: Job, *, needed: bool) -> bool:
        """Whether a run passed, or is declared unsupported and not needed."""
        outcome = self.results[job.key].outcome
        return outcome is Outcome.PASS or (outcome.ok and not needed)

    def run_all(self, jobs: Iterable[Job]) -> None:
        """Run jobs side by side, each reported as it comes."""
        for job, result in run_jobs(jobs, time_limit_s=TIME_LIMIT_S, executor=self.plan.executor):
            self.results[job.key] = result
            self.report(self.plan.scene.name, self.said(job), str(result.outcome))

    def settle(self) -> None:
        """Take defaults for the heights that the scene as it is came to; those expected where it did not run well."""
        run = self.results[self.plan.whole[0].key]
        if run.outcome is Outcome.PASS and run.trajectory is not None:
            self.plan = self.plan.between(seen(self.plan.scene, run.trajectory))

    def said(self, job: Job) -> str:
        """Run in words."""
        titles = (s.title for s in self.plan.switches if s.scene and s.scene.digest == job.scene.digest)
        what = "as it is" if job.scene is self.plan.scene else next(titles)
        return f"{what}, {job.engine} {job.setting}"

    def time(self) -> None:
        """Time the good runs, shortened where three rounds would take too long, then evaluations."""
        good = [j for j in self.plan.tight if self.results[j.key].outcome is Outcome.PASS]
        pass_s = sum(self.results[j.key].seconds["simulate"] for j in good)
        wanted = min(LEAST_ROUNDS, self.plan.repeats)
        span_s = timed_span_s(self.plan.scene, pass_s, self.plan.seconds, wanted)
        part = "" if span_s >= self.plan.scene.run.duration_s else f", the first {span_s:.4g} s of each"
        self.note(f"timing {len(good)} runs in turn{part}: each once to get warm, then in rounds")
        timed = timed_rounds(
            [shortened(j, span_s) for j in good], repeats=self.plan.repeats, seconds=self.plan.seconds,
            time_limit_s=TIME_LIMIT_S, told=lambda k: self.report(self.plan.scene.name, f"round {k}", "pass"),
        )  # fmt: skip
        self.times = {job.key: found for job, found in zip(good, timed, strict=True)}
        rounds = max((len(t.seconds) for t in timed), default=0)
        self.store.record |= {"rounds": rounds, "repeats": self.plan.repeats, "timed_s": span_s}
        if rounds < self.plan.repeats:
            self.note(
                f"{rounds} of {self.plan.repeats} rounds of timing: the budget of {self.plan.seconds:g} s is used up, "
                "--minutes allows more"
            )
        self.note(f"timing one evaluation of {len(good)} right-hand sides by itself")
        self.write()
        time_evaluations((job, self.times[job.key]) for job in good)

    def write(self) -> None:
        """Table and record as they stand."""
        whole = self.runs_of(self.plan.tight[0])
        if whole:
            self.store.record["scene"] |= base_facts(whole)
        self.store.write("effects", [self.row(s) for s in self.plan.switches])
        self.store.write_record()

    def runs_of(self, job: Job) -> RunPair | None:
        """Trajectories of a run and of its looser run; None if either failed or is still to come."""
        found = [self.results.get(j.key) for j in (job, self.plan.looser(job))]
        tight, loose = (r.trajectory if r and r.outcome is Outcome.PASS else None for r in found)
        return RunPair(tight, loose) if tight is not None and loose is not None else None

    def row(self, switch: Switch) -> dict[str, Any]:
        """One effect's row."""
        found: dict[str, Any] = dict.fromkeys(COLUMNS) | {
            "effect": switch.effect, "title": switch.title, "kind": str(switch.kind), "on": switch.on,
            "said": switch.said, "reason": switch.reason, "caveat": switch.caveat,
            "width_least_m": min(switch.width_m, default=None), "width_largest_m": max(switch.width_m, default=None),
        }  # fmt: skip
        if switch.scene is None:
            return found
        own, other = self.plan.pair(switch)
        found["engine"] = own.engine
        scene, switched = self.runs_of(own), self.runs_of(other)
        if scene is None or switched is None:
            return found | {"reason": self.why_not(own, other)}
        found |= size_columns(self.plan, switch, scene) | change_columns(change(scene, switched))
        found["ended"] = switched.tight.ended
        return found | self.price_columns(switch, own, other)

    def why_not(self, *jobs: Job) -> str:
        """Outcomes and reasons of failed runs."""
        results = [(j, self.results.get(r.key)) for j in jobs for r in (j, self.plan.looser(j))]
        said = [f"{self.said(j)}: {r.outcome}, {r.reason}" for j, r in results if r and r.outcome is not Outcome.PASS]
        return "; ".join(dict.fromkeys(said)) or "not run"

    def price_columns(self, switch: Switch, own: Job, other: Job) -> dict[str, Any]:
        """Cost of the effect: time of the run with it over that of the run without it."""
        present, absent = (own, other) if switch.on else (other, own)
        if not {own.key, other.key} <= set(self.times):
            return {}
        timed = self.times[present.key]
        found = price(timed, self.times[absent.key])
        if found is None:
            return {}
        one = float(np.median(timed.evaluation_s)) if timed.evaluation_s else None
        return (
            spread("time_ratio", found.time)
            | spread("evaluation_ratio", found.evaluation)
            | {"rounds": found.rounds, "evaluations_ratio": found.evaluations, "evaluations": timed.evaluations}
            | {"seconds": float(np.nanmedian(timed.seconds)), "evaluation_s": one}
        )


def spread(name: str, found: Interval | None) -> dict[str, float]:
    """Columns of a ratio and where it lies."""
    return {} if found is None else {name: found.value, f"{name}_low": found.low, f"{name}_high": found.high}


def size_columns(plan: EffectsPlan, switch: Switch, scene: RunPair) -> dict[str, float]:
    """Sizes of an effect's push."""
    found = sizes_over(plan.scene, switch, scene.tight)
    if found is None:
        return {}
    named = zip(("start", "largest"), found, strict=True)
    return {f"{name}_{when}": value for when, all_sizes in named for name, value in all_sizes._asdict().items()}


def change_columns(found: SwitchResponse) -> dict[str, float]:
    """Columns of the changes that a switch causes."""
    columns = {"compared_s": found.compared_s}
    for name, unit in UNITS.items():
        if name in found.largest:
            columns |= {f"{name}_{unit}": found.largest[name], f"{name}_noise_{unit}": found.noise[name]}
    return columns


def base_facts(whole: RunPair) -> dict[str, Any]:
    """Entries of the record on the unmodified scene, once it has run."""
    size = sizes(whole.tight, whole.limit_s)
    return {
        "limit_s": whole.limit_s,
        "ended": whole.tight.ended,
        "end_s": float(whole.tight.t_s[-1]),
        "largest_reaction_N": size.get("reaction"),
    }
