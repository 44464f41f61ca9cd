"""Progress of a command, a bar on a terminal and plain lines elsewhere; how much is said: the options -q and -v."""

from __future__ import annotations

import contextlib
import time
from contextvars import ContextVar
from typing import TYPE_CHECKING

from barchain.cli.common.terminal import literal, plain, say

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rich.console import Console
    from rich.progress import Progress

    from barchain.studies.study import Reporter

MILD = ("pass", "unsupported")  # outcomes that a terminal shows in the bar only
VERBOSITY: ContextVar[int] = ContextVar("verbosity", default=0)
"""-1: errors only; 0: progress and notes; 1: every verdict on a terminal too, and the traceback of an error"""


def choose_verbosity(level: int) -> None:
    """Set the verbosity of this command."""
    VERBOSITY.set(level)


def quiet() -> bool:
    """Whether progress and notes are left out."""
    return VERBOSITY.get() < 0


def verbose() -> bool:
    """Whether every verdict and every traceback is printed."""
    return VERBOSITY.get() > 0


def error_console() -> Console:
    """Terminal, or file, that standard error goes to."""
    from rich.console import Console

    return Console(stderr=True)


def progress_bar(console: Console) -> Progress:
    """Bar with a description, a count and the time so far."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    return Progress(*columns, console=console, transient=True)


def note(text: str) -> None:
    """Print a sentence on what goes on."""
    if not quiet():
        say(text, err=True)


@contextlib.contextmanager
def working(what: str) -> Iterator[None]:
    """Show on a terminal that something without steps goes on, and for how long."""
    console = error_console()
    if quiet() or not console.is_terminal:
        yield
        return
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as shown:
        shown.add_task(literal(what), total=None)
        yield


@contextlib.contextmanager
def verdicts_shown(total: int | None) -> Iterator[Reporter]:
    """Reporter that shows each verdict as it comes, of `total` expected; off a terminal one line for each.

    Without a total the study counts by itself, and a line or bar shows that.
    """
    from barchain.studies.study import Reporter, ignore

    console, start, done = error_console(), time.monotonic(), 0

    def line(scene: str, engine: str, outcome: str) -> None:
        nonlocal done
        done += 1
        place = f"[{min(done, total or 0):>3}/{total}]"  # a verdict on all scenes together follows the expected ones
        say(f"{place} {time.monotonic() - start:6.1f} s  {scene}  {engine}  {outcome}", err=True)

    if quiet() or total is None:
        yield Reporter(ignore, note, counted)
    elif not console.is_terminal:
        yield Reporter(line, note, counted)
    else:
        with progress_bar(console) as bar:
            task = bar.add_task("comparing", total=total)

            def show(scene: str, engine: str, outcome: str) -> None:
                bar.update(task, advance=1, description=f"{literal(scene)} · {literal(engine)}")
                if verbose() or outcome not in MILD:
                    bar.console.print(f"{literal(scene)}  {literal(engine)}  [bold]{literal(outcome)}[/bold]")

            yield Reporter(show, lambda text: bar.console.print(plain(text), markup=False, highlight=False))


@contextlib.contextmanager
def counted(what: str, total: int) -> Iterator[Callable[[int], None]]:
    """Callback that counts what is done, of `total` expected; off a terminal a line for every tenth."""
    console, start, done = error_console(), time.monotonic(), 0

    def tenth(more: int) -> None:
        nonlocal done
        before, done = done, done + more
        if 10 * before // total < 10 * done // total:
            say(f"[{done}/{total}] {time.monotonic() - start:6.1f} s  {what}", err=True)

    if quiet():
        yield lambda _: None
    elif not console.is_terminal:
        yield tenth
    else:
        with progress_bar(console) as bar:
            task = bar.add_task(what, total=total)
            yield lambda more: bar.update(task, advance=more)
