r"""Hidden characters made visible: text from outside can't erase, reorder or add lines of a page or a terminal.

The characters are those that a scene file must not hold (``scenarios/text.py``): control characters, invisible formats
as bidirectional overrides, lone surrogates, line and paragraph separators.
"""

from __future__ import annotations

import unicodedata

from markupsafe import Markup

from reports.text.numerals import unpadded

HIDDEN = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})
LAYOUT = "\n\t"


def visible(text: object, *, but: str = "") -> str:
    r"""Text whose hidden characters are written as ``\x1b`` or ``\u202e``, except those in `but`."""
    whole = str(text)
    hidden = {ord(c): ascii(c)[1:-1] for c in set(whole).difference(but) if unicodedata.category(c) in HIDDEN}
    return whole.translate(hidden) if hidden else whole


def written(value: object) -> object:
    """Value as a template writes it: text and markup without hidden characters; lines and tabs are its layout.

    Typed exponents, as in settings, have one form: ``1e-8``.
    """
    if isinstance(value, Markup):
        return Markup(visible(value, but=LAYOUT))  # was markup, and stays
    return unpadded(visible(value, but=LAYOUT)) if isinstance(value, str) else value
