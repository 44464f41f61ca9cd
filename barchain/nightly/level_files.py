"""Levels after a night as a file in the night's folder: a cache of the fold, which may be deleted."""

from __future__ import annotations

import contextlib
import hashlib
import json
import zlib
from typing import TYPE_CHECKING, Any

from barchain.nightly.changes import Change, Direction
from barchain.nightly.faults import HistoryError
from barchain.nightly.figures import Figure, FigureIdentity, FigureKind, FigureUnit
from barchain.nightly.levels import FoldedNight, Level, LevelTable, Step

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.figures import NightSummary
    from barchain.nightly.place import Place


FILE = "levels.z"
FORMAT = 1
"""Of the content: after the digest of all that follows, compressed JSON"""
DIGEST_B = 64
COUNTS = ("judged", "same", "new", "left_out")
CHANGE_TEXTS = ("last", "since", "reason")


class Writer:
    """Content under construction: each distinct figure, text and name is there once."""

    def __init__(self) -> None:
        """Begin empty."""
        self.numbers: dict[Any, int] = {}
        self.values: list[Any] = []

    def number(self, key: Any, value: Any) -> int:
        """Number of a value."""
        if key not in self.numbers:
            self.numbers[key] = len(self.values)
            self.values.append(value)
        return self.numbers[key]

    def name(self, identity: FigureIdentity) -> int:
        """Number of a figure's name."""
        i = identity
        words = [i.scene, i.engine, i.setting, i.quantity, str(i.kind), str(i.unit), i.anchor]
        return self.number(identity, words)

    def figure(self, figure: Figure) -> int:
        """Number of a figure."""
        f = figure
        depends = self.number(("depends", f.depends), list(f.depends))
        values = [self.name(f.identity), f.value, f.word, f.low, f.high, f.tolerance, depends, f.reason]
        return self.number((f.identity, *values), values)

    def row(self, row: Level) -> list[Any]:
        """Values of a level."""
        return [
            self.figure(row.level), row.since, row.right, self.figure(row.told), self.figure(row.last),
            row.last_night, row.present,
            [[step.last, step.night, self.figure(step.now), list(step.settings)] for step in row.steps],
            [self.figure(figure) for figure in row.better], row.seen, row.content, row.plan, row.occasions,
            row.complete, row.left_out, [[self.name(name), last] for name, last in row.earlier],
        ]  # fmt: skip

    def change(self, change: Change) -> list[Any]:
        """Values of a change."""
        return [
            self.figure(change.was), self.figure(change.now), *(getattr(change, name) for name in CHANGE_TEXTS),
            str(change.direction), change.factor, change.irreproducible, [self.name(name) for name in change.named],
            list(change.settings),
        ]  # fmt: skip


class Reader:
    """Values of a content."""

    def __init__(self, values: Sequence[Any]) -> None:
        """Take the values that a writer numbered."""
        self.values = values
        self.made: dict[int, Any] = {}

    def name(self, number: int) -> FigureIdentity:
        """Figure's name of a number."""
        if number not in self.made:
            scene, engine, setting, quantity, kind, unit, anchor = self.values[number]
            kinds = FigureKind(kind), FigureUnit(unit)
            self.made[number] = FigureIdentity(scene, engine, setting, quantity, *kinds, anchor)
        found: FigureIdentity = self.made[number]
        return found

    def figure(self, number: int) -> Figure:
        """Figure of a number."""
        if number not in self.made:
            name, value, word, low, high, tolerance, depends, reason = self.values[number]
            parts = tuple(self.values[depends])
            self.made[number] = Figure(self.name(name), value, word, low, high, tolerance, "", parts, reason)
        found: Figure = self.made[number]
        return found

    def row(self, values: Sequence[Any]) -> Level:
        """Level of its values."""
        (level, since, right, told, last, last_night, present, steps, better, seen, content, plan, occasions, complete,
         left_out, earlier) = values  # fmt: skip
        return Level(
            self.figure(level), since, right, self.figure(told), self.figure(last), last_night, present,
            tuple(Step(last, night, self.figure(now), tuple(settings)) for last, night, now, settings in steps),
            tuple(map(self.figure, better)), tuple((state, word, night) for state, word, night in seen), content, plan,
            occasions, complete, left_out, tuple((self.name(name), until) for name, until in earlier),
        )  # fmt: skip

    def change(self, values: Sequence[Any]) -> Change:
        """Change of its values."""
        was, now, last, since, reason, direction, factor, irreproducible, named, settings = values
        figure = self.figure(now)
        return Change(
            figure.identity, self.figure(was), figure, last, since, Direction(direction), reason, factor,
            irreproducible=irreproducible, named=tuple(map(self.name, named)), settings=tuple(settings),
        )  # fmt: skip


def content_of(folded: FoldedNight) -> bytes:
    """File of a folded night."""
    writer, table = Writer(), folded.table
    rows = [writer.row(row) for row in table.rows.values()]
    news = [writer.change(change) for change in folded.news]
    content = {
        "format": FORMAT, "night": table.night, "plan": table.plan, "folded": table.folded, "values": writer.values,
        "rows": rows, "news": news, "renamed": folded.renamed, **{name: getattr(folded, name) for name in COUNTS},
    }  # fmt: skip
    packed = zlib.compress(json.dumps(content, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode())
    return hashlib.sha256(packed).hexdigest().encode() + packed


def folded_of(content: bytes) -> FoldedNight | None:
    """Folded night of a file; None of a damaged one, or of another format."""
    digest, packed = content[:DIGEST_B], content[DIGEST_B:]
    if hashlib.sha256(packed).hexdigest().encode() != digest:
        return None
    found = json.loads(zlib.decompress(packed))
    if found["format"] != FORMAT:
        return None
    reader = Reader(found["values"])
    rows = [reader.row(values) for values in found["rows"]]
    folded = tuple((name, digest, late) for name, digest, late in found["folded"])
    table = LevelTable(found["night"], found["plan"], folded, {row.told.identity: row for row in rows})
    news = tuple(map(reader.change, found["news"]))
    counts = {name: found[name] for name in COUNTS}
    return FoldedNight(table, news, renamed=tuple(found["renamed"]), **counts)


def read_levels(place: Place, night: NightSummary) -> FoldedNight | None:
    """Levels in a night's folder; None if there are none of its present figures."""
    content = place.read(f"{night.name}/{FILE}")
    found = folded_of(content) if content else None
    return found if found and found.table.folded[-1][:2] == (night.name, night.digest) else None


def keep_levels(place: Place, folded: FoldedNight) -> None:
    """Keep the levels in the night's folder, if it can be written."""
    with contextlib.suppress(HistoryError):  # without them it only takes longer
        place.write(f"{folded.table.night}/{FILE}", content_of(folded))
