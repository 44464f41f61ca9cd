"""One night as a JSON file: a baseline that a user keeps, e.g. in a repository."""

from __future__ import annotations

import datetime
import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from barchain.nightly.history.faults import HistoryError
from barchain.nightly.history.model.checked_text import FigureError
from barchain.nightly.history.model.figures import (
    Environment,
    Figure,
    FigureIdentity,
    FigureKind,
    FigureUnit,
    Night,
    NightPart,
)
from reports.tables.writing import write_atomically

if TYPE_CHECKING:
    from pathlib import Path

FORMAT = "barchain night 1"


def write_night(night: Night, path: Path) -> None:
    """Write a night as JSON.

    Raises
    ------
    OSError
        If the file can't be written; an earlier file then stays.
    """
    content = {"format": FORMAT} | asdict(night) | {"started": night.started.isoformat()}
    write_atomically(path, json.dumps(content, indent=1, allow_nan=False) + "\n")


def read_night_file(path: Path) -> Night:
    """Read a night that :func:`write_night` wrote.

    Raises
    ------
    HistoryError
        If the file can't be read, or is something else.
    """
    try:
        found = json.loads(path.read_text("utf-8"))
        if not isinstance(found, dict) or found.pop("format", None) != FORMAT:
            raise HistoryError(
                f"{path}: is no file of a night; `barchain history export --json FILE --night NIGHT` makes one"
            )
        return night_of(found)
    except OSError as error:
        raise HistoryError(f"{path}: can't be read: {error.strerror}") from None
    except (ValueError, TypeError, KeyError, FigureError) as error:
        if isinstance(error, HistoryError):
            raise
        raise HistoryError(f"{path}: is damaged: {error}") from None


def night_of(found: dict[str, Any]) -> Night:
    """Night of the entries of its file."""
    content = dict(found)
    content["started"] = datetime.datetime.fromisoformat(content["started"])
    content["environment"] = Environment(**content["environment"])
    content["parts"] = tuple(NightPart(**part) for part in content["parts"])
    content["figures"] = tuple(map(figure_of, content["figures"]))
    return Night(**content)


def figure_of(found: dict[str, Any]) -> Figure:
    """Figure of its entry."""
    content = dict(found)
    own = content.pop("identity")
    identity = FigureIdentity(**(own | {"kind": FigureKind(own["kind"]), "unit": FigureUnit(own["unit"])}))
    return Figure(identity, **(content | {"depends": tuple(content["depends"])}))
