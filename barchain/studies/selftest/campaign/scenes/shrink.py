"""The simplest scene that still shows a finding, looked for by hypothesis."""

from __future__ import annotations

import contextlib
import time
from typing import TYPE_CHECKING, Any

from barchain.studies.selftest.campaign.judging import judge_serially
from barchain.studies.selftest.campaign.scenes.simpler import EXACT, Form, effects_of, simplified, whole
from barchain.studies.selftest.campaign.trial_runner import CampaignRunner
from barchain.studies.selftest.runs import RunCache, in_this_process
from reports.tables.crossval import JUDGING_SOLUTION

if TYPE_CHECKING:
    from collections.abc import Callable

    from hypothesis.strategies import SearchStrategy

    from barchain.studies.selftest.campaign.cells import CampaignCell
    from scenarios import Scene

EXAMPLES = 60
AS_IT_IS = 15
"""Chances that one part of a scene stays as it is, to one for each simpler form: hypothesis starts from forms that
differ little from the whole, which mostly show the finding, and then goes to the first form of each part"""
SHARES = (0.05, 0.1, 0.2, 0.5)
DIGITS = (1, 2, 3, 5)
ALL = 10**6


def forms(scene: Scene) -> SearchStrategy[Form]:
    """Forms of a scene, the simplest first."""
    from hypothesis import strategies as st  # noqa: PLC0415  # half a second, for those who look for a finding

    def part(simpler: tuple[Any, ...], full: Any) -> SearchStrategy[Any]:
        return st.sampled_from([*simpler, *[full] * AS_IT_IS])

    samples = tuple(n for n in (3, 5, 11, 31, 101) if n < scene.run.samples)
    return st.builds(
        Form,
        effects=st.tuples(*(part((False,), True) for _ in effects_of(scene))),
        bars=part(tuple(range(1, scene.bars)), scene.bars),
        samples=part(samples, scene.run.samples),
        share=part(SHARES, 1.0),
        digits=part(DIGITS, EXACT),
    )


def simplest(
    scene: Scene,
    shows: Callable[[Scene], bool],
    seconds: float,
    told: Callable[[Scene], None] = lambda _: None,
) -> Scene:
    """Simplest scene found in the time that still shows a finding.

    Parameters
    ----------
    scene : Scene
        Shows it.
    shows : callable
        Whether a scene does.
    seconds : float
        After which no further scene is tried.
    told : callable
        Given each scene that is simpler than all before.
    """
    from hypothesis import HealthCheck, Phase, find, settings  # noqa: PLC0415  # as above
    from hypothesis.errors import HypothesisException  # noqa: PLC0415

    end = time.monotonic() + seconds
    best, least = scene, whole(scene).complexity
    known = {scene.digest: True}

    def still(form: Form) -> bool:
        nonlocal best, least
        candidate = simplified(scene, form)
        if candidate is None:
            return False
        if candidate.digest not in known:  # after the end of the time nothing new is tried: hypothesis comes to its end
            known[candidate.digest] = time.monotonic() < end and shows(candidate)
        if known[candidate.digest] and form.complexity < least:
            best, least = candidate, form.complexity
            told(best)
        return known[candidate.digest]

    wanted = settings(
        derandomize=True, max_examples=EXAMPLES, deadline=None, database=None, phases=(Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    with contextlib.suppress(HypothesisException):  # nothing simpler shows it
        find(forms(scene), still, settings=wanted)
    return best


def cell_of(scene: Scene, engine: str, fault: str) -> CampaignCell | None:
    """Cell of an engine, or of a fault in it, on a scene, all in this process; None where it can't be tried."""
    runner = CampaignRunner(RunCache(in_this_process), judge_serially)
    (sampled,) = runner.establish([scene])
    cells, trials = runner.unmodified_trials(sampled, [] if engine == JUDGING_SOLUTION else [engine])
    cells += runner.judge_trials(trials)
    if fault:
        left_out, trials = runner.fault_trials(sampled, engine, [fault], ALL)
        cells = left_out + runner.judge_trials(trials)
    return cells[0] if cells else None


def alike(found: CampaignCell | None, cell: CampaignCell) -> bool:
    """Whether a scene shows the same finding as another."""
    if found is None or (found.engine, found.kind) != (cell.engine, cell.kind):
        return False
    return bool(cell.fault) or found.outcome == cell.outcome
