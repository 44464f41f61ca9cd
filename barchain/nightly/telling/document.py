"""Facts of a stored night, as ``nightly.json`` holds them."""

from __future__ import annotations

import datetime
import math
from collections import Counter
from dataclasses import asdict
from types import MappingProxyType
from typing import TYPE_CHECKING

from barchain.nightly.figures.changes import VERDICT, results_words
from barchain.nightly.figures.figure import STEPPED, FigureKind
from barchain.nightly.figures.suspects import differing, suspects_of, unknown_parts
from barchain.nightly.history.acceptances import accepted, accepting
from barchain.nightly.history.news import attributed_words, left_out
from barchain.nightly.history.standing import every_change, standing
from barchain.nightly.telling.sentence import opening
from reports.results.comparison import EXPLAINED
from reports.results.nights.document import (
    AcceptanceEntry,
    AgainstEntry,
    ChangeEntry,
    CountsEntry,
    NightEntry,
    NightlyFile,
    RejectedEntry,
)
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from barchain.nightly.figures.changes import Change
    from barchain.nightly.figures.figure import Figure, Night, NightSummary
    from barchain.nightly.history.acceptances import Acceptance
    from barchain.nightly.history.levels import JudgedNight
    from barchain.nightly.history.nights import NightStore


VERSIONED = ("engine:", "library:", "program:", "python")
MISSING = "missing"
FINE = frozenset(str(outcome) for outcome in Outcome if outcome.ok)
"""Verdicts that are a pass, or a limit that the engine states; a word of another version is none"""
OWN = STEPPED | {FigureKind.BITS}
"""Kinds whose changes are attributed by themselves"""


def night_facts(store: NightStore, judged: JudgedNight, night: Night, baseline: str = "") -> NightlyFile:
    """Facts of a judged night, with the acceptances and attributions of its history.

    Parameters
    ----------
    store : NightStore
    judged : JudgedNight
    night : Night
        With its figures.
    baseline : str
        Name of the one night that it was judged against.
    """
    confirmed = attributed_words(store, every_change(judged))
    cells = [f for f in night.figures if f.identity.kind is FigureKind.VERDICT and f.identity.quantity == VERDICT]
    new, earlier = change_entries(judged, accepted(store), confirmed)
    tonight, holding = tuple(events(list(standing_for(new)))), events(earlier)
    steps = {change.figure: change.factor for change in tonight if change.direction == "worse"}
    earlier_nights = {  # with the latest result
        row.told.identity.name: row.last_night for row in judged.above.values()
        if row.last_night != judged.night.name
    }  # fmt: skip
    holding = [
        entry.model_copy(update={
            "fresh": steps.get(entry.figure),
            "measured": "" if entry.became == MISSING else earlier_nights.get(entry.figure, ""),
        })
        for entry in holding
    ]  # fmt: skip
    worse, held = (tuple(e for e in holding if (e.accepted is None) is told) for told in (True, False))
    names = [night.name for night in judged.compared_with]
    fallen = {(e.scene, e.engine) for e in (*tonight, *worse) if e.worse_verdict}
    rejected = [
        RejectedEntry(
            scene=cell.identity.scene, engine=cell.identity.engine, setting=cell.identity.setting,
            verdict=cell.word or MISSING, reason=cell.reason,
        )
        for cell in (*cells, *without_verdict(night.figures, cells))
        if not cell.not_run and cell.word not in FINE
    ]  # fmt: skip
    rejected.sort(key=lambda r: ((r.scene, r.engine) not in fallen, EXPLAINED not in r.reason))
    found = NightlyFile(
        sentence="",
        night=night_entry(judged),
        against=AgainstEntry(nights=len(names), first=names[0] if names else "", last=names[-1] if names else "",
                             baseline=baseline),
        counts=counts(judged, tonight),
        verdicts=dict(Counter(cell.word or MISSING for cell in cells).most_common()),
        rejected=tuple(rejected),
        changes=tonight,
        standing=worse,
        held=held,
        renamed=judged.renamed,
        left_out=left_out(store),
        so_far=judged.so_far,
        run=judged.night.run,
    )  # fmt: skip
    return found.model_copy(update={"sentence": opening(judged, found)})


def without_verdict(figures: Sequence[Figure], verdicts: Sequence[Figure]) -> list[Figure]:
    """Runs that gave no result, of pairs that have no verdict: their part may have ended before it was judged."""
    judged = {(cell.identity.scene, cell.identity.engine) for cell in verdicts}
    failed = {
        (f.identity.scene, f.identity.engine): f for f in figures if f.identity.kind is FigureKind.BITS and f.missing
    }
    return [f for pair, f in failed.items() if pair not in judged]


def change_entries(
    judged: JudgedNight, known: Sequence[Acceptance], confirmed: Mapping[str, str] = MappingProxyType({})
) -> tuple[list[ChangeEntry], list[ChangeEntry]]:
    """Entries of what a night tells first, and of what is worse since an earlier night; what needs a look comes first.

    What changed tonight is accepted by an entry of its night, or if the state that it leads to is.
    """
    now, nights = datetime.datetime.now(datetime.UTC), judged.by_name
    states = standing(judged, known, now)
    of_figure = {state.change.identity: state.acceptance for state in states}
    new = {change.id for change in judged.tonight}
    found: tuple[list[ChangeEntry], list[ChangeEntry]] = [], []
    for change in judged.tonight:
        covering = accepting(change, known, now)
        if covering is None and not change.is_step and not change.irreproducible:
            covering = of_figure.get(change.identity)
        found[0].append(change_entry(change, nights, covering, confirmed.get(change.id, "")))
    for state in (state for state in states if state.change.id not in new):
        entry = change_entry(state.change, nights, state.acceptance, confirmed.get(state.change.id, ""))
        newest = suspects_of(state.newest, nights) if state.newest else ()
        found[1].append(entry.model_copy(update={"newest": tuple(suspect.entry for suspect in newest)}))
    return sorted(found[0], key=weight), sorted(found[1], key=weight)


