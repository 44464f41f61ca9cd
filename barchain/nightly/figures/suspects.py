"""Suspects: parts that differ between two nights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from barchain.nightly.figures.figure import REQUIREMENTS, NightPart
from barchain.nightly.figures.package_origins import state_words as shown
from reports.results.nights.document import SuspectEntry

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from barchain.nightly.figures.changes import Change
    from barchain.nightly.figures.figure import NightSummary

SOLUTION = "solution:"
ENGINES = ("engine:", "program:")
"""Beginnings of the names of engines"""


@dataclass(frozen=True)
class Suspect:
    """Part that may have caused a change."""

    name: str
    before: NightPart | None
    """None of a part that was not there"""
    after: NightPart | None

    @property
    def words(self) -> str:
        """Part with its versions, or the first digits of its digests where the version is the same."""
        return f"{self.name} {state_words(self.before, self.after)} → {state_words(self.after, self.before)}"

    @property
    def entry(self) -> SuspectEntry:
        """Entry of ``nightly.json``."""
        before = state_words(self.before, self.after) if self.before else ""
        after = state_words(self.after, self.before) if self.after else ""
        return SuspectEntry(name=self.name, before=before, after=after)


def differing(last: NightSummary, since: NightSummary, depends: Iterable[str]) -> tuple[Suspect, ...]:
    """Parts of some names that differ between two nights.

    Requirements of an engine whose own distribution differs came with it, and are no suspect beside it; nor is an
    adapter that is not there because no engine of it is.
    """
    if last.part_named == since.part_named:
        return ()
    found = []
    for name in sorted(depends):
        before, after = last.part_named.get(name), since.part_named.get(name)
        if before is None or after is None:
            there, own, other = (after, since, last) if before is None else (before, last, since)
            if there is not None and not is_renamed(there, own, other):
                found.append(Suspect(name, before, after))
        elif before.differs(after):
            found.append(Suspect(name, before, after))
    engines = {rest(one.name) for one in found if one.name.startswith("engine:")}
    absent = any(one.name.startswith(ENGINES) and None in (one.before, one.after) for one in found)

    def came_along(one: Suspect) -> bool:
        idle = absent and one.name.startswith("adapter:") and None in (one.before, one.after)
        return idle or (one.name.startswith(REQUIREMENTS) and rest(one.name) in engines)

    return tuple(one for one in found if not came_along(one))


def suspects_of(change: Change, nights: Mapping[str, NightSummary]) -> tuple[Suspect, ...]:
    """Suspects of a change, another setting among them; `nights` holds its two nights by name."""
    if change.last not in nights or change.since not in nights:
        return ()  # the night has been pruned
    found = differing(nights[change.last], nights[change.since], {*change.was.depends, *change.now.depends})
    if not change.settings:
        return found
    name = f"setting:{change.identity.engine}"
    return Suspect(name, *(NightPart(name, setting) for setting in change.settings)), *found


def unknown_parts(change: Change, nights: Mapping[str, NightSummary]) -> tuple[str, ...]:
    """Parts behind a change of which it is not known whether they differ: of equal versions, without a digest."""
    if gone := [name for name in (change.last, change.since) if name not in nights]:
        return (f"all parts, as the night {gone[0]} is not there any more",)
    last, since = nights[change.last].part_named, nights[change.since].part_named
    both = [name for name in sorted({*change.was.depends, *change.now.depends}) if name in last and name in since]
    return tuple(
        name for name in both
        if not (last[name].digest and since[name].digest) and last[name].version == since[name].version
    )  # fmt: skip


def is_renamed(part: NightPart, own: NightSummary, other: NightSummary) -> bool:
    """Whether a part of one night is there under another name on another: one of the same kind with equal content.

    A solution that a night made has no digest of its own: it is that of its scene.
    """
    if part.name.startswith(SOLUTION) and not part.digest:
        part = own.part_named.get(f"scene:{rest(part.name)}", part)
    kind = f"{part.name.partition(':')[0]}:"
    return bool(part.digest) and any(each.digest == part.digest and each.name.startswith(kind) for each in other.parts)


def rest(name: str) -> str:
    """Name of a part without its kind."""
    return name.partition(":")[2]


def state_words(part: NightPart | None, other: NightPart | None) -> str:
    """State of a part beside another one."""
    if part is None:
        return "(none)"
    if part.name.startswith(REQUIREMENTS) and other is not None:
        own, others = part.version.split(", "), other.version.split(", ")
        return ", ".join(each for each in own if each not in others) or part.digest[:8]
    alike = other is not None and part.version == other.version
    return part.digest[:8] if alike or not part.version else shown(part.version)
