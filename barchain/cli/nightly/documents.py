"""Documents of a stored night: nightly.json, summary.md, nightly.html, JUnit XML; the results page of all nights."""

from __future__ import annotations

import datetime
import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from barchain.cli.common.exit_codes import ExitCode
from barchain.cli.common.numbers import WORDS, NamedPath
from barchain.cli.common.result_folder import need_writable
from barchain.cli.common.terminal import say
from barchain.cli.nightly.options import history_option, opened
from barchain.nightly.errors import need_extra

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.figures.figure import Night
    from barchain.nightly.history.nights import NightStore
    from reports.results.nights.document import NightlyFile

WORSE, CHANGED, NOT_PASS, NEVER = "worse", "changed", "not-pass", "never"
PAGE, JUNIT = "nightly.html", "junit.xml"
DOCUMENTS = (PAGE, "nightly.json", "summary.md", JUNIT)
NIGHTS = Path("nights")
MOST_DAYS = 100_000
MOST_SHOWN = 5
"""Changes, or verdicts, that are printed; the page has all"""

junit_option = click.option(
    "--junit", metavar="FILE", type=NamedPath(path_type=Path, dir_okay=False),
    help="Write JUnit XML into this file; default: junit.xml beside the page.",
)  # fmt: skip
baseline_option = click.option(
    "--baseline", metavar="NIGHT|DIR", type=WORDS,
    help="Judge against this night alone, or against a copy of a night's folder; default: all earlier nights.",
)  # fmt: skip
fail_option = click.option(
    "--fail-on", type=click.Choice([WORSE, CHANGED, NOT_PASS, NEVER]), default=WORSE, show_default=True,
    help="End with exit code 1 if a figure is worse, or changed; `not-pass`: also if a verdict is no pass, changed or "
    "not; `never`: end with 0, also if the night is void or incomplete.",
)  # fmt: skip
require_option = click.option(
    "--require-history",
    "need_history",
    is_flag=True,
    help="End with exit code 3 if no figure could be compared with an earlier night, e.g. as the history is lost.",
)


@click.command("report")
@click.argument("night", metavar="[NIGHT]", default="latest", type=WORDS)
@click.option("--out", metavar="DIR", type=NamedPath(path_type=Path, file_okay=False),
              help="Write the documents into this folder; default: that of the night's results in nights, and of the "
              "latest night also nights.")  # fmt: skip
@junit_option
@baseline_option
@fail_option
@require_option
@history_option
def report_night(
    night: str, out: Path | None, junit: Path | None, baseline: str | None, fail_on: str, need_history: bool,
    url: str | None,
) -> None:  # fmt: skip
    """Write page, summary, nightly.json and JUnit XML of NIGHT; default: the latest night.

    The exit code is that of `barchain nightly`.
    """
    need_extra("junitparser")
    if junit is not None:
        need_writable(junit, "--junit")
    store = opened(url)
    store.check()
    name = store.summary(night).name
    folder = out or (store.place.local or NIGHTS) / name
    facts = write_documents(store, name, folder, junit, baseline, fail_on, need_history=need_history)
    show_night(facts, (folder if out else publish(store, name, folder)) / PAGE)
    end_night(facts, fail_on, need_history=need_history)


@click.command("tell")
@click.argument("night", metavar="[NIGHT]", default="latest", type=WORDS)
@click.option("--link", metavar="URL", default=None, type=WORDS, help="End with this address, e.g. of the page.")
@history_option
def tell_night(night: str, link: str | None, url: str | None) -> None:
    """Print NIGHT in a few short lines for mail or a chat: the sentences, the worst figures with suspects, a link.

    If the latest night has no figures, a line says why, and the latest one with figures follows.
    """
    from barchain.nightly.history.judging import judge  # noqa: PLC0415
    from barchain.nightly.history.nights import LATEST  # noqa: PLC0415
    from barchain.nightly.telling.document import night_facts  # noqa: PLC0415
    from barchain.nightly.telling.sentence import without_figures  # noqa: PLC0415
    from reports.nightly.summary import message  # noqa: PLC0415

    store, here = opened(url), datetime.datetime.now(datetime.UTC)
    store.check()
    judged = judge(store, night)
    later = [each for each in store.nights() if night == LATEST and judged.night.started < each.started <= here]
    killed = [name for name in killed_nights(store) if night == LATEST and name > judged.night.name]
    before = without_figures(later[-1] if later else None, killed)
    say(message(night_facts(store, judged, store.night(judged.night.name)), link or "", before))


@click.command("site")
@click.option("--out", metavar="DIR", type=NamedPath(path_type=Path, file_okay=False), required=True,
              help="Write the site into this folder; pages of earlier nights that are there stay.")  # fmt: skip