def standing_for(changes: Iterable[ChangeEntry]) -> Iterator[ChangeEntry]:
    """Changes, each with the attribution of one of the same engine and suspects, for which that one stands.

    Bits and times stand for themselves alone, as in :func:`barchain.nightly.attribution.attribute.worth_attributing`.
    """
    every = list(changes)
    known = {(c.engine, c.suspects): c.confirmed for c in every if c.confirmed and c.kind not in OWN}
    for change in every:
        found = "" if change.kind in OWN else known.get((change.engine, change.suspects), "")
        yield change if change.confirmed or not found else change.model_copy(update={"confirmed": found})


def events(changes: Sequence[ChangeEntry]) -> list[ChangeEntry]:
    """Changes; figures that one run lacks since then, or has again, are one: the run's verdict, or the first figure."""

    def run(change: ChangeEntry) -> tuple[str, ...]:
        state = MISSING if change.became == MISSING else f"back, {change.direction}"
        return change.scene, change.engine, change.since, str(change.accepted), state

    moved = [change for change in changes if MISSING in (change.was, change.became)]
    heads = {run(c): c.id for c in (*reversed(moved), *[c for c in moved if c.quantity == VERDICT])}
    for c in changes:  # a verdict that became another word may be that of a run without figures
        key = (*run(c)[:-1], MISSING)
        if c.quantity == VERDICT and c.direction == "worse" and MISSING not in (c.was, c.became) and key in heads:
            heads[key] = c.id
    folded = [c for c in moved if heads[run(c)] != c.id]
    also, dropped = Counter(heads[run(c)] for c in folded), {c.id for c in folded}
    kept = [change for change in changes if change.id not in dropped]
    return [c.model_copy(update={"also": also[c.id]}) if c.id in also else c for c in kept]


def weight(change: ChangeEntry) -> tuple[bool, bool, int, bool, float]:
    """Place of a change in a table: what needs a look first, verdicts before numbers, large factors before small."""
    factor = abs(math.log(change.factor)) if change.factor else math.inf
    direction = ("worse", "better", "changed").index(change.direction)
    is_verdict = change.kind == FigureKind.VERDICT
    return not change.irreproducible, change.accepted is not None, direction, not is_verdict, -factor


def change_entry(
    change: Change, nights: Mapping[str, NightSummary], covering: Acceptance | None, confirmed: str
) -> ChangeEntry:
    """Entry of a change."""
    identity = change.identity
    was, became = results_words(change)
    return ChangeEntry(
        id=change.id, figure=identity.name, scene=identity.scene, engine=identity.engine, setting=identity.setting,
        quantity=identity.quantity, kind=str(identity.kind), unit=str(identity.unit),
        was=was, became=became, factor=change.factor,
        factor_low=change.factor_low, factor_high=change.factor_high, direction=change.direction.value,
        last=change.last, since=change.since, reason=change.reason, irreproducible=change.irreproducible,
        suspects=tuple(suspect.entry for suspect in suspects_of(change, nights)),
        unknown=unknown_parts(change, nights), confirmed=confirmed,
        steps=change.steps,
        accepted=covering and AcceptanceEntry(
            who=covering.who, when=covering.date, reason=covering.reason, until=covering.until
        ),
    )  # fmt: skip


def night_entry(judged: JudgedNight) -> NightEntry:
    """Entry of the night, with the parts that differ from the last night before; scenes that one left tell nothing."""
    night, last = judged.night, judged.compared_with[-1] if judged.compared_with else None
    exchanged = differing(last, night, set(last.part_named) & set(night.part_named)) if last else ()
    return NightEntry(
        name=night.name, started=night.started, duration_s=night.duration_s, plan=night.plan, barchain=night.barchain,
        commit=night.commit, state="void" if night.void else "complete" if night.complete else "incomplete",
        void=night.void, figures=night.figures, machine_class=night.environment.machine_class,
        environment={name: value for name, value in asdict(night.environment).items() if name != "cpu_flags"},
        versions={p.name: p.version for p in night.parts if p.name.startswith(VERSIONED) and p.version},
        exchanged=tuple(suspect.entry for suspect in exchanged),
    )  # fmt: skip


def counts(judged: JudgedNight, tonight: Sequence[ChangeEntry]) -> CountsEntry:
    """Numbers of changes; an accepted one counts as accepted only."""
    told: Counter[str] = Counter()
    for change in tonight:
        told["accepted" if change.accepted else change.direction] += 1 + change.also
    return CountsEntry(
        judged=judged.judged, same=judged.same, worse=told["worse"], better=told["better"],
        changed=told["changed"], accepted=told["accepted"],
        irreproducible=sum(change.irreproducible for change in tonight), new=judged.new,
    )  # fmt: skip
