"""The sentences that open the page of a night."""

from __future__ import annotations

import datetime
import textwrap
from collections import Counter
from itertools import takewhile
from typing import TYPE_CHECKING

from barchain.nightly.history.news import AttributionVerdict
from reports.results.nights.document import ratio_words
from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.figures.figure import NightSummary
    from barchain.nightly.history.levels import JudgedNight
    from reports.results.nights.document import ChangeEntry, NightlyFile, NightRun, RejectedEntry, SuspectEntry


SMALL = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
MOST_CAUSES = 3
MOST_SUSPECTS = 3
DIRECTIONS = {"worse": "for the worse", "better": "for the better", "changed": "neither better nor worse"}
NOT_REPRODUCIBLE = "not reproducible: the same sources, versions and machine class gave other bits"
NOT_JUDGED = "Nothing was judged: no figure of this night has an earlier one."
NO_FIGURES = "Nothing was judged: this night has no figures."
MOST_STANDING = 200
"""Characters of the sentence on what is worse than accepted; beyond them it names fewer causes"""
MOST_REASON = 120
"""Characters of a reason in the sentence; the page has all"""


def opening(judged: JudgedNight, facts: NightlyFile) -> str:
    """Sentences on a night: what is worse than accepted, what is new, and what was not measured and why.

    Parameters
    ----------
    judged : JudgedNight
    facts : NightlyFile
        Facts of the night, without their sentences.
    """
    night, changes, baseline = judged.night, facts.changes, facts.against.baseline
    if night.void:
        return f"This night is void: {night.void}."
    unmeasured = not_measured(facts.run, complete=night.complete)
    if baseline and not judged.judged:
        return joined(unmeasured, f"Nothing was compared: {baseline} has no figure of this night.")
    if judged.is_first:
        return joined(
            unmeasured, no_pass(facts.rejected), "This is the first night: there is no earlier one to compare it with."
        )
    since = f" since {baseline}" if baseline else " tonight"
    told = [change for change in changes if change.accepted is None]
    wild = sum(change.irreproducible for change in told)
    new = figures([c for c in facts.other_news if c.direction == "worse" and not (c.accepted or c.irreproducible)])
    news = joined(
        counted(wild, "run", NOT_REPRODUCIBLE),
        changes_words([change for change in told if not change.irreproducible], since, judged.judged),
        accepted_words(figures(changes) - figures(told), since, judged.judged, alone=not told),
    )
    unseen = figures([change for change in facts.standing if change.measured])
    many = plural(judged.judged, "measured figure" if facts.standing else "figure")
    quiet = f"Nothing changed{since} among {many}."
    if facts.standing:
        tonight = "Nothing else changed tonight." if judged.new else "Nothing is new tonight."
        quiet = f"Nothing is new among {many}." if unseen else tonight
    if not judged.judged:
        quiet = NOT_JUDGED if night.figures else NO_FIGURES
    broken = "" if news or facts.standing else no_pass(facts.rejected)
    better = told and not (facts.standing or new or baseline) and all(change.direction == "better" for change in told)
    standing = "Nothing is worse than accepted." if better else standing_words(facts.standing, new, night)
    held = figures(facts.held)
    return joined(
        standing, news, unmeasured, broken, "" if news else quiet,
        "" if baseline else not_ended(judged.compared_with),
        counted(held, "figure", "worse, and accepted"),
        renamed_words(judged.renamed), plan_words(judged, baseline),
    )  # fmt: skip


def joined(*sentences: str) -> str:
    """Sentences one after the other; what is cut short ends in its ellipsis."""
    return " ".join(filter(None, sentences)).replace("….", "…")


