"""Progress of a command, a bar on a terminal and plain lines elsewhere; how much is said: the options -q and -v."""

from __future__ import annotations

import contextlib
import time
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TYPE_CHECKING

from barchain.cli.common.terminal import literal, plain, say

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rich.console import Console
    from rich.progress import Progress

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


@dataclass(frozen=True)
class Shown:
    """Callback that shows each verdict as it comes, and notes between verdicts."""

    verdict: Callable[[str, str, str], None]
    note: Callable[[str], None]

    def __call__(self, scene: str, engine: str, outcome: str) -> None:
        """Show a verdict."""
        self.verdict(scene, engine, outcome)


def error_console() -> Console:
    """Terminal, or file, that standard error goes to."""
    from rich.console import Console

    return Console(stderr=True)


def progress_bar(console: Console) -> Progress:
    """Bar with a description, a count and the time so far."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    return Progress(*columns, console=console, transient=True)


@contextlib.contextmanager
def verdicts_shown(total: int) -> Iterator[Shown]:
    """Callback that shows each verdict as it comes, of `total` expected; off a terminal one line for each."""
    console, start, done = error_console(), time.monotonic(), 0

    def line(scene: str, engine: str, outcome: str) -> None:
        nonlocal done
        done += 1
        place = f"[{min(done, total):>3}/{total}]"  # a verdict on all scenes together follows the expected ones
        say(f"{place} {time.monotonic() - start:6.1f} s  {scene}  {engine}  {outcome}", err=True)

    if quiet():
        yield Shown(lambda *_: None, lambda _: None)
    elif not console.is_terminal:
        yield Shown(line, lambda text: say(text, err=True))
    else:
        with progress_bar(console) as bar:
            task = bar.add_task("comparing", total=total)

            def show(scene: str, engine: str, outcome: str) -> None:
                bar.update(task, advance=1, description=f"{literal(scene)} · {literal(engine)}")
                if verbose() or outcome not in MILD:
                    bar.console.print(f"{literal(scene)}  {literal(engine)}  [bold]{outcome}[/bold]")

            yield Shown(show, lambda text: bar.console.print(plain(text), markup=False, highlight=False))


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
