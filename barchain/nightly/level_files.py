"""Levels after a night as a file in the night's folder: a cache of the fold, which may be deleted."""

from __future__ import annotations

import contextlib
import hashlib
import zlib
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

from barchain.nightly.faults import HistoryError
from barchain.nightly.levels import FoldedNight, Level  # noqa: TC001  # pydantic reads the annotations of files

if TYPE_CHECKING:
    from pydantic import TypeAdapter

    from barchain.nightly.figures import NightSummary
    from barchain.nightly.place import Place


FILE = "levels.z"
FORMAT = 1
MOST_B = 256 * 2**20
"""Largest content: 6600 figures take 8 MB"""
DIGEST_B = 64
"""Bytes of the digest of all that follows it: compressed JSON"""


@dataclass(frozen=True)
class LevelFile:
    """Content of the file."""

    format: int
    folded: FoldedNight
    """Without its levels: their names are no keys of JSON"""
    rows: tuple[Level, ...]


@cache
def files() -> TypeAdapter[LevelFile]:
    """Form of the file."""
    from pydantic import TypeAdapter  # noqa: PLC0415

    return TypeAdapter(LevelFile)


def content_of(folded: FoldedNight) -> bytes:
    """File of a folded night."""
    bare = replace(folded, table=replace(folded.table, rows={}))
    content = LevelFile(FORMAT, bare, tuple(folded.table.rows.values()))
    packed = zlib.compress(files().dump_json(content))
    return hashlib.sha256(packed).hexdigest().encode() + packed


def folded_of(content: bytes) -> FoldedNight | None:
    """Folded night of a file; None of a damaged one, or of another format."""
    digest, packed = content[:DIGEST_B], content[DIGEST_B:]
    if hashlib.sha256(packed).hexdigest().encode() != digest:
        return None
    try:
        found = files().validate_json(zlib.decompressobj().decompress(packed, MOST_B))
    except (ValueError, zlib.error):  # of another version, or larger than any night
        return None
    rows = {row.told.identity: row for row in found.rows}
    return replace(found.folded, table=replace(found.folded.table, rows=rows)) if found.format == FORMAT else None


def read_levels(place: Place, night: NightSummary) -> FoldedNight | None:
    """Levels in a night's folder; None if there are none of its present figures."""
    content = place.read(f"{night.name}/{FILE}")
    found = folded_of(content) if content else None
    return found if found and found.table.folded[-1][:2] == (night.name, night.digest) else None


def keep_levels(place: Place, folded: FoldedNight) -> None:
    """Keep the levels in the night's folder, if it can be written."""
    with contextlib.suppress(HistoryError):  # without them it only takes longer
        place.write(f"{folded.table.night}/{FILE}", content_of(folded))