def standing_words(every: Sequence[ChangeEntry], new: int, night: NightSummary) -> str:
    """What is worse than accepted, by how much, since when and by what; empty if nothing is since an earlier night.

    The `new` figures that are worse since tonight count, too; the sentence after this one is about them. Beside others,
    those that failed tonight from their first night on are new ones.
    """
    if not every:
        return ""
    standing = [change for change in every if change.since != night.name]
    new += figures(every) - figures(standing)
    if not standing and new > figures(every):
        return f"{are(new, 'figure')} worse than accepted, all of them new tonight."
    if not standing:
        standing, new = list(every), 0
    groups: dict[tuple[str, str], list[ChangeEntry]] = {}
    for change in standing:
        names = "from the first night on" if change.never_words else suspect_names(change.suspects)
        groups.setdefault((change.since[:10], names), []).append(change)
    count = figures(standing)
    unseen = figures([change for change in standing if change.measured])
    which = "not" if count == unseen == 1 else "none of them" if count == unseen else f"{amount(unseen)} of them not"
    later = f"; {which} measured tonight" if unseen else ""
    what = f"{are(count + new, 'figure')} worse than accepted"
    if new:
        what += f", {amount(new)} of them new tonight; the other {amount(count)}"
    what += by_words(standing)
    if len(groups) == 1:
        return f"{what} {group_words(*next(iter(groups)), standing, night.started)}{later}."
    ordered, said = sorted(groups.items(), key=lambda group: -figures(group[1])), ""
    for most in range(MOST_CAUSES, 0, -1):
        words = [f"{amount(figures(own))} {group_words(*group, own, night.started)}" for group, own in ordered[:most]]
        more = sum(figures(own) for _, own in ordered[most:])
        said = f"{what}: {listed([*words, f'{amount(more)} more'] if more else words)}{later}."
        if len(said) <= MOST_STANDING:
            break
    return said


def suspect_names(suspects: Sequence[SuspectEntry]) -> str:
    """``engine:mujoco 4.0.0, library:numpy 2.4.6``: the first suspects of a change, as they are now."""
    return ", ".join(f"{one.short} {one.after}".strip() for one in suspects[:MOST_SUSPECTS])


def by_words(worse: Sequence[ChangeEntry]) -> str:
    """`` by up to ×6``; empty without a factor."""
    largest = max((change.factor or 0.0 for change in worse), default=0.0)
    return f" by {'up to ' if figures(worse) > 1 else ''}{ratio_words(largest)}" if largest > 1.0 else ""


def group_words(day: str, names: str, worse: Sequence[ChangeEntry], tonight: datetime.datetime) -> str:
    """``since 3 November (program:mine 1.1)``.

    Of several steps: ``(first mine 1.1; two steps, the latest with mine 1.2)``, or ``(first mine 1.1; two steps, ×1.3
    tonight)``: the sentence after this one has the cause of what is new.
    """
    date = datetime.date.fromisoformat(day)
    year = f" {date.year}" if date.year != tonight.year else ""
    steps, fresh = max(change.steps for change in worse), max(change.fresh or 0.0 for change in worse)
    if steps > 1:
        up_to = "up to " if len({change.steps for change in worse}) > 1 else ""
        newest = {suspect_names(change.newest) for change in worse if change.steps > 1}
        latest = f", the latest with {newest.pop()}" if len(newest) == 1 and newest != {""} else ""
        last = f", {ratio_words(fresh)} tonight" if fresh else latest
        names = "; ".join(filter(None, [f"first {names}" if names else "", f"{up_to}{amount(steps)} steps{last}"]))
    return f"since {date.day} {date:%B}{year}{f' ({names})' if names else ''}"


def not_ended(earlier: Sequence[NightSummary]) -> str:
    """Sentence on the nights just before this one that were begun and did not end; empty without any."""
    cut = list(takewhile(lambda night: night.run is not None and night.run.interrupted, reversed(earlier)))
    if not cut:
        return ""
    before = f", nor did the {'one' if len(cut) == 2 else amount(len(cut) - 1)} before it" if len(cut) > 1 else ""
    return f"The night of {cut[0].started.day} {cut[0].started:%B} did not end{before}."