@click.option("--days", metavar="N", type=click.IntRange(1, MOST_DAYS), default=30, show_default=True,
              help="Write the pages of the last N nights.")  # fmt: skip
@history_option
def results_site(out: Path, days: int, url: str | None) -> None:
    """Write a static site of all nights: results of each engine in each scene, a table of them, the nights' pages.

    It has the latest verdict, error and time at equal error, with intervals and trends, and what was not measured.
    """
    from barchain.nightly.history.acceptances import accepted, holding  # noqa: PLC0415
    from barchain.nightly.history.judging import judge  # noqa: PLC0415
    from barchain.nightly.history.news import told_by  # noqa: PLC0415
    from barchain.nightly.telling.site import site_file  # noqa: PLC0415
    from barchain.nightly.telling.trends import calendar  # noqa: PLC0415
    from reports.nightly.site import write_site  # noqa: PLC0415
    from reports.results.nights.site import FILE  # noqa: PLC0415

    need_extra("junitparser")
    store = opened(url)
    store.check()
    latest, nights = store.summary("latest").name, store.nights()
    for night in nights[-days:]:
        if night.name != latest and not (out / night.name / PAGE).is_file():
            write_documents(store, night.name, out / night.name)
    facts = write_documents(store, latest, out / latest)
    pages = {night.name: f"{night.name}/{PAGE}" for night in nights if (out / night.name / PAGE).is_file()}
    known = holding(accepted(store), datetime.datetime.now(datetime.UTC))
    found = site_file(store, judge(store, latest), facts)
    write_site(out, found, facts, calendar(nights, told_by(store), known), pages)
    say(f"{out / FILE}: {len(found.pairs)} results of {len(found.nights)} nights")


def killed_nights(store: NightStore) -> list[str]:
    """Names of nights that were begun and did not end, and are not in the history."""
    from reports.results.nights import STATE  # noqa: PLC0415

    out, known = store.place.local or NIGHTS, {night.name for night in store.nights()}
    if all(path.parent.name in known for path in out.glob(f"*/{STATE}")):
        return []
    from barchain.nightly.running.state import not_ended  # noqa: PLC0415  # a second, with all that runs a night

    return not_ended(out, known)


def show_night(facts: NightlyFile, page: Path) -> None:
    """Print the night's sentences, what is worse, what is new, the verdicts that are no pass, and the page's place."""
    say(facts.sentence)
    for part in facts.run.parts if facts.run else ():
        if part.missing and part.missing not in facts.sentence:
            say(f"  {part.name}: {part.missing}")
    show_some([f"left out: {name}: {reason}" for name, reason in facts.left_out.items()], "nights left out")
    show_some([change.dated(facts.night.name) for change in facts.standing], "worse since earlier nights")
    worse = sum(change.direction == "worse" for change in facts.other_news[MOST_SHOWN:])
    what = f"changed tonight{f', {worse} of them for the worse' if worse else ''}"
    show_some([change.dated(facts.night.name) for change in facts.other_news], what)
    show_some([rejected.words for rejected in facts.rejected], "verdicts that are no pass")
    if facts.so_far:
        say(f"  {facts.so_far}")
    say(f"page: {page}")


def show_some(lines: Sequence[str], what: str) -> None:
    """Print the first of some lines, and how many more there are."""
    for line in lines[:MOST_SHOWN]:
        say(f"  {line}")
    if len(lines) > MOST_SHOWN:
        say(f"  {len(lines) - MOST_SHOWN} more: {what}")


def publish(store: NightStore, name: str, folder: Path) -> Path:
    """Copy the documents of the newest night beside the folders of all nights, and return where they are.

    Those of a night that ends after a newer one stay in its folder. A start later than now is that of a wrong clock.
    """
    from reports.results.writing import write_atomically  # noqa: PLC0415

    started, now = store.summary(name).started, datetime.datetime.now(datetime.UTC)
    if any(started < night.started <= now for night in store.nights()):
        return folder
    for document in DOCUMENTS:
        if (folder / document).is_file():
            content = (folder / document).read_bytes()  # pages of other nights lie beside the folder
            shown = content.replace(b'href="../', b'href="') if document == PAGE else content
            write_atomically(folder.parent / document, shown)
    return folder.parent


