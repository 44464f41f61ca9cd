"""Conventions: a first run, types and shapes of its result, and the state at t = 0, channel by channel."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import EngineError
from barchain.conform.checks import Check, CheckState, Group
from barchain.conform.physics import ask_about_scenes, main_run, reason_against
from barchain.conform.runs import TIME_LIMITS, ended_early
from barchain.conform.scenes import FIRST, scene_of, solved
from barchain.judge.checks.whole_run import rounded_values
from barchain.judge.error_model import ErrorModel
from barchain.metrics.quantities import differences
from reports.tables.crossval import QUANTITY_UNITS
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.trajectory import Array, Trajectory
    from barchain.conform.target import Examined
    from barchain.runs.job import RunResult

PAGE = "docs/explanation/engine_conventions.md"
FIELDS = {
    "com": ("com_m", "centre of mass", "centre-of-mass"),
    "com_velocity": ("com_velocity_m_s", "velocity of the centre of mass", "centre-of-mass"),
    "attitude": ("angle_rad", "angles", "angles"),
    "rate": ("rate_rad_s", "rates", "rates"),
    "reaction": ("reaction_N", "reactions", "reactions"),
}
"""Array, name and section of the page of each quantity at the start"""
FIRST_RUN = "a first run"
START_SLACK = 1e-9
"""Largest difference at t = 0 relative to a quantity's scale: nothing was integrated yet, and absolute coordinates
keep nine digits of a bar's angle"""


def conventions(engine: Examined) -> Iterator[Check]:
    """Checks of the form of a result, and of its first sample."""
    ask_about_scenes(engine)
    name = next((n for n in FIRST if reason_against(engine, n) is None), None)
    if name is None:
        reasons = dict.fromkeys(str((reason_against(engine, n) or ("", ""))[1]) for n in FIRST)
        said = f"supports none of {', '.join(FIRST)}: {'; '.join(reasons)}"
        yield Check(Group.CONVENTIONS, FIRST_RUN, CheckState.FAILED, said, PAGE)
        return
    engine.note(f"conventions: a first run, of {name}")
    run = main_run(engine, name)
    if run.outcome is not Outcome.PASS or run.trajectory is None:
        yield Check(Group.CONVENTIONS, FIRST_RUN, CheckState.FAILED, run.reason, page_of(run), scene=name)
        return
    early = ended_early(scene_of(name), run.trajectory)
    if early:
        yield Check(Group.CONVENTIONS, FIRST_RUN, CheckState.FAILED, early, f"{PAGE}#landing", scene=name)
        return
    n = len(run.trajectory.t_s)
    said = f"{len(run.trajectory.observables)} quantities of {n} samples, float64"
    yield Check(Group.CONVENTIONS, FIRST_RUN, CheckState.PASSED, said, f"{PAGE}#samples", scene=name)
    yield precision_check(run.trajectory, name)
    yield from start_checks(engine, name, run.trajectory)


def precision_check(run: Trajectory, scene: str) -> Check:
    """Check that no quantity was computed or kept in single precision, or rounded to decimals."""
    said = rounded_values(run, solved(scene)) or ""
    state = CheckState.FAILED if said else CheckState.PASSED
    return Check(Group.CONVENTIONS, "double precision", state, said, f"{PAGE}#samples", scene=scene)


def page_of(run: RunResult) -> str:
    """Page on the reason why a first run gave no result."""
    if run.outcome is Outcome.TIMED_OUT:
        return TIME_LIMITS
    return f"{PAGE}#{'declarations' if 'does not declare' in run.reason else 'samples'}"


def start_checks(engine: Examined, name: str, run: Trajectory) -> Iterator[Check]:
    """Checks of each quantity's first sample."""
    solution, loaded = solved(name), engine.load()
    try:
        errors = ErrorModel(loaded, loaded.sweep.setting(), solution, run)
        bound, scale = errors.bound, errors.scale
    except EngineError as error:
        yield Check(Group.CONVENTIONS, "declared noise", CheckState.FAILED, str(error), f"{PAGE}#declarations")
        return
    apart = differences(run, solution.trajectory)
    for quantity, (field, words, section) in FIELDS.items():
        if quantity not in apart:
            continue
        allowed = float(bound[quantity][0]) + START_SLACK * scale[quantity]
        page = f"{PAGE}#{section}"
        if float(apart[quantity][0]) <= allowed:
            yield Check(Group.CONVENTIONS, f"{words} at t = 0", CheckState.PASSED, page=page)
        else:
            said = given_and_expected(getattr(run, field)[0], getattr(solution.trajectory, field)[0])
            yield Check(Group.CONVENTIONS, f"{words} at t = 0", CheckState.FAILED, f"{said} {QUANTITY_UNITS[quantity]}",
                        page, scene=name)  # fmt: skip


def given_and_expected(given: Array, expected: Array) -> str:
    """The two values as text."""
    said = f"given {text_of(given)}, expected {text_of(expected)}"
    same = text_of(given) == text_of(expected)
    return f"{said}, difference {text_of(given - expected)}" if same else said


def text_of(values: Array) -> str:
    """Numbers with six digits."""
    rows = np.atleast_1d(values).tolist()
    cells = [f"({', '.join(f'{v:.6g}' for v in r)})" if isinstance(r, list) else f"{r:.6g}" for r in rows]
    return f"({', '.join(cells)})"