def without_figures(night: NightSummary | None, killed: Sequence[str]) -> str:
    """Sentences on later nights than the last one with figures, which lead to those on that one; empty without any.

    Parameters
    ----------
    night : NightSummary, optional
        The latest night, if it has no figures.
    killed : sequence of str
        Names of later nights that were begun and did not end.
    """
    said = [f"The night of {name[:10]} was begun and did not end." for name in killed]
    if night is not None:
        name = f"The night of {night.started.day} {night.started:%B}"
        unmeasured = not_measured(night.run, complete=False, night=name)
        empty = f"{name} has no figures." if night.complete else unmeasured
        said.append(f"{name} is void: {night.void}." if night.void else empty)
    return joined(*said, "The last night with figures:") if said else ""


def not_measured(run: NightRun | None, *, complete: bool, night: str = "The night") -> str:
    """What a night did not measure, and why; empty of a complete one."""
    parts = [part for part in run.parts if not part.whole] if run else []
    said = [f"{part.name}, {shortened(part.reasons or str(part.state))}" for part in parts[:MOST_CAUSES]]
    more = f"; and {amount(len(parts) - MOST_CAUSES, 'more part')}" if len(parts) > MOST_CAUSES else ""
    noted = [f"{part.name}: {shortened(part.reason)}." for part in (run.parts if run else ())
             if part.whole and part.reason]  # fmt: skip
    if said:
        return joined(f"{night} is incomplete: {'; '.join(said)}{more}.", *noted)
    return joined("" if complete else f"{night} is incomplete.", *noted)


def no_pass(rejected: Sequence[RejectedEntry]) -> str:
    """Verdicts of a night that are no pass, the first one with its reason; empty without any."""
    if not rejected:
        return ""
    first = shortened(rejected[0].words)
    count = len(rejected)
    eg = "" if count == 1 else "the first "
    return f"{are(count, 'verdict')} no pass: {eg}{first}."


def shortened(text: str) -> str:
    """Text of at most :data:`MOST_REASON` characters, cut between words; a full stop would end the headline."""
    return textwrap.shorten(text.rstrip(". ").replace(". ", "; "), MOST_REASON, placeholder=" …")


def accepted_words(count: int, since: str, judged: int, *, alone: bool) -> str:
    """Sentence on changes of a night that are accepted; empty without any."""
    if not alone or not count:
        return counted(count, "more change", "accepted")
    every = "the change is accepted" if count == 1 else "all changes are accepted"
    return f"{amount(count, 'figure').capitalize()} of {judged} changed{since}; {every}. Nothing else changed."


def plan_words(judged: JudgedNight, baseline: str) -> str:
    """Sentence on another plan than on the night before, and on new figures."""
    if baseline:
        return ""
    if not judged.replanned:
        return counted(judged.new, "figure", "new")
    gone = judged.left_out if judged.night.complete else 0
    states = (counted(judged.new, "figure", "new"), counted(gone, "figure", "not measured tonight"))
    found = ", ".join(f"{state[0].lower()}{state[1:-1]}" for state in states if state)
    return f"The plan is another one than on the night before{': ' if found else ''}{found}."


def figures(changes: Sequence[ChangeEntry]) -> int:
    """Number of the figures of some changes."""
    return sum(1 + change.also for change in changes)


def counted(count: int, noun: str, state: str) -> str:
    """``Three figures are new.``; empty without any."""
    return f"{are(count, noun)} {state}." if count else ""


def renamed_words(renamed: Sequence[str]) -> str:
    """Sentence on names that changed; empty without any."""
    if not renamed:
        return ""
    more = f" and {len(renamed) - MOST_CAUSES} more changed their names" if len(renamed) > MOST_CAUSES else ""
    said = "; ".join(renamed[:MOST_CAUSES])
    return f"{said[0].upper()}{said[1:]}{more}: figures are compared by their role."


