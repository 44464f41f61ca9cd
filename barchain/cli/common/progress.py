"""Progress of a comparison: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import contextlib
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from barchain.cli.common.terminal import literal, plain, say
from barchain.cli.common.verbosity import quiet, verbose

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rich.console import Console
    from rich.progress import Progress

MILD = ("pass", "unsupported")  # outcomes that a terminal shows in the bar only


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
    from rich.console import Console  # noqa: PLC0415

    return Console(stderr=True)


def progress_bar(console: Console) -> Progress:
    """Bar with a description, a count and the time so far."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn  # noqa: PLC0415

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    return Progress(*columns, console=console, transient=True)


@contextlib.contextmanager
def verdicts_shown(total: int) -> Iterator[Shown]:
    """Callback that shows each verdict as it comes, of `total` expected."""
    console = error_console()
    if quiet():
        yield Shown(lambda *_: None, lambda _: None)
        return
    if not console.is_terminal:
        yield Shown(plain_lines(total), plain_note)
        return
    with progress_bar(console) as bar:
        task = bar.add_task("comparing", total=total)

        def show(scene: str, engine: str, outcome: str) -> None:
            bar.update(task, advance=1, description=f"{literal(scene)} · {literal(engine)}")
            if verbose() or outcome not in MILD:
                bar.console.print(f"{literal(scene)}  {literal(engine)}  [bold]{outcome}[/bold]")

        yield Shown(show, lambda text: bar.console.print(plain(text), markup=False, highlight=False))


def plain_note(text: str) -> None:
    """One line between verdicts, for logs."""
    say(text, err=True)


def plain_lines(total: int) -> Callable[[str, str, str], None]:
    """One line a verdict, for logs."""
    start, done = time.monotonic(), 0

    def show(scene: str, engine: str, outcome: str) -> None:
        nonlocal done
        done += 1
        elapsed = time.monotonic() - start
        place = f"[{min(done, total):>3}/{total}]"  # a verdict on all scenes together follows the expected ones
        say(f"{place} {elapsed:6.1f} s  {scene}  {engine}  {outcome}", err=True)

    return show


@contextlib.contextmanager
def counted(what: str, total: int) -> Iterator[Callable[[int], None]]:
    """Callback that counts what is done, of `total` expected; off a terminal a line for every tenth."""
    console = error_console()
    if quiet():
        yield lambda _: None
        return
    if not console.is_terminal:
        yield tenths(what, total)
        return
    with progress_bar(console) as bar:
        task = bar.add_task(what, total=total)
        yield lambda more: bar.update(task, advance=more)


def tenths(what: str, total: int) -> Callable[[int], None]:
    """One line for every tenth of the whole, for logs."""
    start, done = time.monotonic(), 0

    def show(more: int) -> None:
        nonlocal done
        before, done = done, done + more
        if 10 * before // total < 10 * done // total:
            say(f"[{done}/{total}] {time.monotonic() - start:6.1f} s  {what}", err=True)

    return show
