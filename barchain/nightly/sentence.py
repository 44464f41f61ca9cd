"""The sentence that opens the page of a night."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from barchain.nightly.told import AttributionVerdict
from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.judged import JudgedNight
    from reports.tables.nights.facts import ChangeEntry


SMALL = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
MOST_CAUSES = 3
MOST_SUSPECTS = 3
DIRECTIONS = {"worse": "for the worse", "better": "for the better", "changed": "neither better nor worse"}
NOT_REPRODUCIBLE = "not reproducible: the same sources, versions and machine class gave other bits"
NOT_JUDGED = "Nothing was judged: no figure of this night has an earlier one."


def opening(
    judged: JudgedNight, changes: Sequence[ChangeEntry], standing: int = 0, baseline: str = "", held: int = 0
) -> str:  # fmt: skip
    """Sentence on a night.

    Parameters
    ----------
    judged : JudgedNight
    changes : sequence of ChangeEntry
        Of this night, accepted ones among them.
    standing : int
        Changes of earlier nights for the worse that still hold.
    baseline : str
        Name of the one night that it was judged against.
    held : int
        Changes of earlier nights for the worse that still hold and are accepted.
    """
    night = judged.night
    if night.void:
        return f"This night is void: {night.void}."
    ending = "" if night.complete else " The night is incomplete."
    if baseline and not judged.judged:
        return f"Nothing was compared: {baseline} has no figure of this night.{ending}"
    if not judged.compared_with:
        return f"This is the first night: there is no earlier one to compare it with.{ending}"
    since = f" since {baseline}" if baseline else " tonight"
    told = [change for change in changes if change.accepted is None]
    wild = sum(change.irreproducible for change in told)
    accepted = figures(changes) - figures(told)
    if told:
        rest = counted(accepted, "more change", "accepted")
    elif accepted:
        every = "the change is accepted" if accepted == 1 else "all changes are accepted"
        many = f"{amount(accepted, 'figure').capitalize()} of {judged.judged} changed"
        rest = f"{many}{since}; {every}. Nothing else changed."
    else:
        rest = f"Nothing changed{since} among {judged.judged} figures." if judged.judged else NOT_JUDGED
    holding = (still(standing, "earlier change"), still(held, "accepted change"))
    coming = ""
    if judged.replanned and not baseline:
        gone = judged.left_out if night.complete else 0
        states = (counted(judged.new, "figure", "new"), counted(gone, "figure", "not measured tonight"))
        found = ", ".join(f"{state[0].lower()}{state[1:-1]}" for state in states if state)
        coming = f"The plan is another one than on the night before{': ' if found else ''}{found}."
    elif not baseline:
        coming = counted(judged.new, "figure", "new")
    said = (
        counted(wild, "run", NOT_REPRODUCIBLE),
        plain([change for change in told if not change.irreproducible], since, judged.judged),
        rest, *holding, renamed_words(judged.renamed), coming,
    )  # fmt: skip
    return " ".join(part for part in said if part) + ending


def still(count: int, noun: str) -> str:
    """``Three earlier changes for the worse still hold.``; empty without any."""
    return f"{amount(count, noun).capitalize()} for the worse still hold{'s' * (count == 1)}." if count else ""


def figures(changes: Sequence[ChangeEntry]) -> int:
    """Number of the figures of some changes."""
    return sum(1 + change.also for change in changes)


def counted(count: int, noun: str, state: str) -> str:
    """``Three figures are new.``; empty without any."""
    return f"{amount(count, noun).capitalize()} {'is' if count == 1 else 'are'} {state}." if count else ""


def renamed_words(renamed: Sequence[str]) -> str:
    """Sentence on names that changed; empty without any."""
    if not renamed:
        return ""
    more = f" and {len(renamed) - MOST_CAUSES} more changed their names" if len(renamed) > MOST_CAUSES else ""
    said = "; ".join(renamed[:MOST_CAUSES])
    return f"{said[0].upper()}{said[1:]}{more}: figures are compared by their role."


def plain(changes: Sequence[ChangeEntry], since: str, judged: int) -> str:
    """Sentence on changes: how many, for the worse or not, and whose they are; empty without changes."""
    if not changes:
        return ""
    found = {d: figures([change for change in changes if change.direction == d]) for d in DIRECTIONS}
    words = [f"{amount(found[d])} {words}" for d, words in DIRECTIONS.items() if found[d]]
    count = figures(changes)
    many = f"{amount(count, 'figure').capitalize()} of {judged} changed{since}"
    how = listed(words) if len(words) > 1 else f"{'all ' if count > 1 else ''}{words[0].partition(' ')[2]}"
    return f"{many}, {how}; {causes(changes)}."


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
    if len(change.suspects) == 1:
        (only,) = change.suspects
        since = f"since {only.name} {only.after or '(gone)'}".rstrip()
        return since if verdict(change) in ("", AttributionVerdict.CONFIRMED) else f"{since}, {verdict(change)}"
    if change.confirmed:
        return f"by real runs {change.confirmed}"
    if change.suspects:
        names = [suspect.name for suspect in change.suspects]
        more = len(names) - MOST_SUSPECTS
        return f"with the suspects {listed([*names[:MOST_SUSPECTS], f'{amount(more)} more'] if more > 0 else names)}"
    return "with unknown cause" if change.unknown else "without a change of any part"


def verdict(change: ChangeEntry) -> str:
    """Verdict of the attribution of a change, without its causes; empty if none was made."""
    return change.confirmed.partition(":")[0]


def amount(count: int, noun: str = "") -> str:
    """``three figures``: numbers up to twelve in words."""
    number = SMALL[count] if count < len(SMALL) else f"{count}"
    return plural(count, noun, number) if noun else number


def listed(words: Sequence[str]) -> str:
    """``a, b and c``."""
    return " and ".join(part for part in (", ".join(words[:-1]), words[-1]) if part)
