r"""Text of pages and of Markdown: anchors, names in narrow columns, formulas, and nothing hidden.

Hidden characters are made visible, so that text from outside can't erase, reorder or add lines of a page or a terminal.
They are those that a scene file must not hold (``scenarios/text.py``): control characters, invisible formats as
bidirectional overrides, lone surrogates, line and paragraph separators.
"""

from __future__ import annotations

import re
import unicodedata
from typing import TYPE_CHECKING

from markupsafe import Markup

from reports.text.numerals import significant, typeset, unpadded

if TYPE_CHECKING:
    from collections.abc import Iterable

HIDDEN = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})
LAYOUT = "\n\t"
MARKDOWN = str.maketrans({c: "\\" + c for c in "\\|`*_[]<>&"})
GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "epsilon": "ε", "lambda": "λ", "mu": "μ", "omega": "ω", "phi": "φ",
    "pi": "π", "rho": "ρ", "theta": "θ",
}  # fmt: skip
RAISED = str.maketrans("0123456789+-()np", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻⁽⁾ⁿᵖ")
ROUND_OFF = 1e-12  # relative effects below it are zero up to round-off
AS_NONE = "0 (to round-off)"
LETTER = re.compile(rf"(?<![\w-])({'|'.join(GREEK)})(?![^\W_])")  # a name like generalized-alpha stays
ROOT = re.compile(r"sqrt\((\w+)\)")
POWER = re.compile(r"\^(\([-+\dnp]+\)|-?[\dnp]+)")
TIMES_TEN = re.compile(r"(?<![\w.=])(?<!= )(\d+(?:\.\d+)?)e([+-]?\d+)\b")  # a setting like rtol = 1e-13 is typed so
PRIMES = re.compile(r"(?<=[A-Za-zα-ω])''")
LEADING_MINUS = re.compile(r"(?:(?<=^)|(?<= )|(?<=\())-(?=[\d(α-ω ])")


def visible(text: object, *, but: str = "") -> str:
    r"""Text whose hidden characters are written as ``\x1b`` or ``\u202e``, except those in `but`."""
    whole = str(text)
    hidden = {ord(c): ascii(c)[1:-1] for c in set(whole).difference(but) if unicodedata.category(c) in HIDDEN}
    return whole.translate(hidden) if hidden else whole


def shown(value: object) -> object:
    """Value as a template writes it: text and markup without hidden characters; lines and tabs are its layout.

    Typed exponents, as in settings, have one form: ``1e-8``.
    """
    if isinstance(value, Markup):
        return Markup(visible(value, but=LAYOUT))  # was markup, and stays
    return unpadded(visible(value, but=LAYOUT)) if isinstance(value, str) else value


def escape_text(value: object) -> str:
    """Literal Markdown text on one line."""
    return visible(" ".join(str(value).split())).translate(MARKDOWN)


def table_row(values: Iterable[object]) -> str:
    """One row of a Markdown table; None is an empty cell, floats get three significant digits."""
    cells = (significant(v) if isinstance(v, float) else "" if v is None else escape_text(v) for v in values)
    return "| " + " | ".join(cells) + " |"


def written(text: str) -> str:
    """Typographic form of a formula typed in ASCII, as text that can be searched and copied.

    ``3 n^2 sin(phi)`` becomes ``3 n² sin(φ)``, and ``5e4`` ``5×10⁴``; text without formulas is unchanged.
    """
    text = TIMES_TEN.sub(lambda m: ("" if m[1] == "1" else f"{m[1]}×") + f"10^{int(m[2])}", text)
    text = LETTER.sub(lambda m: GREEK[m[1]], text)
    text = PRIMES.sub("″", ROOT.sub(r"√\1", text))
    text = POWER.sub(lambda m: m[1].translate(RAISED), text)
    return LEADING_MINUS.sub("−", text).replace(">=", "≥").replace("<=", "≤")


def written_row(row: dict[str, object]) -> dict[str, object]:
    """Row of a table with formulas of its texts in typographic form; numbers stay."""
    return {k: written(v) if isinstance(v, str) else v for k, v in row.items()}


def effect(value: float | None) -> str:
    """Relative effect of a misprint; in words if it is zero up to round-off."""
    return AS_NONE if value is not None and abs(value) < ROUND_OFF else typeset(value)


def identifier(name: str) -> str:
    """Name of letters, digits, points, underscores and hyphens, different for each name, for use in an id."""
    return re.sub(r"[^A-Za-z0-9_.]", lambda m: "-" if m[0] == "/" else f"-{ord(m[0]):x}-", name)


def anchor(name: str) -> str:
    """Anchor of a scene, valid as an id."""
    return f"scene-{identifier(name)}"


def engine_anchor(name: str) -> str:
    """Anchor of an engine, valid as an id."""
    return f"engine-{identifier(name)}"


def run_anchor(scene: str, engine: str) -> str:
    """Anchor of an engine's run of a scene, valid as an id."""
    return f"{anchor(scene)}:{identifier(engine)}"


def breakable(name: str, after: str = "/_") -> Markup:
    """Name that a narrow column breaks after the characters in `after`, a slash or an underscore by default."""
    ends = re.escape(after)
    return Markup("").join(
        Markup("{}<wbr>").format(part) for part in re.findall(rf"[^{ends}]*[{ends}]|[^{ends}]+", name)
    )
