"""All checks of an engine, in order; a failure ends what it makes meaningless."""

from __future__ import annotations

import time
import traceback
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from barchain.conform.accuracy import accuracy
from barchain.conform.behaviour import behaviour
from barchain.conform.checks import FAILED, NOT_RUN, Check, ConformanceReport, Group
from barchain.conform.conventions import FIRST_RUN, conventions, loading
from barchain.conform.physics import physics
from barchain.conform.target import PHYSICS_RUNS, RUN_S, WHOLE, Extent, examined
from barchain.runs.environment import NoProcessError
from barchain.runs.message import plain_text
from barchain.runs.phases import line

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from barchain.conform.target import Examined

PAGE = "docs/howto/conform.md"
CONVENTIONS = "docs/explanation/engine_conventions.md"
PAGES = {
    Group.LOADING: f"{CONVENTIONS}#declarations",
    Group.CONVENTIONS: CONVENTIONS,
    Group.PHYSICS: CONVENTIONS,
    Group.ACCURACY: f"{PAGE}#accuracy",
    Group.BEHAVIOUR: f"{PAGE}#behaviour",
}
"""Page on the checks of a group that name none themselves"""
MISTAKE = "known mistake"
"""Entry of a failure that a known mistake explains; an unexplained one may be a matter of accuracy"""


def conform(
    given: str,
    report: Callable[[Check], None] = lambda _: None,
    *,
    extent: Extent = WHOLE,
    note: Callable[[str], None] = lambda _: None,
) -> ConformanceReport:
    """Examine an engine.

    Parameters
    ----------
    given : str
        Name of a registered engine, or ``module:Class``.
    report : callable, optional
        Called with each check as it is done.
    extent : Extent, optional
        Groups, scenes and time limit; everything by default.
    note : callable, optional
        Called with a sentence before checks that take long.

    Raises
    ------
    UnknownEngineError
        If no engine has the name.
    """
    end = time.monotonic() + PHYSICS_RUNS * extent.time_limit_s
    engine = replace(examined(given), run_s=extent.time_limit_s, note=note, end=end)
    before = start = time.perf_counter()
    found: list[Check] = []
    for made in checks(engine, extent):
        check = replace(made, seconds=(now := time.perf_counter()) - before)
        found.append(check)
        report(check)
        before = now
    seconds = time.perf_counter() - start
    return ConformanceReport(given, engine.registration.version, tuple(found), seconds, extent.whole)


def assert_conforms(given: str, *, time_limit_s: float = RUN_S) -> None:
    """Raise an AssertionError that names each failure, if an engine does not conform.

    Parameters
    ----------
    given : str
        Name of a registered engine, or ``module:Class``.
    time_limit_s : float, optional
        Longest time of one run after the start of its process, s: building, compiling and integrating.

    Raises
    ------
    AssertionError
        If a check fails.
    UnknownEngineError
        If no engine has the name.
    """
    report = conform(given, extent=Extent(time_limit_s=time_limit_s))
    if not report.passed:
        lines = [f"{c.group}, {c.name}: {c.words} ({c.page})" for c in report.failures]
        raise AssertionError("\n".join([f"{report.engine} does not conform:", *(lines or ["no scene was passed"])]))


def guarded(made: Iterator[Check]) -> Iterator[Check]:
    """Checks of a group; an exception in one becomes a failed check, and ends the group."""
    try:
        yield from made
    except NoProcessError:
        raise
    except Exception as error:
        frame, number = list(traceback.walk_tb(error.__traceback__))[-1]
        words = f"{type(error).__name__}: {plain_text(error)} ({line(frame, number)})"
        yield Check("examination", FAILED, f"ended by an exception: {words}", PAGE)


def checks(engine: Examined, extent: Extent = WHOLE) -> Iterator[Check]:
    """Checks of an extent in order."""
    failed: dict[str, str] = {}
    for group, make, needs in (
        (Group.LOADING, loading, ()),
        (Group.CONVENTIONS, conventions, (Group.LOADING,)),
        (Group.PHYSICS, partial(physics, stages=extent.stages), (Group.LOADING,)),
        (Group.ACCURACY, accuracy, (Group.LOADING, MISTAKE)),
        (Group.BEHAVIOUR, behaviour, (Group.LOADING,)),
    ):
        if group not in extent.groups:
            continue
        reason = next((failed[g] for g in needs if g in failed), failed.get(FIRST_RUN, ""))
        if reason:
            yield Check(str(group), NOT_RUN, f"{reason} fails", group=group)
            continue
        for check in guarded(make(engine)):
            if check.state is FAILED:
                failed.setdefault(group, check.name)
                if check.name == FIRST_RUN:
                    failed[FIRST_RUN] = check.name
                if check.explained:
                    failed.setdefault(MISTAKE, check.name)
            yield replace(check, group=group, page=check.page or PAGES[group])
