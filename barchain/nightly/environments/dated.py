"""Dependencies of a release as they were when it was new, for releases that no longer import with today's."""

from __future__ import annotations

import subprocess
import sys
from datetime import date, timedelta
from importlib.util import find_spec

from barchain.nightly.environments.faults import PinnedEnvironmentError
from barchain.nightly.environments.making import brief, name_of

MONTH = timedelta(days=30)
"""Time after a release within which its dependencies were found to be wrong, if they were"""
LIMIT_S = 120.0


def dependencies_at(pin: str, released: str) -> list[str]:
    """Versions of all dependencies of a release, as the package index had them a month after the release.

    Parameters
    ----------
    pin : str
        Requirement of the release: ``pin==3.4.0``.
    released : str
        Day of the release, e.g. ``2025-02-13``.

    Returns
    -------
    list of str
        Requirements, without that of the release itself.

    Raises
    ------
    PinnedEnvironmentError
        If uv or the day is missing, or there are no such versions; the message is one line.
    """
    if find_spec("uv") is None:
        raise PinnedEnvironmentError("dependencies of an earlier day need uv, which is not installed")
    if not released:
        raise PinnedEnvironmentError(f"the package index gives no day for {pin}")
    day = date.fromisoformat(released) + MONTH
    line = [sys.executable, "-m", "uv", "pip", "compile", "--quiet", "--no-header", "--no-annotate",
            "--only-binary", ":all:", "--exclude-newer", day.isoformat(), "-"]  # fmt: skip
    try:
        done = subprocess.run(line, input=pin, capture_output=True, text=True, timeout=LIMIT_S, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise PinnedEnvironmentError(brief(str(error))) from None
    if done.returncode:
        raise PinnedEnvironmentError(brief(done.stderr or done.stdout))
    found = [line.strip() for line in done.stdout.splitlines() if "==" in line]
    return [one for one in found if name_of(one) != name_of(pin)]
