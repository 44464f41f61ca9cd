"""Declared noise in the verdict on a scene: noise that hides all, noise that makes a pass, errors that are no noise.

Noise differs from setting to setting. An error that is the same at two settings is none, whatever is declared.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from adapters.engine import Declarations, EngineError
from barchain.conform.checks import FAILED, WARNING, CheckState
from barchain.judge.compare import judge
from barchain.judge.residuals import worst
from barchain.judge.scales import declared_noise, max_noise, scales
from barchain.judge.verdict import JUDGED_METRICS
from barchain.metrics.quantities import FIELDS, TRACK, differences
from reports.results.outcome import Outcome
from scenarios.channels import UNITS, WORDS

if TYPE_CHECKING:
    from adapters.engine import Setting
    from adapters.trajectory import Trajectory
    from barchain.judge.evidence import Evidence
    from barchain.judge.verdict import Row, Verdict
    from barchain.runs.job import RunResult
    from barchain.solutions.reference import ReferenceSolution

COMMON_SHARE = 0.1
"""Largest difference of two runs at different settings, relative to their error, at which both have the same error"""


NEEDED = 2.0
"""Least ratio to what is allowed without noise at which noise is what makes a pass"""
DIFFERENCES = frozenset({"normalised_error", "bound_ratio"})
"""Metrics of the whole difference from the solution; others tell of parts that are smaller than the method's error"""


def quiet(engine: Declarations) -> Declarations:
    """The same declarations without noise."""
    return replace(engine, questions=tuple(question for question in engine.questions if question != "noise"))


def noise_fault(engine: Declarations, setting: Setting, solution: ReferenceSolution) -> str:
    """Fault of declared noise that is larger at the end than a quantity of the scene; empty without one.

    The verdict believes no such noise, and would pass a right result: nobody would see the wrong declaration.
    """
    try:
        said = declared_noise(engine, setting, solution, solution.trajectory.t_s)
    except EngineError as error:
        return str(error)
    size = scales(solution)
    for quantity, values in said.items():
        if float(values[-1]) > size.get(quantity, math.inf):
            unit, words = UNITS[quantity], WORDS[quantity]
            return (
                f"declared noise of {values[-1]:.3g} {unit} is larger than the {words} of the scene, "
                f"{size[quantity]:.3g} {unit}: nothing can be judged"
            )
    return ""


def agrees_but_forces(engine: Declarations, setting: Setting, evidence: Evidence, solution: ReferenceSolution) -> bool:
    """Whether a scene that noise makes unjudgeable passes without the forces that are too noisy.

    In absolute coordinates some methods get forces as differences of huge numbers over a step: their motion is still
    judged.
    """
    size = scales(solution)
    noise = declared_noise(engine, setting, solution, solution.trajectory.t_s)
    over = {name for name, values in noise.items() if float(values.max()) > max_noise(name, size)}
    if not engine.coordinates.absolute or not over <= {"reaction", "torque"}:
        return False
    hidden: dict[str, Any] = dict.fromkeys(FIELDS[name] for name in over)

    def shown(result: RunResult) -> RunResult:
        return result if result.trajectory is None else replace(result, trajectory=result.trajectory.replace(**hidden))

    rest = replace(evidence, main=shown(evidence.main), finer=shown(evidence.finer))
    return judge(engine.title, engine, setting, rest, solution).outcome is Outcome.PASS


def needed_noise(
    verdict: Verdict, engine: Declarations, setting: Setting, evidence: Evidence, solution: ReferenceSolution
) -> tuple[CheckState, str] | None:
    """State and words where declared noise makes a pass; None where it does not.

    Parameters
    ----------
    verdict : Verdict
        With the declared noise.
    engine : Declarations
    setting : Setting
    evidence : Evidence
        Runs of the verdict.
    solution : ReferenceSolution
    """
    if not engine.declares_noise:
        return None
    bare = judge(engine.title, quiet(engine), setting, evidence, solution)
    main, finer = evidence.main.trajectory, evidence.finer.trajectory
    if bare.outcome in (Outcome.PASS, verdict.outcome) or main is None or finer is None:
        return None
    row = first_rejected(bare)
    if row is None or row["value"] < NEEDED or row["quantity"] not in differences(main, solution.trajectory):
        return None
    quantity, t_s = row["quantity"], solution.trajectory.t_s
    sizes = {q: float(v.max()) for q, v in declared_noise(engine, setting, solution, t_s).items() if v.max() > 0.0}
    declared = ", ".join(f"{v:.2g} {UNITS[q]} of the {WORDS.get(q, q)}" for q, v in sizes.items())
    error, apart = error_and_scatter(bare, quantity, main, finer, solution)
    unit, words = UNITS[quantity], WORDS[quantity]
    if row["metric"] not in DIFFERENCES:  # smaller than the method's own error
        return WARNING, f"passes by its declared noise alone, {declared}: without it, of the {words}, {row['reason']}"
    if quantity not in TRACK and apart < COMMON_SHARE * error:
        return FAILED, (
            f"{words} are off by {error:.2g} {unit} at two settings, and differ by {apart:.2g} {unit} between them: "
            f"such an error is no noise, though noise is declared, {declared}"
        )
    off, at_s = error_beyond(bare, row)
    said = f"{words} are off by {off:.2g} {unit} at t = {at_s:.6g} s, declared are {declared}"
    return WARNING, f"passes by its declared noise alone: {said}"


def first_rejected(verdict: Verdict) -> Row | None:
    """First judged row of a verdict that is no pass, those of whole differences before others; None without one."""
    good = (Outcome.PASS, Outcome.REPORTED)
    rows = [r for r in verdict.rows if r["metric"] in JUDGED_METRICS and Outcome(r["outcome"]) not in good]
    rows = [r for r in rows if r["quantity"] in FIELDS]
    return min(rows, key=lambda r: r["metric"] not in DIFFERENCES, default=None)


def error_beyond(verdict: Verdict, row: Row) -> tuple[float, float]:
    """Error of a row's quantity where it is largest relative to what is allowed, and that instant in s.

    The largest error may be one of the method, and lie elsewhere.
    """
    series: Any = verdict.series
    allowed = f"{row['quantity']}_{'bound' if row['metric'] == 'bound_ratio' else 'tolerance'}"
    t_s, size, most = (series[name].to_numpy() for name in ("t_s", f"{row['quantity']}_difference", allowed))
    _, at = worst(size, most, t_s <= row["limit_s"])
    return float(size[at]), float(t_s[at])


def error_and_scatter(
    verdict: Verdict, quantity: str, main: Trajectory, finer: Trajectory, solution: ReferenceSolution
) -> tuple[float, float]:
    """Largest error of a quantity where it is compared, and largest difference of the runs at two settings there."""
    limit_s = next(r["limit_s"] for r in verdict.rows if r["quantity"] == quantity)
    found = (differences(main, other)[quantity] for other in (solution.trajectory, finer))
    error, apart = (float(v[main.t_s[: len(v)] <= limit_s].max(initial=0.0)) for v in found)
    return error, apart
