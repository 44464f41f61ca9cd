"""Accepted changes: one file that can be reviewed, with an entry for each pattern of figures and night.

An entry accepts the step of one night, or the steps up to that night. It ends on its date, and where the figure is back
at its level; a figure that becomes worse again is another night's change.
"""

from __future__ import annotations

import datetime
import fnmatch
import json
from typing import TYPE_CHECKING, Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, StringConstraints, ValidationError

from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.changes import results_words
from barchain.nightly.figures.figure import MOST_TEXT
from barchain.nightly.figures.steps import LEAST_EFFECT
from scenarios.nearest import nearest
from scenarios.toml.faults import fault_lines
from scenarios.toml.reading import tables_of
from scenarios.toml.scene_tables import words

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from barchain.nightly.figures.changes import Change
    from barchain.nightly.history.nights import NightStore


FILE = "accepted.toml"
HEAD = "# Changes that somebody accepted on purpose. `barchain history accept` and `withdraw` write this file.\n"
NO_ACCEPTANCE = "a run that is not reproducible can't be accepted"


def utc(given: datetime.datetime) -> datetime.datetime:
    """Instant; a date, or a time without its zone, is of UTC."""
    return given if given.tzinfo else given.replace(tzinfo=datetime.UTC)


Instant = Annotated[datetime.datetime, AfterValidator(utc)]
Line = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1), words(4 * MOST_TEXT)]


