"""Judgement of a night against the earlier ones, or one other; changes that still hold, and their names."""

from __future__ import annotations

import datetime
import math
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING

from barchain.nightly.acceptances import NO_ACCEPTANCE, fits
from barchain.nightly.changes import (
    RULES,
    Change,
    Direction,
    JudgedNight,
    as_of,
    bit_changes,
    is_worse,
    level_changes,
    same_changes,
    without_mended,
)
from barchain.nightly.faults import HistoryError
from barchain.nightly.figures import STEPPED, Figure, FigureKind, FigureSeries, NightSummary
from barchain.nightly.renamed import Lineages, continued
from barchain.nightly.steps import FALSE_ALARMS, LEAST_EFFECT, WINDOW, time_changes
from barchain.nightly.told import comparable_nights, steps_before, told_by
from barchain.nightly.vanished import SAMPLED, Presence, presence_in, vanished
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.figures import FigureIdentity, Night
    from barchain.nightly.history import NightStore
    from barchain.nightly.steps import ToldChanges


def judge_night(
    series: Sequence[FigureSeries],
    nights: Sequence[NightSummary],
    false_alarms: float = FALSE_ALARMS,
    lineages: Lineages | None = None,
    told: ToldChanges = MappingProxyType({}),
) -> JudgedNight:
    """Judge the last of some nights.

    Parameters
    ----------
    series : sequence of FigureSeries
        All figures over these nights.
    nights : sequence of NightSummary
        In their order. Void nights are left out; a void night is not judged.
    false_alarms : float
        Probability of a false alarm in a night, of times and memory together.
    lineages : Lineages, optional
        Names of the figures over the comparable nights; default: those of `series`, which have all of their nights.
    told : mapping
        Steps of times and memory that earlier nights told, by name of the figure.
    """
    tonight = nights[-1]
    if tonight.void is not None:
        return JudgedNight(tonight, ())
    kept = comparable(nights)
    lineages = lineages or Lineages(kept, presence_in(series, nights))
    own = continued([one for one in (restricted(each, kept) for each in series) if one.nights], lineages)
    alike = same_class(kept)
    current = [one for one in own if one.nights[-1].name == tonight.name]
    settled = without_mended(
        change
        for one in own
        if one.identity.kind not in STEPPED
        for change in (level_changes(one) if one.identity.kind in RULES else bit_changes(one))
    )
    noisy = [restricted(one, alike) for one in own if one.identity.kind in STEPPED]
    stepped, fresh = time_changes([one for one in noisy if one.nights], false_alarms, told)
    settled = [
        replace(c, settings=lineages.other_settings(c)) if c.identity.kind is FigureKind.VERDICT else c for c in settled
    ]
    gone = [c for c in vanished(own, kept, lineages.presence) if not of_another_setting(c, lineages)]
    changes = sorted([*settled, *stepped, *gone], key=lambda c: (not c.irreproducible, c.since))
    steps = {change.id for change in stepped}
    new = [c for c in changes if c.since == tonight.name and c.id not in steps]
    replanned = len(kept) > 1 and kept[-2].plan != tonight.plan
    return JudgedNight(
        tonight, tuple(kept[:-1]), tuple(changes), (*new, *fresh),
        tuple(c for one in current if one.identity.kind in RULES for c in same_changes(one)),
        sum(len(one.nights) > 1 and not one.figures[-1].not_run for one in current)
        + sum(c.since == tonight.name for c in gone),
        sum(len(one.nights) == 1 and not one.identity.quantity.startswith(SAMPLED) for one in current),
        sum(one.nights[-1].name == kept[-2].name and not one.identity.quantity.startswith(SAMPLED) for one in own)
        if replanned else 0,
        tuple(words for since, words in lineages.renames if since == tonight.name),
    )  # fmt: skip


def of_another_setting(gone: Change, lineages: Lineages) -> bool:
    """Whether bits are gone because their engine has another setting in the scene: these have other bits."""
    return gone.identity.kind is FigureKind.BITS and bool(lineages.other_settings(gone))


