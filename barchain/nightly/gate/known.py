"""Known failures of a project: a file in its repository, with a reason and perhaps an end for each of them."""

from __future__ import annotations

import datetime
from typing import TYPE_CHECKING, Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.figure import MOST_TEXT
from barchain.nightly.history.acceptances import fits
from scenarios.named_file import UnreadableError
from scenarios.size_limits import LimitError
from scenarios.toml.faults import fault_lines
from scenarios.toml.reading import read_text, tables_of
from scenarios.toml.scene_tables import words

if TYPE_CHECKING:
    from pathlib import Path

FILE = "known_failures.toml"


Words = Annotated[str, Field(min_length=1), words(MOST_TEXT)]


class KnownFailure(BaseModel):
    """Figures that may be worse."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    pattern: Words = Field(description="name of a figure, in which * stands for any text, or of a scene")
    reason: Words = Field(description="why the failure is known and not mended")
    until: datetime.date | None = Field(None, description="day on which the entry ends, UTC")

    def covers(self, figure: str) -> bool:
        """Whether the name of a figure fits; a pattern without a colon is that of its scene."""
        return fits(figure, self.pattern) or (":" not in self.pattern and fits(figure.partition(":")[0], self.pattern))

    @property
    def ended(self) -> bool:
        """Whether the entry has ended."""
        return self.until is not None and self.until <= datetime.datetime.now(datetime.UTC).date()

    @property
    def words(self) -> str:
        """Entry in one line."""
        until = f" ({'ended on' if self.ended else 'until'} {self.until})" if self.until else ""
        return f"{self.pattern}: {self.reason}{until}"


class KnownFile(BaseModel):
    """A file of known failures."""

    model_config = ConfigDict(extra="forbid")

    failure: list[KnownFailure] = Field(default_factory=list, description="one known failure each")


def known_failures(path: Path) -> tuple[KnownFailure, ...]:
    """Known failures of a file; none without the file.

    Raises
    ------
    HistoryError
        If the file can't be read, or has a fault; the message has one line for each fault.
    """
    if not path.exists():
        return ()
    try:
        return tuple(KnownFile.model_validate(tables_of(read_text(path))).failure)
    except (LimitError, UnreadableError) as error:
        raise HistoryError(f"{path}: {error}") from None
    except ValidationError as error:
        raise HistoryError("\n".join(f"{path}: {line}" for line in fault_lines(error, KnownFile))) from None


def covering(known: tuple[KnownFailure, ...], figure: str) -> KnownFailure | None:
    """First known failure that covers a figure of a name and has not ended."""
    return next((one for one in known if not one.ended and one.covers(figure)), None)
