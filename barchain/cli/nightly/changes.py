"""`barchain history changes` and `accept`: what a night changed, and the changes that somebody accepts."""

from __future__ import annotations

import datetime
import getpass
import json
import os
from collections import Counter
from typing import TYPE_CHECKING

import click

from barchain.cli.common.numbers import WORDS
from barchain.cli.common.options import json_option
from barchain.cli.common.terminal import say, show_rows
from barchain.cli.nightly.documents import show_some
from barchain.cli.nightly.options import history_option, opened

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from barchain.nightly.figures.changes import Change
    from barchain.nightly.history.levels import JudgedNight
    from barchain.nightly.history.nights import NightStore

HEADINGS = ("change", "figure", "was", "is", "direction", "since", "suspects", "accepted")
UNKNOWN_USER = "unknown"


@click.command("changes")
@click.argument("night", metavar="[NIGHT]", default="latest", type=WORDS)
@click.option("--all", "every", is_flag=True, help="List also what is worse since earlier nights.")
@history_option
@json_option
def changes(night: str, every: bool, url: str | None, as_json: bool) -> None:
    """List what NIGHT changed, each with its suspects; default: the latest night."""
    from barchain.nightly.history import acceptances, judging  # noqa: PLC0415
    from barchain.nightly.telling import document  # noqa: PLC0415

    store = opened(url)
    judged = judging.judge(store, night)
    tonight, earlier = document.change_entries(judged, acceptances.accepted(store))
    entries = [*tonight, *(entry for entry in earlier if every or entry.since == judged.night.name)]
    found = document.night_facts(store, judged, store.night(judged.night.name))
    if as_json:
        say(json.dumps([entry.model_dump(mode="json") for entry in entries], indent=2))
        return
    say(f"{judged.night.name}: {found.sentence}")
    if len(entries) < len(tonight) + len(earlier):
        say("--all lists what is worse since earlier nights, too")
    if entries:
        show_rows(HEADINGS, [
            (e.id, e.figure, *e.results, e.direction, e.since, e.suspect_words, e.accepted.words if e.accepted else "")
            for e in entries
        ])  # fmt: skip


@click.command("accept")
@click.argument("names", metavar="CHANGE...", nargs=-1, required=True, type=WORDS)
@click.option("--reason", metavar="TEXT", required=True, type=WORDS, help="Say why; the reason is shown and kept.")
@click.option("--until", metavar="DATE", type=click.DateTime(["%Y-%m-%d"]),
              help="Let the change come back on this date (UTC); default: when the figure is worse again.")  # fmt: skip
@click.option("--night", metavar="NIGHT", default="latest", type=WORDS,
              help="Take the change as it stands on this night; default: the latest.")  # fmt: skip
@click.option("--step", metavar="NIGHT", type=WORDS,
              help="Accept only what this night changed; default: all steps up to what a figure is.")  # fmt: skip
@history_option
def accept_change(
    names: tuple[str, ...], reason: str, until: datetime.datetime | None, night: str, step: str | None,
    url: str | None,
) -> None:  # fmt: skip
    """Accept each CHANGE on purpose: an id of `barchain history changes`, or the name of a figure.

    An id accepts the step of its night alone; a name accepts what the figure is, with all steps since it was as it may
    be; with --step, only the step of that night. In a name * stands for any text: '*:exudyn:*' accepts all figures of
    an engine, with one entry for each night since which they are worse. Entries stand in the file accepted.toml of the
    history.
    """
    from barchain.nightly.figures import suspects  # noqa: PLC0415
    from barchain.nightly.history import acceptances, judging, news  # noqa: PLC0415
    from scenarios.plural import plural  # noqa: PLC0415

    end, now = None if until is None else until.replace(tzinfo=datetime.UTC), datetime.datetime.now(datetime.UTC)
    store = opened(url)
    judged = judging.judge(store, step or night)
    news.keep_judgement(store, judged)  # a step keeps the name under which it is accepted
    known = acceptances.accepted(store)
    # a wrong name accepts nothing
    every = {name: judging.changes_named(judged, name, alone=step is not None) for name in names}
    chosen = [change for own in every.values() for change in own]
    acceptances.acceptances_of(chosen, user(), now, reason, end)  # all, or none
    nights = judged.by_name
    causes = {change.id: ", ".join(s.words for s in suspects.suspects_of(change, nights)) for change in chosen}
    made = [
        entry for name, own in every.items()
        for entry in acceptances.accept(store, own, user(), reason, end, name if "*" in name else "", causes)
    ]  # fmt: skip
    say(f"{plural(len({change.identity for change in chosen}), 'figure')} accepted{counted(chosen)}; {covered(chosen)}")
    show_some([f"accepted: {entry.words}" for entry in made], "`barchain history accepted` lists them")
    replaced = {(entry.pattern, entry.since) for entry in made}
    earlier = {one.words: one for change in chosen if (one := acceptances.accepting(change, known, now)) is not None}
    lines = [
        f"{'replaces' if (one.pattern, one.since) in replaced else 'stands beside'}: {words}"
        for words, one in earlier.items()
    ]
    show_some(lines, "earlier acceptances of these figures")
    now_judged = judged if step is None else judging.judge(store, night)
    left_open(store, now_judged, names, {change.identity.name for change in chosen})
    if left := judging.irreproducible(judged, names):
        say(f"left out: {plural(left, 'run')} that {'is' if left == 1 else 'are'} not reproducible")


