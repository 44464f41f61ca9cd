"""Loading and conventions: entry point, class, declarations, the import; a first run, and its state at t = 0."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.command.entries import deciding_files, unpacked
from adapters.engine import AccuracyParameter, EngineError
from adapters.registry import engines
from barchain.conform.checks import FAILED, PASSED, WARNING, Check
from barchain.conform.physics import ask_about_scenes, main_run, reason_against
from barchain.conform.runs import TIME_LIMITS, collapse, ended_early
from barchain.conform.scenes import FIRST, solved
from barchain.judge.checks.whole_run import rounded_values
from barchain.judge.error_model import ErrorModel
from barchain.metrics.quantities import differences
from barchain.runs import examination
from barchain.runs.asking import ask
from reports.results.outcome import Outcome
from scenarios import nearest
from scenarios.channels import COMPARED
from scenarios.effect_types import all_effect_names

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.trajectory import Array, Trajectory
    from barchain.conform.target import Examined
    from barchain.runs.asking import Reply
    from barchain.runs.job import RunResult

SLOW_IMPORT_S = 1.0
"""Import of an adapter from which on users wait at every command that lists engines"""
CLASS = ("import", "class")
"""Steps before the declarations"""
PAGE = "docs/explanation/engine_conventions.md"
FIRST_RUN = "a first run"
START_SLACK = 1e-9
"""Largest difference at t = 0 relative to a quantity's scale: nothing was integrated yet, and absolute coordinates
keep nine digits of a bar's angle"""


def loading(engine: Examined) -> Iterator[Check]:
    """Checks of the entry point, the import, the class and its declarations."""
    yield name_check(engine)
    reply = ask(examination.examined_class, engine.registration)
    if reply.problem:
        yield Check("import", FAILED, reply.problem)
        return
    steps = reply.header["steps"]
    for name, fault in steps:
        if fault:
            yield Check(str(name), FAILED, str(fault))
    if any(fault for _, fault in steps):
        return
    yield Check("class", PASSED, engine.registration.target)
    yield Check("declarations", PASSED, f"{len(steps) - len(CLASS)} of the right types")
    yield effects_check(reply)
    yield order_check(engine)
    if not engine.registration.entry:  # a program's class is barchain's
        yield import_check(reply)


def name_check(engine: Examined) -> Check:
    """Check that a distribution provides the engine, or tell how a class is registered."""
    r = engine.registration
    if r.missing:
        return Check("entry point", FAILED, r.missing)
    if not engine.registered:
        known = next((name for name, other in engines().items() if other.target == r.target), "")
        if known:
            return Check("entry point", PASSED, f"registered as {known}")
        said = f'none; `{engine.name} = "{r.target}"` under [project.entry-points."barchain.engines"] registers it'
        return Check("entry point", WARNING, said)
    if not engine.own and r.version == "none":
        said = "no distribution provides it, so that results can't be told apart by its version"
        return Check("entry point", FAILED, said)
    if r.entry:
        folder, entry = unpacked(r.entry)
        files = deciding_files(folder, entry)
        said = f"version {r.version}, of its entry and {', '.join(files)}"
        lacking = "names no files, so that results can't be told apart by their contents"
        state, words = (PASSED, said) if files else (WARNING, lacking)
        return Check("entry point", state, f"{engine.name} in {folder}: {words}")
    provided = f"{r.distribution or r.requires or 'barchain'} {r.version}"
    return Check("entry point", PASSED, f"{engine.name} of {provided}")


def effects_check(reply: Reply) -> Check:
    """Check that all declared effects are effects of scenes."""
    known, said = all_effect_names(), reply.header["effects"]
    unknown = [name for name in said if name not in known]
    if unknown:
        words = "; ".join(f"{name!r} is no effect{nearest(name, known)}" for name in unknown)
        return Check("effect names", FAILED, words)
    return Check("effect names", PASSED, f"{len(said)} of {len(known)}, each model of gravity counted by itself")


