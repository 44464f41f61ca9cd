"""Fold of the nights of a history: which nights a night is judged from, and in which order; and the files of levels.

A night is judged from the earlier ones of its machine class. The first of a class is judged from the nights of another
class that were there before, so that a change that came with a new machine stands on its later nights. The levels after
a night are a file in its folder: a cache of the fold, which may be deleted.
"""

from __future__ import annotations

import contextlib
import hashlib
import zlib
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.figure import STEPPED, Figure
from barchain.nightly.figures.table import read_figures
from barchain.nightly.history.advance import advance
from barchain.nightly.history.levels import FoldedNight, LevelOf, LevelTable
from barchain.nightly.history.news import told_by
from reports.results.reading import form_of

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from barchain.nightly.figures.figure import NightSummary
    from barchain.nightly.figures.storage import Place
    from barchain.nightly.history.nights import NightStore


FILE = "levels.z"
FORMAT = 4
MOST_B = 256 * 2**20
"""Largest content: 6600 figures take 6 MB"""
QUICK = 1
"""Level of compression: the best one takes three times as long, for a third of the size"""
DIGEST_B = 64
"""Bytes of the digest of all that follows it: compressed JSON"""


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
        found = form_of(LevelFile).validate_json(zlib.decompressobj().decompress(packed, MOST_B))
    except (ValueError, zlib.error):  # of another version, or larger than any night
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
    kept = kept_levels(store, own, {night.name: night.digest for night in nights}, wrong)
    others = [night for night in nights[: place[own[0].name]] if night.added <= own[0].added]
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
    store: NightStore, own: Sequence[NightSummary], digests: Mapping[str, str], wrong: Collection[str]
) -> FoldedNight | None:
    """Levels of the latest night that keeps some that hold."""
    there = {name.partition("/")[0] for name in store.place.sizes(f"*/{FILE}")}
    for night in reversed(own):
        found = read_levels(store.place, night) if night.name in there else None
        if found is not None and not any(
            name in wrong or digests.get(name, digest) != digest for name, digest, _ in found.table.folded
        ):
            return found
    return None


def late_nights(store: NightStore, some: Sequence[NightSummary], own: Sequence[NightSummary]) -> set[str]:
    """Names of those nights that were added after a later night of their class had told its changes."""
    told = {name: facts.told for name, facts in told_by(store).items() if facts.told}
    return {
        night.name
        for night in some
        if any(other.started > night.started and night.added > told.get(other.name, night.added) for other in own)
    }
