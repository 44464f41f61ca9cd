"""What stands beside an outcome: numbers of each run, laws of long ones, SciPy at its defaults, condition numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from adapters.common.initial_state import chain_model
from barchain.judge.checks.relative_energy import kinetic_ratio
from barchain.metrics.quantities import drifts
from barchain.run.job import Role
from barchain.studies.stability.engine_runs import LEVEL_WORDS, OTHER
from barchain.studies.stability.growth import attitude_error, growth_excess
from barchain.studies.stability.law import law
from reference_impl.model.complex_vectors import along
from reference_impl.model.joints import condition_number, joint_matrix
from reports.tables.outcome import Outcome
from reports.tables.stability import LAWS

if TYPE_CHECKING:
    from adapters.engine import Setting
    from adapters.trajectory import Array, Trajectory
    from barchain.judge.comparison import Row
    from barchain.solutions.reference import Truth
    from barchain.studies.stability.engine_runs import Seen
    from scenarios import Scene

MOST_BARS = 100  # a condition number costs N²
CONDITION_SAMPLES = 21
FOLLOWED = ("energy", "angular_momentum", "gap")
SERIES_POINTS = 400  # evenly spaced in log t


def evidence(seen: Seen) -> list[dict[str, Any]]:
    """A row for each run."""
    return [evidence_row(seen, role) for role in seen.levels]


def evidence_row(seen: Seen, role: Role) -> dict[str, Any]:
    """Numbers of one run."""
    result, trajectory, truth = seen.runs[role], seen.trajectory(role), seen.truth
    row: dict[str, Any] = {
        "scene": seen.scene.name,
        "engine": seen.name,
        "level": LEVEL_WORDS[role],
        "setting": str(seen.settings[role]),
        "run": str(result.outcome),
        "reason": result.reason,
        "mean_step_s": seen.mean_step_s(role),
        "simulate_s": result.seconds.get("simulate"),
    }
    if trajectory is not None:
        row |= {"steps": trajectory.info.get("steps")} | drift_numbers(seen.scene, trajectory)
    if trajectory is not None and truth is not None:
        row |= against_truth(trajectory, truth)
    return row | judged_numbers(seen.rows(role))


def drift_numbers(scene: Scene, trajectory: Trajectory) -> dict[str, float]:
    """Largest drift of each kind, and the exponent of the energy's."""
    found = drifts(scene, trajectory)
    row = {"gap_m" if k == "gap" else k: float(found[k].max()) for k in FOLLOWED if k in found}
    grown = law(trajectory.t_s, found["energy"]) if "energy" in found else None
    return row | ({"energy_exponent": grown.exponent} if grown else {})


def against_truth(trajectory: Trajectory, truth: Truth) -> dict[str, float | None]:
    """Differences from the truth that need no tolerance."""
    error = attitude_error(trajectory, truth)
    return {
        "attitude_rad": None if error is None else float(error[1].max()),
        "kinetic_ratio": kinetic_ratio(trajectory, truth),
        "growth_excess": growth_excess(trajectory, truth),
    }


def judged_numbers(rows: list[Row]) -> dict[str, Any]:
    """Worst ratio of each kind of check, the quantity it is of, and the horizon."""
    found: dict[str, Any] = {}
    for metric, name in (("consistency", "consistency_of"), ("band_used", "band_of")):
        own = [r for r in rows if r["metric"] == metric]
        if own:
            row = max(own, key=lambda r: float(r["value"]))
            found |= {metric: float(row["value"]), name: row["quantity"], "horizon_s": row["horizon_s"]}
    return found


def condition_range(scene: Scene, truth: Truth) -> tuple[float, float] | None:
    """Least and largest condition number of the joint system along the truth; None of chains of too many bars."""
    angle = truth.trajectory.angle_rad
    if angle is None or scene.bars > MOST_BARS:
        return None
    model = chain_model(scene)
    at = np.unique(np.linspace(0, len(angle) - 1, CONDITION_SAMPLES).astype(int))
    found = [condition_number(joint_matrix(model, 1j * along(angle[k]))) for k in at]
    return min(found), max(found)


def plain_row(seen: Seen) -> dict[str, Any] | None:
    """A SciPy solver at its own default tolerances; None of other engines, and without a truth."""
    result = seen.runs.get(Role.PLAIN)
    if result is None or seen.truth is None:
        return None
    trajectory = seen.trajectory(Role.PLAIN)
    error = attitude_error(trajectory, seen.truth) if trajectory is not None else None
    main = seen.runs.get(OTHER[Role.PLAIN])
    verdict = seen.verdicts.get(Role.PLAIN) if main is not None and main.outcome is Outcome.PASS else None
    return {
        "scene": seen.scene.name,
        "engine": seen.name,
        "run": str(result.outcome),
        "reason": result.reason,
        "attitude_rad": None if error is None else float(error[1].max()),
        "judged": "" if verdict is None else str(verdict.outcome),
        "seconds": result.seconds.get("simulate"),
    }


def followed(scene: Scene, trajectory: Trajectory, truth: Truth | None) -> dict[str, tuple[Array, Array]]:
    """What is followed over time in a long scene: its energy's drift, and the attitude's difference from the truth."""
    found = {}
    if "energy" in (kept := drifts(scene, trajectory)):
        found["energy"] = trajectory.t_s, kept["energy"]
    error = None if truth is None or trajectory is truth.trajectory else attitude_error(trajectory, truth)
    if error is not None:
        found["attitude"] = error
    return found


def laws(
    scene: Scene, engine: str, level: str, setting: Setting, trajectory: Trajectory, truth: Truth | None
) -> tuple[list[dict[str, Any]], pd.DataFrame]:
    """Laws of one run's drifts in a long scene, and the drifts themselves, thinned evenly in log t."""
    rows, series = [], []
    named = {"scene": scene.name, "engine": engine, "level": level}
    for quantity, (t, size) in followed(scene, trajectory, truth).items():
        found = law(t, size)
        if found is not None:
            values = (found.exponent, found.low, found.high, found.at_end)
            rows.append(named | dict(zip(LAWS[3:], (str(setting), quantity, *values), strict=True)))
        largest = np.maximum.accumulate(np.abs(size))
        at = np.unique(np.geomspace(1, len(t), SERIES_POINTS).astype(int)) - 1
        series.append(pd.DataFrame(named | {"quantity": quantity, "t_s": t[at], "value": largest[at]}))
    return rows, pd.concat(series, ignore_index=True) if series else pd.DataFrame()
