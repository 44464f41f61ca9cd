"""What may help where a run fails, takes too long, or takes longer than it need."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from adapters.common.equal_steps import step_s
from adapters.engine import AccuracyParameter
from adapters.registry import COMPILED, ENGINES
from barchain.runs.asking import declarations_of
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterable

    from adapters.engine import Setting
    from scenarios import Scene

REFERENCE = "reference"
RADIANS = 0.5
"""Of the scene's fastest rate in a step that is advised: explicit steps of any order in use are stable from 1 on"""
FAILURES = (Outcome.TIMED_OUT, Outcome.FAILED, Outcome.NOT_FINITE)
"""Outcomes of runs that did not come to their end"""
LONG_S = 5.0
"""Time of a run from which a quicker form of the engine is named, s"""


def compiled_can(scenes: Iterable[Scene]) -> bool:
    """Whether the compiled reference is installed and can do these scenes."""
    registration = ENGINES[COMPILED]
    if registration.missing:
        return False
    engine = declarations_of(registration)
    return all(engine.unsupported(scene) is None for scene in scenes)


def default_engine(scene: Scene, *, condition: bool = False) -> str:
    """Form of the reference for a scene: the compiled one where it is built and can do it, else NumPy's.

    Only NumPy's has condition numbers.
    """
    return COMPILED if not condition and compiled_can([scene]) else REFERENCE


def failure_advice(scene: Scene, engine: str, setting: Setting, outcome: Outcome) -> str:
    """Advice after a run that failed, as a further part of a sentence; empty where none is known.

    Parameters
    ----------
    scene : Scene
    engine : str
        Name of the engine that failed.
    setting : Setting
        Of the run.
    outcome : Outcome
    """
    parts = [setting_advice(scene, setting, outcome)]
    if outcome not in FAILURES:
        return ""
    if engine not in (COMPILED, "heyoka") and compiled_can([scene]):
        parts.append(f"`{COMPILED}` chooses its steps, and its method where joints are stiff: --engine {COMPILED}")
    return "".join(f"; {part}" for part in parts if part)


def setting_advice(scene: Scene, setting: Setting, outcome: Outcome) -> str:
    """Other setting, or limit, with which a run that failed may come to its end; empty where none is known."""
    if outcome is Outcome.TIMED_OUT:
        return "a longer time limit or a coarser setting may do"
    return finer_words(scene, setting) if outcome in FAILURES else ""


def finer_words(scene: Scene, setting: Setting) -> str:
    """Setting whose steps follow the scene's fastest motion, where those of a setting do not."""
    if setting.parameter is not AccuracyParameter.STEPS_PER_ORBIT:
        return ""
    rate = scene.fastest_rate_rad_s
    step = step_s(scene, setting.value) * rate
    if step <= 1.0:
        return ""
    finer = scene.step_period_s * rate / RADIANS
    unit = 10.0 ** (math.floor(math.log10(finer)) - 1)
    by = "joint springs and dampers let" if rate == scene.spring_rate_rad_s else "the scene's fastest motion lets"
    return (
        f"a step is {step:.3g} times as long as {by} it be ({1.0 / rate:.2g} s): "
        f"--set steps_per_orbit={math.ceil(finer / unit) * unit:.0f} may do"
    )


def quicker_advice(scene: Scene, engine: str, seconds: float) -> str:
    """Form of the engine that needs less time; empty where a run was short, or there is none."""
    if engine != REFERENCE or seconds < LONG_S or not compiled_can([scene]):
        return ""
    return f"the run took {seconds:.0f} s; the compiled form is far quicker: --engine {COMPILED}"
