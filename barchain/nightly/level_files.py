"""Levels after a night as a file in the night's folder: a cache of the fold, which may be deleted."""

from __future__ import annotations

import contextlib
import hashlib
import zlib
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

from barchain.nightly.faults import HistoryError
from barchain.nightly.figures import Figure  # noqa: TC001  # pydantic reads the annotations of files
from barchain.nightly.levels import FoldedNight, LevelOf  # noqa: TC001  # the same

if TYPE_CHECKING:
    from pydantic import TypeAdapter

    from barchain.nightly.figures import NightSummary
    from barchain.nightly.place import Place


FILE = "levels.z"
FORMAT = 3
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


@cache
def files() -> TypeAdapter[LevelFile]:
    """Form of the file."""
    from pydantic import TypeAdapter  # noqa: PLC0415

    return TypeAdapter(LevelFile)


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
    packed = zlib.compress(files().dump_json(LevelFile(FORMAT, bare, tuple(figures), rows)), QUICK)
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
    rows = {row.told.identity: row for row in (row.mapped(found.figures.__getitem__) for row in found.rows)}
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
