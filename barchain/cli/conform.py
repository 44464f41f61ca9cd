"""`barchain conform`: whether an engine keeps the contract, and which mistake it makes if it does not."""

from __future__ import annotations

import json
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

import click

from barchain.cli.common.exit_codes import findings
from barchain.cli.common.numbers import POSITIVE_SECONDS, WORDS, NamedPath
from barchain.cli.common.options import json_option, programs_option
from barchain.cli.common.progress import quiet
from barchain.cli.common.terminal import literal, plain, say

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.conform.checks import Check, ConformanceReport

SIGNS = {"passed": "✓", "warning": "!", "unsupported": "-", "not run": "·", "failed": "✗"}
COLOURS = {"passed": "green", "warning": "yellow", "unsupported": "dim", "not run": "dim", "failed": "bold red"}
NAME_WIDTH = 38
INDENT = 6 * " "
"""Of a check's further lines on a terminal"""


@click.command("conform", short_help="Examine an engine, and name its mistakes.")
@programs_option
@click.argument("targets", metavar="ENGINE|MODULE:CLASS...", nargs=-1, required=True, type=WORDS)
@click.option("--junit", metavar="FILE", type=NamedPath(path_type=Path, dir_okay=False),
              help="Write the checks as JUnit XML into this file.")  # fmt: skip
@click.option("--time-limit", metavar="S", type=POSITIVE_SECONDS, default=10.0, show_default=True,
              help="End a run after this wall time, in seconds, beside 30 s for the start of its process.")  # fmt: skip
@click.option("--only", "names", metavar="NAME", multiple=True, type=WORDS,
              help="Examine this group of checks, or this scene of the physics (impulse_alone), alone, beside loading. "
                   "May be repeated.")  # fmt: skip
@json_option
def conform(
    targets: tuple[str, ...], junit: Path | None, time_limit: float, names: tuple[str, ...], as_json: bool
) -> None:
    """Examine an engine: declarations, conventions, physics, accuracy and behaviour, and name its mistakes.

    ENGINE is a name of `barchain engines`; MODULE:CLASS is a class that no package registers yet. Exits with 1 if a
    check fails. A part of the examination is no conformance. docs/howto/conform.md describes the checks.
    """
    from barchain.cli.common.result_folder import need_writable
    from barchain.conform.run import conform as examine
    from barchain.conform.target import examined, extent_of

    extent = extent_of(names, time_limit)
    for target in targets:
        examined(target)  # a wrong name is told before anything runs
    if junit is not None:
        from barchain.nightly.errors import need_extra

        need_extra("junitparser")
        need_writable(junit, "--junit")
    reports = []
    for target in targets:
        if not as_json:
            say(target)
        reports.append(examine(target, shown(as_json), extent=extent, note=announced(as_json)))
    if junit is not None:
        from barchain.conform.junit import write_junit

        write_junit(junit, reports)
    if as_json:
        say(json.dumps([report.as_dict() for report in reports], indent=2))
    else:
        for report in reports:
            say(summary(report))
        if any(check.page for report in reports for check in report.failures):
            say("The pages are in the folder docs/ of barchain's repository.")
    if not all(report.passed for report in reports):
        raise findings()


def shown(as_json: bool) -> Callable[[Check], None]:
    """Callback that prints each check as it is done."""
    if as_json or quiet():
        return lambda _: None
    from rich.console import Console

    console = Console()
    if not console.is_terminal:
        return lambda check: say(line(check))

    def show(check: Check) -> None:
        for text in textwrap.wrap(line(check), console.width - 1, subsequent_indent=INDENT, break_on_hyphens=False):
            console.print(f"[{COLOURS[check.state]}]{literal(text)}[/]", highlight=False)

    return show


def announced(as_json: bool) -> Callable[[str], None]:
    """Callback that prints to standard error what begins: the runs of a stage may take minutes."""
    if as_json or quiet():
        return lambda _: None
    return lambda text: say(f"  … {text}", err=True)


def line(check: Check) -> str:
    """Check in one line, a failure with the page that states the convention."""
    name = f"{check.group}: {check.name}"
    said = plain(" ".join(check.words.split()))
    page = f"{'' if said.endswith('.') else '.'} See {check.page}." if check.state == "failed" and check.page else ""
    return f"  {SIGNS[check.state]} {name:{NAME_WIDTH}} {said}{page}".rstrip()


def summary(report: ConformanceReport) -> str:
    """Result in one line."""
    from scenarios.plural import plural

    count = {state: sum(c.state == state for c in report.checks) for state in SIGNS}
    said = ", ".join(plural(n, state) if state == "warning" else f"{n} {state}" for state, n in count.items() if n)
    return f"{report.engine}: {report.verdict} ({said}; {report.seconds:.1f} s)"