def order_check(engine: Examined) -> Check:
    """Check that a method has an order exactly if it takes equal steps."""
    loaded = engine.declarations
    chooses = loaded.sweep.parameter is AccuracyParameter.RTOL
    if chooses and loaded.order is not None:
        said = f"order is {loaded.order:g}, though the method chooses its steps; expected None"
        return Check("order and setting", FAILED, said)
    if not chooses and loaded.order is None:
        said = "order is None, though the method takes equal steps; expected its order"
        return Check("order and setting", FAILED, said)
    said = "chooses its steps" if chooses else f"equal steps of order {loaded.order:g}"
    return Check("order and setting", PASSED, said)


def import_check(reply: Reply) -> Check:
    """Check that the import is quick, and that libraries are imported inside methods only."""
    seconds, libraries = float(reply.header["import_s"]), reply.header["libraries"]
    if libraries:
        said = f"imports {', '.join(libraries)} at its top ({seconds:.2f} s); import inside methods"
        return Check("time of import", WARNING, said)
    state = WARNING if seconds > SLOW_IMPORT_S else PASSED
    return Check("time of import", state, f"{seconds:.2f} s")


def conventions(engine: Examined) -> Iterator[Check]:
    """Checks of the form of a result, and of its first sample."""
    ask_about_scenes(engine)
    name = next((n for n in FIRST if reason_against(engine, n) is None), None)
    if name is None:
        reasons = dict.fromkeys(str((reason_against(engine, n) or ("", ""))[1]) for n in FIRST)
        yield Check(FIRST_RUN, FAILED, f"supports none of {', '.join(FIRST)}: {'; '.join(reasons)}")
        return
    engine.note(f"conventions: a first run, of {name}")
    run = main_run(engine, name, engine.declarations)
    if run.outcome is not Outcome.PASS or run.trajectory is None:
        yield Check(FIRST_RUN, FAILED, f"{run.reason}{collapse(engine, name, run)}", page_of(run), scene=name)
        return
    if said := collapse(engine, name, run):
        took = f"{run.seconds['simulate']:.1f} s for a run of {name}"
        yield Check(FIRST_RUN, FAILED, f"{took}{said}", TIME_LIMITS, scene=name)
        return
    early = ended_early(engine.scene(name), run.trajectory)
    if early:
        yield Check(FIRST_RUN, FAILED, early, f"{PAGE}#landing", scene=name)
        return
    n = len(run.trajectory.t_s)
    said = f"{len(run.trajectory.observables)} quantities of {n} samples, float64"
    yield Check(FIRST_RUN, PASSED, said, f"{PAGE}#samples", scene=name)
    rounded = rounded_values(run.trajectory, solved(engine.scene(name))) or ""
    yield Check("double precision", FAILED if rounded else PASSED, rounded, f"{PAGE}#samples", scene=name)
    yield from start_checks(engine, name, run.trajectory)


def page_of(run: RunResult) -> str:
    """Page on the reason why a first run gave no result."""
    if run.outcome is Outcome.TIMED_OUT:
        return TIME_LIMITS
    return f"{PAGE}#{'declarations' if run.outcome is Outcome.MALFORMED else 'samples'}"


def start_checks(engine: Examined, name: str, run: Trajectory) -> Iterator[Check]:
    """Checks of each quantity's first sample."""
    solution, loaded = solved(engine.scene(name)), engine.declarations
    try:
        errors = ErrorModel(loaded, loaded.sweep.setting(), solution, run)
        bound, scale = errors.bound, errors.scale
    except EngineError as error:
        yield Check("declared noise", FAILED, str(error), f"{PAGE}#declarations")
        return
    apart = differences(run, solution.trajectory)
    for channel in COMPARED:
        quantity, words = channel.name, channel.words
        if quantity not in apart:
            continue
        allowed = float(bound[quantity][0]) + START_SLACK * scale[quantity]
        page = f"{PAGE}#{channel.section}"
        if float(apart[quantity][0]) <= allowed:
            yield Check(f"{words} at t = 0", PASSED, page=page)
        else:
            said = given_and_expected(*(getattr(motion, channel.array)[0] for motion in (run, solution.trajectory)))
            yield Check(f"{words} at t = 0", FAILED, f"{said} {channel.unit}", page, scene=name)


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
