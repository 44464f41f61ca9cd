"""The study's folder; :mod:`reports.tables.stability` says what is in it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from barchain.runs.job import Job, RunResult
from barchain.runs.store import RunStore
from barchain.studies.stability.evidence import evidence, plain_row
from reports.tables.outcome import Outcome
from reports.tables.run_rows import recorded_runs
from reports.tables.stability import TABLES

if TYPE_CHECKING:
    import pandas as pd

    from barchain.record.study_store import StudyStore
    from barchain.studies.stability.engine_runs import EngineRuns
    from barchain.studies.stability.expected import OutcomeChange
    from barchain.studies.stability.rules import Finding

MOST_BARS_KEPT = 2000  # a table has six columns a bar, and takes minutes to write beyond


class StabilityStore(RunStore):
    """Runs as a comparison keeps them, and the study's own tables."""

    def __init__(self, store: StudyStore, time_limit_s: float, order: list[tuple[str, str]]) -> None:
        """Start with empty tables; their rows are sorted by `order`, pairs of scene and engine."""
        super().__init__(store, order)
        self.time_limit_s = time_limit_s
        self.tables: dict[str, list[dict[str, Any]]] = {name: [] for name in TABLES}

    def earlier_runs(self) -> dict[str, dict[str, Any]]:
        """Runs that an interrupted study in the same folder recorded, by key.

        A time-out counts only if that study allowed a run at least as much time. A failure counts only if the engine
        gave a result that was rejected: the process of any other may have been killed.
        """
        short = float(self.study.earlier.get("time_limit_s") or 0.0) < self.time_limit_s
        runs = recorded_runs(self.study.earlier)
        return {
            run["key"]: run for run in runs if not (short and run["outcome"] == Outcome.TIMED_OUT) and not lost(run)
        }

    def recall(self, job: Job, earlier: dict[str, dict[str, Any]]) -> RunResult | None:
        """Result of `job` as an earlier study stored it, or None."""
        run = earlier.get(job.key)
        if run is None or run.get("file") is not None:
            found = super().recall(job, earlier)
            return None if found is None else replace(found, rejected=bool(run and run.get("rejected")))
        if run["outcome"] == Outcome.PASS:
            return None
        return RunResult(
            Outcome(run["outcome"]), run.get("reason", ""), None, run.get("seconds", {}), run.get("rejected", False)
        )

    def keep_run(self, job: Job, result: RunResult) -> None:
        """Write a run's trajectory and note it in record.json; no earlier trajectory stays beside a failure.

        Of very many bars none is kept, and is run again where a study is resumed.
        """
        if result.trajectory is None or job.scene.bars > MOST_BARS_KEPT:
            self.files.remove(self.file(job))
            result = replace(result, trajectory=None)
        super().keep_run(job, result)

    def keep_finding(
        self, engine_runs: EngineRuns, finding: Finding, before: str | None, changed: OutcomeChange | None
    ) -> None:
        """Write an outcome and its evidence."""
        self.tables["outcomes"].append(outcome_row(engine_runs.scene.name, engine_runs.name, finding, before, changed))
        self.tables["evidence"] += evidence(engine_runs)
        row = plain_row(engine_runs)
        if row is not None:
            self.tables["plain"].append(row)
            self.write("plain")
        self.write("outcomes")
        self.write("evidence")

    def keep_left_out(
        self, scene: str, engine: str, finding: Finding, before: str | None, changed: OutcomeChange | None
    ) -> None:
        """Write the outcome of an engine that was not run."""
        self.tables["outcomes"].append(outcome_row(scene, engine, finding, before, changed))
        self.write("outcomes")

    def keep_laws(self, rows: list[dict[str, Any]], series: pd.DataFrame) -> None:
        """Write laws and what they were fitted to."""
        self.tables["laws"] += rows
        self.tables["long"] += [{str(k): v for k, v in row.items()} for row in series.to_dict("records")]
        self.write("laws")
        self.write("long")

    def write(self, name: str) -> None:
        """Write one table, rows in the order of the scenes and engines of the plan."""
        place = self.place
        rows = sorted(self.tables[name], key=lambda r: place.get((r["scene"], r["engine"]), len(place)))
        self.study.write(name, rows)


def outcome_row(
    scene: str, engine: str, finding: Finding, before: str | None, changed: OutcomeChange | None
) -> dict[str, Any]:
    """Row of the table of outcomes."""
    law = finding.law
    return {
        "scene": scene,
        "engine": engine,
        "stability": str(finding.stability),
        "slow": finding.slow,
        "reason": finding.reason,
        "quantity": finding.quantity,
        "exponent": law and law.exponent,
        "low": law and law.low,
        "high": law and law.high,
        "at_end": law and law.at_end,
        "expected": before or "",
        "change": changed.direction if changed else "",
    }


def lost(run: dict[str, Any]) -> bool:
    """Whether a recorded run failed without a result, for whatever reason."""
    return run["outcome"] == Outcome.FAILED and not run.get("rejected")
