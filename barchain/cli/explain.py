"""Command `explain`: the meaning of a word that barchain prints or reads."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from barchain.cli.common.terminal import say, show_rows

if TYPE_CHECKING:
    from barchain.cli.common.meanings import Meaning

MOST_WHOLE = 4
"""Meanings that are printed whole; more of them as a list"""


@click.command(short_help="Explain an outcome, a term, a key or a known mistake.")
@click.argument("words", metavar="[WORD]...", nargs=-1)
def explain(words: tuple[str, ...]) -> None:
    """Explain WORD: an outcome, a term, a key of a scene file, a known mistake or an exit code.

    Several words are taken together, e.g. `barchain explain opposite sign`. A kind in place of a word lists the words
    of that kind; without WORD the kinds are listed. Exits with 2 if the word is not known, and names the nearest one.
    """
    from barchain.cli.common.meanings import UnknownWordError, kinds
    from barchain.cli.common.meanings import explain as meanings_of

    given, known = " ".join(words), kinds()
    if not words:
        rows = [(kind, str(len(found)), found[0].word) for kind, found in known.items()]
        show_rows(("kind", "words", "e.g."), rows, right=("words",))
        say("barchain explain KIND lists the words of a kind, barchain explain WORD explains one")
        return
    if given in known:
        listed(known[given])
        return
    try:
        found = meanings_of(given)
    except UnknownWordError as error:
        raise click.UsageError(str(error)) from error
    if len(found) > MOST_WHOLE:
        listed(found)
        return
    for meaning in found:
        say(f"{meaning.word} ({meaning.kind}): {meaning.text}\n  {meaning.page}")


def listed(found: list[Meaning]) -> None:
    """Print several words, one a line."""
    for meaning in found:
        say(f"{meaning.word}: {meaning.text}")