def comparable(nights: Sequence[NightSummary]) -> list[NightSummary]:
    """Nights that the last one is judged against, and itself: those of its machine class, and all before the first.

    A change that came with a new machine stands on its later nights, too.
    """
    believed = [night for night in nights if night.void is None]
    own = same_class(believed)
    return [*believed[: believed.index(own[0])], *own]


def same_class(nights: Sequence[NightSummary]) -> list[NightSummary]:
    """Nights of the machine class of the last one."""
    return [n for n in nights if n.environment.machine_class == nights[-1].environment.machine_class]


def restricted(series: FigureSeries, nights: Sequence[NightSummary]) -> FigureSeries:
    """Series over some nights only."""
    names = {night.name for night in nights}
    return series.at([k for k, night in enumerate(series.nights) if night.name in names])


def still_holding(judged: JudgedNight) -> list[Change]:
    """Changes for the worse of earlier nights, before which the figure was still better than it is, and what it is now.

    Of a figure the last one stands for those before it, as the figure is where that one led. Steps of times and memory
    are factors, and stand for themselves. A run that was not reproducible is an event of its night, and no state that
    holds.
    """
    own: dict[FigureIdentity, list[Change]] = {}
    for change in sorted(judged.changes, key=lambda c: c.since):
        own.setdefault(change.identity, []).append(change)
    told = {change.id for change in judged.tonight}
    found = []
    for identity, changes in own.items():
        holding = [c for c in changes if is_regression(c) and holds(c, changes)]
        shown = holding if identity.kind in STEPPED else [as_of(c, changes[-1].now) for c in holding[-1:]]
        found += [c for c in shown if c.id not in told]
    return found


def is_regression(change: Change) -> bool:
    """Whether a change is for the worse, and a state that can hold."""
    return change.direction is Direction.WORSE and not change.irreproducible


def holds(change: Change, own: Sequence[Change]) -> bool:
    """Whether a figure is still worse than before a change, from all of its changes in their order.

    Steps of times and memory multiply: a slow-down holds until later steps have taken it back, up to half the least
    effect. One without later steps holds as long as it is there.
    """
    if change.identity.kind in STEPPED and change.factor is not None:
        steps = [c.factor for c in own if c.since >= change.since and c.factor is not None]
        return len(steps) == 1 or math.prod(steps) >= 1.0 + LEAST_EFFECT / 2.0
    return change.now is own[-1].now or is_worse(change.was, own[-1].now)


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
    nights = (replace(before.summary(), void=None, started=started), after.summary())
    if after.void is not None:
        return JudgedNight(nights[1], nights[:1])
    found: dict[FigureIdentity, list[tuple[NightSummary, Figure]]] = {}
    for night, content in zip(nights, (before, after), strict=True):
        for figure in content.figures:
            found.setdefault(figure.identity, []).append((night, figure))
    series = tuple(
        FigureSeries(identity, tuple(n for n, _ in own), tuple(f for _, f in own)) for identity, own in found.items()
    )
    lineages = Lineages(nights, presence_in(series, nights))
    judged, whole = judge_night(series, nights, lineages=lineages), continued(series, lineages)
    compared = sum(len(one.nights) > 1 for one in whole if one.identity.kind not in STEPPED)
    gone = []
    for one in whole if before.plan == after.plan and after.complete else ():
        rotates = one.identity.quantity.startswith(SAMPLED) or one.identity.kind in STEPPED
        if one.nights == nights[:1] and not rotates and not one.figures[0].missing:
            reason = "not measured, though the baseline of the same plan has it"
            now = Figure(one.identity, reason=reason, depends=one.figures[0].depends)
            last, since = (night.name for night in nights)
            change = Change(one.identity, one.figures[0], now, last, since, Direction.WORSE, reason)
            gone += [] if of_another_setting(change, lineages) else [change]
    return replace(
        judged, changes=(*judged.changes, *gone), tonight=(*judged.tonight, *gone), judged=compared + len(gone),
        left_out=sum(one.nights == nights[:1] for one in whole),
    )  # fmt: skip


