"""How a command ended: with a known exit code, in short lines, and in time."""

from __future__ import annotations

import time
import traceback
from typing import TYPE_CHECKING

from barchain.cli.common.exit_codes import ExitCode
from barchain.cli.main import run

if TYPE_CHECKING:
    import pytest

KNOWN = frozenset(ExitCode) - {ExitCode.INTERNAL_ERROR}
LONGEST = 2500
"""Characters of a line"""


def fault_of(arguments: list[str], capsys: pytest.CaptureFixture[str], limit_s: float) -> str:
    """What is wrong with the end of a command; empty if nothing is."""
    capsys.readouterr()
    begun = time.monotonic()
    try:
        code = run(arguments)
    except BaseException as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__}: {error}"[:500] + f" ({place.filename}:{place.lineno})"
    seconds, (out, error) = time.monotonic() - begun, capsys.readouterr()
    if code not in KNOWN or "Traceback" in error:
        return f"code {code}: {error[:500]}"
    if code == ExitCode.BAD_INPUT and not error:
        return "code 2 without a word"
    long = next((line for line in (out + error).split("\n") if len(line) > LONGEST), "")
    if long:
        return f"a line of {len(long)} characters: {long[:200]}"
    return f"took {seconds:.0f} s" if seconds > limit_s else ""
