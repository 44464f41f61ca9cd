"""Judgement of a gate: the rules of nights on two builds, with known failures as an overlay."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from barchain.nightly.errors import PinnedEnvironmentError
from barchain.nightly.figures.changes import RIGHT, VERDICT
from barchain.nightly.figures.figure import STEPPED, FigureKind
from barchain.nightly.figures.suspects import differing
from barchain.nightly.gate.known import covering
from barchain.nightly.gate.measuring import least_rounds, time_changes_between
from barchain.nightly.history.judging import judge_pair
from barchain.nightly.telling.document import change_entry, events, weight
from barchain.nightly.telling.sentence import amount, are
from reports.results.nights.gate import GateResult
from reports.results.outcome import Outcome
from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from barchain.nightly.figures.figure import Figure, Night
    from barchain.nightly.gate.known import KnownFailure
    from barchain.nightly.gate.measuring import SceneTimes
    from barchain.nightly.history.levels import JudgedNight
    from reports.results.nights.document import ChangeEntry

MOST_PARTS = 5
"""Parts that differ and are named"""


def verdicts_of(night: Night) -> list[Figure]:
    """Verdicts of a comparison."""
    return [figure for figure in night.figures if figure.identity.quantity == VERDICT]


def judged_gate(
    engine: str, specs: tuple[str, str], nights: tuple[Night, Night], times: dict[str, SceneTimes],
    known: tuple[KnownFailure, ...], asked: int,
) -> GateResult:  # fmt: skip
    """Judge the head against the base.

    Parameters
    ----------
    engine : str
    specs : tuple of str
        Base and head as they were given.
    nights : tuple of Night
        Figures of both.
    times : dict
        Times in turns, by scene.
    known : tuple of KnownFailure
    asked : int
        Number of scenes that were asked for.

    Raises
    ------
    PinnedEnvironmentError
        If the builds were not measured on one class of machine, or the base passes no scene.
    """
    base, head = nights
    if base.environment.machine_class != head.environment.machine_class:
        cpus = ", ".join(dict.fromkeys((base.environment.cpu, head.environment.cpu)))
        raise PinnedEnvironmentError(f"base and head were measured on different processors ({cpus}); run them again")
    if not any(figure.word in RIGHT for figure in verdicts_of(base)):  # nothing could be worse beside it
        said = next((f"; {f.identity.scene}: {f.word or 'missing'}, {f.reason}" for f in verdicts_of(base)), "")
        raise PinnedEnvironmentError(f"{specs[0]}: passes no scene, so that nothing can be worse{said}")
    judged = judge_pair(base, head)
    changes = [*judged.tonight, *time_changes_between(times, engine, base, head)]
    entries = sorted((change_entry(change, judged.by_name, None, "") for change in changes), key=weight)
    worse = [entry for entry in entries if entry.direction == "worse"]
    entry_of = {entry.figure: covering(known, entry.figure) for entry in worse}
    listed = [entry for entry in worse if entry_of[entry.figure]]
    unlisted = [entry for entry in worse if not entry_of[entry.figure]]
    ended = tuple(one.words for one in known if one.ended)
    moved = [entry for entry in entries if entry.kind != FigureKind.BITS]
    return GateResult(
        answer(unlisted, len(listed), len(ended), judged.judged, asked - len(verdicts_of(head))), engine, *specs,
        worse=grouped(unlisted),
        listed=tuple((entry, one.words) for entry in grouped(listed) if (one := entry_of[entry.figure])),
        better=grouped(entry for entry in moved if entry.direction == "better"),
        changed=grouped(entry for entry in moved if entry.direction == "changed"),
        ended=ended,
        passing=tuple(passing(known, head.figures, worse)),
        notes=tuple(filter(None, notes(judged, nights, times, entries))),
    )  # fmt: skip


def answer(worse: Sequence[ChangeEntry], listed: int, ended: int, figures: int, left: int) -> str:
    """First sentence, of what is worse, the numbers of known failures, of figures, and of scenes that had no time."""
    scenes = len({entry.scene for entry in worse})
    where = f" in {amount(scenes, 'scene')}" if scenes else ""
    said = f"{are(len(worse), 'figure')} worse{where}" if worse else "Nothing is worse"
    known = f"{amount(listed, 'figure')} that {'is' if listed == 1 else 'are'} known"
    more = f" {'beside' if worse else 'but'} {known}" if listed else ""
    over = f"; {amount(ended, 'known failure')} ended" if ended else ""
    unseen = f"; {amount(left, 'scene')} had no time" if left else ""
    return f"{said}{more}, among {figures} figures{over}{unseen}."


def grouped(entries: Iterable[ChangeEntry]) -> tuple[ChangeEntry, ...]:
    """Changes, of each scene the gravest with the number of the others; times for themselves."""
    groups: dict[tuple[str, bool], list[ChangeEntry]] = {}
    for entry in events(list(entries)):
        groups.setdefault((entry.scene, entry.kind in STEPPED), []).append(entry)
    return tuple(
        own[0].model_copy(update={"also": sum(one.also + 1 for one in own) - 1}) for own in groups.values()
    )  # fmt: skip


def passing(known: Iterable[KnownFailure], figures: Sequence[Figure], worse: Sequence[ChangeEntry]) -> Iterator[str]:
    """Known failures that cover figures of the head of which none is worse, and no verdict is a failure."""
    names = [entry.figure for entry in worse]
    verdicts = {f.identity.name: f.word for f in figures if f.identity.quantity == VERDICT}
    for one in known:
        own = [word for name, word in verdicts.items() if one.covers(name)]
        seen = own or any(one.covers(f.identity.name) for f in figures)
        fine = all(word in RIGHT or word == str(Outcome.UNSUPPORTED) for word in own)
        if seen and fine and not one.ended and not any(map(one.covers, names)):
            yield one.words


def notes(
    judged: JudgedNight, nights: tuple[Night, Night], times: dict[str, SceneTimes], entries: Sequence[ChangeEntry]
) -> Iterator[str]:
    """What was compared, and what was not."""
    base, head = nights
    counts = Counter(figure.word or "missing" for figure in verdicts_of(head))
    yield f"Verdicts of the head: {', '.join(f'{n} {word}' for word, n in counts.most_common())}."
    bits = {e.scene for e in entries if e.kind == FigureKind.BITS and not e.irreproducible}
    runs = {f.identity.scene for f in head.figures if f.identity.kind is FigureKind.BITS and not f.missing}
    yield f"Trajectories have other bits in {len(bits)} of {len(runs)} scenes."
    yield f"{judged.same} figures differ within rounding." if judged.same else ""
    yield "".join(f"{words}. " for words in judged.renamed).strip()
    rounds = min((one.rounds for one in times.values()), default=0)
    if rounds < least_rounds(len(times)):
        needed = f"{plural(rounds, 'round')} of {least_rounds(len(times))} that they need; --minutes allows more"
        yield f"Times were not judged: {needed}."
    else:
        yield f"Times: {plural(rounds, 'round')} of both builds in turns, of {', '.join(times)}."
    parts = differing(base.summary(), head.summary(), {name for f in head.figures for name in f.depends})
    more = f" and {len(parts) - MOST_PARTS} more" if len(parts) > MOST_PARTS else ""
    yield f"Parts that differ: {', '.join(part.words for part in parts[:MOST_PARTS])}{more}." if parts else ""
    yield f"Processor: {head.environment.cpu}."