def judge(store: NightStore, name: str = "latest", *, false_alarms: float = FALSE_ALARMS) -> JudgedNight:
    """Judge a night against the earlier ones.

    Parameters
    ----------
    store : NightStore
    name : str
        Of the night.
    false_alarms : float

    Raises
    ------
    HistoryError
        If there is no such night.
    """
    chosen, told = store.summary(name), told_by(store)
    before = comparable_nights(store.nights(), chosen, told)
    if chosen.void is not None:
        return judge_night((), before, false_alarms)
    before, table = comparable(before), store.table()
    lineages = Lineages(before, Presence(table.nights, table.identities, table.cells >= 0))
    stepped = same_class(before)[-WINDOW:]
    settled = [kind for kind in FigureKind if kind not in STEPPED]
    series = (
        *table.levels(before, settled, lineages.borders),
        *table.series_at(table.where(stepped, STEPPED)),
        *table.gone(before, stepped, STEPPED),
    )
    return judge_night(series, before, false_alarms, lineages, steps_before(told, chosen.name))


def change_named(judged: JudgedNight, name: str) -> Change:
    """Change by its id, or by the name of its figure, of which the last one counts.

    Raises
    ------
    HistoryError
        If there is none; the message gives the nearest name.
    """
    known: dict[str, Change] = {}
    ordered = sorted(judged.changes, key=lambda c: c.since)
    known |= {name: change for change in ordered for name in change.ids}
    known |= {name: change for change in ordered for name in (change.identity.name, change.id)}
    if name not in known:
        there = f"{len(judged.changes)} changes are there" if known else "there are none"
        raise HistoryError(f"{name[:80]}: no such change{nearest(name, known)}; {there} up to {judged.night.name}")
    return known[name]


def changes_named(judged: JudgedNight, name: str) -> list[Change]:
    """Change of an id, or the last change of each figure of a name, or that fits a pattern with ``*``.

    A pattern takes what is worse, and what changed tonight: what became better earlier needs no acceptance.

    Raises
    ------
    HistoryError
        If there is none.
    """
    every = acceptable(judged)
    named = [change for change in every if change.identity.name == name]
    if named or "*" not in name:
        return named or event_of(change_named(judged, name), judged.changes)
    tonight = {change.id for change in judged.tonight}
    fitting = [
        change for change in every
        if fits(change.identity.name, name) and (change.direction is Direction.WORSE or change.id in tonight)
    ]  # fmt: skip
    if not fitting:
        refused = any(fits(change.identity.name, name) for change in judged.changes)
        changed = len({change.identity for change in judged.changes})
        fault = NO_ACCEPTANCE if refused else f"fits none of {changed} changed figures up to {judged.night.name}"
        raise HistoryError(f"{name[:80]}: {fault}")
    return fitting


def event_of(change: Change, every: Sequence[Change]) -> list[Change]:
    """Change with the figures that are missing since the same run: they are told, and accepted, as one event."""
    if change.irreproducible:
        return [change]
    i = change.identity
    place = (i.scene, i.engine, change.since)
    return [change, *(c for c in every if c.now.missing and c is not change
                      and (c.identity.scene, c.identity.engine, c.since) == place)]  # fmt: skip


def acceptable(judged: JudgedNight) -> list[Change]:
    """Changes that a name or a pattern accepts: those that hold, new steps, and the last ones of all other figures."""
    steps = [change for change in judged.tonight if change.identity.kind in STEPPED]
    found = [*still_holding(judged), *steps]  # not a recovery in part after a change that holds
    last = {change.identity: change for change in sorted(judged.changes, key=lambda c: c.since)}
    taken = {change.identity for change in found}
    found += [change for identity, change in last.items() if identity not in taken]
    return [change for change in found if not change.irreproducible]


def irreproducible(judged: JudgedNight, names: Sequence[str]) -> int:
    """Number of tonight's runs that are not reproducible and fit a pattern: an acceptance leaves them out."""
    wild = [change for change in judged.tonight if change.irreproducible]
    return sum(any("*" in name and fits(change.identity.name, name) for name in names) for change in wild)
