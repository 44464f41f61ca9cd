"""Evidence beside an outcome: numbers of each run, laws of long ones, SciPy at its defaults, condition numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from adapters.common.reference_model import chain_model
from barchain.judge.checks.beyond_limit import kinetic_ratio
from barchain.metrics.quantities import drifts
from barchain.runs.job import Role
from barchain.studies.stability.rules import LEVEL_WORDS, OTHER, attitude_error, growth_excess, law
from reference_impl.model.complex_vectors import unit_along
from reference_impl.model.joints import condition_number, joint_matrix
from reports.results.outcome import Outcome
from reports.results.rows import NOT_RUN

if TYPE_CHECKING:
    from adapters.engine import Setting
    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.stability.rules import EngineRuns
    from scenarios import Scene

MOST_BARS = 100  # a condition number costs N²
CONDITION_SAMPLES = 21
FOLLOWED = ("energy", "angular_momentum", "gap")
SERIES_POINTS = 400  # evenly spaced in log t


def evidence(engine_runs: EngineRuns) -> list[dict[str, Any]]:
    """A row for each run: drifts, differences from the reference solution that need no tolerance, worst ratios."""
    rows = []
    for role in engine_runs.levels:
        result, trajectory, solution = engine_runs.runs[role], engine_runs.trajectory(role), engine_runs.solution
        row: dict[str, Any] = {
            "scene": engine_runs.scene.name,
            "engine": engine_runs.name,
            "level": LEVEL_WORDS[role],
            "setting": str(engine_runs.settings[role]),
            "run": NOT_RUN if role in engine_runs.not_run else str(result.outcome),
            "reason": result.reason.removeprefix(f"{NOT_RUN}: "),
            "mean_step_s": engine_runs.mean_step_s(role),
            "simulate_s": result.seconds.get("simulate"),
        }
        if trajectory is not None:
            found = drifts(engine_runs.scene, trajectory)
            row |= {"gap_m" if k == "gap" else k: float(found[k].max()) for k in FOLLOWED if k in found}
            grown = law(trajectory.t_s, found["energy"]) if "energy" in found else None
            row |= {"steps": trajectory.info.get("steps"), "energy_exponent": grown and grown.exponent}
        if trajectory is not None and solution is not None:
            error = attitude_error(trajectory, solution)
            row |= {
                "attitude_rad": None if error is None else float(error[1].max()),
                "kinetic_ratio": kinetic_ratio(trajectory, solution),
                "growth_excess": growth_excess(trajectory, solution),
            }
        for metric, name in (("normalised_error", "normalised_error_of"), ("bound_ratio", "bound_of")):
            own = [r for r in engine_runs.rows(role) if r["metric"] == metric]
            if own:
                largest = max(own, key=lambda r: float(r["value"]))
                row |= {metric: float(largest["value"]), name: largest["quantity"], "limit_s": largest["limit_s"]}
        rows.append(row)
    return rows


def condition_range(scene: Scene, solution: ReferenceSolution) -> tuple[float, float] | None:
    """Least and largest condition number of the joint system along the reference solution; None of too many bars."""
    angle = solution.trajectory.angle_rad
    if angle is None or scene.bars > MOST_BARS:
        return None
    model = chain_model(scene)
    at = np.unique(np.linspace(0, len(angle) - 1, CONDITION_SAMPLES).astype(int))
    found = [condition_number(joint_matrix(model, 1j * unit_along(angle[k]))) for k in at]
    return min(found), max(found)


def plain_row(engine_runs: EngineRuns) -> dict[str, Any] | None:
    """A SciPy solver at its own default tolerances; None of other engines, and without a reference solution."""
    result = engine_runs.runs.get(Role.PLAIN)
    if result is None or engine_runs.solution is None:
        return None
    trajectory = engine_runs.trajectory(Role.PLAIN)
    error = attitude_error(trajectory, engine_runs.solution) if trajectory is not None else None
    main = engine_runs.runs.get(OTHER[Role.PLAIN])
    verdict = engine_runs.verdicts.get(Role.PLAIN) if main is not None and main.outcome is Outcome.PASS else None
    return {
        "scene": engine_runs.scene.name,
        "engine": engine_runs.name,
        "run": str(result.outcome),
        "reason": result.reason,
        "attitude_rad": None if error is None else float(error[1].max()),
        "judged": "" if verdict is None else str(verdict.outcome),
        "seconds": result.seconds.get("simulate"),
    }


def followed(
    scene: Scene, trajectory: Trajectory, solution: ReferenceSolution | None
) -> dict[str, tuple[Array, Array]]:
    """Quantities followed over time in a long scene: drift of the energy, error of the attitude."""
    found = {}
    if "energy" in (kept := drifts(scene, trajectory)):
        found["energy"] = trajectory.t_s, kept["energy"]
    error = None if solution is None or trajectory is solution.trajectory else attitude_error(trajectory, solution)
    if error is not None:
        found["attitude"] = error
    return found


def laws(
    scene: Scene, engine: str, level: str, setting: Setting, trajectory: Trajectory, solution: ReferenceSolution | None
) -> tuple[list[dict[str, Any]], pd.DataFrame]:
    """Laws of one run's drifts in a long scene, and the drifts themselves, thinned evenly in log t."""
    rows, series = [], []
    named = {"scene": scene.name, "engine": engine, "level": level}
    for quantity, (t, size) in followed(scene, trajectory, solution).items():
        found = law(t, size)
        if found is not None:
            law_columns = {name: getattr(found, name) for name in ("exponent", "low", "high", "at_end")}
            rows.append(named | {"setting": str(setting), "quantity": quantity} | law_columns)
        largest = np.maximum.accumulate(np.abs(size))
        at = np.unique(np.geomspace(1, len(t), SERIES_POINTS).astype(int)) - 1
        series.append(pd.DataFrame(named | {"quantity": quantity, "t_s": t[at], "value": largest[at]}))
    return rows, pd.concat(series, ignore_index=True) if series else pd.DataFrame()
