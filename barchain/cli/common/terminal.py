"""Text and tables on a terminal, or in a pipe."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rich.table import Table

PIPE_COLUMNS = 240  # without a terminal, wide enough never to break a line


def say(text: object, *, err: bool = False) -> None:
    """Print lines; hidden characters, which may come from an engine, a file or an argument, are escaped.

    Raises
    ------
    ClickException
        If standard output is full. A full standard error costs its lines alone.
    """
    try:
        click.echo(plain(str(text)), err=err)
    except BrokenPipeError:
        raise
    except OSError as error:
        if not err:
            raise click.ClickException(f"standard output is lost: {error.strerror}") from None


def plain(text: str, but: str = "\n\t") -> str:
    """Text with hidden characters escaped, except those in `but`."""
    if text.isprintable():  # quick, and without an import
        return text
    from reports.text.words import visible

    return visible(text, but=but)


def counts_of(words: Iterable[object]) -> str:
    """Number of each word, e.g. ``12 pass, 3 unsupported``; the most frequent first."""
    return ", ".join(f"{count} {word}" for word, count in Counter(map(str, words)).most_common())


def literal(text: str) -> str:
    """Cell of a table as Rich takes it: literal, on one line, without hidden characters."""
    from rich.markup import escape

    return escape(" ".join(plain(text).split("\n")))


def show(table: Table) -> None:
    """Print a table."""
    from rich.console import Console

    console = Console()
    if not console.is_terminal:
        console = Console(width=PIPE_COLUMNS)
    console.print(table)


def show_rows(headings: Sequence[str], rows: Iterable[Sequence[str]], right: Sequence[str] = ()) -> None:
    """Print rows of plain text below headings, the columns named in `right` aligned right."""
    from rich.table import Table

    table = Table(box=None, header_style="bold")
    for heading in headings:
        table.add_column(literal(heading), justify="right" if heading in right else "left")
    for row in rows:
        table.add_row(*map(literal, row))
    show(table)
