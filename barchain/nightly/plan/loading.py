"""Loading of a plan: the shipped one, or a TOML file, with errors that name the remedy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from barchain.nightly.history.faults import HistoryError
from barchain.nightly.history.model.identity import content_digest
from barchain.nightly.plan.tables import PlanFile
from scenarios.limits import LimitError
from scenarios.text import visible
from scenarios.toml.faults import fault_lines
from scenarios.toml.reading import UnreadableError, read_text, tables_of

SHIPPED = Path(__file__).with_name("default.toml")
DIGITS = 8


class PlanError(HistoryError):
    """Raised for a plan that can't be read or met; the message has one line for each fault."""


@dataclass(frozen=True)
class NightPlan:
    """Plan with the place of its file: files of scenes are looked for beside it."""

    file: PlanFile
    folder: Path
    shown: str = "plan"
    """Name of the file in messages"""

    @property
    def identity(self) -> str:
        """Name and digest of the content: nights of the same plan are expected to have the same figures."""
        content = self.file.model_dump(mode="json", exclude={"minutes"})
        return f"{self.file.name} {content_digest(content)[:DIGITS]}"


def load_plan(path: Path | None = None) -> NightPlan:
    """Plan of a file; the one that comes with barchain by default.

    Raises
    ------
    PlanError
        If the file can't be read or is no plan.
    """
    path = path or SHIPPED
    shown = visible(path) if path != SHIPPED else path.name
    try:
        file = PlanFile.model_validate(tables_of(read_text(path)))
    except ValidationError as error:
        raise PlanError("\n".join(f"{shown}: {line}" for line in fault_lines(error, PlanFile))) from None
    except (LimitError, UnreadableError) as error:
        raise PlanError(f"{shown}: {error}") from None
    return NightPlan(file, path.parent, shown)