class Acceptance(BaseModel):
    """Changes of one night that somebody accepted."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    pattern: Line
    """Name of a figure, in which * stands for any text"""
    was: str = ""
    became: str = ""
    """Results of a single figure in words, for readers"""
    cause: str = ""
    """Suspects of the changes, for readers"""
    first: str = ""
    """Night of the first step that is accepted with that of `since`; empty if it is the only one"""
    since: Line
    """Name of the night of the latest step that is accepted"""
    reason: Line
    who: Line
    date: Instant
    until: Instant | None = None
    """The changes come back afterwards"""
    factors: dict[str, float] = {}
    """Accepted steps of times and memory, by name of the figure"""

    def reaches(self, latest: str, first: str, names: Iterable[str]) -> bool:
        """Whether it accepts the step of a night, with all steps since another night, of a figure of some names."""
        own = start(self.since) == start(latest) and start(self.first or self.since) <= start(first)
        return own and any(fits(name, self.pattern) for name in names)

    @property
    def words(self) -> str:
        """Acceptance in one line."""
        ending = f", until {self.until.date()}" if self.until else ""
        moved = f": {self.became} (before {self.was})" if self.became else ""
        nights = f"{self.first}, up to {self.since}" if self.first else self.since
        return f"{self.pattern}{moved}, since {nights}, by {self.who} on {self.date.date()}{ending}: {self.reason}"


class AcceptedFile(BaseModel):
    """The file of all acceptances."""

    model_config = ConfigDict(extra="forbid")

    accepted: list[Acceptance] = []


def fits(figure: str, pattern: str) -> bool:
    """Whether the name of a figure fits a pattern, in which * stands for any text."""
    return figure == pattern or fnmatch.fnmatchcase(figure, pattern.replace("[", "[[]"))


def acceptances_of(
    changes: Sequence[Change], who: str, date: datetime.datetime, reason: str,
    until: datetime.datetime | None = None, pattern: str = "", causes: Mapping[str, str] | None = None,
) -> list[Acceptance]:  # fmt: skip
    """Acceptances of changes as they stand: one for each night of a pattern, or for each figure and night.

    Raises
    ------
    HistoryError
        If a change is that a run is not reproducible, or the end has passed already.
    """
    if until is not None and until <= date:
        raise HistoryError(f"--until {until.date()}: has passed; allowed: a later date")
    refused = next((change for change in changes if change.irreproducible), None)
    if refused is not None:
        raise HistoryError(f"{refused.identity.name}: {NO_ACCEPTANCE}; nothing was accepted")
    grouped: dict[tuple[str, str, str], list[Change]] = {}
    for change in changes:
        nights = (change.since, change.through) if change.through else ("", change.since)
        grouped.setdefault((pattern or change.identity.name, *nights), []).append(change)
    made = []
    for (name, first, since), own in grouped.items():
        factors = {c.identity.name: c.factor for c in own if c.is_step and c.factor is not None}
        said = sorted({(causes or {}).get(change.id, "") for change in own} - {""})
        single = own[0] if name == own[0].identity.name else None
        was, became = results_words(single) if single else ("", "")
        made.append(
            Acceptance(
                pattern=name, was=was, became=became, cause="; ".join(said)[:MOST_TEXT], first=first, since=since,
                reason=reason, who=who, date=date, until=until, factors=factors,
            )
        )  # fmt: skip
    return made


def holding(known: Iterable[Acceptance], at: datetime.datetime) -> list[Acceptance]:
    """Acceptances that have not ended at an instant."""
    return [one for one in known if one.until is None or at < one.until]


def accepting(change: Change, known: Iterable[Acceptance], at: datetime.datetime) -> Acceptance | None:
    """Last acceptance that covers a change by itself at an instant; None without, and of what is not reproducible.

    A change of another night is another change, though it may lead to the same value.
    """
    if change.irreproducible:
        return None
    covering = [
        one for one in holding(known, at)
        if one.reaches(change.since, change.since, change.names) and is_as_large(one, change)
    ]  # fmt: skip
    return covering[-1] if covering else None


def is_as_large(acceptance: Acceptance, change: Change) -> bool:
    """Whether a step of times, or memory, is as large as it was accepted, within its interval and the least effect.

    Later steps beside it make it grow. Other changes have no size of their own.
    """
    if not change.is_step:
        return True
    accepted = next((acceptance.factors[name] for name in change.names if name in acceptance.factors), None)
    if accepted is None or change.factor is None:
        return False
    low, high = change.factor_low or change.factor, change.factor_high or change.factor
    return low / (1.0 + LEAST_EFFECT) <= accepted <= high * (1.0 + LEAST_EFFECT)


def start(night: str) -> str:
    """Start of a night by its name."""
    return night.rpartition("-")[0]


def accepted(store: NightStore) -> tuple[Acceptance, ...]:
    """All acceptances, in the order in which they were given.

    Raises
    ------
    HistoryError
        If the file is something else; the message has a line for each fault.
    """
    try:
        found = AcceptedFile.model_validate(tables_of((store.place.read(FILE) or b"").decode()))
    except ValidationError as error:
        lines = fault_lines(error, AcceptedFile)
        raise HistoryError("\n".join(f"{store}/{FILE}: {line}" for line in lines)) from None
    except ValueError as error:
        raise HistoryError(f"{store}/{FILE}: {error}") from None
    return tuple(sorted(found.accepted, key=lambda one: one.date))


def write_accepted(store: NightStore, known: Iterable[Acceptance]) -> None:
    """Write the file with all acceptances."""
    store.place.write(FILE, "\n".join([HEAD, *map(entry_text, known)]).encode())


def entry_text(one: Acceptance) -> str:
    """Entry of the file."""
    lines = ["[[accepted]]"]
    for key, value in one.model_dump(exclude_defaults=True, exclude={"factors"}).items():
        text = value.isoformat() if isinstance(value, datetime.datetime) else json.dumps(value, ensure_ascii=False)
        lines.append(f"{key} = {text}")
    if one.factors:
        pairs = (f"{json.dumps(name, ensure_ascii=False)} = {factor!r}" for name, factor in one.factors.items())
        lines.append(f"factors = {{ {', '.join(pairs)} }}")
    return "\n".join(lines) + "\n"


def accept(
    store: NightStore, changes: Sequence[Change], who: str, reason: str, until: datetime.datetime | None = None,
    pattern: str = "", causes: Mapping[str, str] | None = None,
) -> list[Acceptance]:  # fmt: skip
    """Store that somebody accepts some changes: all of them, or none. An earlier entry for the same ones is replaced.

    Errors are those of :func:`acceptances_of`.
    """
    made = acceptances_of(changes, who, datetime.datetime.now(datetime.UTC), reason, until, pattern, causes)
    new = {(one.pattern, one.first, one.since) for one in made}
    write_accepted(store, [*(a for a in accepted(store) if (a.pattern, a.first, a.since) not in new), *made])
    return made


def withdraw(store: NightStore, pattern: str, since: str = "") -> list[Acceptance]:
    """Remove the acceptances of a pattern, all or those of one night, and return them.

    Raises
    ------
    HistoryError
        If there is none; the message gives the nearest pattern.
    """
    known = accepted(store)
    gone = [one for one in known if one.pattern == pattern and one.since.startswith(since)]
    if not gone:
        raise HistoryError(f"{pattern[:80]}: nothing is accepted for it{nearest(pattern, {a.pattern for a in known})}")
    write_accepted(store, [one for one in known if one not in gone])
    return gone
