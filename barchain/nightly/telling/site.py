"""Results of a whole history: of each engine in each scene the latest verdict, error and time at equal error."""

from __future__ import annotations

from collections import defaultdict
from itertools import pairwise, takewhile
from typing import TYPE_CHECKING

from barchain.nightly.figures.figure import FigureKind
from barchain.nightly.figures.table import PROGRAM, versions_of
from barchain.nightly.history.news import told_by
from barchain.nightly.telling.trends import curve_name, trend_charts
from reports.results.cost import REACHED
from reports.results.nights.site import Measured, PairResult, SiteFile, Unmeasured
from reports.results.outcome import Outcome
from reports.results.stability import Stability

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from barchain.nightly.figures.figure import Figure, FigureIdentity, NightSummary
    from barchain.nightly.history.levels import JudgedNight
    from barchain.nightly.history.nights import NightStore
    from reports.results.nights.document import NightlyFile
    from reports.results.nights.trends import TrendCurve

    Series = list[tuple[NightSummary, Figure]]
    Choice = tuple[FigureIdentity, Series]
    Curves = Mapping[tuple[str, str, str, str], TrendCurve]

VERDICTS = ("verdict", "stability.class")
ERRORS = ("attitude.first_orbit_max", "attitude.max", "com.first_orbit_max", "com.max")
"""Error that is shown, the first that an engine has: one that follows a particle has no attitude"""
TIME, REACH = "cost.time_ratio", "cost.reach"
TARGET = 1e-6
"""Error of the attitude at which times are shown, rad: of an engine that does not reach it, the next larger one"""
SKIPPED = frozenset({Outcome.UNSUPPORTED, Outcome.MISSING, Stability.UNSUPPORTED})
"""Verdicts on what was not run"""
NO_TIME = f"time at {TARGET:g} rad"


def site_file(store: NightStore, judged: JudgedNight, facts: NightlyFile) -> SiteFile:
    """Latest results of all pairs of an engine and a scene.

    Parameters
    ----------
    store : NightStore
    judged : JudgedNight
        The latest night, for earlier names of figures.
    facts : NightlyFile
        Of the same night, for what is worse than accepted.

    Raises
    ------
    HistoryError
        If the history holds none, or can't be read.
    """
    nights = [night for night in store.nights() if night.void is None]
    charts = trend_charts(store.numbers(), nights, told_by(store), judged.earlier)
    curves = {(c.scene, c.engine, one.kind, one.quantity): one for c in charts for one in c.curves}
    pairs: dict[tuple[str, str], list[Choice]] = defaultdict(list)
    patterns = (*(f"*:{name}" for name in (*VERDICTS, *ERRORS, REACH)), f"*:{TIME}/*")
    for identity, series in store.series(*patterns).items():
        own = [(night, figure) for night, figure in series if night.void is None]
        if own and identity.engine:
            pairs[identity.engine, identity.scene].append((identity, own))
    worse: dict[tuple[str, str], list[str]] = defaultdict(list)
    for change in (*facts.standing, *facts.changes):
        if change.direction == "worse" and change.accepted is None:
            worse[change.engine, change.scene].append(change.since)
    found, unmeasured = [], defaultdict(list)
    for (engine, scene), choices in sorted(pairs.items()):
        pair = pair_of(engine, scene, choices, curves, min(worse[engine, scene], default=""))
        found.append(pair)
        for what, reason in lacking(pair, choices, nights[-1]):
            unmeasured[engine, what, reason].append(scene)
    return SiteFile(
        tuple(night.name for night in nights), tuple(found), releases(pairs, nights),
        tuple(Unmeasured(*key, tuple(scenes)) for key, scenes in unmeasured.items()),
    )  # fmt: skip


