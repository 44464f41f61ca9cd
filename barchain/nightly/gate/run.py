"""Run of a gate inside its budget: environments, a comparison of each build, times in turns."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

from barchain.nightly.attribution.environments import installed_tree
from barchain.nightly.gate.builds import build_of
from barchain.nightly.gate.judging import judged_gate
from barchain.nightly.gate.measuring import compared_in_parts, night_of, timed_scenes, times_in_turns
from barchain.runs.environment import scratch_folder
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from barchain.nightly.gate.known import KnownFailure
    from reports.results.nights.gate import GateResult

END_S = 12.0
"""Time for the start, and for judging and telling"""
SHARE = 0.65
"""Share of the time after which no part of the comparisons begins"""
RUN_SHARE = 0.1
"""Share of the time that one run may take"""


def run_gate(
    engine: str, base: str, head: str, scenes: Sequence[str], known: tuple[KnownFailure, ...], minutes: float,
    note: Callable[[str], None],
) -> GateResult:  # fmt: skip
    """Measure two builds of an engine in turns, and judge the head against the base.

    Parameters
    ----------
    engine : str
        Name that both builds know.
    base, head : str
        Builds, see :func:`barchain.nightly.gate.builds.build_of`.
    scenes : sequence of str
        Names, or paths of files.
    known : tuple of KnownFailure
    minutes : float
        Budget of wall time; the making of environments is part of it.
    note : callable
        Called with a sentence on what begins.

    Raises
    ------
    PinnedEnvironmentError
        If a build can't be installed or gives no results, the base passes no scene, or the processor changed.
    SceneError
        If a scene can't be read.
    """
    end = time.monotonic() + 60.0 * minutes - END_S
    files = {load_scene(name).name: str(Path(name).resolve()) if Path(name).is_file() else name for name in scenes}
    note(f"environments of {base} and {head}")
    builds = build_of(base, engine), build_of(head, engine)
    with scratch_folder() as scratch:
        tree, now = installed_tree(scratch / "tree"), time.monotonic()
        folders = compared_in_parts(
            builds, tree, engine, list(files.values()), RUN_SHARE * 60.0 * minutes, now + SHARE * (end - now), scratch,
            note,
        )  # fmt: skip
        nights = night_of(folders[0], builds[0]), night_of(folders[1], builds[1])
        timed = {name: files[name] for name in timed_scenes(folders[0])}
        times = times_in_turns(builds, tree, engine, timed, end, note)
    return judged_gate(engine, (base, head), nights, times, known, len(files))