def counted(chosen: Sequence[Change]) -> str:
    """``: 3 worse, 25 better``: numbers of accepted figures by direction; empty where all are worse."""
    directions = Counter(str(direction) for direction in {c.identity: c.direction for c in chosen}.values())
    if set(directions) == {"worse"}:
        return ""
    return ": " + ", ".join(f"{directions[name]} {name}" for name in ("worse", "better", "changed") if directions[name])


def covered(chosen: Sequence[Change]) -> str:
    """What an acceptance covers: the largest factor of what is worse, if anything is, its steps and first night."""
    from barchain.nightly.figures.changes import results_words  # noqa: PLC0415
    from barchain.nightly.telling.sentence import amount  # noqa: PLC0415
    from reports.results.nights.document import ratio_words  # noqa: PLC0415

    worse = [change for change in chosen if change.direction == "worse"] or chosen
    largest = max(worse, key=lambda change: change.factor or 0.0)
    was, became = results_words(largest)
    never = largest.last == largest.since  # a run that failed from the first night on
    what = ratio_words(largest.factor) if largest.factor else became if never else f"{was} → {became}"
    up_to = "up to " if len(worse) > 1 and largest.factor else ""
    return f"covers {up_to}{what} in {amount(largest.steps, 'step')} since {largest.since}"


def left_open(store: NightStore, judged: JudgedNight, given: Sequence[str], names: Collection[str]) -> None:
    """Say how many of the accepted figures are still worse than accepted, and how they are accepted whole."""
    from barchain.nightly.history import acceptances, standing  # noqa: PLC0415
    from reports.results.nights.document import ratio_words  # noqa: PLC0415
    from scenarios.plural import plural  # noqa: PLC0415

    every = [state.change for state in standing.standing(judged, acceptances.accepted(store)) if not state.acceptance]
    found = [change for change in every if change.identity.name in names and not change.is_step]
    if not found:
        return
    largest, many = max(change.factor or 0.0 for change in found), len(found) > 1
    factor = f" {'by up to ' if many else ''}{ratio_words(largest)}" if largest else ""
    which = f" {plural(len(found), 'figure')}" if many else ""
    steps = "these changes are steps" if many else "this change is a step"
    patterns = " ".join(f"'{name}'" for name in given if "*" in name)
    remedy = patterns or ("FIGURE" if many else found[0].identity.name)
    say(f"  still worse than accepted:{which}{factor} since {min(change.since for change in found)}, which {steps} of; "
        f"`barchain history accept {remedy}` accepts all of it")  # fmt: skip


@click.command("accepted")
@history_option
@json_option
def accepted_changes(url: str | None, as_json: bool) -> None:
    """List what is accepted, as it stands in the file accepted.toml of the history; what has lapsed comes last.

    An entry has lapsed if its date has passed, or if what it accepts is back at its level.
    """
    from barchain.nightly.history import acceptances, judging, standing  # noqa: PLC0415

    store = opened(url)
    known = acceptances.accepted(store)
    holding = standing.in_force(judging.latest_judged(store), known, datetime.datetime.now(datetime.UTC))
    if as_json:
        say(json.dumps([one.model_dump() | {"lapsed": one not in holding} for one in known], indent=2, default=str))
        return
    for one in sorted(known, key=lambda one: one not in holding):
        say(one.words if one in holding else f"lapsed: {one.words}")
    if not known:
        say("nothing is accepted")


@click.command("withdraw")
@click.argument("pattern", metavar="PATTERN", type=WORDS)
@click.option("--since", metavar="NIGHT", type=WORDS, help="Take back the entry of this night alone.")
@history_option
def withdraw_acceptance(pattern: str, since: str | None, url: str | None) -> None:
    """Take back the acceptances of PATTERN, as `barchain history accepted` shows it."""
    from barchain.nightly.history.acceptances import withdraw  # noqa: PLC0415

    store = opened(url)
    for gone in withdraw(store, pattern, since or ""):
        say(f"withdrawn: {gone.words}")


def user() -> str:
    """Name of the user; of a container without users the environment's."""
    try:
        return getpass.getuser()
    except (OSError, KeyError):
        return os.environ.get("USER") or UNKNOWN_USER
