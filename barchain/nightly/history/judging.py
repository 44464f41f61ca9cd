"""Judgement of a night against the earlier ones, or one other; the files of levels; the names of changes.

A night is judged from the earlier ones of its machine class. The first of a class is judged from the nights of another
class that were there before, so that a change that came with a new machine stands on its later nights. The levels after
a night are a file in its folder: a cache of the fold over nights, which may be deleted.
"""

from __future__ import annotations

import contextlib
import datetime
import hashlib
import zlib
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.figure import STEPPED, Figure
from barchain.nightly.figures.steps import WINDOW, so_far, time_changes
from barchain.nightly.figures.table import read_figures
from barchain.nightly.history.acceptances import NO_ACCEPTANCE, fits
from barchain.nightly.history.advance import SAMPLED, advance
from barchain.nightly.history.levels import FoldedNight, JudgedNight, LevelOf, LevelTable
from barchain.nightly.history.news import steps_before, told_by
from barchain.nightly.history.standing import every_change, standing
from reports.results.reading import form_of
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from barchain.nightly.figures.changes import Change
    from barchain.nightly.figures.figure import Night, NightSummary
    from barchain.nightly.figures.storage import Place
    from barchain.nightly.history.nights import NightStore

FILE = "levels.z"
FORMAT = 4
QUICK = 1
"""Level of compression: the best one takes three times as long, for a third of the size"""
DIGEST_B = 64
"""Bytes of the digest of all that follows it: compressed JSON"""


def judge(store: NightStore, name: str = "latest") -> JudgedNight:
    """Judge a night against the earlier ones.

    Parameters
    ----------
    store : NightStore
    name : str
        Of the night.

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
    stepped, fresh = time_changes(series, steps_before(told_by(store), chosen.name))
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
        refused = any(change.irreproducible and fits(change.identity.name, name) for change in changed)
        count, which = len({change.identity for change in changed}), "up to"
        if alone:
            count, which = len({change.identity for change in every}), "on"
        fault = NO_ACCEPTANCE if refused else f"fits none of {count} changed figures {which} {judged.night.name}"
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


@dataclass(frozen=True)
class LevelFile:
    """Content of the file."""

    format: int
    folded: FoldedNight
    """Without its levels: their names are no keys of JSON"""
    figures: tuple[Figure, ...]
    rows: tuple[LevelOf[int], ...]
    """With the places of their figures: level, told and last result of most rows are one figure"""


def content_of(folded: FoldedNight) -> bytes:
    """File of a folded night."""
    bare = replace(folded, table=replace(folded.table, rows={}))
    places: dict[int, int] = {}
    figures: list[Figure] = []

    def place_of(figure: Figure) -> int:
        place = places.setdefault(id(figure), len(figures))
        if place == len(figures):
            figures.append(figure)
        return place

    rows = tuple(row.mapped(place_of) for row in folded.table.rows.values())
    packed = zlib.compress(form_of(LevelFile).dump_json(LevelFile(FORMAT, bare, tuple(figures), rows)), QUICK)
    return hashlib.sha256(packed).hexdigest().encode() + packed


def folded_of(content: bytes) -> FoldedNight | None:
    """Folded night of a file; None of a damaged one, or of another format."""
    digest, packed = content[:DIGEST_B], content[DIGEST_B:]
    if hashlib.sha256(packed).hexdigest().encode() != digest:
        return None
    try:
        found = form_of(LevelFile).validate_json(zlib.decompress(packed))
    except (ValueError, zlib.error):  # of another version
        return None
    rows = {row.told.identity: row for row in (row.mapped(found.figures.__getitem__) for row in found.rows)}
    return replace(found.folded, table=replace(found.folded.table, rows=rows)) if found.format == FORMAT else None


def read_levels(place: Place, night: NightSummary) -> FoldedNight | None:
    """Levels in a night's folder; None if there are none of its present figures."""
    content = place.read(f"{night.name}/{FILE}")
    found = folded_of(content) if content else None
    return found if found and found.table.folded[-1][:2] == (night.name, night.digest) else None