def changes_words(changes: Sequence[ChangeEntry], since: str, judged: int) -> str:
    """Sentence on changes: how many, for the worse or not, and whose they are; empty without changes."""
    if not changes:
        return ""
    found = {d: figures([change for change in changes if change.direction == d]) for d in DIRECTIONS}
    worse = [change for change in changes if change.direction == "worse"]
    sizes = {"worse": f"{by_words(worse)}{verdict_words(worse)}"}
    words = [f"{amount(found[d])} {words}{sizes.get(d, '')}" for d, words in DIRECTIONS.items() if found[d]]
    count = figures(changes)
    many = f"{amount(count, 'figure').capitalize()} of {judged} changed{since}"
    how = listed(words) if len(words) > 1 else f"{'all ' if count > 1 else ''}{words[0].partition(' ')[2]}"
    return f"{many}, {how}; {causes(changes)}."


def verdict_words(worse: Sequence[ChangeEntry]) -> str:
    """`` (two verdicts: failed, inconsistent)``: those among the changes for the worse; empty without any."""
    found = [change.became for change in worse if change.worse_verdict]
    return f" ({amount(len(found), 'verdict')}: {', '.join(sorted(set(found)))})" if found else ""


def causes(changes: Sequence[ChangeEntry]) -> str:
    """Whose changes they are: ``all three since engine:mujoco 4.0.0, confirmed``."""
    found: Counter[str] = Counter()
    confirmed: Counter[str] = Counter()
    for change in changes:
        name, count = cause(change), 1 + change.also
        found[name] += count
        confirmed[name] += count * (len(change.suspects) == 1 and verdict(change) == AttributionVerdict.CONFIRMED)

    def shown(name: str) -> str:
        if not confirmed[name]:
            return name
        every = confirmed[name] == found[name]
        return f"{name}, {'' if every else f'{amount(confirmed[name])} of them '}{AttributionVerdict.CONFIRMED}"

    if len(found) == 1:
        (only,) = found
        count = figures(changes)
        every = "" if count == 1 else "both " if count == 2 else f"all {amount(count)} "
        return f"{every}{shown(only)}"
    words = [f"{amount(count)} {shown(name)}" for name, count in found.most_common(MOST_CAUSES)]
    more = figures(changes) - sum(count for _, count in found.most_common(MOST_CAUSES))
    return listed([*words, f"{amount(more)} by other causes"] if more else words)


def cause(change: ChangeEntry) -> str:
    """Cause of a change in words."""
    if len(change.suspects) == 1 and not change.unknown:
        (only,) = change.suspects
        since = f"since {only.short} {only.after or '(gone)'}".rstrip()
        return since if verdict(change) in ("", AttributionVerdict.CONFIRMED) else f"{since}, {verdict(change)}"
    if change.confirmed:
        return f"by real runs {change.confirmed}"
    if change.suspects:
        names = [suspect.short for suspect in change.suspects]
        more = len(names) - MOST_SUSPECTS
        few = [*names[:MOST_SUSPECTS], f"{amount(more)} more"] if more > 0 else names
        unknown = [f"perhaps {change.unknown[0]}"] if change.unknown else []
        return f"with the suspects {listed([*few, *unknown])}"
    return "with unknown cause" if change.unknown else "without a change of any part"


def verdict(change: ChangeEntry) -> str:
    """Verdict of the attribution of a change, without its causes; empty if none was made."""
    return change.confirmed.partition(":")[0]


def amount(count: int, noun: str = "") -> str:
    """``three figures``: numbers up to twelve in words."""
    number = SMALL[count] if count < len(SMALL) else f"{count}"
    return plural(count, noun, number) if noun else number


def are(count: int, noun: str) -> str:
    """``Three figures are``, at the beginning of a sentence."""
    return f"{amount(count, noun).capitalize()} {'is' if count == 1 else 'are'}"


def listed(words: Sequence[str]) -> str:
    """``a, b and c``."""
    return " and ".join(part for part in (", ".join(words[:-1]), words[-1]) if part)
