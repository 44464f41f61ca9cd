"""Text from outside: characters that a reader can't see, or that change how other characters are shown."""

from __future__ import annotations

import unicodedata

from scenarios.size_limits import MOST_NAME, MOST_SHOWN, LimitError

HIDDEN = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})
"""Unicode categories: control characters (newline, tab, escape), invisible formats (bidirectional overrides, zero-width
characters), lone surrogates, line and paragraph separators"""


def is_hidden(character: str) -> bool:
    """Whether a character can't be seen, or changes how others are shown."""
    return unicodedata.category(character) in HIDDEN


def first_hidden(text: str, *, but: str = "") -> str | None:
    """First hidden character of a text, except those in `but`; None if there is none."""
    if text.isprintable():  # quick, and true of almost all text
        return None
    return next((c for c in text if c not in but and is_hidden(c)), None)


def code_point(character: str) -> str:
    """``U+202E RIGHT-TO-LEFT OVERRIDE``; control characters have no name."""
    return f"U+{ord(character):04X} {unicodedata.name(character, '')}".strip()


def visible(text: object, most: int | None = None) -> str:
    r"""Text whose hidden characters are written as ``\x1b`` or ``\u202e``, cut to `most` characters."""
    whole = str(text)
    short = whole if most is None else cut(whole, most)
    return short if short.isprintable() else "".join(map(escaped, short))


def escaped(character: str) -> str:
    """Character, or its code where it is hidden."""
    return ascii(character)[1:-1] if is_hidden(character) else character


def shorten(value: object, most: int = MOST_SHOWN) -> str:
    """Text of a given value, cut to `most` characters."""
    if isinstance(value, str):
        return cut(repr(value[:most]) if len(value) > most else repr(value), most)
    try:
        return cut(repr(value), most)
    except ValueError:  # a whole number of more digits than Python writes
        return "a number of thousands of digits"


def cut(text: str, most: int) -> str:
    """Text, cut to `most` characters."""
    return text if len(text) <= most else f"{text[: most - 3]}..."


def check_text(text: str, most: int, *, but: str = "") -> None:
    """Reject a text that is too long, or has hidden characters other than those in `but`.

    Raises
    ------
    LimitError
        With what is given and what is allowed.
    """
    if len(text) > most:
        raise LimitError(f"{len(text)} characters given, allowed: at most {most}")
    found = first_hidden(text, but=but)
    if found is not None:
        kind = "text" if but else "one line of text"
        raise LimitError(
            f"character {text.index(found) + 1} is {code_point(found)}, allowed: {kind} without control characters "
            "and invisible characters"
        )


def is_scene_name(name: str) -> bool:
    """Whether a name is a path below a folder of scenes or results, and nothing else; see :func:`check_scene_name`."""
    try:
        check_scene_name(name)
    except LimitError:
        return False
    return True


def check_scene_name(name: str) -> None:
    r"""Reject the name of a scene that would lead out of a folder of results.

    A name has parts with ``/`` between them, ``paper/fig05``: each is the name of a folder or file on any system.

    Raises
    ------
    LimitError
        If a part is empty, is ``.`` or ``..``, is too long, or holds ``\``, ``:`` or a hidden character.
    """
    parts = name.split("/")
    safe = all(
        part.strip(" .") and not set(part) & {"\\", ":"} and first_hidden(part) is None
        and len(part.encode(errors="replace")) <= MOST_NAME
        for part in parts
    )  # fmt: skip
    if not safe:
        raise LimitError(
            f"scene name {shorten(name)} given, allowed: names like paper/fig05, without empty parts, '.', '..', "
            f"backslashes, colons and invisible characters, and up to {MOST_NAME} bytes in a part"
        )