def folded_night(store: NightStore, chosen: NightSummary, every: Sequence[NightSummary]) -> FoldedNight:
    """Levels after a night, and what it tells: those that its folder keeps, else folded from the nights before.

    Kept levels hold as long as each night that they fold is as it was. A night that was there when they were folded and
    is gone since has been pruned.

    Parameters
    ----------
    store : NightStore
    chosen : NightSummary
    every : sequence of NightSummary
        Nights of the history in their order.
    """
    wrong = {*store.left_out(), *(night.name for night in every if night.void is not None)}
    nights = [night for night in every if night.name not in wrong]
    return folded_of_nights(store, chosen, nights, wrong)


def folded_of_nights(
    store: NightStore, chosen: NightSummary, nights: Sequence[NightSummary], wrong: Collection[str]
) -> FoldedNight:
    """Levels after one of the nights that count; `wrong` names those that don't: what folds them is folded again."""
    place = {night.name: k for k, night in enumerate(nights)}
    machine = chosen.environment.machine_class
    own = [night for night in nights[: place[chosen.name] + 1] if night.environment.machine_class == machine]
    others = [night for night in nights[: place[own[0].name]] if night.added <= own[0].added]
    kept = kept_levels(store, own, others[-1:], {night.name: night.digest for night in nights}, wrong)
    if kept is not None and kept.table.night == chosen.name:
        return kept
    table = LevelTable() if kept is None else kept.table
    if kept is None and others:
        before = folded_of_nights(store, others[-1], nights, wrong).table
        table = replace(before, rows={i: row for i, row in before.rows.items() if i.kind not in STEPPED})
    known = {name for name, _, _ in table.folded}
    missing = [night for night in own if night.name not in known]
    late = late_nights(store, missing, own) if len(missing) > 1 else set()
    late |= {night.name for night in missing if kept is not None and place[night.name] < place[table.night]}
    found = FoldedNight(table)
    for night, content in store.contents(missing):
        is_late = night.name in late and night.name != chosen.name
        found = advance(found.table, night, read_figures(content), late=is_late)
    if found.table.night != chosen.name:
        return FoldedNight(found.table)  # the night is damaged, and tells nothing
    with contextlib.suppress(HistoryError):  # without them it only takes longer
        store.place.write(f"{chosen.name}/{FILE}", content_of(found))
    return found


def kept_levels(
    store: NightStore,
    own: Sequence[NightSummary],
    base: Sequence[NightSummary],
    digests: Mapping[str, str],
    wrong: Collection[str],
) -> FoldedNight | None:
    """Levels that some nights keep: of those that hold, the latest ones that fold most of these nights.

    Levels that came with a night from another history fold that one's nights, and would hide what is open in this one.
    Those of a single night hold only without a `base` of another class.
    """
    there = {name.partition("/")[0] for name in store.place.sizes(f"*/{FILE}")}
    best, most = None, 0
    for k, night in reversed([*enumerate(own, start=1)]):
        if most >= k:
            break  # earlier ones fold fewer
        found = read_levels(store.place, night) if night.name in there else None
        folded = {} if found is None else {name: digest for name, digest, _ in found.table.folded}
        holds = not any(name in wrong or digests.get(name, digest) != digest for name, digest in folded.items())
        count = sum(each.name in folded for each in own[:k])
        if holds and count > most:
            best, most = found, count
    return best if most > 1 or not base else None


def late_nights(store: NightStore, some: Sequence[NightSummary], own: Sequence[NightSummary]) -> set[str]:
    """Names of those nights that were added after a later night of their class had told its changes."""
    told = {name: facts.told for name, facts in told_by(store).items() if facts.told}
    return {
        night.name
        for night in some
        if any(other.started > night.started and night.added > told.get(other.name, night.added) for other in own)
    }
