"""Judgement of a night against the earlier ones, or one other; changes and their names."""

from __future__ import annotations

import datetime
from dataclasses import replace
from typing import TYPE_CHECKING

from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.figure import STEPPED
from barchain.nightly.figures.steps import FALSE_ALARMS, WINDOW, so_far, time_changes
from barchain.nightly.history.acceptances import NO_ACCEPTANCE, fits
from barchain.nightly.history.advance import SAMPLED, advance
from barchain.nightly.history.fold import folded_night
from barchain.nightly.history.levels import JudgedNight, LevelTable
from barchain.nightly.history.news import steps_before, told_by
from barchain.nightly.history.standing import every_change, standing
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.figures.changes import Change
    from barchain.nightly.figures.figure import Night
    from barchain.nightly.history.nights import NightStore


def judge(store: NightStore, name: str = "latest", *, false_alarms: float = FALSE_ALARMS) -> JudgedNight:
    """Judge a night against the earlier ones.

    Parameters
    ----------
    store : NightStore
    name : str
        Of the night.
    false_alarms : float
        Probability of a false alarm in a night, of times and memory together.

    Raises
    ------
    HistoryError
        If there is no such night.
    """
    chosen = store.summary(name)
    if chosen.void is not None:
        return JudgedNight(LevelTable(), night=chosen)
    every = store.nights()
    folded = folded_night(store, chosen, every)
    known = {night.name: night for night in every}
    nights = [known[name] for name, _, late in folded.table.folded if name in known and not late]
    alike = [n for n in nights if n.environment.machine_class == chosen.environment.machine_class][-WINDOW:]
    numbers = store.numbers().among(alike)
    series = [
        numbers.series(identity, row.earlier) for identity, row in folded.table.rows.items()
        if identity.kind in STEPPED and (identity in numbers.row or row.earlier)
    ]  # fmt: skip
    stepped, fresh = time_changes(series, false_alarms, steps_before(told_by(store), chosen.name))
    return JudgedNight(
        **vars(folded), night=chosen, compared_with=tuple(nights[:-1]), stepped=stepped, fresh=fresh,
        so_far=so_far(series),
    )  # fmt: skip


def latest_judged(store: NightStore) -> list[JudgedNight]:
    """The last night of each machine class, judged."""
    last = {night.environment.machine_class: night.name for night in store.nights() if night.void is None}
    return [judge(store, name) for name in last.values()]


def judge_pair(before: Night, after: Night) -> JudgedNight:
    """Judge a night against one other.

    Times and memory need many nights, so that a baseline tells nothing of them. A figure of the baseline that a
    complete night of the same plan lacks is a change for the worse. A void baseline is believed, as it was named on
    purpose; a void night is not judged.

    Parameters
    ----------
    before : Night
        Baseline.
    after : Night
    """
    started = min(before.started, after.started - datetime.timedelta(seconds=1))  # it is before, whenever it was
    first, last = replace(before.summary(), void=None, started=started), after.summary()
    if after.void is not None:
        return JudgedNight(LevelTable(), night=last, compared_with=(first,))
    there = {figure.identity for figure in after.figures}
    steady = [
        figure for figure in before.figures
        if figure.identity.kind not in STEPPED
        and (figure.identity in there or not figure.identity.quantity.startswith(SAMPLED))
    ]  # fmt: skip
    later = [figure for figure in after.figures if figure.identity.kind not in STEPPED]
    baseline = advance(LevelTable(), first, steady, late=True).table  # what it has is as it may be
    folded = advance(baseline, last, later, occasions=1)
    renamed = {name for row in folded.table.rows.values() for name, _ in row.earlier}
    left_out = sum(figure.identity not in there | renamed for figure in before.figures)
    return JudgedNight(**vars(folded) | {"left_out": left_out}, night=last, compared_with=(first,))


def change_named(judged: JudgedNight, name: str) -> Change:
    """Change by its id, or by the name of its figure, of which the last one counts.

    Raises
    ------
    HistoryError
        If there is none; the message gives the nearest name.
    """
    every = sorted(every_change(judged), key=lambda c: c.since)
    known: dict[str, Change] = {name: change for change in every for name in change.ids}
    known |= {name: change for change in every for name in (change.identity.name, change.id)}
    if name not in known:
        there = f"{len(every)} changes are there" if known else "there are none"
        raise HistoryError(f"{name[:80]}: no such change{nearest(name, known)}; {there} up to {judged.night.name}")
    return known[name]


def changes_named(judged: JudgedNight, name: str, *, alone: bool = False) -> list[Change]:
    """Change of an id, or the state of each figure of a name, or that fits a pattern with ``*``.

    A pattern takes what is worse, and what changed tonight: what became better earlier needs no acceptance. The id of a
    change takes that change alone, a name or a pattern all steps that lead to what the figure is; `alone` leaves them
    the changes of this night.

    Raises
    ------
    HistoryError
        If there is none.
    """
    every = [change for change in judged.tonight if not change.irreproducible] if alone else acceptable(judged)
    named = [change for change in every if change.identity.name == name]
    if named or "*" not in name:
        return named or event_of(change_named(judged, name), every)
    fitting = [change for change in every if fits(change.identity.name, name)]
    if not fitting:
        changed = every_change(judged)
        refused = any(fits(change.identity.name, name) for change in changed)
        count = len({change.identity for change in changed})
        fault = NO_ACCEPTANCE if refused else f"fits none of {count} changed figures up to {judged.night.name}"
        raise HistoryError(f"{name[:80]}: {fault}")
    return fitting


def event_of(change: Change, every: Sequence[Change]) -> list[Change]:
    """Change with the figures that are missing since the same run: they are told, and accepted, as one event."""
    if change.irreproducible:
        return [change]
    i = change.identity
    place = (i.scene, i.engine, change.since)
    return [change, *(c for c in every if c.now.missing and c.id != change.id
                      and (c.identity.scene, c.identity.engine, c.since) == place)]  # fmt: skip


def acceptable(judged: JudgedNight) -> list[Change]:
    """Changes that a name or a pattern accepts: states that hold, and what else changed tonight."""
    states = [state.change for state in standing(judged)]
    taken = {change.identity for change in states}
    rest = [change for change in judged.tonight if change.identity not in taken]
    return [change for change in (*states, *rest) if not change.irreproducible]


def irreproducible(judged: JudgedNight, names: Sequence[str]) -> int:
    """Number of tonight's runs that are not reproducible and fit a pattern: an acceptance leaves them out."""
    wild = [change for change in judged.tonight if change.irreproducible]
    return sum(any("*" in name and fits(change.identity.name, name) for name in names) for change in wild)