def pair_of(engine: str, scene: str, choices: Sequence[Choice], curves: Curves, worse: str) -> PairResult:
    """Latest results of a pair: of several figures that may stand for one, that with the latest result."""

    def latest(fits: Callable[[FigureIdentity], bool], order: Callable[[FigureIdentity], float]) -> Measured | None:
        known = [(i, own) for i, series in choices if fits(i) and (own := [s for s in series if not s[1].missing])]
        chosen = max(known, key=lambda one: (one[1][-1][0].started, -order(one[0])), default=None)
        return None if chosen is None else measured(*chosen, curves)

    verdict = latest(lambda i: i.quantity in VERDICTS, lambda i: VERDICTS.index(i.quantity))
    error = latest(lambda i: i.quantity in ERRORS, lambda i: ERRORS.index(i.quantity))
    time = latest(lambda i: i.quantity == TIME and target(i) >= TARGET, target)
    night, figure = max((own[-1] for _, own in choices), key=lambda one: one[0].started)
    return PairResult(engine, scene, version(figure, night), verdict, error, time, worse)


def target(identity: FigureIdentity) -> float:
    """Error of the attitude at which a time is measured, rad; zero of another quantity."""
    quantity, _, number = identity.setting.partition("<=")
    return float(number) if quantity == "attitude" else 0.0


def measured(identity: FigureIdentity, own: Series, curves: Curves) -> Measured:
    """Latest result of a figure; `own` are the nights that have one."""
    night, figure = own[-1]
    low, high = figure.low, figure.high
    if figure.value is not None and figure.tolerance is not None:
        low, high = max(figure.value - figure.tolerance, 0.0), figure.value + figure.tolerance
    same = list(takewhile(lambda one: one[1].word == figure.word, reversed(own)))
    worded = identity.kind is FigureKind.VERDICT
    return Measured(
        identity.setting, identity.quantity, night.name, figure.value, figure.word, str(identity.unit), low, high,
        identity.anchor, figure.reason, same[-1][0].name if worded else "",
        curves.get((identity.scene, identity.engine, str(identity.kind), curve_name(identity))), len(own),
    )  # fmt: skip


def version(figure: Figure, night: NightSummary) -> str:
    """Version of the engine behind a figure, as its distribution or its entry states it; else barchain's own."""
    if any(name.startswith(PROGRAM) for name in figure.depends):
        return versions_of(figure, night) or "version not stated"
    return versions_of(figure, night) or f"barchain {night.barchain}"


def releases(
    pairs: Mapping[tuple[str, str], Sequence[Choice]], nights: Sequence[NightSummary]
) -> dict[str, tuple[tuple[int, str], ...]]:
    """Versions of each engine over the nights, each with the number of its first night."""
    number = {night.name: k for k, night in enumerate(nights)}
    found: dict[str, dict[int, str]] = defaultdict(dict)
    for (engine, _), choices in pairs.items():
        for night, figure in (one for _, own in choices for one in own):
            if number[night.name] not in found[engine]:
                found[engine][number[night.name]] = version(figure, night)
    every = {engine: [(-1, ""), *sorted(own.items())] for engine, own in found.items()}
    return {engine: tuple(now for was, now in pairwise(own) if now[1] != was[1]) for engine, own in every.items()}


def lacking(pair: PairResult, choices: Sequence[Choice], last: NightSummary) -> Iterator[tuple[str, str]]:
    """What a pair lacks, each with the reason."""
    verdict = pair.verdict
    if verdict is not None and verdict.word in SKIPPED:
        yield verdict.word, verdict.reason
    elif verdict is None or verdict.night != last.name:
        why = f"not on the latest night; last {verdict.night[:10]}" if verdict else ""
        why = missing(choices, VERDICTS) or why
        yield from [("verdict", why)] if why else []  # a scene that is timed alone has none
    for identity, own in choices:
        if identity.quantity == REACH and target(identity) == TARGET:
            reach = own[-1][1]
            why = missing(choices, (TIME,)) if reach.word in REACHED else f"{reach.word}: {reach.reason}".strip(": ")
            yield from [(NO_TIME, why)] if why else []


def missing(choices: Sequence[Choice], quantities: Sequence[str]) -> str:
    """Reason why the latest figure of some quantities has no result; empty if it has one."""
    latest = (own[-1][1] for identity, own in choices if identity.quantity in quantities)
    return next((figure.reason for figure in latest if figure.missing), "")
