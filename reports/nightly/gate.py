"""Comment of a gate as Markdown, for a pull request."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from reports.page import templates

if TYPE_CHECKING:
    from reports.results.nights.gate import GateResult

MOST_ROWS = 20


def gate_comment(result: GateResult) -> str:
    """Comment whose first line is the answer."""
    text = templates().get_template("nightly/gate.md.j2").render(result=result, most=MOST_ROWS)
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"
