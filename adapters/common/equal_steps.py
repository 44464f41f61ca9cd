"""Equal steps: their number at a setting, and the next finer setting."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter, AccuracySweep, Setting

if TYPE_CHECKING:
    from scenarios import Scene

WHOLE = 1e-9  # distance up to which a step count is the next integer


def steps_between_samples(scene: Scene, steps_per_orbit: float) -> int:
    """Number of steps between two samples, rounded up to an even number.

    Multipliers held at velocity level oscillate from step to step, by h² and undamped. After an odd number of steps a
    sample would fall on the other side of the oscillation, and two settings could not be compared.

    Parameters
    ----------
    scene : Scene
    steps_per_orbit : float
        Value of the setting: steps per `Scene.step_period_s`.

    Returns
    -------
    int
        Even, at least two.
    """
    intervals = scene.run.samples - 1
    wanted = steps_per_orbit * scene.run.duration_s / scene.step_period_s / intervals
    return 2 * max(1, math.ceil(0.5 * (wanted - WHOLE)))


def step_s(scene: Scene, steps_per_orbit: float) -> float:
    """Size of the steps, s.

    Parameters
    ----------
    scene : Scene
    steps_per_orbit : float
        Value of the setting.

    Returns
    -------
    float
        A whole number of steps fills the time between two samples.
    """
    return scene.run.duration_s / ((scene.run.samples - 1) * steps_between_samples(scene, steps_per_orbit))


def finer_setting(scene: Scene, sweep: AccuracySweep, setting: Setting) -> Setting:
    """Setting with half the actual step, or a tenth of the requested error.

    Samples may lie so close together that twice the requested steps give the same actual step. Two equal runs would
    then suggest an error of zero.
    """
    if setting.parameter is AccuracyParameter.RTOL:
        return sweep.finer(setting)
    return Setting(setting.parameter, 2.0 * scene.step_period_s / step_s(scene, setting.value))
