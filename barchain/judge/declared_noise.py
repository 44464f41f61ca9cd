"""What an engine says of itself, taken only as far as something that the engine does not control allows.

An engine's class declares noise, and its runs count steps. Both widen what the engine is allowed. A wrong engine could
make room for its errors that way, so each has a bound from the scene.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import AccuracyParameter
from barchain.judge.local_errors import step_s
from barchain.judge.scales import scales
from barchain.metrics.rates import rate_scale
from barchain.solutions.reference import TRACK
from reports.tables.crossval import QUANTITY_UNITS

if TYPE_CHECKING:
    from adapters.engine import Engine, Setting
    from adapters.trajectory import Array
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

MOST_NOISE = 1e-2
"""Share of a quantity's scale that declared noise may be: with more, nothing worth comparing is left"""
MOST_ATTITUDE_NOISE_RAD = 1e-5  # it is amplified: a thousandth of what two runs may part by
MOST_TRACK_NOISE = 1e-6  # of the distance and the speed: a track is good to 1e-9 in all engines here
MOST_STEPS = 1e8  # of a run: with more, none would end
STEPS_SLACK = 10.0  # error constants, rejected steps, restarts at events
LOWEST_ORDER = 4.0  # of the error estimates of methods that choose their steps: rtol^(-1/5) steps a radian


def noise(engine: type[Engine], setting: Setting, solution: ReferenceSolution, t_s: Array) -> dict[str, Array]:
    """Noise that an engine declares, (n,) for each quantity, as declared.

    Parameters
    ----------
    engine : type
    setting : Setting
    truth : Truth
    t_s : ndarray, shape (n,)
        Instants from the start of the scene, s.
    """
    said = engine.noise(solution.scene, setting, t_s)
    return {name: np.array(np.broadcast_to(np.abs(values), t_s.shape)) for name, values in said.items()}


def bounded(noise: dict[str, Array], solution: ReferenceSolution) -> dict[str, Array]:
    """Declared noise as far as it is believed, (n,) for each quantity.

    What dies away in the course of the run, such as a transient of the start, is cut off at :data:`MOST_NOISE` of the
    quantity's scale. Noise that is still larger at the end is not believed at all: an engine that noisy can't pass.
    """
    size, found = scales(solution), {}
    for name, values in noise.items():
        most = most_noise(name, size)
        found[name] = np.minimum(values, most) if values[-1] <= most else np.zeros_like(values)
    return found


def most_noise(quantity: str, size: dict[str, float]) -> float:
    """Largest declared noise of a quantity that is believed, in its unit; `size`: the quantities' scales."""
    if quantity == "attitude":
        return MOST_ATTITUDE_NOISE_RAD
    return (MOST_TRACK_NOISE if quantity in TRACK else MOST_NOISE) * size[quantity]


def too_noisy(noise: dict[str, Array], solution: ReferenceSolution) -> str | None:
    """What an engine declares that is more than is believed, where it is most so; None if all is believed."""
    size = scales(solution)
    over = {name: float(values.max()) / most_noise(name, size) for name, values in noise.items()}
    worst = max(over, key=lambda name: over[name], default="")
    if not worst or over[worst] <= 1.0:
        return None
    unit, said = QUANTITY_UNITS[worst], float(noise[worst].max())
    return (
        f"its adapter declares that iterations and rounding leave {said:.2g} {unit} of the {worst} uncertain here; "
        f"at most {most_noise(worst, size):.2g} {unit} can be compared"
    )


def believed_steps(setting: Setting, solution: ReferenceSolution, counted: float) -> float:
    """Steps that a method which chooses them says that it took, or 0 where no method would take so many.

    A method whose error estimate is of order p takes about rtol^(-1/(p+1)) steps in a radian of what it follows. A
    count beyond that of the lowest order in use, and a generous slack, is no count, and is not used at all.
    """
    rate = rate_scale(solution.scene, solution.trajectory)
    radians = 1.0 + rate * solution.scene.run.duration_s
    most = STEPS_SLACK * radians * setting.value ** (-1.0 / (LOWEST_ORDER + 1.0))
    return counted if 0.0 < counted <= max(most, solution.scene.run.samples) else 0.0


def steps_taken(scene: Scene, setting: Setting, counted: float, t_s: Array) -> Array:
    """Steps taken since ``t_s[0]`` up to each instant, (n,): `counted` for the whole run, or by the setting."""
    by_setting = setting.parameter is AccuracyParameter.STEPS_PER_ORBIT
    whole = scene.run.duration_s / step_s(scene, setting) if by_setting else counted or scene.run.samples
    found: Array = 1.0 + (t_s - t_s[0]) / scene.run.duration_s * min(whole, MOST_STEPS)
    return found