def write_documents(
    store: NightStore, name: str, out: Path, junit: Path | None = None, baseline: str | None = None,
    fail_on: str = WORSE, *, need_history: bool = False,
) -> NightlyFile:  # fmt: skip
    """Judge a stored night, and write its documents into a folder.

    Raises
    ------
    HistoryError
        If the night or the baseline does not exist, or the history can't be read.
    OSError
        If a file can't be written.
    """
    from barchain.nightly.history.acceptances import accepted, holding  # noqa: PLC0415
    from barchain.nightly.history.judging import judge, judge_pair  # noqa: PLC0415
    from barchain.nightly.history.news import keep_judgement, told_by  # noqa: PLC0415
    from barchain.nightly.telling.document import night_facts  # noqa: PLC0415
    from barchain.nightly.telling.junit import write_junit  # noqa: PLC0415
    from barchain.nightly.telling.trends import calendar, trend_charts  # noqa: PLC0415
    from reports.nightly.page import write_page  # noqa: PLC0415
    from reports.nightly.summary import write_summary  # noqa: PLC0415
    from reports.results.nights.document import FILE  # noqa: PLC0415
    from reports.results.writing import write_atomically  # noqa: PLC0415

    summary, night = store.summary(name), store.night(name)
    before = None if baseline is None else baseline_night(store, baseline)
    judged = judge(store, summary.name)
    keep_judgement(store, judged)
    against = baseline or ""
    if before is not None:
        judged = judge_pair(before, night)
        against += f" (a night of another plan, {before.plan})" if before.plan != night.plan else ""
    facts = night_facts(store, judged, night, against)
    nights = [each for each in store.nights() if each.started <= summary.started]
    told = told_by(store)
    charts = trend_charts(store.numbers(), nights, told, judged.earlier)
    out.mkdir(parents=True, exist_ok=True)
    write_atomically(out / FILE, facts.model_dump_json(indent=1) + "\n")
    write_summary(out, facts)
    days = calendar(nights, told, holding(accepted(store), datetime.datetime.now(datetime.UTC)))
    folders = [out.absolute().parent, *([store.place.local] if store.place.local else [])]
    pages = night_pages(out.absolute(), folders, [each.name for each in nights])
    write_page(out, facts, charts, days, pages, part_pages(out.absolute()))
    write_junit(junit or out / JUNIT, facts, night.figures, fail_on, need_history=need_history)
    return facts


def night_pages(out: Path, folders: Sequence[Path], names: Sequence[str]) -> dict[str, str]:
    """Pages of nights, by name, in the first of some folders that has one, relative to a page in a night's folder."""
    places = {name: [folder / name / PAGE for folder in folders] for name in names}
    found = ((name, next(filter(Path.is_file, own), None)) for name, own in places.items())
    return {name: Path(os.path.relpath(page, out)).as_posix() for name, page in found if page is not None}


def part_pages(out: Path) -> dict[str, str]:
    """Pages of the parts of a night, by the name of the part, relative to a page in the night's folder."""
    from barchain.nightly.figures.results import STUDIES  # noqa: PLC0415

    names = {page for files in STUDIES for page in files.pages if page.endswith(".html")}
    found = sorted(page for name in names for page in out.glob(f"*/{name}"))
    return {page.parent.name: f"../{out.name}/{page.parent.name}/{page.name}" for page in found}


def baseline_night(store: NightStore, given: str) -> Night:
    """Night of a name in the history, or of a folder that is a copy of a night's.

    Raises
    ------
    HistoryError
        If there is neither.
    """
    from barchain.nightly.history.nights import open_store  # noqa: PLC0415

    path = Path(given).absolute()
    return open_store(str(path.parent)).night(path.name) if path.is_dir() else store.night(given)


def end_night(facts: NightlyFile, fail_on: str, *, need_history: bool = False) -> None:
    """End a command with the exit code of what a night found."""
    code = exit_code(facts, fail_on, need_history=need_history)
    if need_history and not facts.compared and code is ExitCode.NOT_BELIEVED:
        say("exit code 3: --require-history asks for an earlier night to compare with", err=True)
    if code is ExitCode.FINDINGS and fail_on == NOT_PASS and not facts.worse:
        say("exit code 1: --fail-on not-pass asks for verdicts that are all a pass", err=True)
    if code is not ExitCode.OK:
        raise click.exceptions.Exit(code)


def exit_code(facts: NightlyFile, fail_on: str, *, need_history: bool = False) -> ExitCode:
    """Exit code of a night: void, or nothing to compare with, first; then what is worse, changed, or no pass."""
    if fail_on == NEVER:
        return ExitCode.OK
    if facts.night.state == "void":
        return ExitCode.NOT_BELIEVED
    if (facts.against.baseline or need_history) and not facts.compared:
        return ExitCode.NOT_BELIEVED
    if (facts.differs if fail_on == CHANGED else facts.worse) or (fail_on == NOT_PASS and facts.rejected):
        return ExitCode.FINDINGS
    if facts.bad_input:
        return ExitCode.BAD_INPUT
    return ExitCode.NOT_BELIEVED if facts.night.state == "incomplete" else ExitCode.OK
