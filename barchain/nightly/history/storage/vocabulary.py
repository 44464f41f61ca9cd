"""Rows that nights share: texts, identities of figures, parts and environments. Each is stored once, by its digest."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from typing import TYPE_CHECKING, Any, TypeVar

import sqlalchemy as sa
from sqlalchemy.dialects import postgresql, sqlite

from barchain.nightly.history.model.figures import Environment, FigureIdentity, FigureKind, FigureUnit, NightPart
from barchain.nightly.history.model.identity import content_digest
from barchain.nightly.history.storage.tables import environments, night_parts, parts, series, texts

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from sqlalchemy import Connection, Table

ItemT = TypeVar("ItemT")
CHUNK = 400
"""Values in one query; SQLite of old allows 999 parameters"""


def insert_new(connection: Connection, table: Table, rows: Sequence[Mapping[str, Any]]) -> None:
    """Insert rows, except those that are there already."""
    make = postgresql.insert if connection.dialect.name == "postgresql" else sqlite.insert
    if rows:
        connection.execute(make(table).on_conflict_do_nothing(), [dict(row) for row in rows])


def numbers_by_digest(connection: Connection, table: Table, rows: Mapping[str, Mapping[str, Any]]) -> dict[str, int]:
    """Numbers of rows by their digests; rows that are not there yet are added."""
    found = present(connection, table, rows)
    missing = sorted(set(rows) - set(found))
    if missing:
        insert_new(connection, table, [{"digest": digest, **rows[digest]} for digest in missing])
        found |= present(connection, table, missing)
    return found


def present(connection: Connection, table: Table, digests: Iterable[str]) -> dict[str, int]:
    """Numbers of the rows that are there, by digest."""
    found: dict[str, int] = {}
    for some in pieces(list(digests)):
        rows = connection.execute(sa.select(table.c.digest, table.c.id).where(table.c.digest.in_(some)))
        found |= {row.digest: row.id for row in rows}
    return found


def pieces(items: Sequence[ItemT], most: int = CHUNK) -> Iterator[Sequence[ItemT]]:
    """Pieces of a sequence that one query takes: databases limit the number of parameters."""
    for first in range(0, len(items), most):
        yield items[first : first + most]


def text_numbers(connection: Connection, wanted: Iterable[str]) -> dict[str, int]:
    """Numbers of texts."""
    digests = {hashlib.sha256(text.encode("utf-8")).hexdigest(): text for text in set(wanted)}
    numbers = numbers_by_digest(connection, texts, {d: {"text": text} for d, text in digests.items()})
    return {text: numbers[digest] for digest, text in digests.items()}


def series_numbers(connection: Connection, wanted: Iterable[FigureIdentity]) -> dict[FigureIdentity, int]:
    """Numbers of the series of figures."""
    digests = {content_digest(identity): identity for identity in wanted}
    numbers = numbers_by_digest(connection, series, {d: identity_columns(i) for d, i in digests.items()})
    return {identity: numbers[digest] for digest, identity in digests.items()}


def identity_columns(identity: FigureIdentity) -> dict[str, str]:
    """Columns of an identity."""
    return {field.name: str(getattr(identity, field.name)) for field in dataclasses.fields(identity)}


def identity_of(row: Any) -> FigureIdentity:
    """Identity of a row of the table of series."""
    return FigureIdentity(
        row.scene, row.engine, row.setting, row.quantity, FigureKind(row.kind), FigureUnit(row.unit), row.anchor
    )


def environment_number(connection: Connection, environment: Environment) -> int:
    """Number of an environment."""
    digest = content_digest(environment)
    columns = dataclasses.asdict(environment) | {"machine_class": environment.machine_class}
    return numbers_by_digest(connection, environments, {digest: columns})[digest]


def environment_of(row: Any) -> Environment:
    """Environment of a row."""
    return Environment(**{field.name: getattr(row, field.name) for field in dataclasses.fields(Environment)})


def link_parts(connection: Connection, night: int, wanted: Iterable[NightPart]) -> None:
    """Store the parts of a night."""
    known = list(wanted)
    insert_new(connection, parts, [dataclasses.asdict(part) for part in known])
    names = {part.name for part in known}
    rows = connection.execute(sa.select(parts.c.id, parts.c.name, parts.c.version, parts.c.digest))
    numbers = {NightPart(row.name, row.version, row.digest): row.id for row in rows if row.name in names}
    insert_new(connection, night_parts, [{"night_id": night, "part_id": numbers[part]} for part in known])


def parts_by_night(connection: Connection, nights: Sequence[int]) -> dict[int, tuple[NightPart, ...]]:
    """Parts of some nights, by name. Equal parts are one object: nights share most of them."""
    rows = connection.execute(sa.select(parts).order_by(parts.c.name))
    known = {row.id: NightPart(row.name, row.version, row.digest) for row in rows}
    place = {part: k for k, part in enumerate(known)}
    found: dict[int, list[int]] = {number: [] for number in nights}
    for some in pieces(nights):
        chosen = sa.select(night_parts.c.night_id, night_parts.c.part_id).where(night_parts.c.night_id.in_(some))
        for night, part in connection.execute(chosen):
            found[night].append(part)
    return {number: tuple(known[part] for part in sorted(own, key=place.__getitem__)) for number, own in found.items()}


def depends_text(names: Sequence[str]) -> str:
    """Names of parts as one text."""
    return json.dumps(list(names), ensure_ascii=False)


def depends_of(text: str) -> tuple[str, ...]:
    """Names of parts from the text."""
    return tuple(json.loads(text))
